//! What approximate techniques of transparency make of a pixel's fragments, in double precision, from their papers.

use glam::{DMat3, DVec3, DVec4};

use super::layers::{Fragment, composite};

/// McGuire and Bavoil 2013, equation 6, with the weight of each fragment: premultiplied colour and alpha.
pub fn weighted(fragments: &[Fragment], weight: impl Fn(&Fragment) -> f64, opaque: DVec4) -> DVec4 {
    let (mut sum, mut weights, mut through) = (DVec3::ZERO, 0.0, 1.0);
    for fragment in fragments {
        let w = weight(fragment);
        sum += w * fragment.color.truncate();
        weights += w * fragment.color.w;
        through *= 1.0 - fragment.color.w;
    }
    if weights == 0.0 {
        return opaque;
    }
    let color = sum / weights * (1.0 - through) + opaque.truncate() * through;
    color.extend(1.0 - through * (1.0 - opaque.w))
}

/// McGuire and Bavoil 2013, equations 7 to 10: the weight of a fragment at the distance `z`, whose ordinary (not
/// reversed) depth is `d`.
pub fn weight(equation: u32, z: f64, d: f64, alpha: f64) -> f64 {
    let z = z.abs();
    let raw = match equation {
        7 => 10.0 / (1e-5 + (z / 5.0).powi(2) + (z / 200.0).powi(6)),
        8 => 10.0 / (1e-5 + (z / 10.0).powi(3) + (z / 200.0).powi(6)),
        9 => 0.03 / (1e-5 + (z / 200.0).powi(4)),
        _ => 3e3 * (1.0 - d).powi(3),
    };
    alpha * if equation == 10 { raw.max(1e-2) } else { raw.clamp(1e-2, 3e3) }
}

/// Sorted fragments of which the first `kept` are composited, and all others as one layer behind them: their average
/// colour (McGuire and Bavoil 2013, equation 5).
pub fn kept(sorted: &[Fragment], kept: usize, opaque: DVec4) -> DVec4 {
    let (near, rest) = sorted.split_at(kept.min(sorted.len()));
    composite(near, weighted(rest, |_| 1.0, opaque))
}

/// Salvi et al. 2011 from sorted fragments, with `kept` nodes: the transmittance as a step function of distance `z`. Where
/// a fragment more comes than is kept, the step goes that changes the area under the function least, of those behind the
/// first; the one before takes its transmittance. `None` where rounding may decide which of two that can be seen goes.
pub fn adaptive(sorted: &[Fragment], kept: usize, z: impl Fn(&Fragment) -> f64, opaque: DVec4) -> Option<DVec4> {
    // 1. Steps: the place of the fragment, its distance, and what is let through behind it.
    let mut steps: Vec<(usize, f64, DVec3)> = Vec::new();
    let mut through = DVec3::ONE;
    for (place, fragment) in sorted.iter().enumerate() {
        through *= fragment.through;
        steps.push((place, z(fragment), through));
        if steps.len() > kept {
            let mean = |i: usize| steps[i].2.element_sum() / 3.0;
            let fall = |i: usize| mean(i - 1) - mean(i);
            let area = |i: usize| (steps[i].1 - steps[i - 1].1) * fall(i);
            let mut areas: Vec<_> = (1..steps.len()).map(|i| (area(i), i)).collect();
            areas.sort_by(|a, b| a.0.total_cmp(&b.0));
            if areas[1].0 - areas[0].0 < 1e-7 && fall(areas[0].1).max(fall(areas[1].1)) > 1e-4 {
                return None;
            }
            let least = areas[0].1;
            steps[least - 1].2 = steps[least].2;
            steps.remove(least);
        }
    }
    // 2. Each fragment as visible as the last step before it says.
    let color: DVec3 = sorted
        .iter()
        .enumerate()
        .map(|(place, fragment)| {
            let before = steps.iter().rev().find(|step| step.0 < place);
            before.map_or(DVec3::ONE, |step| step.2) * fragment.color.truncate()
        })
        .sum();
    let left = 1.0 - through.element_sum() / 3.0 * (1.0 - opaque.w);
    Some((color + through * opaque.truncate()).extend(left))
}

/// Münstermann et al. 2018 with four power moments, as they sum up: fragments at the places `z` from -1 to 1, each
/// weighted by what is let through before it, and averaged.
pub fn by_moments(fragments: &[Fragment], z: impl Fn(&Fragment) -> f64, opaque: DVec4) -> DVec4 {
    let absorbance = |f: &Fragment| (-(1.0 - f.color.w).ln()).min(10.0);
    let moment = |k: i32| fragments.iter().map(|f| absorbance(f) * z(f).powi(k)).sum::<f64>();
    let whole = moment(0);
    let b = [1, 2, 3, 4].map(|k| moment(k) / whole);
    weighted(fragments, |f| (-whole * absorbed_before(b, z(f))).exp(), opaque)
}

/// Share of a distribution with these moments that lies before `z`: between the least and the greatest that the moments
/// allow, 0.25 of the way (section 3.2; bias of table 1 for floats of 32 bits).
///
/// Of all distributions with these moments, one on three points with `z` among them has the extremes (Peters and Klein
/// 2015): all its mass before `z` is the least, with that at `z` the greatest.
pub fn absorbed_before(b: [f64; 4], z: f64) -> f64 {
    let towards = [0.0, 0.375, 0.0, 0.375];
    let [b1, b2, b3, b4] = [0, 1, 2, 3].map(|k| b[k] + 5e-7 * (towards[k] - b[k]));
    // 1. The other two points are where the kernel polynomial c0 + c1 x + c2 x² is 0.
    let hankel = DMat3::from_cols(DVec3::new(1.0, b1, b2), DVec3::new(b1, b2, b3), DVec3::new(b2, b3, b4));
    let c = hankel.inverse() * DVec3::new(1.0, z, z * z);
    let root = (c.y * c.y - 4.0 * c.z * c.x).max(0.0).sqrt();
    let points = [z, (-c.y - root) / (2.0 * c.z), (-c.y + root) / (2.0 * c.z)];
    // 2. Their masses give the moments 0 to 2.
    let powers = DMat3::from_cols_array_2d(&points.map(|x| [1.0, x, x * x]));
    let masses = powers.inverse() * DVec3::new(1.0, b1, b2);
    // 3. What is before.
    let before: f64 = (1..3).filter(|&i| points[i] < z).map(|i| masses[i]).sum();
    (before + 0.25 * masses.x).clamp(0.0, 1.0)
}

/// Enderton et al. 2010, sections 3 and 4, with `samples` a pixel: each fragment covers those samples that its mask has,
/// is as visible as the share of samples that nothing nearer covers, and the whole is averaged.
pub fn stochastic(fragments: &[Fragment], samples: u32, mask: impl Fn(&Fragment) -> u64, opaque: DVec4) -> DVec4 {
    let nearest = |sample: u32| {
        let covering = fragments.iter().filter(|f| mask(f) >> sample & 1 == 1);
        covering.map(|f| f.depth).fold(f64::NEG_INFINITY, f64::max)
    };
    let nearest: Vec<_> = (0..samples).map(nearest).collect();
    let seen = |f: &Fragment| nearest.iter().filter(|&&depth| depth <= f.depth).count() as f64 / f64::from(samples);
    weighted(fragments, seen, opaque)
}

/// The samples that a triangle of this alpha covers in a pixel: as many as alpha says, rounded at random, and any of them
/// as likely, by a hash that the technique's page states.
pub fn mask(pixel: [u32; 2], key: u32, alpha: f32, samples: u32) -> u64 {
    let mix = |x: u32, factor: u32| x.wrapping_mul(factor);
    let mut state = mix(pixel[0], 73_856_093) ^ mix(pixel[1], 19_349_663) ^ mix(key, 83_492_791);
    let mut random = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    };
    random();
    let share = alpha * samples as f32 + (random() >> 8) as f32 / 16_777_216.0;
    let mut wanted = (share as u32).min(samples);
    let mut mask = 0;
    for sample in 0..samples {
        let chosen = random() % (samples - sample) < wanted;
        mask |= u64::from(chosen) << sample;
        wanted -= u32::from(chosen);
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::super::layers::through_alpha;
    use super::*;

    fn layer(depth: f64, color: [f64; 4]) -> Fragment {
        Fragment { depth, key: 0, color: color.into(), through: through_alpha(color[3]), flat: true }
    }

    #[test]
    fn weighted_is_exact_for_one_layer_and_for_one_color() {
        let opaque = DVec4::new(0.5, 0.25, 0.0, 1.0);
        let one = [layer(0.5, [0.2, 0.1, 0.0, 0.4])];
        let expected = DVec3::new(0.2, 0.1, 0.0) + 0.6 * opaque.truncate();
        assert!(weighted(&one, |_| 7.0, opaque).truncate().distance(expected) < 1e-15);
        // Two of one colour hide what both hide, whatever the weights.
        let two = [layer(0.5, [0.4, 0.0, 0.0, 0.4]), layer(0.2, [0.5, 0.0, 0.0, 0.5])];
        let found = weighted(&two, |f| 1.0 + f.depth, opaque);
        assert!((found - DVec4::new(0.7 + 0.3 * 0.5, 0.3 * 0.25, 0.0, 1.0)).length() < 1e-15, "{found}");
        assert_eq!(weighted(&[], |_| 1.0, opaque), opaque);
    }

    #[test]
    fn weights_are_those_of_the_paper() {
        // At 10 m, by hand.
        assert!((weight(7, 10.0, 0.0, 1.0) - 10.0 / (1e-5 + 4.0 + 1.5625e-8)).abs() < 1e-12);
        assert!((weight(8, -10.0, 0.0, 0.5) - 5.0 / (1e-5 + 1.0 + 1.5625e-8)).abs() < 1e-12);
        assert!((weight(9, 10.0, 0.0, 1.0) - 0.03 / (1e-5 + 6.25e-6)).abs() < 1e-9);
        assert_eq!(weight(10, 10.0, 0.5, 1.0), 375.0);
        assert_eq!([weight(7, 0.0, 0.0, 1.0), weight(7, 1e4, 0.0, 1.0), weight(10, 0.0, 1.0, 1.0)], [3e3, 1e-2, 1e-2]);
    }

    #[test]
    fn a_k_buffer_is_exact_as_far_as_it_goes() {
        let opaque = DVec4::new(0.5, 0.25, 0.0, 1.0);
        let layers = [0.9, 0.6, 0.3].map(|z| layer(z, [0.2 * z, 0.1, 0.3 - 0.2 * z, 0.4]));
        assert_eq!(kept(&layers, 3, opaque), composite(&layers, opaque));
        // A tail of one layer is that layer.
        assert!((kept(&layers, 2, opaque) - composite(&layers, opaque)).length() < 1e-15);
        assert!((kept(&layers, 1, opaque) - composite(&layers, opaque)).length() > 1e-3);
        assert_eq!(kept(&layers, 0, opaque), weighted(&layers, |_| 1.0, opaque));
    }

    #[test]
    fn adaptive_transparency_loses_the_smallest_step() {
        let opaque = DVec4::new(0.5, 0.25, 0.0, 1.0);
        let layers = [(0.9, 0.5), (0.6, 0.1), (0.3, 0.5)].map(|(depth, a)| layer(depth, [0.2, 0.1, a, a]));
        let of = |kept| adaptive(&layers, kept, |f| 1.0 - f.depth, opaque).unwrap_or(DVec4::NAN);
        assert!((of(3) - composite(&layers, opaque)).length() < 1e-15);
        // The middle step falls by 0.05 over 0.3, the last by 0.225: the middle one goes, and is let through at the first.
        let expected = layers[0].color + 0.45 * (layers[1].color + layers[2].color) + 0.225 * opaque;
        assert!((of(2) - expected).truncate().length() < 1e-15, "{}", of(2));
        // Equal areas are for rounding to decide.
        let even = [(0.75, 0.5), (0.5, 0.2), (0.25, 0.25)].map(|(depth, a)| layer(depth, [0.0, 0.0, 0.0, a]));
        assert!(adaptive(&even, 2, |f| 1.0 - f.depth, opaque).is_none());
    }

    #[test]
    fn moments_of_two_depths_tell_what_is_before_both() {
        // Half at -0.5, half at 0.5: exact between and beyond, a quarter of the mass at each.
        let b = [0.0, 0.25, 0.0, 0.0625];
        for (z, share) in [(-0.9, 0.0), (0.0, 0.5), (0.9, 1.0), (-0.5, 0.125), (0.5, 0.625)] {
            assert!((absorbed_before(b, z) - share).abs() < 2e-2, "{z}: {}", absorbed_before(b, z));
        }
        let opaque = DVec4::new(0.5, 0.25, 0.0, 1.0);
        let one = [layer(0.5, [0.2, 0.1, 0.0, 0.4])];
        assert!((by_moments(&one, |f| f.depth, opaque) - composite(&one, opaque)).length() < 1e-12);
    }

    #[test]
    fn samples_are_covered_as_alpha_says_and_tend_to_the_exact_composite() {
        // As many bits as alpha says, and on the average exactly so.
        let bits = |alpha| (0..4000).map(|key| mask([3, 5], key, alpha, 8).count_ones()).sum::<u32>();
        assert_eq!([bits(0.0), bits(0.5), bits(1.0)], [0, 16_000, 32_000]);
        assert!((f64::from(bits(0.3)) / 4000.0 - 2.4).abs() < 0.03);
        // Each sample as often.
        let often = |sample: u32| (0..4000).filter(|&key| mask([1, 2], key, 0.25, 8) >> sample & 1 == 1).count();
        assert!((0..8).all(|sample| (900..1100).contains(&often(sample))), "{:?}", [0, 1, 2, 3].map(often));
        // Many pixels, on the average.
        let opaque = DVec4::new(0.5, 0.25, 0.0, 1.0);
        let mut layers = [0.9, 0.6, 0.3].map(|z| layer(z, [0.2 * z, 0.1, 0.3 - 0.2 * z, 0.4]));
        layers.iter_mut().zip(1..).for_each(|(layer, key)| layer.key = key);
        let picture = |x| stochastic(&layers, 8, |f| mask([x, 7], f.key, f.color.w as f32, 8), opaque);
        let mean = (0..2000).map(picture).sum::<DVec4>() / 2000.0;
        assert!((mean - composite(&layers, opaque)).length() < 0.01, "{mean} {}", composite(&layers, opaque));
    }
}

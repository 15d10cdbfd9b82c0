//! What approximate techniques of transparency make of a pixel's fragments, in double precision, from their papers.

use glam::{DVec3, DVec4};

use super::layers::Fragment;

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

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(depth: f64, color: [f64; 4]) -> Fragment {
        Fragment { depth, key: 0, color: color.into(), flat: true }
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
}

//! All fragments of each pixel, rasterised by Vulkan's rules, and composited.
//!
//! - Vulkan 1.3, 28.12 "Polygon rasterization": a fragment for each pixel whose centre is inside the triangle. Of centres
//!   on an edge Vulkan asks that triangles which share it give one fragment; chosen here is the top-left rule, which
//!   devices have (Direct3D 11 functional specification, 3.4.2.1).
//! - Vertices lie on a grid of 1/256 pixel, so that inside or outside is decided in whole numbers.
//! - Of several samples a pixel (28.3 "Multisampling"), each is inside or outside by itself, at its standard location. A
//!   triangle gives one fragment to a pixel of which it covers a sample.
//! - Depth is affine over the triangle (28.12.1), with reversed depth: larger is nearer.
//! - Compositing: Porter and Duff 1984, *over*, premultiplied, channel by channel, nearest first. Of equal depth the larger key is nearer, as
//!   if triangles were drawn in the order of their keys.

use glam::{DVec3, DVec4};

/// Parts of a pixel that vertices lie on.
pub const GRID: i64 = 256;

/// A triangle in the picture.
#[derive(Clone, Debug)]
pub struct Triangle {
    /// x and y of the vertices, in 1/256 pixel from the upper left corner.
    pub corners: [[i64; 2]; 3],
    /// Depth at the vertices.
    pub depth: [f64; 3],
    /// Premultiplied; alpha is what it hides in the mean of the channels.
    pub color: DVec4,
    /// What it lets through, channel by channel.
    pub through: DVec3,
    /// Breaks ties.
    pub key: u32,
}

/// What a triangle gives to a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Fragment {
    /// Reversed.
    pub depth: f64,
    /// Breaks ties.
    pub key: u32,
    /// Premultiplied; alpha is what it hides in the mean of the channels.
    pub color: DVec4,
    /// What it lets through, channel by channel.
    pub through: DVec3,
    /// Whether its triangle has one depth everywhere: then no rounding changes it.
    pub flat: bool,
}

/// What a triangle gives to a pixel of several samples.
#[derive(Clone, Debug)]
pub struct Covered {
    /// Its depth is that of the triangle's plane at the pixel's centre, no less than 0 and no more than 1.
    pub fragment: Fragment,
    /// Number and depth of each sample that the triangle covers.
    pub samples: Vec<(u32, f64)>,
}

/// What is left of it behind what is opaque.
#[derive(Clone, Debug)]
pub struct Seen {
    /// As before.
    pub fragment: Fragment,
    /// Samples that it is seen at, a bit each.
    pub samples: u32,
}

/// Where the samples of a pixel lie (28.3, standard sample locations), in 1/256 pixel from its upper left corner.
pub fn sample_locations(samples: u32) -> Vec<[i64; 2]> {
    let sixteenths: &[[i64; 2]] = match samples {
        1 => &[[8, 8]],
        2 => &[[12, 12], [4, 4]],
        4 => &[[6, 2], [14, 6], [2, 10], [10, 14]],
        8 => &[[9, 5], [7, 11], [13, 9], [5, 3], [3, 13], [1, 7], [11, 15], [15, 1]],
        _ => panic!("{samples} samples a pixel have no standard locations here"),
    };
    sixteenths.iter().map(|at| at.map(|sixteenth| sixteenth * (GRID / 16))).collect()
}

/// Fragments of each pixel, in the order of the triangles.
pub fn rasterise(size: [u32; 2], triangles: &[Triangle]) -> Vec<Vec<Fragment>> {
    let pixels = rasterise_samples(size, triangles, 1);
    pixels.into_iter().map(|covered| covered.into_iter().map(|covered| covered.fragment).collect()).collect()
}

/// The same of several samples a pixel.
pub fn rasterise_samples(size: [u32; 2], triangles: &[Triangle], samples: u32) -> Vec<Vec<Covered>> {
    let locations = sample_locations(samples);
    let mut pixels = vec![Vec::new(); (size[0] * size[1]) as usize];
    for triangle in triangles {
        let [a, b, c] = triangle.corners;
        let area = edge(a, b, c);
        if area == 0 {
            continue;
        }
        // Either winding; inside is where all three have the sign of the area.
        let sign = area.signum();
        let range = |axis: usize| {
            let of = [a[axis], b[axis], c[axis]];
            let (low, high) = (of.iter().min().copied().unwrap_or(0), of.iter().max().copied().unwrap_or(0));
            low.div_euclid(GRID).max(0)..(high.div_euclid(GRID) + 1).min(i64::from(size[axis]))
        };
        let flat = triangle.depth.iter().all(|&depth| depth == triangle.depth[0]);
        for y in range(1) {
            for x in range(0) {
                let place = |[right, down]: [i64; 2]| [x * GRID + right, y * GRID + down];
                // Sides of the edges that a place is on, and depth there.
                let edges = |p| [(b, c), (c, a), (a, b)].map(|(from, to)| (sign * edge(from, to, p), from, to));
                let depth = |p| {
                    let weights = edges(p).map(|(e, ..)| e as f64 / (sign * area) as f64);
                    if flat { triangle.depth[0] } else { DVec3::from(weights).dot(DVec3::from(triangle.depth)) }
                };
                let inside = |p| edges(p).iter().all(|&(e, from, to)| e > 0 || (e == 0 && is_top_left(from, to, sign)));
                let own = (0..).zip(&locations).filter(|(_, location)| inside(place(**location)));
                let own: Vec<_> = own.map(|(sample, location)| (sample, depth(place(*location)))).collect();
                if own.is_empty() {
                    continue;
                }
                let Triangle { key, color, through, .. } = *triangle;
                let depth = depth(place([GRID / 2; 2])).clamp(0.0, 1.0);
                let fragment = Fragment { depth, key, color, through, flat };
                pixels[(y * i64::from(size[0]) + x) as usize].push(Covered { fragment, samples: own });
            }
        }
    }
    pixels
}

/// Twice the area of a triangle, positive where it runs clockwise in a picture with y down.
fn edge(a: [i64; 2], b: [i64; 2], p: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

/// Whether an edge of a triangle, clockwise where `sign` is 1, is a left one, or a top one that is level.
fn is_top_left(from: [i64; 2], to: [i64; 2], sign: i64) -> bool {
    let (dx, dy) = (sign * (to[0] - from[0]), sign * (to[1] - from[1]));
    dy < 0 || (dy == 0 && dx > 0)
}

/// Sorts fragments, nearest first.
pub fn sort(fragments: &mut [Fragment]) {
    fragments.sort_by(|a, b| b.depth.total_cmp(&a.depth).then(b.key.cmp(&a.key)));
}

/// Composites sorted fragments over what is opaque: premultiplied colour and alpha.
pub fn composite(sorted: &[Fragment], opaque: DVec4) -> DVec4 {
    let (mut color, mut through) = (DVec3::ZERO, DVec3::ONE);
    for fragment in sorted {
        color += through * fragment.color.truncate();
        through *= fragment.through;
    }
    (color + through * opaque.truncate()).extend(1.0 - through.element_sum() / 3.0 * (1.0 - opaque.w))
}

/// Composites the samples of a pixel, each of what is seen at it, over the same background, and averages.
pub fn composite_samples(sorted: &[Seen], samples: u32, opaque: DVec4) -> DVec4 {
    let sample = |i| {
        let own: Vec<_> = sorted.iter().filter(|seen| seen.samples >> i & 1 == 1).map(|seen| seen.fragment).collect();
        composite(&own, opaque)
    };
    (0..samples).map(sample).sum::<DVec4>() / f64::from(samples)
}

/// What a layer of an alpha lets through.
pub fn through_alpha(alpha: f64) -> DVec3 {
    DVec3::splat(1.0 - alpha)
}

/// Whether rounding of depth may change the order: two fragments at most `margin` apart, not both at an exact depth.
pub fn close_call(sorted: &[Fragment], margin: f64) -> bool {
    sorted.windows(2).any(|pair| pair[0].depth - pair[1].depth <= margin && !(pair[0].flat && pair[1].flat))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[i64; 2]; 3], depth: [f64; 3]) -> Triangle {
        Triangle { corners, depth, color: DVec4::new(0.25, 0.0, 0.0, 0.5), through: through_alpha(0.5), key: 0 }
    }

    #[test]
    fn triangles_that_share_edges_cover_each_centre_once() {
        // A fan around a pixel's centre, with an edge through centres in every direction.
        let middle = [4 * GRID + 128, 4 * GRID + 128];
        let around = [[0, 0], [4, 0], [8, 0], [8, 4], [8, 8], [4, 8], [0, 8], [0, 4]];
        let around = around.map(|[x, y]| [x * GRID + 128, y * GRID + 128]);
        for turn in [false, true] {
            let fan: Vec<_> = (0..8)
                .map(|i| {
                    let (a, b) = (around[i], around[(i + 1) % 8]);
                    triangle(if turn { [middle, b, a] } else { [middle, a, b] }, [0.5; 3])
                })
                .collect();
            let pixels = rasterise([10, 10], &fan);
            for (i, fragments) in pixels.iter().enumerate() {
                // The square covers centres 0 to 8; its right and lower edges belong to others.
                let inside = i % 10 < 8 && i / 10 < 8;
                assert_eq!(fragments.len(), usize::from(inside), "pixel {i}, {turn}");
            }
        }
    }

    #[test]
    fn samples_are_covered_one_by_one() {
        // The left half of a pixel, and all of the next one below a diagonal.
        let half = triangle([[0, 0], [128, 0], [0, 100 * GRID]], [0.5; 3]);
        let found = &rasterise_samples([1, 1], &[half], 4)[0][0];
        assert_eq!(found.samples.iter().map(|(sample, _)| *sample).collect::<Vec<_>>(), [0, 2]);
        // Both triangles of a rectangle that covers a pixel: no sample twice, none left out, whatever the number.
        for samples in [1, 2, 4, 8] {
            let [a, b, c, d] = [[0, 0], [GRID, 0], [GRID, GRID], [0, GRID]];
            let both =
                rasterise_samples([1, 1], &[triangle([a, b, c], [0.5; 3]), triangle([a, c, d], [0.5; 3])], samples);
            let masks = both[0].iter().map(|covered| covered.samples.iter().map(|(i, _)| 1 << i).sum::<u32>());
            assert_eq!(masks.clone().sum::<u32>(), (1 << samples) - 1, "{samples} samples");
            assert_eq!(masks.fold(0, |all, mask| all ^ mask), (1 << samples) - 1, "{samples} samples");
            // Seen from the pixel's centre, samples lie as far on one side as on the other.
            let sum = sample_locations(samples).into_iter().fold([0; 2], |sum, at| [sum[0] + at[0], sum[1] + at[1]]);
            assert_eq!(sum, [i64::from(samples) * GRID / 2; 2]);
        }
        // A slope whose plane leaves the range of depth at the centre that it does not cover.
        let steep = triangle([[0, 0], [64, 0], [0, 100 * GRID]], [0.9, 0.0, 0.9]);
        let found = &rasterise_samples([1, 1], &[steep], 4)[0][0];
        assert_eq!(found.fragment.depth, 0.0);
        assert!(found.samples.iter().all(|(_, depth)| (0.0..=0.9).contains(depth)));
        // Half of the samples see red of half an alpha before white.
        let red = Fragment { color: DVec4::new(0.5, 0.0, 0.0, 0.5), ..found.fragment };
        let average = composite_samples(&[Seen { fragment: red, samples: 0b0101 }], 4, DVec4::ONE);
        assert_eq!(average, DVec4::new(1.0, 0.75, 0.75, 1.0));
    }

    #[test]
    fn depth_is_affine_and_layers_composite_nearest_first() {
        let slope = triangle([[0, 0], [8 * GRID, 0], [0, 8 * GRID]], [0.0, 0.8, 0.4]);
        let pixels = rasterise([8, 8], &[slope]);
        let found = pixels[8 + 2][0].depth;
        assert!((found - (0.1 * 2.5 + 0.05 * 1.5)).abs() < 1e-15, "{found}");

        let layer = |depth, key, color: [f64; 4]| {
            let through = through_alpha(color[3]);
            Fragment { depth, key, color: color.into(), through, flat: true }
        };
        let mut layers = vec![
            layer(0.2, 0, [0.0, 0.0, 1.0, 1.0]),
            layer(0.5, 1, [0.0, 0.5, 0.0, 0.5]),
            layer(0.5, 2, [0.5, 0.0, 0.0, 0.5]),
        ];
        sort(&mut layers);
        assert_eq!(layers.iter().map(|layer| layer.key).collect::<Vec<_>>(), [2, 1, 0]);
        assert_eq!(composite(&layers, DVec4::ONE), DVec4::new(0.5, 0.25, 0.25, 1.0));
        assert!(!close_call(&layers, 1e-6));
        // Red glass before it all keeps red alone.
        let red = Fragment { through: DVec3::X, ..layer(0.9, 3, [0.0, 0.0, 0.0, 2.0 / 3.0]) };
        let through_red = composite(&[&[red], &layers[..]].concat(), DVec4::ONE);
        assert_eq!(through_red, DVec4::new(0.5, 0.0, 0.0, 1.0));
        layers[0].flat = false;
        assert!(close_call(&layers, 1e-6));
    }
}

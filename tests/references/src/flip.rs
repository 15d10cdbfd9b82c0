//! How different two pictures look when one is flipped to the other: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström
//! and Fairchild 2020, "FLIP: A difference evaluator for alternating images", for pictures as they are shown.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

/// Pixels of a degree of the visual field: 0.7 m before a screen 0.7 m wide with 3840 pixels (section 3).
const PIXELS_PER_DEGREE: f64 = 0.7 * (3840.0 / 0.7) * (PI / 180.0);

/// What the eye makes of a picture.
pub struct Seen {
    width: usize,
    /// Colours after the contrast sensitivity filter, in L*a*b* with Hunt's adjustment.
    colors: Vec<DVec3>,
    /// Strengths of edges and of points.
    features: [Vec<f64>; 2],
}

impl Seen {
    /// Of a picture of sRGB values, 0 to 1, rows from the top.
    pub fn new(size: [u32; 2], picture: &[[f64; 3]]) -> Self {
        let width = size[0] as usize;
        assert_eq!(picture.len(), width * size[1] as usize);
        let opponent: Vec<DVec3> = picture.iter().map(|&srgb| opponent(to_xyz() * linear(srgb.into()))).collect();
        // 1. Filtered by contrast sensitivity, channel by channel (section 4.1.1).
        let channels = [0, 1, 2].map(|channel| {
            let plane = Plane { width, values: opponent.iter().map(|color| color[channel]).collect() };
            plane.filtered(channel)
        });
        let filtered = |i: usize| DVec3::new(channels[0][i], channels[1][i], channels[2][i]);
        let to_rgb = to_xyz().inverse();
        let adjusted = |i: usize| {
            let rgb = (to_rgb * from_opponent(filtered(i))).clamp(DVec3::ZERO, DVec3::ONE);
            hunt(lab(to_xyz() * rgb))
        };
        let colors = (0..picture.len()).map(adjusted).collect();
        // 2. Edges and points of the luminance (section 4.2).
        let luminance = opponent.iter().map(|color| (color.x + 16.0) / 116.0).collect();
        let luminance = Plane { width, values: luminance };
        let deviation = 0.5 * 0.082 * PIXELS_PER_DEGREE;
        let gauss = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
        let radius = (3.0 * deviation).ceil() as i64;
        let along = |of: &dyn Fn(f64) -> f64| (-radius..=radius).map(|x| of(x as f64)).collect::<Vec<_>>();
        let across = balanced(along(&gauss));
        let edge = balanced(along(&|x| -x * gauss(x)));
        let point = balanced(along(&|x| (x * x / (deviation * deviation) - 1.0) * gauss(x)));
        let features = [edge, point].map(|kernel| {
            let [x, y] = [luminance.convolved(&kernel, &across), luminance.convolved(&across, &kernel)];
            x.iter().zip(&y).map(|(x, y)| x.hypot(*y)).collect()
        });
        Self { width, colors, features }
    }

    /// The difference of each pixel, 0 to 1.
    pub fn difference(&self, other: &Self) -> Vec<f64> {
        assert_eq!((self.width, self.colors.len()), (other.width, other.colors.len()));
        let pixel = |i: usize| {
            let color = redistributed(hyab(self.colors[i], other.colors[i]));
            let change = [0, 1].map(|k| (self.features[k][i] - other.features[k][i]).abs());
            let feature = (change[0].max(change[1]) / 2.0_f64.sqrt()).sqrt();
            color.powf(1.0 - feature)
        };
        (0..self.colors.len()).map(pixel).collect()
    }
}

/// One channel of a picture.
struct Plane {
    width: usize,
    values: Vec<f64>,
}

impl Plane {
    /// By a kernel along x and one along y; what lies beyond the edge is as the edge.
    fn convolved(&self, along_x: &[f64], along_y: &[f64]) -> Vec<f64> {
        let (width, height) = (self.width as i64, (self.values.len() / self.width) as i64);
        let pass = |values: &[f64], kernel: &[f64], step: [i64; 2]| -> Vec<f64> {
            let radius = kernel.len() as i64 / 2;
            let at = |i: i64| {
                let (x, y) = (i % width, i / width);
                let tap = |(k, weight): (usize, &f64)| {
                    let offset = k as i64 - radius;
                    let x = (x + step[0] * offset).clamp(0, width - 1);
                    let y = (y + step[1] * offset).clamp(0, height - 1);
                    weight * values[(y * width + x) as usize]
                };
                kernel.iter().enumerate().map(tap).sum()
            };
            (0..width * height).map(at).collect()
        };
        pass(&pass(&self.values, along_x, [1, 0]), along_y, [0, 1])
    }

    /// By the contrast sensitivity of a channel: sums of Gaussians, table 1.
    fn filtered(&self, channel: usize) -> Vec<f64> {
        let gaussians: &[[f64; 2]] = [&[[1.0, 0.0047]][..], &[[1.0, 0.0053]], &[[34.1, 0.04], [13.5, 0.025]]][channel];
        // Three standard deviations of the widest.
        let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i64;
        let mut sum = vec![0.0; self.values.len()];
        let mut whole = 0.0;
        for [a, b] in gaussians {
            let gauss = |x: i64| (-(PI * x as f64 / PIXELS_PER_DEGREE).powi(2) / b).exp();
            let kernel: Vec<f64> = (-radius..=radius).map(gauss).collect();
            let weight = a * (PI / b).sqrt();
            whole += weight * kernel.iter().sum::<f64>().powi(2);
            let one = self.convolved(&kernel, &kernel);
            sum.iter_mut().zip(one).for_each(|(sum, value)| *sum += weight * value);
        }
        sum.iter().map(|value| value / whole).collect()
    }
}

/// A kernel whose positive weights sum up to 1, and its negative ones to -1.
fn balanced(kernel: Vec<f64>) -> Vec<f64> {
    let positive: f64 = kernel.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f64 = -kernel.iter().filter(|weight| **weight < 0.0).sum::<f64>();
    kernel.iter().map(|&weight| weight / if weight > 0.0 { positive } else { negative.max(1e-300) }).collect()
}

fn linear(srgb: DVec3) -> DVec3 {
    let channel = |c: f64| if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
    DVec3::new(channel(srgb.x), channel(srgb.y), channel(srgb.z))
}

/// CIE XYZ from linear Rec. 709.
fn to_xyz() -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.412_390_799, 0.212_639_006, 0.019_330_819),
        DVec3::new(0.357_584_339, 0.715_168_679, 0.119_194_780),
        DVec3::new(0.180_480_788, 0.072_192_315, 0.950_532_152),
    )
}

fn white() -> DVec3 {
    to_xyz() * DVec3::ONE
}

/// Y Cx Cz: a linear kind of L*a*b*.
fn opponent(xyz: DVec3) -> DVec3 {
    let t = xyz / white();
    DVec3::new(116.0 * t.y - 16.0, 500.0 * (t.x - t.y), 200.0 * (t.y - t.z))
}

fn from_opponent(color: DVec3) -> DVec3 {
    let y = (color.x + 16.0) / 116.0;
    DVec3::new(y + color.y / 500.0, y, y - color.z / 200.0) * white()
}

fn lab(xyz: DVec3) -> DVec3 {
    const DELTA: f64 = 6.0 / 29.0;
    let f = |t: f64| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let t = xyz / white();
    let [x, y, z] = [f(t.x), f(t.y), f(t.z)];
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// Colours look less colourful where it is dark (Hunt 1952; section 4.1.2).
fn hunt(lab: DVec3) -> DVec3 {
    DVec3::new(lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z)
}

/// Distance of large differences (Abasi, Amani Tehran and Fairchild 2020), to the power that the paper takes it to.
fn hyab(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    (d.x.abs() + d.y.hypot(d.z)).powf(0.7)
}

/// The greatest of it: green against blue.
fn greatest() -> f64 {
    hyab(hunt(lab(to_xyz() * DVec3::Y)), hunt(lab(to_xyz() * DVec3::Z)))
}

/// Small differences spread over most of 0 to 1 (section 4.1.3).
fn redistributed(difference: f64) -> f64 {
    let (most, small) = (greatest(), 0.4 * greatest());
    if difference < small { 0.95 / small * difference } else { 0.95 + 0.05 * (difference - small) / (most - small) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(a: &Seen, b: &Seen) -> f64 {
        let all = a.difference(b);
        all.iter().sum::<f64>() / all.len() as f64
    }

    fn even(color: [f64; 3]) -> Seen {
        Seen::new([24, 20], &[color; 480])
    }

    #[test]
    fn even_pictures_differ_as_their_colors_do() {
        // The constant of the authors' implementation.
        assert!((greatest() - 41.2760).abs() < 1e-3, "{}", greatest());
        assert_eq!(mean(&even([0.3, 0.6, 0.2]), &even([0.3, 0.6, 0.2])), 0.0);
        assert!((mean(&even([0.0, 1.0, 0.0]), &even([0.0, 0.0, 1.0])) - 1.0).abs() < 1e-9);
        // Black against white is a difference of 100 in lightness alone.
        let expected = 0.95 + 0.05 * (100.0_f64.powf(0.7) - 0.4 * greatest()) / (0.6 * greatest());
        assert!((mean(&even([0.0; 3]), &even([1.0; 3])) - expected).abs() < 1e-6);
    }

    #[test]
    fn edges_count_more_than_the_same_change_without() {
        let picture = |at: &dyn Fn(usize) -> f64| -> Vec<[f64; 3]> { (0..64 * 32).map(|i| [at(i % 64); 3]).collect() };
        let flat = Seen::new([64, 32], &picture(&|_| 0.5));
        let step = Seen::new([64, 32], &picture(&|x| if x < 32 { 0.5 } else { 0.6 }));
        let at_edge = flat.difference(&step)[16 * 64 + 32];
        let inside = flat.difference(&step)[16 * 64 + 60];
        assert!(at_edge > 1.05 * inside, "{at_edge} {inside}");
        // Detail too fine to be seen is not.
        let fine = Seen::new([64, 32], &picture(&|x| if x % 2 == 0 { 0.45 } else { 0.55 }));
        assert!(mean(&flat, &fine) < 0.5 * mean(&flat, &step), "{} {}", mean(&flat, &fine), mean(&flat, &step));
    }
}

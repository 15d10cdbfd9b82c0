//! PNG, for looking at: tone-mapped, 8 bits, sRGB. Data goes into EXR.

use std::path::Path;
use std::sync::LazyLock;

use glam::Vec3;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};

use super::write_atomically;
use crate::gpu::linear_from_srgb;
use crate::{Error, Result, parallel};

/// Pixels of a picture that one core takes at a time.
pub(super) const BLOCK: usize = 1 << 15;

/// How linear radiance becomes 8 bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PngOptions {
    /// Factor on colours, before the tone curve.
    pub exposure: f32,
    /// Tone curve.
    pub tone_map: ToneMap,
}

impl Default for PngOptions {
    fn default() -> Self {
        Self { exposure: 1.0, tone_map: ToneMap::Neutral }
    }
}

/// A tone curve, from linear Rec. 709 to linear Rec. 709 between 0 and 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Khronos PBR Neutral (*Khronos PBR Neutral Tone Mapper*, 2024): base colours come out as they are, highlights
    /// are compressed and lose saturation.
    #[default]
    Neutral,
    /// What exceeds 1 is 1.
    Clip,
}

impl ToneMap {
    /// Applies the curve. What is negative or not a number counts as 0.
    pub fn apply(self, color: [f32; 3]) -> [f32; 3] {
        // Zero where the comparison says nothing.
        let positive = Vec3::from(color).max(Vec3::ZERO);
        match self {
            Self::Clip => positive.min(Vec3::ONE).to_array(),
            Self::Neutral => neutral(positive.min(Vec3::MAX)).to_array(),
        }
    }
}

/// The specification's function, with its names: `F90` Fresnel offset, `K_S` start of compression, `K_D` desaturation.
fn neutral(color: Vec3) -> Vec3 {
    const F90: f32 = 0.04;
    const K_S: f32 = 0.8 - F90;
    const K_D: f32 = 0.15;
    let least = color.min_element();
    let offset = if least <= 2.0 * F90 { least - least * least / (4.0 * F90) } else { F90 };
    let color = color - offset;
    let peak = color.max_element();
    if peak <= K_S {
        return color;
    }
    let compressed = 1.0 - (1.0 - K_S) * (1.0 - K_S) / (peak + 1.0 - 2.0 * K_S);
    let saturation = 1.0 / (K_D * (peak - compressed) + 1.0);
    color / peak * compressed * saturation + compressed * (1.0 - saturation)
}

/// The exposure that brings the log-average luminance of what is covered (alpha above 0) to 0.18, middle grey
/// (Reinhard et al., *Photographic Tone Reproduction for Digital Images*, 2002, equations 1 and 2); 1 for a black
/// picture. `rgba` is linear Rec. 709.
pub fn auto_exposure(rgba: &[[f32; 4]]) -> f32 {
    const KEY: f64 = 0.18;
    let (mut sum, mut count) = (0.0, 0_u64);
    // Blocks of one size, added in order: the same on any number of cores.
    for (part, pixels) in blocks(rgba, log_luminance) {
        sum += part;
        count += pixels;
    }
    if count == 0 { 1.0 } else { (KEY / (sum / count as f64).exp()) as f32 }
}

/// Sum of the logarithms of the luminances of what is covered, and of how many pixels.
fn log_luminance(rgba: &[[f32; 4]]) -> (f64, u64) {
    let (mut sum, mut count) = (0.0, 0);
    for &[red, green, blue, alpha] in rgba {
        let luminance = 0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue);
        // Black pixels carry no light to expose for; the logarithm would let them decide.
        if alpha > 0.0 && luminance > 0.0 && luminance.is_finite() {
            sum += luminance.ln();
            count += 1;
        }
    }
    (sum, count)
}

/// What `work` makes of each block of pixels, on all cores.
fn blocks<T: Send>(rgba: &[[f32; 4]], work: impl Fn(&[[f32; 4]]) -> T + Sync) -> Vec<T> {
    let blocks: Vec<_> = rgba.chunks(BLOCK).collect();
    // Nothing here can fail; a panic of `work` is one of this thread then.
    let done: std::result::Result<_, ()> = parallel::map(blocks.len(), |index| Ok(work(blocks[index])), |_| ());
    done.unwrap_or_else(|()| blocks.into_iter().map(&work).collect())
}

/// Writes a picture: exposure, tone curve, sRGB transfer function (IEC 61966-2-1), 8 bits. `rgba` is linear Rec. 709,
/// premultiplied, rows from the top; it is laid over black, and the file has no alpha. The file appears whole or not
/// at all.
///
/// # Errors
/// [`Error::Invalid`] where `rgba` has not one element a pixel or the exposure is not positive and finite;
/// [`Error::Io`].
pub fn write_png(path: &Path, size: [u32; 2], rgba: &[[f32; 4]], options: &PngOptions) -> Result<()> {
    let [width, height] = size;
    if width == 0 || height == 0 || rgba.len() as u64 != u64::from(width) * u64::from(height) {
        let why = format!("{width}×{height} pixels need as many colours, and at least one; there are {}", rgba.len());
        return Err(Error::invalid(format!("picture {}", path.display()), why));
    }
    if !(options.exposure.is_finite() && options.exposure > 0.0) {
        return Err(Error::invalid(format!("exposure {}", options.exposure), "it must be positive and finite"));
    }
    let pixels = blocks(rgba, |rgba| to_rgb8(rgba, options)).concat();
    write_atomically(path, |file| {
        PngEncoder::new(file).write_image(&pixels, width, height, ExtendedColorType::Rgb8).map_err(
            |error| match error {
                ImageError::IoError(error) => error,
                other => std::io::Error::other(other),
            },
        )
    })
}

fn to_rgb8(rgba: &[[f32; 4]], options: &PngOptions) -> Vec<u8> {
    let mut pixels = vec![0; 3 * rgba.len()];
    for (to, &[red, green, blue, _]) in pixels.as_chunks_mut().0.iter_mut().zip(rgba) {
        let exposure = options.exposure;
        let [red, green, blue] = options.tone_map.apply([red * exposure, green * exposure, blue * exposure]);
        *to = [to_srgb8(red), to_srgb8(green), to_srgb8(blue)];
    }
    pixels
}

/// IEC 61966-2-1, clamped. What is not a number is 0.
pub(super) fn to_srgb8(linear: f32) -> u8 {
    /// So many that none has two of the steps, of which there are 3294 to 1 where they are closest.
    const CELLS: usize = 4096;
    struct Steps {
        /// The byte of a cell's beginning.
        first: [u8; CELLS],
        /// By byte, the least that is more.
        next: [f32; 256],
    }
    static STEPS: LazyLock<Steps> = LazyLock::new(|| {
        let mut next = [f32::INFINITY; 256];
        for (byte, next) in next.iter_mut().enumerate().take(255) {
            *next = linear_from_srgb((byte as f64 + 0.5) / 255.0) as f32;
        }
        let first = std::array::from_fn(|cell| {
            let begin = cell as f32 / CELLS as f32;
            next.iter().take_while(|&&step| step <= begin).count() as u8
        });
        Steps { first, next }
    });
    if linear >= 1.0 {
        return 255;
    }
    // Casting takes what is less than 0, or not a number, to 0.
    let Steps { first, next } = &*STEPS;
    let byte = first[(linear * CELLS as f32) as usize];
    byte + u8::from(linear >= next[usize::from(byte)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_gets_the_nearest_byte() {
        let exactly = |linear: f64| {
            let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
            encoded * 255.0
        };
        for i in 0..1_000_000 {
            let linear = i as f32 / 1e6;
            let byte = f64::from(to_srgb8(linear));
            assert!((byte - exactly(f64::from(linear))).abs() < 0.5 + 1e-4, "{linear} became {byte}");
        }
        let odd = [-1.0, f32::NAN, f32::NEG_INFINITY, 1.0, f32::INFINITY, 0.999_999_9];
        assert_eq!(odd.map(to_srgb8), [0, 0, 0, 255, 255, 255]);
    }
}

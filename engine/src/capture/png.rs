//! PNG, for looking at: tone-mapped, 8 bits, sRGB. Data goes into EXR.

use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};

use super::write_atomically;
use crate::{Error, Result};

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
        // `max` gives the other operand where one is not a number.
        let color = color.map(|c| c.max(0.0));
        match self {
            Self::Clip => color.map(|c| c.min(1.0)),
            Self::Neutral => neutral(color.map(|c| c.min(f32::MAX))),
        }
    }
}

/// The specification's function, with its names: `F90` Fresnel offset, `K_S` start of compression, `K_D` desaturation.
fn neutral(color: [f32; 3]) -> [f32; 3] {
    const F90: f32 = 0.04;
    const K_S: f32 = 0.8 - F90;
    const K_D: f32 = 0.15;
    let least = color[0].min(color[1]).min(color[2]);
    let offset = if least <= 2.0 * F90 { least - least * least / (4.0 * F90) } else { F90 };
    let color = color.map(|c| c - offset);
    let peak = color[0].max(color[1]).max(color[2]);
    if peak <= K_S {
        return color;
    }
    let compressed = 1.0 - (1.0 - K_S) * (1.0 - K_S) / (peak + 1.0 - 2.0 * K_S);
    let saturation = 1.0 / (K_D * (peak - compressed) + 1.0);
    color.map(|c| c / peak * compressed * saturation + compressed * (1.0 - saturation))
}

/// The exposure that brings the log-average luminance of what is covered (alpha above 0) to 0.18, middle grey
/// (Reinhard et al., *Photographic Tone Reproduction for Digital Images*, 2002, equations 1 and 2); 1 for a black
/// picture. `rgba` is linear Rec. 709.
pub fn auto_exposure(rgba: &[[f32; 4]]) -> f32 {
    const KEY: f64 = 0.18;
    let (mut sum, mut count) = (0.0, 0_u64);
    for &[red, green, blue, alpha] in rgba {
        let luminance = 0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue);
        // Black pixels carry no light to expose for; the logarithm would let them decide.
        if alpha > 0.0 && luminance > 0.0 && luminance.is_finite() {
            sum += luminance.ln();
            count += 1;
        }
    }
    if count == 0 { 1.0 } else { (KEY / (sum / count as f64).exp()) as f32 }
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
    let mut pixels = Vec::with_capacity(3 * rgba.len());
    for &[red, green, blue, _] in rgba {
        let mapped = options.tone_map.apply([red, green, blue].map(|c| c * options.exposure));
        pixels.extend(mapped.map(to_srgb8));
    }
    write_atomically(path, |file| {
        PngEncoder::new(file).write_image(&pixels, width, height, ExtendedColorType::Rgb8).map_err(
            |error| match error {
                ImageError::IoError(error) => error,
                other => std::io::Error::other(other),
            },
        )
    })
}

/// IEC 61966-2-1, clamped.
pub(super) fn to_srgb8(linear: f32) -> u8 {
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

//! What texels read back from an image mean.

use ash::vk;
use half::f16;

use super::Samples;
use crate::{Error, Result};

/// Takes tightly packed texels of a format apart, into one [`Samples`] a component in the order R, G, B, A.
///
/// Half-floats stay half-floats; other floats, normalised and depth formats become 32-bit floats, sRGB decoded;
/// unsigned integers become 32-bit ones.
///
/// # Errors
/// [`Error::Invalid`] where the format is not one of these, or `bytes` is not a whole number of texels.
pub fn unpack(format: vk::Format, bytes: &[u8]) -> Result<Vec<Samples>> {
    use vk::Format as F;
    let unorm8 = |byte: [u8; 1]| f32::from(byte[0]) / 255.0;
    let half: fn([u8; 2]) -> f16 = f16::from_le_bytes;
    let float: fn([u8; 4]) -> f32 = f32::from_le_bytes;
    let uint: fn([u8; 4]) -> u32 = u32::from_le_bytes;
    let short = |bytes| u32::from(u16::from_le_bytes(bytes));
    let byte = |byte: [u8; 1]| u32::from(byte[0]);
    let planes = match format {
        F::R8_UNORM => planes(bytes, 1, unorm8).map(floats),
        F::R8G8_UNORM => planes(bytes, 2, unorm8).map(floats),
        F::R8G8B8A8_UNORM => planes(bytes, 4, unorm8).map(floats),
        F::R8G8B8A8_SRGB => {
            let linear: [f32; 256] = std::array::from_fn(|byte| from_srgb(byte as f32 / 255.0));
            planes(bytes, 4, |byte: [u8; 1]| byte[0]).map(|planes| {
                let decode = |(component, plane): (usize, Vec<u8>)| {
                    // Alpha is linear as it is.
                    let value = |byte: u8| if component < 3 { linear[usize::from(byte)] } else { unorm8([byte]) };
                    plane.into_iter().map(value).collect()
                };
                floats(planes.into_iter().enumerate().map(decode).collect())
            })
        }
        F::R8_UINT => planes(bytes, 1, byte).map(uints),
        F::R16_UINT => planes(bytes, 1, short).map(uints),
        F::R16_UNORM | F::D16_UNORM => {
            planes(bytes, 1, |bytes| f32::from(u16::from_le_bytes(bytes)) / 65535.0).map(floats)
        }
        F::R16_SFLOAT => planes(bytes, 1, half).map(halves),
        F::R16G16_SFLOAT => planes(bytes, 2, half).map(halves),
        F::R16G16B16A16_SFLOAT => planes(bytes, 4, half).map(halves),
        F::R32_UINT => planes(bytes, 1, uint).map(uints),
        F::R32G32_UINT => planes(bytes, 2, uint).map(uints),
        F::R32G32B32A32_UINT => planes(bytes, 4, uint).map(uints),
        F::R32_SFLOAT | F::D32_SFLOAT => planes(bytes, 1, float).map(floats),
        F::R32G32_SFLOAT => planes(bytes, 2, float).map(floats),
        F::R32G32B32A32_SFLOAT => planes(bytes, 4, float).map(floats),
        _ => {
            let why =
                "captures know 8-bit unorm, sRGB and uint, 16-bit float, uint and depth, 32-bit float, uint and depth";
            return Err(Error::invalid(format!("format {format:?}"), why));
        }
    };
    planes.ok_or_else(|| {
        Error::invalid(format!("texels of {format:?}"), format!("{} bytes are no whole number of texels", bytes.len()))
    })
}

/// One vector a component, or `None` where `bytes` does not divide into texels.
fn planes<const N: usize, T: Copy>(
    bytes: &[u8],
    components: usize,
    read: impl Fn([u8; N]) -> T,
) -> Option<Vec<Vec<T>>> {
    if !bytes.len().is_multiple_of(N * components) {
        return None;
    }
    let (scalars, _) = bytes.as_chunks::<N>();
    let plane = |component| scalars.iter().skip(component).step_by(components).map(|&scalar| read(scalar)).collect();
    Some((0..components).map(plane).collect())
}

fn halves(planes: Vec<Vec<f16>>) -> Vec<Samples> {
    planes.into_iter().map(Samples::F16).collect()
}

fn floats(planes: Vec<Vec<f32>>) -> Vec<Samples> {
    planes.into_iter().map(Samples::F32).collect()
}

fn uints(planes: Vec<Vec<u32>>) -> Vec<Samples> {
    planes.into_iter().map(Samples::U32).collect()
}

/// IEC 61966-2-1.
fn from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

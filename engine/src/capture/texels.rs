//! What texels read back from an image mean.

use std::sync::LazyLock;

use ash::vk;
use half::f16;

use super::Samples;
use crate::gpu::linear_from_srgb;
use crate::{Error, Result};

/// Takes tightly packed texels of a format apart, into one [`Samples`] a component in the order R, G, B, A.
///
/// Half-floats stay half-floats; other floats, normalised and depth formats become 32-bit floats, sRGB decoded;
/// unsigned integers become 32-bit ones.
///
/// # Errors
/// [`Error::Invalid`] where the format is not one of these, or `bytes` is not a whole number of texels.
pub fn unpack(format: vk::Format, bytes: &[u8]) -> Result<Vec<Samples>> {
    (0..components(format)?).map(|component| unpack_component(format, bytes, component)).collect()
}

/// How many components a texel of a format has.
pub(super) fn components(format: vk::Format) -> Result<usize> {
    use vk::Format as F;
    match format {
        F::R8_UNORM | F::R8_UINT | F::R16_UINT | F::R16_UNORM | F::D16_UNORM | F::R16_SFLOAT => Ok(1),
        F::R32_UINT | F::R32_SFLOAT | F::D32_SFLOAT => Ok(1),
        F::R8G8_UNORM | F::R16G16_SFLOAT | F::R32G32_UINT | F::R32G32_SFLOAT => Ok(2),
        F::R8G8B8A8_UNORM | F::R8G8B8A8_SRGB => Ok(4),
        F::R16G16B16A16_SFLOAT | F::R32G32B32A32_UINT | F::R32G32B32A32_SFLOAT => Ok(4),
        _ => {
            let why =
                "captures know 8-bit unorm, sRGB and uint, 16-bit float, uint and depth, 32-bit float, uint and depth";
            Err(Error::invalid(format!("format {format:?}"), why))
        }
    }
}

/// Whether all values of a format are from 0 to 1.
pub(super) fn is_normalised(format: vk::Format) -> bool {
    use vk::Format as F;
    matches!(format, F::R8_UNORM | F::R8G8_UNORM | F::R8G8B8A8_UNORM | F::R8G8B8A8_SRGB | F::R16_UNORM | F::D16_UNORM)
}

/// One component of texels, as [`unpack`] gives it.
pub(super) fn unpack_component(format: vk::Format, bytes: &[u8], component: usize) -> Result<Samples> {
    use vk::Format as F;
    let wrong = || {
        let why = format!("{} bytes are no whole number of texels with a component {component}", bytes.len());
        Error::invalid(format!("texels of {format:?}"), why)
    };
    let unorm8 = |byte: [u8; 1]| f32::from(byte[0]) / 255.0;
    // Closures and not functions by name, which would be called through a pointer for each texel.
    let half = |bytes: [u8; 2]| f16::from_le_bytes(bytes);
    let float = |bytes: [u8; 4]| f32::from_le_bytes(bytes);
    let uint = |bytes: [u8; 4]| u32::from_le_bytes(bytes);
    let short = |bytes: [u8; 2]| u32::from(u16::from_le_bytes(bytes));
    let samples = match format {
        F::R8_UNORM => plane::<1, 1, _>(bytes, component, unorm8).map(Samples::F32),
        F::R8G8_UNORM => plane::<1, 2, _>(bytes, component, unorm8).map(Samples::F32),
        // Alpha is linear as it is.
        F::R8G8B8A8_SRGB if component < 3 => {
            static LINEAR: LazyLock<[f32; 256]> =
                LazyLock::new(|| std::array::from_fn(|byte| linear_from_srgb(byte as f64 / 255.0) as f32));
            let linear = &*LINEAR;
            plane::<1, 4, _>(bytes, component, |[byte]| linear[usize::from(byte)]).map(Samples::F32)
        }
        F::R8G8B8A8_UNORM | F::R8G8B8A8_SRGB => plane::<1, 4, _>(bytes, component, unorm8).map(Samples::F32),
        F::R8_UINT => plane::<1, 1, _>(bytes, component, |[byte]| u32::from(byte)).map(Samples::U32),
        F::R16_UINT => plane::<2, 1, _>(bytes, component, short).map(Samples::U32),
        F::R16_UNORM | F::D16_UNORM => {
            plane::<2, 1, _>(bytes, component, |bytes| f32::from(u16::from_le_bytes(bytes)) / 65535.0).map(Samples::F32)
        }
        F::R16_SFLOAT => plane::<2, 1, _>(bytes, component, half).map(Samples::F16),
        F::R16G16_SFLOAT => plane::<2, 2, _>(bytes, component, half).map(Samples::F16),
        F::R16G16B16A16_SFLOAT => plane::<2, 4, _>(bytes, component, half).map(Samples::F16),
        F::R32_UINT => plane::<4, 1, _>(bytes, component, uint).map(Samples::U32),
        F::R32G32_UINT => plane::<4, 2, _>(bytes, component, uint).map(Samples::U32),
        F::R32G32B32A32_UINT => plane::<4, 4, _>(bytes, component, uint).map(Samples::U32),
        F::R32_SFLOAT | F::D32_SFLOAT => plane::<4, 1, _>(bytes, component, float).map(Samples::F32),
        F::R32G32_SFLOAT => plane::<4, 2, _>(bytes, component, float).map(Samples::F32),
        F::R32G32B32A32_SFLOAT => plane::<4, 4, _>(bytes, component, float).map(Samples::F32),
        _ => components(format).map(|_| None)?,
    };
    samples.ok_or_else(wrong)
}

/// One component of texels of `C` components with `N` bytes each, or `None` where `bytes` does not divide into them.
fn plane<const N: usize, const C: usize, T>(
    bytes: &[u8],
    component: usize,
    read: impl Fn([u8; N]) -> T,
) -> Option<Vec<T>> {
    let (scalars, odd) = bytes.as_chunks::<N>();
    let (texels, rest) = scalars.as_chunks::<C>();
    let whole = odd.is_empty() && rest.is_empty() && component < C;
    whole.then(|| texels.iter().map(|texel| read(texel[component])).collect())
}

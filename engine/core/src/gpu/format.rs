//! What the engine knows of texel formats.

use ash::vk;

/// How a format's numbers read in a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Numeric {
    /// Normalised or floating point.
    Float,
    /// Unsigned integer.
    Uint,
    /// Signed integer.
    Sint,
}

/// Size and meaning of a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FormatInfo {
    /// Bytes of a block (of a texel, where it is not compressed). For depth with stencil: of the depth alone, as
    /// a buffer copy lays it out.
    pub block_bytes: u32,
    /// Width and height of a block in texels.
    pub block: [u32; 2],
    /// Aspects.
    pub aspects: vk::ImageAspectFlags,
    /// How its colours or its depth read.
    pub numeric: Numeric,
    /// Components, 1 to 4.
    pub components: u32,
}

impl FormatInfo {
    /// What is known of a format; `None` for those that the engine does not use.
    pub fn of(format: vk::Format) -> Option<FormatInfo> {
        use vk::Format as F;
        let color = |numeric, components, block_bytes| FormatInfo {
            block_bytes,
            block: [1, 1],
            aspects: vk::ImageAspectFlags::COLOR,
            numeric,
            components,
        };
        let depth = |aspects, block_bytes| FormatInfo { aspects, ..color(Numeric::Float, 1, block_bytes) };
        let compressed =
            |components, block_bytes| FormatInfo { block: [4, 4], ..color(Numeric::Float, components, block_bytes) };
        let (d, s) = (vk::ImageAspectFlags::DEPTH, vk::ImageAspectFlags::STENCIL);
        Some(match format {
            F::R8_UNORM | F::R8_SNORM | F::R8_SRGB => color(Numeric::Float, 1, 1),
            F::R8_UINT => color(Numeric::Uint, 1, 1),
            F::R8_SINT => color(Numeric::Sint, 1, 1),
            F::R8G8_UNORM | F::R8G8_SNORM | F::R8G8_SRGB => color(Numeric::Float, 2, 2),
            F::R8G8_UINT => color(Numeric::Uint, 2, 2),
            F::R8G8_SINT => color(Numeric::Sint, 2, 2),
            F::R8G8B8A8_UNORM | F::R8G8B8A8_SNORM | F::R8G8B8A8_SRGB | F::B8G8R8A8_UNORM | F::B8G8R8A8_SRGB => {
                color(Numeric::Float, 4, 4)
            }
            F::R8G8B8A8_UINT => color(Numeric::Uint, 4, 4),
            F::R8G8B8A8_SINT => color(Numeric::Sint, 4, 4),
            F::A2B10G10R10_UNORM_PACK32 | F::A2R10G10B10_UNORM_PACK32 => color(Numeric::Float, 4, 4),
            F::A2B10G10R10_UINT_PACK32 => color(Numeric::Uint, 4, 4),
            F::B10G11R11_UFLOAT_PACK32 | F::E5B9G9R9_UFLOAT_PACK32 => color(Numeric::Float, 3, 4),
            F::R16_UNORM | F::R16_SNORM | F::R16_SFLOAT => color(Numeric::Float, 1, 2),
            F::R16_UINT => color(Numeric::Uint, 1, 2),
            F::R16_SINT => color(Numeric::Sint, 1, 2),
            F::R16G16_UNORM | F::R16G16_SNORM | F::R16G16_SFLOAT => color(Numeric::Float, 2, 4),
            F::R16G16_UINT => color(Numeric::Uint, 2, 4),
            F::R16G16_SINT => color(Numeric::Sint, 2, 4),
            F::R16G16B16A16_UNORM | F::R16G16B16A16_SNORM | F::R16G16B16A16_SFLOAT => color(Numeric::Float, 4, 8),
            F::R16G16B16A16_UINT => color(Numeric::Uint, 4, 8),
            F::R16G16B16A16_SINT => color(Numeric::Sint, 4, 8),
            F::R32_SFLOAT => color(Numeric::Float, 1, 4),
            F::R32_UINT => color(Numeric::Uint, 1, 4),
            F::R32_SINT => color(Numeric::Sint, 1, 4),
            F::R32G32_SFLOAT => color(Numeric::Float, 2, 8),
            F::R32G32_UINT => color(Numeric::Uint, 2, 8),
            F::R32G32_SINT => color(Numeric::Sint, 2, 8),
            F::R32G32B32_SFLOAT => color(Numeric::Float, 3, 12),
            F::R32G32B32_UINT => color(Numeric::Uint, 3, 12),
            F::R32G32B32_SINT => color(Numeric::Sint, 3, 12),
            F::R32G32B32A32_SFLOAT => color(Numeric::Float, 4, 16),
            F::R32G32B32A32_UINT => color(Numeric::Uint, 4, 16),
            F::R32G32B32A32_SINT => color(Numeric::Sint, 4, 16),
            F::R64_UINT => color(Numeric::Uint, 1, 8),
            F::R64_SINT => color(Numeric::Sint, 1, 8),
            F::D16_UNORM => depth(d, 2),
            F::X8_D24_UNORM_PACK32 | F::D32_SFLOAT => depth(d, 4),
            F::D16_UNORM_S8_UINT => depth(d | s, 2),
            F::D24_UNORM_S8_UINT | F::D32_SFLOAT_S8_UINT => depth(d | s, 4),
            F::S8_UINT => FormatInfo { numeric: Numeric::Uint, ..depth(s, 1) },
            F::BC1_RGB_UNORM_BLOCK | F::BC1_RGB_SRGB_BLOCK => compressed(3, 8),
            F::BC1_RGBA_UNORM_BLOCK | F::BC1_RGBA_SRGB_BLOCK => compressed(4, 8),
            F::BC4_UNORM_BLOCK | F::BC4_SNORM_BLOCK => compressed(1, 8),
            F::BC5_UNORM_BLOCK | F::BC5_SNORM_BLOCK => compressed(2, 16),
            F::BC6H_UFLOAT_BLOCK | F::BC6H_SFLOAT_BLOCK => compressed(3, 16),
            F::BC2_UNORM_BLOCK
            | F::BC2_SRGB_BLOCK
            | F::BC3_UNORM_BLOCK
            | F::BC3_SRGB_BLOCK
            | F::BC7_UNORM_BLOCK
            | F::BC7_SRGB_BLOCK => compressed(4, 16),
            _ => return None,
        })
    }

    /// Bytes of a part of one layer, rows packed, of one aspect.
    pub fn bytes(&self, extent: [u32; 3]) -> u64 {
        let blocks = |texels: u32, block: u32| u64::from(texels.div_ceil(block));
        blocks(extent[0], self.block[0])
            * blocks(extent[1], self.block[1])
            * u64::from(extent[2])
            * u64::from(self.block_bytes)
    }

    /// Whether colours are stored with the sRGB curve.
    pub fn is_srgb(format: vk::Format) -> bool {
        format!("{format:?}").contains("SRGB")
    }
}

/// IEC 61966-2-1: light from its encoding, both 0 to 1.
pub fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

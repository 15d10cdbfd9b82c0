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
    pub fn of(_format: vk::Format) -> Option<FormatInfo> {
        unimplemented!()
    }
}

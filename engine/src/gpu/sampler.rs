//! Samplers.

use ash::vk;

use super::Gpu;
use crate::Result;

/// What sampler to make. The default is trilinear, repeating, over all mip levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplerInfo {
    /// Filter where texels are smaller than pixels.
    pub min: vk::Filter,
    /// Filter where texels are larger than pixels.
    pub mag: vk::Filter,
    /// Between mip levels.
    pub mip: vk::SamplerMipmapMode,
    /// Beyond the edges, per axis.
    pub wrap: [vk::SamplerAddressMode; 3],
    /// Comparison of the reference with the texel, for `sampler2DShadow`.
    pub compare: Option<vk::CompareOp>,
    /// Smallest and largest level of detail.
    pub lod: [f32; 2],
    /// Colour beyond the edge with `CLAMP_TO_BORDER`.
    pub border: vk::BorderColor,
    /// Weighted average, or minimum or maximum of the texels ([`super::Feature::SamplerFilterMinmax`]).
    pub reduction: vk::SamplerReductionMode,
}

impl Default for SamplerInfo {
    fn default() -> Self {
        Self {
            min: vk::Filter::LINEAR,
            mag: vk::Filter::LINEAR,
            mip: vk::SamplerMipmapMode::LINEAR,
            wrap: [vk::SamplerAddressMode::REPEAT; 3],
            compare: None,
            lod: [0.0, vk::LOD_CLAMP_NONE],
            border: vk::BorderColor::FLOAT_TRANSPARENT_BLACK,
            reduction: vk::SamplerReductionMode::WEIGHTED_AVERAGE,
        }
    }
}

impl SamplerInfo {
    /// Nearest texel of the nearest level, clamped to the edge.
    pub fn nearest() -> Self {
        Self {
            min: vk::Filter::NEAREST,
            mag: vk::Filter::NEAREST,
            mip: vk::SamplerMipmapMode::NEAREST,
            wrap: [vk::SamplerAddressMode::CLAMP_TO_EDGE; 3],
            ..Self::default()
        }
    }
}

/// A sampler. One exists for each [`SamplerInfo`]; it lives as long as its device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sampler(pub(super) vk::Sampler);

impl Sampler {
    /// The Vulkan handle.
    pub fn raw(self) -> vk::Sampler {
        self.0
    }
}

impl Gpu {
    /// The sampler that does what `info` says.
    ///
    /// # Errors
    /// [`crate::Error::Missing`] for a reduction that the device lacks; [`crate::Error::Vulkan`].
    pub fn sampler(&self, _info: &SamplerInfo) -> Result<Sampler> {
        unimplemented!()
    }
}

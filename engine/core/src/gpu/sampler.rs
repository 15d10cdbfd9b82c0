//! Samplers.

use ash::vk;

use super::{Feature, Gpu, lock};
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
    pub(super) fn key(&self) -> SamplerKey {
        let w = self.wrap.map(|w| w.as_raw());
        SamplerKey(
            [
                self.min.as_raw(),
                self.mag.as_raw(),
                self.mip.as_raw(),
                w[0],
                w[1],
                w[2],
                self.compare.map_or(-1, |c| c.as_raw()),
                self.border.as_raw(),
                self.reduction.as_raw(),
            ],
            self.lod.map(f32::to_bits),
        )
    }

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

/// A [`SamplerInfo`] that can be looked up.
#[derive(PartialEq, Eq, Hash)]
pub(super) struct SamplerKey([i32; 9], [u32; 2]);

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
    pub fn sampler(&self, info: &SamplerInfo) -> Result<Sampler> {
        if info.reduction != vk::SamplerReductionMode::WEIGHTED_AVERAGE {
            self.device.caps.require("a sampler's reduction", &[Feature::SamplerFilterMinmax])?;
        }
        let mut samplers = lock(&self.device.samplers);
        if let Some(&known) = samplers.get(&info.key()) {
            return Ok(Sampler(known));
        }
        let mut reduction = vk::SamplerReductionModeCreateInfo::default().reduction_mode(info.reduction);
        let mut create = vk::SamplerCreateInfo::default()
            .min_filter(info.min)
            .mag_filter(info.mag)
            .mipmap_mode(info.mip)
            .address_mode_u(info.wrap[0])
            .address_mode_v(info.wrap[1])
            .address_mode_w(info.wrap[2])
            .compare_enable(info.compare.is_some())
            .compare_op(info.compare.unwrap_or(vk::CompareOp::ALWAYS))
            .min_lod(info.lod[0])
            .max_lod(info.lod[1])
            .border_color(info.border);
        if info.reduction != vk::SamplerReductionMode::WEIGHTED_AVERAGE {
            create = create.push_next(&mut reduction);
        }
        // SAFETY: a valid structure; the reduction's feature is on.
        let made = unsafe { self.device.raw.create_sampler(&create, None) };
        let made = made.map_err(|e| self.device.error("vkCreateSampler", "a sampler", e))?;
        self.device.name(made, &format!("sampler {:?} {:?} {:?}", info.min, info.wrap[0], info.compare));
        samplers.insert(info.key(), made);
        Ok(Sampler(made))
    }
}

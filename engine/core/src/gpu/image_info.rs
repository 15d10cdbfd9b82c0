//! What images and views are made of.

use ash::vk;

use super::device::Device;
use crate::{Error, Result};

/// What image to make. `..Default::default()` gives one mip level, one layer, one sample.
#[derive(Clone, Copy, Debug)]
pub struct ImageInfo<'a> {
    /// Debug name.
    pub name: &'a str,
    /// Texel format.
    pub format: vk::Format,
    /// Width, height, depth in texels. Three-dimensional where the depth is above 1.
    pub extent: [u32; 3],
    /// Mip levels.
    pub mips: u32,
    /// Array layers.
    pub layers: u32,
    /// Samples a texel.
    pub samples: u32,
    /// What it is used for.
    pub usage: vk::ImageUsageFlags,
    /// Cube views may be made of it: square, layers a multiple of 6.
    pub cube: bool,
    /// Slices of the three-dimensional image may be attachments, as layers of two-dimensional views.
    pub array_2d: bool,
    /// Views may have another format of the same texel size.
    pub mutable_format: bool,
}

impl Default for ImageInfo<'_> {
    fn default() -> Self {
        Self {
            name: "",
            format: vk::Format::UNDEFINED,
            extent: [1; 3],
            mips: 1,
            layers: 1,
            samples: 1,
            usage: vk::ImageUsageFlags::empty(),
            cube: false,
            array_2d: false,
            mutable_format: false,
        }
    }
}

impl ImageInfo<'_> {
    fn kind(&self) -> vk::ImageType {
        if self.extent[2] > 1 { vk::ImageType::TYPE_3D } else { vk::ImageType::TYPE_2D }
    }

    fn flags(&self) -> vk::ImageCreateFlags {
        let mut flags = vk::ImageCreateFlags::empty();
        if self.cube {
            flags |= vk::ImageCreateFlags::CUBE_COMPATIBLE;
        }
        if self.array_2d {
            flags |= vk::ImageCreateFlags::TYPE_2D_ARRAY_COMPATIBLE;
        }
        if self.mutable_format {
            flags |= vk::ImageCreateFlags::MUTABLE_FORMAT;
        }
        flags
    }

    pub(super) fn vulkan(&self) -> vk::ImageCreateInfo<'static> {
        let [width, height, depth] = self.extent;
        vk::ImageCreateInfo::default()
            .image_type(self.kind())
            .format(self.format)
            .extent(vk::Extent3D { width, height, depth })
            .mip_levels(self.mips)
            .array_layers(self.layers)
            .samples(vk::SampleCountFlags::from_raw(self.samples))
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(self.usage)
            .flags(self.flags())
            .initial_layout(vk::ImageLayout::UNDEFINED)
    }

    /// Whether the device can make it.
    pub(super) fn check(&self, device: &Device) -> Result<()> {
        let invalid = |why| Err(Error::invalid(format!("image {:?}", self.name), why));
        let [width, height, depth] = self.extent;
        let largest = width.max(height).max(depth);
        if largest == 0 || width.min(height).min(depth) == 0 || self.mips == 0 || self.layers == 0 {
            return invalid(format!(
                "{:?} texels, {} mips, {} layers: none may be 0",
                self.extent, self.mips, self.layers
            ));
        }
        if self.mips > largest.ilog2() + 1 {
            return invalid(format!("{} mip levels are more than {:?} texels have", self.mips, self.extent));
        }
        if !self.samples.is_power_of_two() || self.usage.is_empty() {
            return invalid(format!("{} samples, usage {:?}: not possible", self.samples, self.usage));
        }
        if self.cube && (width != height || depth != 1 || !self.layers.is_multiple_of(6)) {
            return invalid(format!("{:?} texels and {} layers make no cube", self.extent, self.layers));
        }
        if self.array_2d && depth == 1 {
            return invalid("array_2d is for three-dimensional images".into());
        }
        let query = vk::PhysicalDeviceImageFormatInfo2::default()
            .format(self.format)
            .ty(self.kind())
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(self.usage)
            .flags(self.flags());
        let mut answer = vk::ImageFormatProperties2::default();
        // SAFETY: a plain query.
        let asked = unsafe {
            device.instance.get_physical_device_image_format_properties2(device.physical, &query, &mut answer)
        };
        let Err(result) = asked else {
            let most = answer.image_format_properties;
            let extent = [most.max_extent.width, most.max_extent.height, most.max_extent.depth];
            let fits = self.extent.iter().zip(extent).all(|(&e, m)| e <= m)
                && self.layers <= most.max_array_layers
                && self.mips <= most.max_mip_levels
                && most.sample_counts.as_raw() & self.samples != 0;
            return if fits {
                Ok(())
            } else {
                invalid(format!(
                    "{:?} texels, {} layers, {} mips, {} samples; the device allows {extent:?}, {}, {}, {:?} of {:?} \
                     with {:?}",
                    self.extent,
                    self.layers,
                    self.mips,
                    self.samples,
                    most.max_array_layers,
                    most.max_mip_levels,
                    most.sample_counts,
                    self.format,
                    self.usage
                ))
            };
        };
        match result {
            vk::Result::ERROR_FORMAT_NOT_SUPPORTED => invalid(format!(
                "the device does not support {:?} as {:?} with {:?}, {:?}",
                self.format,
                self.kind(),
                self.usage,
                self.flags()
            )),
            result => Err(device.error("vkGetPhysicalDeviceImageFormatProperties2", self.name, result)),
        }
    }
}

/// What part of an image a view shows, and as what.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ViewInfo {
    /// Two-dimensional, array, cube, …
    pub kind: vk::ImageViewType,
    /// Format; the image's own where it is `UNDEFINED`.
    pub format: vk::Format,
    /// Aspects. A view that is sampled shows one.
    pub aspects: vk::ImageAspectFlags,
    /// `[first, end)` of the mip levels.
    pub mips: [u32; 2],
    /// `[first, end)` of the layers.
    pub layers: [u32; 2],
}

impl ViewInfo {
    /// One mip level only.
    pub fn mip(self, mip: u32) -> Self {
        Self { mips: [mip, mip + 1], ..self }
    }

    /// One layer only, as a plain two-dimensional view.
    pub fn layer(self, layer: u32) -> Self {
        Self { layers: [layer, layer + 1], kind: vk::ImageViewType::TYPE_2D, ..self }
    }

    /// Other aspects.
    pub fn aspects(self, aspects: vk::ImageAspectFlags) -> Self {
        Self { aspects, ..self }
    }

    /// Another kind.
    pub fn kind(self, kind: vk::ImageViewType) -> Self {
        Self { kind, ..self }
    }

    /// Another format, of the same texel size.
    pub fn format(self, format: vk::Format) -> Self {
        Self { format, ..self }
    }

    /// As a barrier's range.
    pub fn range(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange {
            aspect_mask: self.aspects,
            base_mip_level: self.mips[0],
            level_count: self.mips[1].saturating_sub(self.mips[0]),
            base_array_layer: self.layers[0],
            layer_count: self.layers[1].saturating_sub(self.layers[0]),
        }
    }

    /// For debug names.
    pub(super) fn suffix(&self) -> String {
        format!(".view({:?} mips {:?} layers {:?} {:?})", self.kind, self.mips, self.layers, self.aspects)
    }
}

impl super::Gpu {
    /// What images of a format can be used for, with optimal tiling.
    pub fn image_usages(&self, format: vk::Format) -> vk::ImageUsageFlags {
        use vk::FormatFeatureFlags as Feature;
        use vk::ImageUsageFlags as Usage;
        let device = &self.device;
        // SAFETY: a plain query.
        let can = unsafe { device.instance.get_physical_device_format_properties(device.physical, format) };
        let usages = [
            (Feature::SAMPLED_IMAGE, Usage::SAMPLED),
            (Feature::STORAGE_IMAGE, Usage::STORAGE),
            (Feature::COLOR_ATTACHMENT, Usage::COLOR_ATTACHMENT),
            (Feature::COLOR_ATTACHMENT, Usage::INPUT_ATTACHMENT),
            (Feature::DEPTH_STENCIL_ATTACHMENT, Usage::DEPTH_STENCIL_ATTACHMENT),
            (Feature::TRANSFER_SRC, Usage::TRANSFER_SRC),
            (Feature::TRANSFER_DST, Usage::TRANSFER_DST),
        ];
        let all = usages.into_iter().filter(|(feature, _)| can.optimal_tiling_features.contains(*feature));
        all.fold(Usage::empty(), |all, (_, usage)| all | usage)
    }
}

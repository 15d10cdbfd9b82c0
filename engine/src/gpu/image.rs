//! Images and their views.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use ash::vk;
use gpu_allocator::vulkan::Allocation;

use super::device::{Device, Garbage};
use super::{FormatInfo, Gpu, Heap, Memory, lock};
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
        if self.cube && (width != height || depth != 1 || self.layers % 6 != 0) {
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
    fn suffix(&self) -> String {
        format!(".view({:?} mips {:?} layers {:?} {:?})", self.kind, self.mips, self.layers, self.aspects)
    }
}

/// An image with its memory and its views.
#[derive(Clone)]
pub struct Image(Arc<Inner>);

struct Inner {
    device: Arc<Device>,
    id: u64,
    name: String,
    info: ImageInfo<'static>,
    aspects: vk::ImageAspectFlags,
    image: vk::Image,
    /// Whether the image is ours to destroy.
    owned: bool,
    views: Mutex<HashMap<ViewInfo, vk::ImageView>>,
    /// Taken by `Drop`; none where the memory is a heap's or somebody else's.
    allocation: Option<Allocation>,
    /// Dropped after the image was given away.
    _heap: Option<Heap>,
}

impl Image {
    pub(super) fn new(
        device: Arc<Device>,
        info: &ImageInfo,
        image: vk::Image,
        owned: bool,
        allocation: Option<Allocation>,
        heap: Option<Heap>,
    ) -> Self {
        device.name(image, info.name);
        Self(Arc::new(Inner {
            id: device.register("image", info.name),
            name: info.name.into(),
            info: ImageInfo { name: "", ..*info },
            aspects: FormatInfo::of(info.format).map_or(vk::ImageAspectFlags::COLOR, |f| f.aspects),
            image,
            owned,
            views: Mutex::default(),
            allocation,
            _heap: heap,
            device,
        }))
    }

    /// The Vulkan handle.
    pub fn raw(&self) -> vk::Image {
        self.0.image
    }

    /// Debug name.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// How it was made.
    pub fn info(&self) -> ImageInfo<'_> {
        ImageInfo { name: &self.0.name, ..self.0.info }
    }

    /// Every aspect of its format.
    pub fn aspects(&self) -> vk::ImageAspectFlags {
        self.0.aspects
    }

    /// Width, height, depth of a mip level.
    pub fn mip_extent(&self, mip: u32) -> [u32; 3] {
        self.0.info.extent.map(|e| (e >> mip.min(31)).max(1))
    }

    /// A view's description that shows all mips, all layers, all aspects: 3D, cube or cube array where it was made
    /// for that, else 2D or, with several layers, 2D array.
    pub fn whole(&self) -> ViewInfo {
        let info = &self.0.info;
        let kind = if info.extent[2] > 1 {
            vk::ImageViewType::TYPE_3D
        } else if info.cube && info.layers > 6 {
            vk::ImageViewType::CUBE_ARRAY
        } else if info.cube {
            vk::ImageViewType::CUBE
        } else if info.layers > 1 {
            vk::ImageViewType::TYPE_2D_ARRAY
        } else {
            vk::ImageViewType::TYPE_2D
        };
        ViewInfo {
            kind,
            format: vk::Format::UNDEFINED,
            aspects: self.0.aspects,
            mips: [0, info.mips],
            layers: [0, info.layers],
        }
    }

    /// The whole as a barrier's range.
    pub fn range(&self) -> vk::ImageSubresourceRange {
        self.whole().range()
    }

    /// A view, made at its first use and kept as long as the image.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the part is not in the image; [`crate::Error::Vulkan`].
    pub fn view(&self, view: &ViewInfo) -> Result<vk::ImageView> {
        let mut views = lock(&self.0.views);
        if let Some(&known) = views.get(view) {
            return Ok(known);
        }
        self.check_view(view)?;
        let format = if view.format == vk::Format::UNDEFINED { self.0.info.format } else { view.format };
        // A view in another format need not allow all that the image does: sRGB views cannot be stored to.
        let mut usage =
            vk::ImageViewUsageCreateInfo::default().usage(self.0.info.usage & !vk::ImageUsageFlags::STORAGE);
        let mut info = vk::ImageViewCreateInfo::default()
            .image(self.0.image)
            .view_type(view.kind)
            .format(format)
            .subresource_range(view.range());
        if FormatInfo::is_srgb(format) {
            info = info.push_next(&mut usage);
        }
        // SAFETY: a live image, a part of it, a compatible format.
        let made = unsafe { self.0.device.raw.create_image_view(&info, None) };
        let made = made.map_err(|e| self.0.device.error("vkCreateImageView", &self.0.name, e))?;
        self.0.device.name(made, &format!("{}{}", self.0.name, view.suffix()));
        views.insert(*view, made);
        Ok(made)
    }

    fn check_view(&self, view: &ViewInfo) -> Result<()> {
        let info = &self.0.info;
        let slices = matches!(view.kind, vk::ImageViewType::TYPE_2D | vk::ImageViewType::TYPE_2D_ARRAY);
        let layers = if info.array_2d && slices { self.mip_extent(view.mips[0])[2] } else { info.layers };
        let inside = |[first, end]: [u32; 2], count| first < end && end <= count;
        let count = view.layers[1].saturating_sub(view.layers[0]);
        let fitting = match view.kind {
            vk::ImageViewType::TYPE_2D | vk::ImageViewType::TYPE_3D => count == 1,
            vk::ImageViewType::CUBE => info.cube && count == 6,
            vk::ImageViewType::CUBE_ARRAY => info.cube && count % 6 == 0,
            _ => true,
        };
        let why = if !inside(view.mips, info.mips) {
            format!("mip levels {:?} are not in its {}", view.mips, info.mips)
        } else if !inside(view.layers, layers) {
            format!("layers {:?} are not in its {layers}", view.layers)
        } else if !fitting {
            format!("{count} layers make no {:?} view of it", view.kind)
        } else if view.aspects.is_empty() || !self.0.aspects.contains(view.aspects) {
            format!("it has the aspects {:?}, not {:?}", self.0.aspects, view.aspects)
        } else if view.format != vk::Format::UNDEFINED && view.format != info.format && !info.mutable_format {
            format!("a view as {:?} needs mutable_format, it is {:?}", view.format, info.format)
        } else {
            return Ok(());
        };
        Err(self.invalid(why))
    }

    pub(super) fn is_of(&self, device: &Arc<Device>) -> bool {
        Arc::ptr_eq(&self.0.device, device)
    }

    pub(super) fn invalid(&self, why: impl Into<String>) -> Error {
        Error::invalid(format!("image {:?}", self.0.name), why)
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        self.device.forget(self.id);
        let views = lock(&self.views).drain().map(|v| v.1).collect();
        let image = self.owned.then_some(self.image);
        self.device.defer(Garbage::Image { image, views, allocation: self.allocation.take() });
    }
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Image({:?}, {:?}, {:?})", self.0.name, self.0.info.format, self.0.info.extent)
    }
}

impl Device {
    /// Makes an image without memory.
    pub(super) fn make_image(&self, info: &ImageInfo) -> Result<vk::Image> {
        // SAFETY: a structure that was checked for this device.
        unsafe { self.raw.create_image(&info.vulkan(), None) }.map_err(|e| self.error("vkCreateImage", info.name, e))
    }
}

impl Gpu {
    /// Makes an image in device memory. Its contents are undefined and its layout is `UNDEFINED`.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the device does not support format, usage and size together;
    /// [`crate::Error::OutOfMemory`].
    pub fn create_image(&self, info: &ImageInfo) -> Result<Image> {
        info.check(&self.device)?;
        let device = &self.device;
        let image = device.make_image(info)?;
        // SAFETY: the image was just made.
        let requirements = unsafe { device.raw.get_image_memory_requirements(image) };
        let mut owned = None;
        let bound = device.allocate(info.name, requirements, Memory::Device, false).and_then(|allocation| {
            // SAFETY: memory that satisfies the image's requirements and is its own.
            let bound = unsafe { device.raw.bind_image_memory(image, allocation.memory(), allocation.offset()) };
            owned = Some(allocation);
            bound.map_err(|e| device.error("vkBindImageMemory", info.name, e))
        });
        if let Err(e) = bound {
            device.destroy(Garbage::Image { image: Some(image), views: Vec::new(), allocation: owned });
            return Err(e);
        }
        Ok(Image::new(device.clone(), info, image, true, owned, None))
    }

    /// Takes in an image of the application's. It is not destroyed at the end; its views are.
    ///
    /// # Safety
    /// `raw` was made on this device as `info` says and outlives the returned object and the device's work on it.
    pub unsafe fn import_image(&self, raw: vk::Image, info: &ImageInfo) -> Image {
        Image::new(self.device.clone(), info, raw, false, None, None)
    }
}

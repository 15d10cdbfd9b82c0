//! Images and their views.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use ash::vk;
use gpu_allocator::vulkan::Allocation;

use super::device::{Device, Garbage};
use super::{FormatInfo, Gpu, Heap, ImageInfo, Memory, ViewInfo, lock};
use crate::{Error, Result};

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

    /// A number that no other object of its device ever has.
    pub(super) fn id(&self) -> u64 {
        self.0.id
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
            vk::ImageViewType::TYPE_2D => count == 1,
            vk::ImageViewType::TYPE_3D => count == 1 && info.extent[2] > 1,
            vk::ImageViewType::CUBE => info.cube && count == 6,
            vk::ImageViewType::CUBE_ARRAY => info.cube && count.is_multiple_of(6),
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

    /// Whether it is of this device.
    pub(crate) fn is_from(&self, gpu: &super::Gpu) -> bool {
        self.is_of(&gpu.device)
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

//! Images and their views.

use ash::vk;

use super::{Gpu, Memory};
use crate::Result;

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
}

/// An image with its memory and its views.
#[derive(Clone)]
pub struct Image {}

impl Image {
    /// The Vulkan handle.
    pub fn raw(&self) -> vk::Image {
        unimplemented!()
    }

    /// Debug name.
    pub fn name(&self) -> &str {
        unimplemented!()
    }

    /// How it was made.
    pub fn info(&self) -> ImageInfo<'_> {
        unimplemented!()
    }

    /// Every aspect of its format.
    pub fn aspects(&self) -> vk::ImageAspectFlags {
        unimplemented!()
    }

    /// A view's description that shows all mips, all layers, all aspects: 3D, cube or cube array where it was made
    /// for that, else 2D or, with several layers, 2D array.
    pub fn whole(&self) -> ViewInfo {
        unimplemented!()
    }

    /// The whole as a barrier's range.
    pub fn range(&self) -> vk::ImageSubresourceRange {
        unimplemented!()
    }

    /// A view, made at its first use and kept as long as the image.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the part is not in the image; [`crate::Error::Vulkan`].
    pub fn view(&self, _info: &ViewInfo) -> Result<vk::ImageView> {
        unimplemented!()
    }
}

impl Gpu {
    /// Makes an image in device memory. Its contents are undefined and its layout is `UNDEFINED`.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the device does not support format, usage and size together;
    /// [`crate::Error::OutOfMemory`].
    pub fn create_image(&self, _info: &ImageInfo) -> Result<Image> {
        let _ = Memory::Device;
        unimplemented!()
    }

    /// Takes in an image of the application's. It is not destroyed at the end; its views are.
    ///
    /// # Safety
    /// `raw` was made on this device as `info` says and outlives the returned object.
    pub unsafe fn import_image(&self, _raw: vk::Image, _info: &ImageInfo) -> Image {
        unimplemented!()
    }
}

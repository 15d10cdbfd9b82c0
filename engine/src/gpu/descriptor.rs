//! Descriptor sets.

use ash::vk;

use super::{Buffer, Gpu, Image, Pipeline, Sampler, ViewInfo};
use crate::Result;
use crate::shader::Shader;

/// What a binding points at.
#[derive(Clone)]
pub enum Descriptor {
    /// A uniform or storage buffer: bytes `[offset, offset + size)`.
    Buffer {
        /// The buffer.
        buffer: Buffer,
        /// First byte; a multiple of the device's alignment for such buffers.
        offset: u64,
        /// Bytes; `vk::WHOLE_SIZE` for the rest.
        size: u64,
    },
    /// A sampled or storage image.
    Image {
        /// The image.
        image: Image,
        /// The part.
        view: ViewInfo,
        /// Layout it will be in.
        layout: vk::ImageLayout,
    },
    /// A combined image sampler.
    Sampled {
        /// The image.
        image: Image,
        /// The part.
        view: ViewInfo,
        /// Layout it will be in.
        layout: vk::ImageLayout,
        /// The sampler.
        sampler: Sampler,
    },
    /// A sampler.
    Sampler(Sampler),
}

impl Descriptor {
    /// A whole buffer.
    pub fn buffer(buffer: &Buffer) -> Self {
        Self::Buffer { buffer: buffer.clone(), offset: 0, size: vk::WHOLE_SIZE }
    }

    /// A whole image in `SHADER_READ_ONLY_OPTIMAL`, with a sampler.
    pub fn texture(image: &Image, sampler: Sampler) -> Self {
        Self::Sampled {
            image: image.clone(),
            view: image.whole(),
            layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
            sampler,
        }
    }

    /// A whole image (its first mip level) for loads and stores, in `GENERAL`.
    pub fn storage(image: &Image) -> Self {
        Self::Image { image: image.clone(), view: image.whole().mip(0), layout: vk::ImageLayout::GENERAL }
    }
}

/// Layout of one descriptor set. Equal contents are one Vulkan object.
#[derive(Clone)]
pub struct SetLayout {}

impl SetLayout {
    /// The Vulkan handle.
    pub fn raw(&self) -> vk::DescriptorSetLayout {
        unimplemented!()
    }
}

/// A long-lived descriptor set. It keeps alive what it points at.
#[derive(Clone)]
pub struct DescriptorSet {}

impl DescriptorSet {
    /// The Vulkan handle.
    pub fn raw(&self) -> vk::DescriptorSet {
        unimplemented!()
    }
}

/// Descriptor sets that live for one frame: allocated one by one, given back together.
pub struct DescriptorArena {}

impl DescriptorArena {
    /// A set with every binding of `pipeline`'s set number `set`; as [`Gpu::descriptor_set`]. It is valid until the
    /// next `reset`, and until then what it points at is kept.
    ///
    /// # Errors
    /// As [`Gpu::descriptor_set`].
    pub fn set(
        &mut self,
        _pipeline: &Pipeline,
        _set: u32,
        _descriptors: &[(u32, Descriptor)],
    ) -> Result<vk::DescriptorSet> {
        unimplemented!()
    }

    /// Gives all sets back. The device must be done with them.
    pub fn reset(&mut self) {
        unimplemented!()
    }
}

impl Gpu {
    /// The layout of set number `set` that fits all of these shaders: for a set (a material's) that pipelines with
    /// different shaders share; give it to each of them in [`super::GraphicsPipelineInfo::set_layouts`].
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] naming both files where two shaders disagree about a binding.
    pub fn set_layout(&self, _set: u32, _shaders: &[&'static Shader]) -> Result<SetLayout> {
        unimplemented!()
    }

    /// A long-lived set for set number `set` of `pipeline` and of every pipeline with the same layout there.
    /// `descriptors` are by binding number; an array takes as many entries as it has elements, in order.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] naming the bindings that were not given (none may stay unwritten: a driver may
    /// crash), are not there, or are of another kind.
    pub fn descriptor_set(
        &self,
        _name: &str,
        _pipeline: &Pipeline,
        _set: u32,
        _descriptors: &[(u32, Descriptor)],
    ) -> Result<DescriptorSet> {
        unimplemented!()
    }

    /// As [`Gpu::descriptor_set`], from a layout.
    ///
    /// # Errors
    /// As [`Gpu::descriptor_set`].
    pub fn descriptor_set_of(
        &self,
        _name: &str,
        _layout: &SetLayout,
        _descriptors: &[(u32, Descriptor)],
    ) -> Result<DescriptorSet> {
        unimplemented!()
    }

    /// An arena for the sets of one frame.
    pub fn descriptor_arena(&self, _name: &str) -> DescriptorArena {
        unimplemented!()
    }
}

//! Kinds of memory, requirements, and heaps that resources are placed in by hand.

use super::{Buffer, BufferInfo, Gpu, Image, ImageInfo};
use crate::Result;

/// Who reads and writes the memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Memory {
    /// The device only.
    #[default]
    Device,
    /// The host writes, the device reads. Mapped and coherent.
    Upload,
    /// The device writes, the host reads. Mapped and coherent; cached where the device has such memory.
    Readback,
}

/// What a resource asks of the memory it lies in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Requirements {
    /// Bytes.
    pub size: u64,
    /// The offset's divisor, in bytes.
    pub alignment: u64,
    /// Bit `i` set: memory type `i` will do.
    pub type_bits: u32,
}

impl Requirements {
    /// What memory must satisfy that holds both, one over the other: the larger size and alignment, the types that
    /// both allow (possibly none).
    pub fn union(self, other: Requirements) -> Requirements {
        Requirements {
            size: self.size.max(other.size),
            alignment: self.alignment.max(other.alignment),
            type_bits: self.type_bits & other.type_bits,
        }
    }
}

/// One allocation that images and buffers are placed in at chosen offsets, and may overlap in.
#[derive(Clone)]
pub struct Heap {}

impl Heap {
    /// Its name.
    pub fn name(&self) -> &str {
        unimplemented!()
    }

    /// Bytes.
    pub fn size(&self) -> u64 {
        unimplemented!()
    }
}

impl Gpu {
    /// What memory an image would ask for. Makes no image.
    pub fn image_requirements(&self, _info: &ImageInfo) -> Requirements {
        unimplemented!()
    }

    /// What memory a buffer would ask for. Makes no buffer.
    pub fn buffer_requirements(&self, _info: &BufferInfo) -> Requirements {
        unimplemented!()
    }

    /// Allocates memory to place resources in. Its start is aligned to `requirements.alignment` and to
    /// [`super::Limits::buffer_image_granularity`].
    ///
    /// # Errors
    /// [`crate::Error::OutOfMemory`], also where no memory type fits.
    pub fn create_heap(&self, _name: &str, _requirements: Requirements, _memory: Memory) -> Result<Heap> {
        unimplemented!()
    }

    /// Makes an image at `offset` bytes of a heap. Its contents are undefined, again after a resource that overlaps
    /// it was written. It keeps the heap alive.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where it does not fit or is misaligned; [`crate::Error::Vulkan`].
    pub fn place_image(&self, _heap: &Heap, _offset: u64, _info: &ImageInfo) -> Result<Image> {
        unimplemented!()
    }

    /// Makes a buffer at `offset` bytes of a heap; as [`Gpu::place_image`]. `info.memory` is not looked at.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where it does not fit or is misaligned; [`crate::Error::Vulkan`].
    pub fn place_buffer(&self, _heap: &Heap, _offset: u64, _info: &BufferInfo) -> Result<Buffer> {
        unimplemented!()
    }
}

//! Kinds of memory, requirements, and heaps that resources are placed in by hand.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::device::{Device, Garbage, RawBuffer};
use super::{Buffer, BufferInfo, Gpu, Image, ImageInfo};
use crate::{Error, Result};

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

impl Memory {
    pub(super) fn location(self) -> MemoryLocation {
        match self {
            Memory::Device => MemoryLocation::GpuOnly,
            Memory::Upload => MemoryLocation::CpuToGpu,
            Memory::Readback => MemoryLocation::GpuToCpu,
        }
    }
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

    fn from_vulkan(r: vk::MemoryRequirements) -> Self {
        Self { size: r.size, alignment: r.alignment, type_bits: r.memory_type_bits }
    }
}

/// One allocation that images and buffers are placed in at chosen offsets, and may overlap in.
#[derive(Clone)]
pub struct Heap(Arc<Inner>);

struct Inner {
    device: Arc<Device>,
    id: u64,
    name: String,
    requirements: Requirements,
    /// Taken by `Drop`.
    allocation: Option<Allocation>,
    memory: vk::DeviceMemory,
    offset: u64,
}

impl Heap {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Bytes.
    pub fn size(&self) -> u64 {
        self.0.requirements.size
    }

    /// Where in the device's memory a resource with these requirements lies at `offset`.
    fn place(&self, what: &str, offset: u64, needs: Requirements) -> Result<(vk::DeviceMemory, u64)> {
        let has = self.0.requirements;
        let why = if !offset.is_multiple_of(needs.alignment) {
            format!("offset {offset} is no multiple of {}", needs.alignment)
        } else if !self.0.offset.is_multiple_of(needs.alignment) {
            format!("the heap is aligned to {}, not to {}", has.alignment, needs.alignment)
        } else if offset.checked_add(needs.size).is_none_or(|end| end > has.size) {
            format!("{} bytes at {offset} do not fit into {}", needs.size, has.size)
        } else if has.type_bits & !needs.type_bits != 0 {
            format!("the heap is of memory types {:#b}, it can lie in {:#b}", has.type_bits, needs.type_bits)
        } else {
            return Ok((self.0.memory, self.0.offset + offset));
        };
        Err(Error::invalid(format!("{what} in heap {:?}", self.0.name), why))
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        self.device.forget(self.id);
        if let Some(allocation) = self.allocation.take() {
            self.device.defer(Garbage::Memory(allocation));
        }
    }
}

impl std::fmt::Debug for Heap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Heap({:?}, {} bytes)", self.0.name, self.0.requirements.size)
    }
}

impl Gpu {
    /// What memory an image would ask for. Makes no image.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the device does not support format, usage and size together.
    pub fn image_requirements(&self, info: &ImageInfo) -> Result<Requirements> {
        info.check(&self.device)?;
        let create = info.vulkan();
        let query = vk::DeviceImageMemoryRequirements::default().create_info(&create);
        let mut answer = vk::MemoryRequirements2::default();
        // SAFETY: a structure that was checked for this device.
        unsafe { self.device.raw.get_device_image_memory_requirements(&query, &mut answer) };
        Ok(Requirements::from_vulkan(answer.memory_requirements))
    }

    /// What memory a buffer would ask for. Makes no buffer.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] for a size of 0 or beyond the device's limit.
    pub fn buffer_requirements(&self, info: &BufferInfo) -> Result<Requirements> {
        info.check(&self.device)?;
        let create = info.vulkan();
        let query = vk::DeviceBufferMemoryRequirements::default().create_info(&create);
        let mut answer = vk::MemoryRequirements2::default();
        // SAFETY: a structure that was checked for this device.
        unsafe { self.device.raw.get_device_buffer_memory_requirements(&query, &mut answer) };
        Ok(Requirements::from_vulkan(answer.memory_requirements))
    }

    /// Allocates memory to place resources in. Its start is aligned to `requirements.alignment` and to
    /// [`super::Limits::buffer_image_granularity`].
    ///
    /// # Errors
    /// [`crate::Error::OutOfMemory`], also where no memory type fits.
    pub fn create_heap(&self, name: &str, requirements: Requirements, memory: Memory) -> Result<Heap> {
        if requirements.size == 0 || !requirements.alignment.is_power_of_two() {
            let why = format!("it needs a size and an alignment of a power of two, not {requirements:?}");
            return Err(Error::invalid(format!("heap {name:?}"), why));
        }
        // Whole pages, so that no neighbour of the other kind (linear, optimal) shares one.
        let page = self.device.caps.limits.buffer_image_granularity.max(1);
        let asked = vk::MemoryRequirements {
            size: requirements.size.next_multiple_of(page),
            alignment: requirements.alignment.max(page),
            memory_type_bits: requirements.type_bits,
        };
        let allocation = self.device.allocate(name, asked, memory, false)?;
        // SAFETY: the handle is only stored; the allocation outlives it.
        let handle = unsafe { allocation.memory() };
        Ok(Heap(Arc::new(Inner {
            id: self.device.register("heap", name),
            name: name.into(),
            requirements: Requirements { alignment: asked.alignment, ..requirements },
            memory: handle,
            offset: allocation.offset(),
            allocation: Some(allocation),
            device: self.device.clone(),
        })))
    }

    /// Makes an image at `offset` bytes of a heap. Its contents are undefined, again after a resource that overlaps
    /// it was written. It keeps the heap alive.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where it does not fit or is misaligned; [`crate::Error::Vulkan`].
    pub fn place_image(&self, heap: &Heap, offset: u64, info: &ImageInfo) -> Result<Image> {
        let needs = self.image_requirements(info)?;
        let (memory, at) = heap.place(&format!("image {:?}", info.name), offset, needs)?;
        let image = self.device.make_image(info)?;
        // SAFETY: the part of the memory satisfies the image's requirements.
        if let Err(e) = unsafe { self.device.raw.bind_image_memory(image, memory, at) } {
            self.device.destroy(Garbage::Image { image: Some(image), views: Vec::new(), allocation: None });
            return Err(self.device.error("vkBindImageMemory", info.name, e));
        }
        Ok(Image::new(self.device.clone(), info, image, true, None, Some(heap.clone())))
    }

    /// Makes a buffer at `offset` bytes of a heap; as [`Gpu::place_image`]. `info.memory` is not looked at, and the
    /// buffer is not mapped.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where it does not fit or is misaligned; [`crate::Error::Vulkan`].
    pub fn place_buffer(&self, heap: &Heap, offset: u64, info: &BufferInfo) -> Result<Buffer> {
        let needs = self.buffer_requirements(info)?;
        let (memory, at) = heap.place(&format!("buffer {:?}", info.name), offset, needs)?;
        // SAFETY: a structure that was checked.
        let buffer = unsafe { self.device.raw.create_buffer(&info.vulkan(), None) };
        let buffer = buffer.map_err(|e| self.device.error("vkCreateBuffer", info.name, e))?;
        let raw = RawBuffer { buffer, allocation: None };
        // SAFETY: the part of the memory satisfies the buffer's requirements.
        if let Err(e) = unsafe { self.device.raw.bind_buffer_memory(buffer, memory, at) } {
            self.device.destroy(Garbage::Buffer(raw));
            return Err(self.device.error("vkBindBufferMemory", info.name, e));
        }
        self.device.name(buffer, info.name);
        Ok(Buffer::new(self.device.clone(), info, raw, Some(heap.clone())))
    }
}

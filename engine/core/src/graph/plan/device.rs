//! What planning asks of a device. Plans are tested with made-up ones.

use ash::vk;

use crate::graph::description::{Queue, Shape};

/// A device, as far as planning is concerned.
pub trait DeviceModel {
    /// Queue family that work of this kind is submitted to; `None` where the device has no such queue and
    /// [`Queue::Graphics`] does the work. Graphics work always has a family.
    ///
    /// Two kinds of the same family are two queues of it: they need semaphores but no ownership transfers.
    fn family(&self, queue: Queue) -> Option<u32>;

    /// Memory that a resource of this shape takes when it is made with these usages.
    fn requirements(&self, shape: &Shape, usage: Usage) -> Requirements;

    /// `bufferImageGranularity`: a buffer and an image never share a block of so many bytes. At least 1.
    fn granularity(&self) -> u64;

    /// Image usages that the format allows with optimal tiling.
    fn image_usages(&self, _format: vk::Format) -> vk::ImageUsageFlags {
        vk::ImageUsageFlags::from_raw(!0)
    }
}

/// Everything that a resource is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Usage {
    /// Of an image.
    Image(vk::ImageUsageFlags),
    /// Of a buffer.
    Buffer(vk::BufferUsageFlags),
}

/// Memory that a resource takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Requirements {
    /// Bytes.
    pub size: u64,
    /// Its offset is a multiple of this. At least 1.
    pub alignment: u64,
    /// Bit `i`: memory type `i` will do, narrowed by the device model to those it would choose from.
    pub type_bits: u32,
}

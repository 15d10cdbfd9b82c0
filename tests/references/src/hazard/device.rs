//! Devices that do not exist.

use ash::vk;
use shadowgraph::graph::description::{Queue, Shape};
use shadowgraph::graph::plan::{DeviceModel, Requirements, Usage};

/// A device with chosen queue families and rules of memory.
#[derive(Clone, Debug)]
pub struct MadeUpDevice {
    /// Families of graphics, compute and transfer queues.
    pub families: [Option<u32>; 3],
    /// `bufferImageGranularity`.
    pub granularity: u64,
    /// `maxMemoryAllocationSize`.
    pub most_at_once: u64,
    /// Alignment of images.
    pub image_alignment: u64,
    /// Alignment of buffers.
    pub buffer_alignment: u64,
    /// Memory types of colour images, of depth images, and of buffers.
    pub type_bits: [u32; 3],
    /// Image usages that are not allowed, by format.
    pub forbidden: Vec<(vk::Format, vk::ImageUsageFlags)>,
}

impl MadeUpDevice {
    /// One queue and one kind of memory, like a software driver.
    pub fn one_queue() -> Self {
        Self {
            families: [Some(0), None, None],
            most_at_once: u64::MAX,
            granularity: 1,
            image_alignment: 256,
            buffer_alignment: 16,
            type_bits: [1; 3],
            forbidden: Vec::new(),
        }
    }

    /// Graphics and asynchronous compute.
    pub fn two_queues() -> Self {
        Self { families: [Some(0), Some(1), None], ..Self::one_queue() }
    }

    /// Graphics, asynchronous compute and transfer.
    pub fn three_queues() -> Self {
        Self { families: [Some(0), Some(2), Some(1)], ..Self::one_queue() }
    }
}

impl DeviceModel for MadeUpDevice {
    fn family(&self, queue: Queue) -> Option<u32> {
        self.families[queue as usize]
    }

    /// Four bytes a texel, all mips as large as the first; whole multiples of the alignment, as drivers say.
    fn requirements(&self, shape: &Shape, _usage: Usage) -> Requirements {
        match shape {
            Shape::Image(shape) => {
                let [width, height, depth] = shape.extent;
                let texels = u64::from(width).saturating_mul(height.into()).saturating_mul(depth.into());
                let depth = !shape.aspects().contains(vk::ImageAspectFlags::COLOR);
                let factors = [4, shape.layers, shape.mips, shape.samples].map(u64::from);
                let size = factors.iter().fold(texels, |size, &factor| size.saturating_mul(factor));
                Requirements {
                    size: size.checked_next_multiple_of(self.image_alignment).unwrap_or(u64::MAX),
                    alignment: self.image_alignment,
                    type_bits: self.type_bits[usize::from(depth)],
                }
            }
            Shape::Buffer { size } => {
                Requirements { size: *size, alignment: self.buffer_alignment, type_bits: self.type_bits[2] }
            }
        }
    }

    fn granularity(&self) -> u64 {
        self.granularity
    }

    fn most_at_once(&self) -> u64 {
        self.most_at_once
    }

    fn image_usages(&self, format: vk::Format) -> vk::ImageUsageFlags {
        let all = vk::ImageUsageFlags::from_raw(!0);
        let forbidden = self.forbidden.iter().filter(|(other, _)| *other == format);
        forbidden.fold(all, |all, (_, usage)| all & !*usage)
    }
}

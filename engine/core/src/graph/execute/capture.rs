//! Reading contents back.

use ash::vk;

use super::resources::Resources;
use crate::gpu::{Buffer, BufferInfo, Commands, FormatInfo, Gpu, Memory};
use crate::graph::description::{Description, ImageShape, Range, Root, Shape};
use crate::graph::record;
use crate::{Error, Result};

/// Contents read back. Clones share them.
#[derive(Clone)]
pub struct Capture {
    /// Name given to [`crate::graph::Graph::capture`].
    pub name: String,
    /// Image (of the captured mips and layers) or buffer.
    pub shape: Shape,
    buffer: Buffer,
    /// Where each mip of each layer begins: layers of a mip lie side by side.
    mips: Vec<u64>,
    layer_sizes: Vec<u64>,
}

impl Capture {
    /// With a host buffer for a root.
    pub(super) fn new(gpu: &Gpu, kept: &mut HostBuffers, description: &Description, root: &Root) -> Result<Self> {
        let version = &description.versions[root.version.0 as usize];
        let resource = &description.resources[version.resource.0 as usize];
        let (shape, mips, layer_sizes, size) = captured_layout(&resource.shape, version.range);
        let buffer = kept.buffer(gpu, &format!("capture {}", root.name), size)?;
        Ok(Self { name: root.name.clone(), shape, buffer, mips, layer_sizes })
    }

    /// Has its memory ready before the device gets there.
    pub(super) fn populate(&self) {
        self.buffer.populate();
    }

    /// Looks at all bytes: mips one after the other, in each its layers, rows from the top, tightly packed.
    ///
    /// # Errors
    /// [`Error::Vulkan`] where the memory cannot be read.
    pub fn bytes<R>(&self, look: impl FnOnce(&[u8]) -> R) -> Result<R> {
        self.buffer.read_with(look)
    }

    /// All bytes as values of one type: `f32` four times a texel for `R32G32B32A32_SFLOAT`.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the bytes are not a whole number of values; [`Error::Vulkan`] where the memory cannot
    /// be read.
    pub fn texels<T: bytemuck::Pod>(&self) -> Result<Vec<T>> {
        self.bytes(|bytes| {
            let whole = size_of::<T>() > 0 && bytes.len() % size_of::<T>() == 0;
            let wrong = || format!("has {} bytes, no whole number of {}", bytes.len(), std::any::type_name::<T>());
            whole.then(|| bytemuck::pod_collect_to_vec(bytes)).ok_or_else(|| Error::invalid(&self.name, wrong()))
        })?
    }

    /// Looks at the texels of one layer of the first mip.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a layer it does not have; [`Error::Vulkan`] where the memory cannot be read.
    pub fn layer<R>(&self, layer: u32, look: impl FnOnce(&[u8]) -> R) -> Result<R> {
        let (Some(&start), Some(&size)) = (self.mips.first(), self.layer_sizes.first()) else {
            return Err(Error::invalid(&self.name, "is a buffer, which has no layers"));
        };
        let first = (start + size * u64::from(layer)) as usize;
        let end = first + size as usize;
        self.buffer.read_with(|bytes| bytes.get(first..end).map(look))?.ok_or_else(|| {
            Error::invalid(format!("layer {layer} of `{}`", self.name), "is not among the captured layers")
        })
    }
}

/// Submissions after which a host buffer that none has used goes.
const KEPT_SUBMISSIONS: u64 = 4;

/// Buffers that captures are read back into, used again once nobody holds the capture: a system gives out memory slower
/// than a device fills it.
#[derive(Default)]
pub(super) struct HostBuffers {
    /// With the submission that used it last.
    kept: Vec<(Buffer, u64)>,
    submission: u64,
}

impl HostBuffers {
    /// Begins a submission.
    pub(super) fn begin(&mut self) {
        self.submission += 1;
        let submission = self.submission;
        self.kept.retain(|&(_, last_used)| last_used + KEPT_SUBMISSIONS >= submission);
    }

    fn buffer(&mut self, gpu: &Gpu, name: &str, size: u64) -> Result<Buffer> {
        for (buffer, last_used) in &mut self.kept {
            if buffer.size() == size && buffer.name() == name && buffer.is_held_once() {
                *last_used = self.submission;
                return Ok(buffer.clone());
            }
        }
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let buffer = gpu.create_buffer(&BufferInfo { name, size, usage, memory: Memory::Readback })?;
        self.kept.push((buffer.clone(), self.submission));
        Ok(buffer)
    }
}

/// Copies a root to its host buffer.
pub(super) fn read_back(
    device: &ash::Device,
    commands: &Commands,
    description: &Description,
    root: usize,
    memory: &Resources,
    capture: Option<&Capture>,
) {
    let version = &description.versions[description.roots[root].version.0 as usize];
    let (Some(capture), resource) = (capture, version.resource) else { return };
    match version.range {
        Range::Buffer([first, end]) => {
            if let Some(buffer) = memory.buffer(resource) {
                let region = vk::BufferCopy { src_offset: first, dst_offset: 0, size: end - first };
                record::copy_buffer(device, commands, buffer, &capture.buffer, region);
            }
        }
        Range::Image { aspects, mips, layers } => {
            let (Some(image), Shape::Image(shape)) = (memory.image(resource), &capture.shape) else { return };
            let depth = vk::ImageAspectFlags::DEPTH;
            let aspect_mask = if aspects.contains(depth) { depth } else { aspects };
            let regions: Vec<_> = (mips[0]..mips[1])
                .zip(&capture.mips)
                .enumerate()
                .map(|(i, (mip_level, &buffer_offset))| vk::BufferImageCopy {
                    buffer_offset,
                    image_subresource: vk::ImageSubresourceLayers {
                        aspect_mask,
                        mip_level,
                        base_array_layer: layers[0],
                        layer_count: layers[1] - layers[0],
                    },
                    image_extent: extent(shape.extent.map(|size| (size >> i).max(1))),
                    ..vk::BufferImageCopy::default()
                })
                .collect();
            record::copy_image(device, commands, image, &capture.buffer, &regions);
        }
    }
}

fn extent([width, height, depth]: [u32; 3]) -> vk::Extent3D {
    vk::Extent3D { width, height, depth }
}

/// Shape of what is captured, offset of each mip, bytes of a layer of each mip, bytes in all.
fn captured_layout(shape: &Shape, range: Range) -> (Shape, Vec<u64>, Vec<u64>, u64) {
    match (shape, range) {
        (Shape::Image(shape), Range::Image { aspects, mips, layers }) => {
            let at_mip = |mip: u32| shape.extent.map(|size| (size >> mip).max(1));
            let count = layers[1] - layers[0];
            let texel = match aspects {
                vk::ImageAspectFlags::STENCIL => 1,
                _ => FormatInfo::of(shape.format).map_or(16, |info| u64::from(info.block_bytes)),
            };
            let (mut offsets, mut sizes, mut size) = (Vec::new(), Vec::new(), 0);
            for mip in mips[0]..mips[1] {
                let layer = at_mip(mip).iter().map(|&s| u64::from(s)).product::<u64>() * texel;
                offsets.push(size);
                sizes.push(layer);
                size += layer * u64::from(count);
            }
            let captured = ImageShape { extent: at_mip(mips[0]), mips: mips[1] - mips[0], layers: count, ..*shape };
            (Shape::Image(captured), offsets, sizes, size)
        }
        (_, Range::Buffer([first, end])) => (Shape::Buffer { size: end - first }, Vec::new(), Vec::new(), end - first),
        (shape, Range::Image { .. }) => (shape.clone(), Vec::new(), Vec::new(), 0),
    }
}

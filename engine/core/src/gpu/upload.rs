//! Getting bytes into device memory.

use std::collections::{BTreeSet, HashMap};

use ash::vk;

use super::{Buffer, BufferInfo, Commands, FormatInfo, Gpu, Image, Memory, SubmitToken};
use crate::{Error, Result};

/// Bytes of one staging buffer, but for larger single uploads.
const STAGING: u64 = 16 << 20;
/// Staged bytes after which is submitted in between, so that staging memory can be freed.
const FLUSH: u64 = 128 << 20;

/// Collects uploads and submits them together. Where much is collected, it submits in between.
///
/// Whatever is submitted to the [`Gpu`] afterwards sees the data; nobody needs to wait. An image belongs to one
/// uploader from its first upload until [`Uploader::submit`]: its earlier contents are lost, and then it is in
/// `SHADER_READ_ONLY_OPTIMAL` as a whole.
pub struct Uploader<'g> {
    gpu: &'g Gpu,
    name: String,
    commands: Option<Commands>,
    staging: Option<Staging>,
    /// Bytes staged since the last submission.
    staged: u64,
    images: HashMap<vk::Image, Touched>,
    /// Parts of buffers that the commands write.
    written: HashMap<vk::Buffer, Vec<[u64; 2]>>,
}

struct Staging {
    buffer: Buffer,
    used: u64,
}

/// An image that was written to.
struct Touched {
    image: Image,
    /// Level and layer of what was written since the last barrier.
    written: BTreeSet<(u32, u32)>,
}

impl Uploader<'_> {
    /// Uploads into a part of a buffer (made with `TRANSFER_DST`).
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the bytes do not fit; [`crate::Error::OutOfMemory`] for staging memory.
    pub fn buffer(&mut self, buffer: &Buffer, offset: u64, bytes: &[u8]) -> Result<()> {
        let size = bytes.len() as u64;
        if !buffer.is_of(&self.gpu.device) || !buffer.usage().contains(vk::BufferUsageFlags::TRANSFER_DST) {
            return Err(
                buffer.invalid("to upload into it, it has to be of this device and have the usage TRANSFER_DST")
            );
        }
        if offset.checked_add(size).is_none_or(|end| end > buffer.size()) {
            return Err(buffer.invalid(format!("{size} bytes at {offset} do not fit into {}", buffer.size())));
        }
        if size == 0 {
            return Ok(());
        }
        let (staging, from) = self.stage(bytes, 4)?;
        let part = [offset, offset + size];
        let parts = self.written.entry(buffer.raw()).or_default();
        if parts.iter().any(|p| p[0] < part[1] && part[0] < p[1]) {
            parts.clear();
            self.order_writes()?;
        }
        self.written.entry(buffer.raw()).or_default().push(part);
        let region = [vk::BufferCopy { src_offset: from, dst_offset: offset, size }];
        let commands = self.commands()?;
        commands.keep(buffer.clone());
        // SAFETY: both are live and kept, the ranges lie in them, and no copy overlaps another without a barrier.
        unsafe {
            commands.device().cmd_copy_buffer(commands.raw(), staging.raw(), buffer.raw(), &region);
        }
        Ok(())
    }

    /// Uploads one mip level of one layer of an image (made with `TRANSFER_DST`), rows packed from the top.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the bytes are not exactly those of the level, or the format is unknown;
    /// [`crate::Error::OutOfMemory`] for staging memory.
    pub fn image(&mut self, image: &Image, mip: u32, layer: u32, bytes: &[u8]) -> Result<()> {
        let info = image.info();
        let extent = image.mip_extent(mip);
        if !image.is_of(&self.gpu.device) || !info.usage.contains(vk::ImageUsageFlags::TRANSFER_DST) {
            return Err(image.invalid("to upload into it, it has to be of this device and have the usage TRANSFER_DST"));
        }
        if mip >= info.mips || layer >= info.layers || info.samples != 1 {
            return Err(image.invalid(format!(
                "level {mip} of layer {layer} is not in its {} levels and {} layers of one sample",
                info.mips, info.layers
            )));
        }
        let Some(format) = FormatInfo::of(info.format) else {
            return Err(image.invalid(format!("uploads of {:?} are not supported", info.format)));
        };
        if format.bytes(extent) != bytes.len() as u64 {
            return Err(image.invalid(format!(
                "level {mip} of {:?} with {extent:?} texels takes {} bytes, not {}",
                info.format,
                format.bytes(extent),
                bytes.len()
            )));
        }
        // A copy's offset is a multiple of 4 and of the texel's size; these are 1, 2, 4, 8, 12 or 16.
        let align = if format.block_bytes == 12 { 12 } else { u64::from(format.block_bytes.max(4)) };
        let (staging, from) = self.stage(bytes, align)?;
        let touched = self.touch(image)?;
        if !touched.written.insert((mip, layer)) {
            touched.written = [(mip, layer)].into();
            self.order_writes()?;
        }
        let aspect = if format.aspects.contains(vk::ImageAspectFlags::DEPTH) {
            vk::ImageAspectFlags::DEPTH
        } else {
            format.aspects
        };
        let region = [vk::BufferImageCopy::default()
            .buffer_offset(from)
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: aspect,
                mip_level: mip,
                base_array_layer: layer,
                layer_count: 1,
            })
            .image_extent(vk::Extent3D { width: extent[0], height: extent[1], depth: extent[2] })];
        let commands = self.commands()?;
        // SAFETY: both are live and kept, the level is in the image, the bytes in the buffer, the layout as stated.
        unsafe {
            commands.device().cmd_copy_buffer_to_image(
                commands.raw(),
                staging.raw(),
                image.raw(),
                vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                &region,
            );
        }
        Ok(())
    }

    /// Submits the rest.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`], [`crate::Error::Vulkan`].
    pub fn submit(mut self) -> Result<SubmitToken> {
        let images = std::mem::take(&mut self.images);
        let commands = self.commands()?;
        let mut barriers = Vec::new();
        for Touched { image, .. } in images.values() {
            let (old, new) = (vk::ImageLayout::TRANSFER_DST_OPTIMAL, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
            barriers.push(barrier(image, old, new));
        }
        // SAFETY: live images that are kept, in the stated layouts.
        unsafe {
            let dependency = vk::DependencyInfo::default().image_memory_barriers(&barriers);
            commands.device().cmd_pipeline_barrier2(commands.raw(), &dependency);
        }
        self.flush()
    }

    // --- parts ---

    /// Copies bytes into a staging buffer; gives it and the offset.
    fn stage(&mut self, bytes: &[u8], align: u64) -> Result<(Buffer, u64)> {
        let size = bytes.len() as u64;
        if self.staged > FLUSH {
            self.flush()?;
        }
        let fits = |s: &Staging| s.used.next_multiple_of(align) + size <= s.buffer.size();
        if !self.staging.as_ref().is_some_and(fits) {
            let buffer = self.gpu.create_buffer(&BufferInfo {
                name: &format!("{}.staging", self.name),
                size: size.max(STAGING),
                usage: vk::BufferUsageFlags::TRANSFER_SRC,
                memory: Memory::Upload,
            })?;
            self.commands()?.keep(buffer.clone());
            self.staging = Some(Staging { buffer, used: 0 });
        }
        let Some(staging) = &mut self.staging else {
            return Err(Error::invalid(&self.name, "no staging buffer"));
        };
        let from = staging.used.next_multiple_of(align);
        staging.buffer.write(from, bytes)?;
        staging.used = from + size;
        self.staged += size;
        Ok((staging.buffer.clone(), from))
    }

    /// The commands that are being recorded. They begin after everything that was submitted before.
    fn commands(&mut self) -> Result<&mut Commands> {
        if self.commands.is_none() {
            let mut commands = self.gpu.commands(&self.name)?;
            commands.begin_pass(&self.name);
            global_barrier(&commands, vk::PipelineStageFlags2::ALL_COMMANDS, vk::PipelineStageFlags2::ALL_TRANSFER);
            self.commands = Some(commands);
        }
        self.commands.as_mut().ok_or_else(|| Error::invalid(&self.name, "no commands"))
    }

    /// Submits what is recorded; images stay with this uploader.
    fn flush(&mut self) -> Result<SubmitToken> {
        self.commands()?;
        let Some(commands) = self.commands.take() else {
            return Err(Error::invalid(&self.name, "no commands"));
        };
        global_barrier(&commands, vk::PipelineStageFlags2::ALL_TRANSFER, vk::PipelineStageFlags2::ALL_COMMANDS);
        self.staging = None;
        self.staged = 0;
        self.written.clear();
        self.images.values_mut().for_each(|t| t.written.clear());
        self.gpu.submit(commands)
    }

    /// The image's state; at the first touch it is made ready to be written to.
    fn touch(&mut self, image: &Image) -> Result<&mut Touched> {
        let first = !self.images.contains_key(&image.raw());
        let commands = self.commands()?;
        if first {
            commands.keep(image.clone());
            let (old, new) = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
            let barriers = [barrier(image, old, new)];
            // SAFETY: a live image that is kept; its contents are given up.
            unsafe {
                let dependency = vk::DependencyInfo::default().image_memory_barriers(&barriers);
                commands.device().cmd_pipeline_barrier2(commands.raw(), &dependency);
            }
        }
        Ok(self.images.entry(image.raw()).or_insert_with(|| Touched { image: image.clone(), written: BTreeSet::new() }))
    }

    /// Copies from here on come after those before: something is written a second time.
    fn order_writes(&mut self) -> Result<()> {
        let commands = self.commands()?;
        global_barrier(commands, vk::PipelineStageFlags2::ALL_TRANSFER, vk::PipelineStageFlags2::ALL_TRANSFER);
        Ok(())
    }
}

/// All accesses of `from` before all of `to`.
fn global_barrier(commands: &Commands, from: vk::PipelineStageFlags2, to: vk::PipelineStageFlags2) {
    let barrier = [vk::MemoryBarrier2::default()
        .src_stage_mask(from)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(to)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)];
    // SAFETY: the command buffer is being recorded, outside of rendering.
    unsafe {
        let dependency = vk::DependencyInfo::default().memory_barriers(&barrier);
        commands.device().cmd_pipeline_barrier2(commands.raw(), &dependency);
    }
}

/// A change of layout between transfers, or from the last one to whatever follows.
fn barrier(image: &Image, old: vk::ImageLayout, new: vk::ImageLayout) -> vk::ImageMemoryBarrier2<'static> {
    use vk::{AccessFlags2 as A, PipelineStageFlags2 as S};
    let to = if new == vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL { S::ALL_COMMANDS } else { S::ALL_TRANSFER };
    vk::ImageMemoryBarrier2::default()
        .src_stage_mask(S::ALL_TRANSFER)
        .src_access_mask(A::MEMORY_WRITE)
        .dst_stage_mask(to)
        .dst_access_mask(A::MEMORY_READ | A::MEMORY_WRITE)
        .old_layout(old)
        .new_layout(new)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image.raw())
        .subresource_range(image.range())
}

impl Gpu {
    /// Begins to collect uploads.
    pub fn uploader(&self, name: &str) -> Uploader<'_> {
        Uploader {
            gpu: self,
            name: name.into(),
            commands: None,
            staging: None,
            staged: 0,
            images: HashMap::new(),
            written: HashMap::new(),
        }
    }

    /// Uploads to the start of one buffer.
    ///
    /// # Errors
    /// As [`Uploader::buffer`].
    pub fn upload_buffer(&self, buffer: &Buffer, bytes: &[u8]) -> Result<SubmitToken> {
        let mut uploader = self.uploader(&format!("upload.{}", buffer.name()));
        uploader.buffer(buffer, 0, bytes)?;
        uploader.submit()
    }

    /// Uploads the layers of an image without further mip levels, one after the other in `bytes`.
    ///
    /// # Errors
    /// As [`Uploader::image`]; [`crate::Error::Invalid`] where the image has more than one level.
    pub fn upload_image(&self, image: &Image, bytes: &[u8]) -> Result<SubmitToken> {
        let layers = image.info().layers as usize;
        if bytes.is_empty() || !bytes.len().is_multiple_of(layers) {
            return Err(image.invalid(format!("{} bytes are not {layers} layers of the same size", bytes.len())));
        }
        if image.info().mips != 1 {
            return Err(image.invalid("it has several mip levels: an uploader takes them one by one"));
        }
        let mut uploader = self.uploader(&format!("upload.{}", image.name()));
        for (layer, bytes) in bytes.chunks_exact(bytes.len() / layers).enumerate() {
            uploader.image(image, 0, layer as u32, bytes)?;
        }
        uploader.submit()
    }
}

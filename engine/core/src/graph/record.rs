//! Recording of Vulkan commands: the only file of the graph that does.
//!
//! Why its `unsafe` is sound, for every block: the command buffer is in the recording state and used by this thread
//! alone; handles come from live objects that the frame keeps until the device is done; layouts and hazards are the
//! plan's business, which validation and the plan's own checker watch; indices out of range are bounded by
//! `robustBufferAccess`.
#![allow(unsafe_code)]

use std::ops::Range;

use ash::vk;

use super::plan::{Plan, Statistics};
use crate::gpu::{Buffer, Commands, DescriptorSet, Image, Pipeline, QueryPool};

/// Records the draws of one pass. Given to the pass's closure.
pub struct Recorder<'a> {
    device: &'a ash::Device,
    commands: vk::CommandBuffer,
    programs: &'a [Ready],
    current: usize,
}

/// A program with its pipeline and its pass-level set.
pub(super) struct Ready {
    pub(super) pipeline: Pipeline,
    pub(super) set: vk::DescriptorSet,
}

impl<'a> Recorder<'a> {
    pub(super) fn new(device: &'a ash::Device, commands: &Commands, programs: &'a [Ready]) -> Self {
        let mut recorder = Self { device, commands: commands.raw(), programs, current: 0 };
        recorder.program(0);
        recorder
    }

    /// Takes one of the pass's programs, by its place in the list. The first is taken at the start. A number out of
    /// range takes the last.
    pub fn program(&mut self, index: usize) {
        self.current = index.min(self.programs.len().saturating_sub(1));
        let Some(ready) = self.programs.get(self.current) else { return };
        // SAFETY: see the module.
        unsafe {
            let graphics = vk::PipelineBindPoint::GRAPHICS;
            self.device.cmd_bind_pipeline(self.commands, graphics, ready.pipeline.raw());
            if ready.set != vk::DescriptorSet::null() {
                let layout = ready.pipeline.layout();
                self.device.cmd_bind_descriptor_sets(self.commands, graphics, layout, 0, &[ready.set], &[]);
            }
            self.device.cmd_set_cull_mode(self.commands, vk::CullModeFlags::NONE);
            self.device.cmd_set_front_face(self.commands, vk::FrontFace::COUNTER_CLOCKWISE);
        }
        self.stencil_reference(0);
    }

    /// Culling, and whether the winding is turned around.
    pub fn faces(&mut self, cull: vk::CullModeFlags, mirrored: bool) {
        let front = if mirrored { vk::FrontFace::CLOCKWISE } else { vk::FrontFace::COUNTER_CLOCKWISE };
        // SAFETY: see the module.
        unsafe {
            self.device.cmd_set_cull_mode(self.commands, cull);
            self.device.cmd_set_front_face(self.commands, front);
        }
    }

    /// Draws only over these pixels of the pass's area, from the upper left.
    pub fn scissor(&mut self, offset: [u32; 2], size: [u32; 2]) {
        let offset = vk::Offset2D { x: offset[0] as i32, y: offset[1] as i32 };
        let area = vk::Rect2D { offset, extent: vk::Extent2D { width: size[0], height: size[1] } };
        // SAFETY: see the module.
        unsafe { self.device.cmd_set_scissor(self.commands, 0, &[area]) }
    }

    /// Stencil reference of both faces; 0 before, and after each change of program.
    pub fn stencil_reference(&mut self, reference: u32) {
        // SAFETY: see the module.
        unsafe { self.device.cmd_set_stencil_reference(self.commands, vk::StencilFaceFlags::FRONT_AND_BACK, reference) }
    }

    /// Binds set 1, where the current program has one.
    pub fn material(&mut self, set: &DescriptorSet) {
        let Some(ready) = self.programs.get(self.current) else { return };
        if ready.pipeline.set_layout(1).is_none() {
            return;
        }
        let layout = ready.pipeline.layout();
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: see the module.
        unsafe { self.device.cmd_bind_descriptor_sets(self.commands, graphics, layout, 1, &[set.raw()], &[]) }
    }

    /// Push constants of the current program, from offset 0; what it has no room for is left out.
    pub fn push<T: bytemuck::Pod>(&mut self, value: &T) {
        if let Some(ready) = self.programs.get(self.current) {
            push(self.device, self.commands, &ready.pipeline, bytemuck::bytes_of(value));
        }
    }

    /// Vertex buffers from binding 0 on. More than a program has do no harm.
    pub fn vertex_buffers(&mut self, buffers: &[&Buffer]) {
        let raw: Vec<_> = buffers.iter().map(|buffer| buffer.raw()).collect();
        // SAFETY: see the module.
        unsafe { self.device.cmd_bind_vertex_buffers(self.commands, 0, &raw, &vec![0; raw.len()]) }
    }

    /// 32-bit indices.
    pub fn index_buffer(&mut self, buffer: &Buffer) {
        // SAFETY: see the module.
        unsafe { self.device.cmd_bind_index_buffer(self.commands, buffer.raw(), 0, vk::IndexType::UINT32) }
    }

    /// Draws vertices without indices.
    pub fn draw(&mut self, vertices: Range<u32>, instances: Range<u32>) {
        let (count, copies) = (vertices.len() as u32, instances.len() as u32);
        // SAFETY: see the module.
        unsafe { self.device.cmd_draw(self.commands, count, copies, vertices.start, instances.start) }
    }

    /// Draws indexed vertices. `instances.start` becomes `gl_InstanceIndex` of the first.
    pub fn draw_indexed(&mut self, indices: Range<u32>, vertex_offset: i32, instances: Range<u32>) {
        let (count, copies) = (indices.len() as u32, instances.len() as u32);
        // SAFETY: see the module.
        unsafe {
            self.device.cmd_draw_indexed(self.commands, count, copies, indices.start, vertex_offset, instances.start);
        }
    }
}

/// Push constants of all of a pipeline's stages.
fn push(device: &ash::Device, commands: vk::CommandBuffer, pipeline: &Pipeline, bytes: &[u8]) {
    let Some((stages, size)) = pipeline.push() else { return };
    let bytes = &bytes[..bytes.len().min(size as usize)];
    if !bytes.is_empty() {
        // SAFETY: see the module.
        unsafe { device.cmd_push_constants(commands, pipeline.layout(), stages, 0, bytes) }
    }
}

/// Batches of barriers, one behind the other in flat lists.
#[derive(Default)]
pub(super) struct Batches {
    pub(super) memory: Vec<vk::MemoryBarrier2<'static>>,
    pub(super) images: Vec<vk::ImageMemoryBarrier2<'static>>,
    /// By batch: where its barriers for all memory, and where those of images end.
    ends: Vec<[usize; 2]>,
}

impl Batches {
    /// With room for the barriers of a plan.
    pub(super) fn with_capacity(plan: &Plan) -> Self {
        let Statistics { memory_barriers, buffer_barriers, image_barriers, .. } = plan.statistics;
        let memory = Vec::with_capacity(memory_barriers + buffer_barriers + image_barriers);
        Self { memory, images: Vec::with_capacity(image_barriers), ends: Vec::with_capacity(plan.steps.len() + 1) }
    }

    /// What was added since the last batch is one.
    pub(super) fn end(&mut self) {
        self.ends.push([self.memory.len(), self.images.len()]);
    }

    /// Barriers for all memory of the batch that is not ended yet.
    pub(super) fn open_memory(&self) -> &[vk::MemoryBarrier2<'static>] {
        &self.memory[self.ends.last().map_or(0, |end| end[0])..]
    }

    pub(super) fn record(&self, device: &ash::Device, commands: &Commands, batch: usize) {
        let Some(&[memory, images]) = self.ends.get(batch) else { return };
        let [first_memory, first_image] = batch.checked_sub(1).map_or([0; 2], |before| self.ends[before]);
        barriers(device, commands, &self.memory[first_memory..memory], &self.images[first_image..images]);
    }
}

fn barriers(
    device: &ash::Device,
    commands: &Commands,
    memory: &[vk::MemoryBarrier2],
    images: &[vk::ImageMemoryBarrier2],
) {
    if memory.is_empty() && images.is_empty() {
        return;
    }
    let dependency = vk::DependencyInfo::default().memory_barriers(memory).image_memory_barriers(images);
    // SAFETY: see the module.
    unsafe { device.cmd_pipeline_barrier2(commands.raw(), &dependency) }
}

/// What is rendered to.
#[derive(Clone, Copy)]
pub(super) struct Area {
    pub(super) size: [u32; 2],
    pub(super) layers: u32,
    pub(super) view_mask: u32,
}

/// Begins dynamic rendering over an area, with viewport and scissor.
pub(super) fn begin_rendering(
    device: &ash::Device,
    commands: &Commands,
    color: &[vk::RenderingAttachmentInfo],
    [depth, stencil]: [Option<&vk::RenderingAttachmentInfo>; 2],
    area: Area,
) {
    let Area { size, layers, view_mask } = area;
    let extent = vk::Extent2D { width: size[0], height: size[1] };
    let area = vk::Rect2D { offset: vk::Offset2D::default(), extent };
    let mut info = vk::RenderingInfo::default()
        .render_area(area)
        .layer_count(if view_mask == 0 { layers } else { 1 })
        .view_mask(view_mask)
        .color_attachments(color);
    if let Some(depth) = depth {
        info = info.depth_attachment(depth);
    }
    if let Some(stencil) = stencil {
        info = info.stencil_attachment(stencil);
    }
    let viewport =
        vk::Viewport { width: size[0] as f32, height: size[1] as f32, max_depth: 1.0, ..vk::Viewport::default() };
    // SAFETY: see the module.
    unsafe {
        device.cmd_begin_rendering(commands.raw(), &info);
        device.cmd_set_viewport(commands.raw(), 0, &[viewport]);
        device.cmd_set_scissor(commands.raw(), 0, &[area]);
    }
}

pub(super) fn end_rendering(device: &ash::Device, commands: &Commands) {
    // SAFETY: see the module.
    unsafe { device.cmd_end_rendering(commands.raw()) }
}

/// The compute pipeline that is bound: passes in a row that run the same one bind it once.
#[derive(Default)]
pub(super) struct BoundCompute(vk::Pipeline);

/// One dispatch: of `groups` workgroups, or of as many as `indirect` says.
pub(super) fn dispatch(
    device: &ash::Device,
    commands: &Commands,
    (ready, bound): (&Ready, &mut BoundCompute),
    push_bytes: &[u8],
    groups: [u32; 3],
    indirect: Option<(&Buffer, u64)>,
) {
    let compute = vk::PipelineBindPoint::COMPUTE;
    // SAFETY: see the module.
    unsafe {
        if bound.0 != ready.pipeline.raw() {
            bound.0 = ready.pipeline.raw();
            device.cmd_bind_pipeline(commands.raw(), compute, bound.0);
        }
        if ready.set != vk::DescriptorSet::null() {
            let layout = ready.pipeline.layout();
            device.cmd_bind_descriptor_sets(commands.raw(), compute, layout, 0, &[ready.set], &[]);
        }
    }
    push(device, commands.raw(), &ready.pipeline, push_bytes);
    // SAFETY: see the module.
    unsafe {
        match indirect {
            Some((buffer, offset)) => device.cmd_dispatch_indirect(commands.raw(), buffer.raw(), offset),
            None => device.cmd_dispatch(commands.raw(), groups[0], groups[1], groups[2]),
        }
    }
}

pub(super) fn fill(device: &ash::Device, commands: &Commands, buffer: &Buffer, range: [u64; 2], value: u32) {
    // Vulkan fills whole words; the last bytes of an odd size are nobody's.
    let size = (range[1] - range[0]) / 4 * 4;
    // SAFETY: see the module.
    unsafe { device.cmd_fill_buffer(commands.raw(), buffer.raw(), range[0], size, value) }
}

pub(super) fn clear(
    device: &ash::Device,
    commands: &Commands,
    image: &Image,
    range: vk::ImageSubresourceRange,
    value: vk::ClearColorValue,
) {
    let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
    // SAFETY: see the module.
    unsafe { device.cmd_clear_color_image(commands.raw(), image.raw(), layout, &value, &[range]) }
}

pub(super) fn clear_depth(
    device: &ash::Device,
    commands: &Commands,
    image: &Image,
    range: vk::ImageSubresourceRange,
    depth: f32,
) {
    let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
    let value = vk::ClearDepthStencilValue { depth, stencil: 0 };
    // SAFETY: see the module.
    unsafe { device.cmd_clear_depth_stencil_image(commands.raw(), image.raw(), layout, &value, &[range]) }
}

pub(super) fn copy_image(
    device: &ash::Device,
    commands: &Commands,
    image: &Image,
    to: &Buffer,
    regions: &[vk::BufferImageCopy],
) {
    let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
    // SAFETY: see the module.
    unsafe { device.cmd_copy_image_to_buffer(commands.raw(), image.raw(), layout, to.raw(), regions) }
}

pub(super) fn copy_buffer(
    device: &ash::Device,
    commands: &Commands,
    from: &Buffer,
    to: &Buffer,
    region: vk::BufferCopy,
) {
    // SAFETY: see the module.
    unsafe { device.cmd_copy_buffer(commands.raw(), from.raw(), to.raw(), &[region]) }
}

pub(super) fn begin_query(device: &ash::Device, commands: &Commands, pool: &QueryPool, precise: bool) {
    let flags = if precise { vk::QueryControlFlags::PRECISE } else { vk::QueryControlFlags::empty() };
    // SAFETY: see the module.
    unsafe { device.cmd_begin_query(commands.raw(), pool.raw(), 0, flags) }
}

pub(super) fn end_query(device: &ash::Device, commands: &Commands, pool: &QueryPool) {
    // SAFETY: see the module.
    unsafe { device.cmd_end_query(commands.raw(), pool.raw(), 0) }
}

/// Everything recorded before is done, and seen by everything recorded after.
pub(super) fn full_barrier(device: &ash::Device, commands: &Commands) {
    let all = vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE;
    let memory = vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(all)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .dst_access_mask(all);
    barriers(device, commands, &[memory], &[]);
}

pub(super) fn timestamp(device: &ash::Device, commands: &Commands, pool: &QueryPool, index: u32) {
    let stage = vk::PipelineStageFlags2::ALL_COMMANDS;
    // SAFETY: see the module.
    unsafe { device.cmd_write_timestamp2(commands.raw(), stage, pool.raw(), index) }
}

//! Passes of draws.

use ash::vk;

use super::bind::{Fits, Unchanging, binding_methods};
use super::collect::Collected;
use super::{Attachment, Attachments, Load, What, Work};
use crate::Result;
use crate::gpu::{Image, QueryKind, SamplerInfo};
use crate::graph::builder::{Data, Graph};
use crate::graph::description::{Access, Queue};
use crate::graph::handle::ImageHandle;
use crate::graph::record::Recorder;
use crate::shader::{self, ColorSlot, Program, ReadSlot, SampledSlot, StorageSlot, Targets, UniformSlot, WriteSlot};

/// A pass of draws being described; [`RasterPass::draw`] ends it.
#[must_use = "a pass is recorded by `draw`"]
pub struct RasterPass<'g, 'f> {
    graph: &'g mut Graph<'f>,
    collected: Collected,
    programs: Vec<Program>,
    targets: Targets,
    attachments: Attachments,
}

impl<'g, 'f> RasterPass<'g, 'f> {
    pub(in crate::graph) fn new(graph: &'g mut Graph<'f>, name: String, programs: Vec<Program>) -> Self {
        let collected = Collected::new(graph.next_pass(), name, programs.iter().flat_map(Program::shaders));
        let targets = Targets { samples: 1, ..Targets::default() };
        Self { graph, collected, programs, targets, attachments: Attachments::default() }
    }

    binding_methods!();

    /// Draws `count` views at once into as many layers (multiview).
    pub fn views(&mut self, count: u32) -> &mut Self {
        self.targets.view_mask = if count >= 32 { u32::MAX } else { (1 << count) - 1 };
        self
    }

    /// Draws over so many pixels without an attachment, for what shaders store elsewhere. With one, its size counts.
    pub fn area(&mut self, size: [u32; 2]) -> &mut Self {
        if self.attachments.size == [0; 2] {
            (self.attachments.size, self.attachments.layers) = (size, 1);
        }
        self
    }

    /// Writes a colour attachment through a fragment shader's output.
    pub fn color(&mut self, slot: ColorSlot, handle: ImageHandle, load: Load<[f32; 4]>) -> ImageHandle {
        let clear = |rgba| vk::ClearValue { color: vk::ClearColorValue { float32: rgba } };
        self.color_attachment(slot, handle, map_load(load, clear))
    }

    /// Writes a colour attachment of unsigned integers.
    pub fn color_uint(&mut self, slot: ColorSlot, handle: ImageHandle, load: Load<[u32; 4]>) -> ImageHandle {
        let clear = |rgba| vk::ClearValue { color: vk::ClearColorValue { uint32: rgba } };
        self.color_attachment(slot, handle, map_load(load, clear))
    }

    /// Tests and writes depth.
    pub fn depth(&mut self, handle: ImageHandle, load: Load<f32>) -> ImageHandle {
        let clear = |depth| vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth, stencil: 0 } };
        let (load, clear) = map_load(load, clear);
        let access = Access::depth_attachment_write();
        let reads = load == vk::AttachmentLoadOp::LOAD;
        self.cover("depth", &handle);
        self.targets.depth = Some(handle.shape.format);
        self.attachments.depth = Some(attachment(&handle, access, load, vk::AttachmentStoreOp::STORE, clear));
        let (used, next) = self.graph.written(self.collected.pass, "depth", handle, reads, access);
        self.collected.uses.push(used);
        next
    }

    /// Tests depth and leaves it as it is.
    pub fn depth_test(&mut self, handle: &ImageHandle) -> &mut Self {
        let access = Access::depth_attachment_read();
        self.cover("depth", handle);
        self.targets.depth = Some(handle.shape.format);
        let (load, store) = (vk::AttachmentLoadOp::LOAD, vk::AttachmentStoreOp::NONE);
        self.attachments.depth = Some(attachment(handle, access, load, store, vk::ClearValue::default()));
        let used = self.graph.used("depth", handle, access);
        self.collected.uses.push(used);
        self
    }

    /// Counts the samples that pass all tests, exactly and over all draws of this pass, which therefore runs whoever
    /// reads what it writes ([`crate::graph::Executed::samples`]). Needs `occlusionQueryPrecise`.
    pub fn count_samples(&mut self) -> &mut Self {
        self.collected.counted.push(QueryKind::Occlusion);
        self
    }

    /// Ends the description: `draw` records the draws when the frame is executed.
    pub fn draw(self, draw: impl FnMut(&mut Recorder) -> Result<()> + 'f) {
        let Self { graph, collected, programs, targets, attachments } = self;
        let name = &collected.name;
        if attachments.size == [0; 2] {
            graph.mistake(Some(name), None, "has no attachment".into(), "colour or depth, or an area".into());
        }
        for program in &programs {
            for output in program.fragment.map_or(&[][..], |shader| shader.outputs) {
                if output.location as usize >= attachments.color.len() {
                    let file = program.fragment.map_or("", |shader| shader.file);
                    let wrong = format!("has no attachment; {file} writes it");
                    graph.mistake(Some(name), Some(output.name), wrong, format!("location {}", output.location));
                }
            }
        }
        if let Some(gap) = attachments.color.iter().position(Option::is_none) {
            let wrong = format!("has no attachment for location {gap}, but for a higher one");
            graph.mistake(Some(name), None, wrong, "locations from 0 without a gap".into());
        }
        let (name, uses, bound) = collected.finish(graph);
        let work = Work::Raster { programs, targets, attachments, bound, draw: Box::new(draw) };
        graph.push_pass(name, Queue::Graphics, uses, work);
    }

    fn color_attachment(
        &mut self,
        slot: ColorSlot,
        handle: ImageHandle,
        (load, clear): (vk::AttachmentLoadOp, vk::ClearValue),
    ) -> ImageHandle {
        let output = slot.output();
        let location = output.location as usize;
        let reads = load == vk::AttachmentLoadOp::LOAD;
        let blends = self.programs.iter().any(|program| program.blend.blend_enable == vk::TRUE);
        let access = Access::color_attachment(reads || blends);
        self.cover(output.name, &handle);
        if self.attachments.color.len() <= location {
            self.attachments.color.resize_with(location + 1, || None);
            self.targets.color.resize(location + 1, vk::Format::UNDEFINED);
        }
        self.targets.color[location] = handle.shape.format;
        self.attachments.color[location] = Some(attachment(&handle, access, load, vk::AttachmentStoreOp::STORE, clear));
        let (used, next) = self.graph.written(self.collected.pass, output.name, handle, reads, access);
        self.collected.uses.push(used);
        next
    }

    /// All attachments of a pass have one size and one number of layers.
    fn cover(&mut self, slot: &str, handle: &ImageHandle) {
        let (size, layers) = (handle.size(), handle.layers()[1] - handle.layers()[0]);
        let first = self.attachments.color.is_empty() && self.attachments.depth.is_none();
        if !first && (self.attachments.size != size || self.attachments.layers != layers) {
            let describe = |size: [u32; 2], layers| format!("{}×{} with {layers} layers", size[0], size[1]);
            let wrong = format!("is {}", describe(size, layers));
            let allowed =
                format!("{}, as the attachment before", describe(self.attachments.size, self.attachments.layers));
            self.graph.mistake(Some(&self.collected.name), Some(slot), wrong, allowed);
        }
        (self.attachments.size, self.attachments.layers) = (size, layers);
    }
}

fn map_load<T>(load: Load<T>, clear: impl FnOnce(T) -> vk::ClearValue) -> (vk::AttachmentLoadOp, vk::ClearValue) {
    match load {
        Load::Clear(value) => (vk::AttachmentLoadOp::CLEAR, clear(value)),
        Load::Keep => (vk::AttachmentLoadOp::LOAD, vk::ClearValue::default()),
        Load::Discard => (vk::AttachmentLoadOp::DONT_CARE, vk::ClearValue::default()),
    }
}

fn attachment(
    handle: &ImageHandle,
    access: Access,
    load: vk::AttachmentLoadOp,
    store: vk::AttachmentStoreOp,
    clear: vk::ClearValue,
) -> Attachment {
    Attachment { resource: handle.resource, range: handle.range, layout: access.layout, load, store, clear }
}

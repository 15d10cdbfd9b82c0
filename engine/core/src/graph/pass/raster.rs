//! Passes of draws.

use ash::vk;

use super::bind::{Fits, Unchanging, binding_methods};
use super::collect::{Collected, Shaders};
use super::{Attachment, Attachments, Load, Raster, What, Work};
use crate::Result;
use crate::gpu::{Image, QueryKind, SamplerInfo};
use crate::graph::builder::{Data, Graph};
use crate::graph::description::{Access, Queue};
use crate::graph::handle::ImageHandle;
use crate::graph::name::Name;
use crate::graph::record::Recorder;
use crate::shader::{
    self, ColorSlot, InputSlot, Program, ReadSlot, SampledSlot, StorageSlot, Targets, UniformSlot, WriteSlot,
};

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
    pub(in crate::graph) fn new(graph: &'g mut Graph<'f>, name: Name, programs: Vec<Program>) -> Self {
        let shaders = Shaders::Several(programs.iter().flat_map(Program::shaders).collect());
        let collected = Collected::new(graph, name, shaders);
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

    /// Writes a colour attachment that fragments read through an input attachment: each finds what those of earlier
    /// primitives left in its pixel. It is the pass's only one, of one layer. Needs
    /// [`crate::gpu::Feature::OrderedAttachments`].
    pub fn color_in_order(&mut self, slot: ColorSlot, input: InputSlot, handle: ImageHandle) -> ImageHandle {
        self.collected.attached(self.graph, &input.binding(), &handle);
        self.attachments.ordered = true;
        self.color_attachment(slot, handle, map_load(Load::Keep, |()| vk::ClearValue::default()))
    }

    /// Tests and writes depth.
    pub fn depth(&mut self, handle: ImageHandle, load: Load<f32>) -> ImageHandle {
        let clear = |depth| vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth, stencil: 0 } };
        self.tested(Test::Depth, handle, map_load(load, clear))
    }

    /// Tests depth and leaves it as it is.
    pub fn depth_test(&mut self, handle: &ImageHandle) -> &mut Self {
        self.only_tested(Test::Depth, handle)
    }

    /// Tests and writes the stencil. Together with depth, both are parts of one image ([`Graph::split_aspects`]).
    pub fn stencil(&mut self, handle: ImageHandle, load: Load<u32>) -> ImageHandle {
        let clear = |stencil| vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: 0.0, stencil } };
        self.tested(Test::Stencil, handle, map_load(load, clear))
    }

    /// Tests the stencil and leaves it as it is.
    pub fn stencil_test(&mut self, handle: &ImageHandle) -> &mut Self {
        self.only_tested(Test::Stencil, handle)
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
            graph.mistake(Some(name), None, "has no attachment".into(), "colour, depth or stencil, or an area".into());
        }
        for program in &programs {
            let asked = [(Test::Depth, program.depth.is_some()), (Test::Stencil, program.stencil.is_some())];
            for (test, _) in asked.iter().filter(|(test, asks)| *asks && attachments.of(*test).is_none()) {
                let wrong = format!("is tested by the program of {}, and the pass has none", program.vertex.file);
                graph.mistake(Some(name), Some(test.name()), wrong, "an attachment for it".into());
            }
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
        let Attachments { color, stencil, layers, ordered, .. } = &attachments;
        if *ordered && (color.len() != 1 || stencil.is_some() || *layers != 1 || targets.view_mask != 0) {
            let wrong = "reads a colour attachment in order beside others".into();
            graph.mistake(Some(name), None, wrong, "this one, of one layer, and depth".into());
        }
        let (name, bound) = collected.finish(graph);
        let raster = Raster { programs, targets, attachments, bound, draw: Box::new(draw) };
        graph.push_pass(name, Queue::Graphics, Work::Raster(Box::new(raster)));
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
        let access = match self.attachments.ordered {
            true => Access::ordered_attachment(),
            false => Access::color_attachment(reads || blends),
        };
        self.cover(output.name, &handle);
        if self.attachments.color.len() <= location {
            self.attachments.color.resize_with(location + 1, || None);
            self.targets.color.resize(location + 1, vk::Format::UNDEFINED);
        }
        self.targets.color[location] = handle.shape.format;
        self.attachments.color[location] = Some(attachment(&handle, access, load, vk::AttachmentStoreOp::STORE, clear));
        self.graph.written(self.collected.pass, output.name, handle, reads, access)
    }

    fn tested(
        &mut self,
        test: Test,
        handle: ImageHandle,
        (load, clear): (vk::AttachmentLoadOp, vk::ClearValue),
    ) -> ImageHandle {
        let access = Access::depth_attachment_write();
        let reads = load == vk::AttachmentLoadOp::LOAD;
        self.attach(test, &handle, attachment(&handle, access, load, vk::AttachmentStoreOp::STORE, clear));
        self.graph.written(self.collected.pass, test.name(), handle, reads, access)
    }

    fn only_tested(&mut self, test: Test, handle: &ImageHandle) -> &mut Self {
        let access = Access::depth_attachment_read();
        let (load, store) = (vk::AttachmentLoadOp::LOAD, vk::AttachmentStoreOp::NONE);
        self.attach(test, handle, attachment(handle, access, load, store, vk::ClearValue::default()));
        self.graph.used(test.name(), handle, access);
        self
    }

    /// Makes it the pass's depth or stencil attachment.
    fn attach(&mut self, test: Test, handle: &ImageHandle, attachment: Attachment) {
        let (slot, format) = (test.name(), handle.shape.format);
        self.cover(slot, handle);
        if !handle.aspects().contains(test.aspect()) {
            let wrong = format!("is {format:?}, of which it holds {:?}", handle.aspects());
            self.graph.mistake(
                Some(&self.collected.name),
                Some(slot),
                wrong,
                format!("the aspect {:?}", test.aspect()),
            );
        }
        let other = self.attachments.of(test.other());
        if other.is_some_and(|other| other.resource != handle.resource) {
            let wrong = format!("is another image than the pass's {}", test.other().name());
            let allowed = "two aspects of one image".into();
            self.graph.mistake(Some(&self.collected.name), Some(slot), wrong, allowed);
        }
        let (format_of, place) = match test {
            Test::Depth => (&mut self.targets.depth, &mut self.attachments.depth),
            Test::Stencil => (&mut self.targets.stencil, &mut self.attachments.stencil),
        };
        (*format_of, *place) = (Some(format), Some(attachment));
    }

    /// All attachments of a pass have one size, one number of layers, and as many samples a pixel.
    fn cover(&mut self, slot: &str, handle: &ImageHandle) {
        let covered = (handle.size(), handle.layers()[1] - handle.layers()[0], handle.shape().samples);
        let Attachments { color, depth, stencil, size, layers, .. } = &self.attachments;
        let first = color.is_empty() && depth.is_none() && stencil.is_none();
        let before = (*size, *layers, self.targets.samples);
        if !first && before != covered {
            let describe = |([width, height], layers, samples): ([u32; 2], u32, u32)| {
                let of_samples = if samples == 1 { String::new() } else { format!(" of {samples} samples a pixel") };
                format!("{width}×{height} with {layers} layers{of_samples}")
            };
            let wrong = format!("is {}", describe(covered));
            let allowed = format!("{}, as the attachment before", describe(before));
            self.graph.mistake(Some(&self.collected.name), Some(slot), wrong, allowed);
        }
        (self.attachments.size, self.attachments.layers, self.targets.samples) = covered;
    }
}

/// What fragments are tested against.
#[derive(Clone, Copy)]
enum Test {
    Depth,
    Stencil,
}

impl Test {
    fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Stencil => "stencil",
        }
    }

    fn aspect(self) -> vk::ImageAspectFlags {
        match self {
            Self::Depth => vk::ImageAspectFlags::DEPTH,
            Self::Stencil => vk::ImageAspectFlags::STENCIL,
        }
    }

    fn other(self) -> Self {
        match self {
            Self::Depth => Self::Stencil,
            Self::Stencil => Self::Depth,
        }
    }
}

impl Attachments {
    fn of(&self, test: Test) -> Option<&Attachment> {
        match test {
            Test::Depth => self.depth.as_ref(),
            Test::Stencil => self.stencil.as_ref(),
        }
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

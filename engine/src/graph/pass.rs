//! Describing a pass: what its shaders' bindings and its attachments are.

use ash::vk;

use super::builder::{Data, Graph};
use super::description::{Access, PassId, Queue, Range, ResourceId, Use};
use super::handle::{BufferHandle, Handle, ImageHandle};
use super::record::Recorder;
use crate::Result;
use crate::gpu::{self, Buffer, Image, SamplerInfo};
use crate::shader::{
    self, Binding, BindingKind, ColorSlot, Program, ReadSlot, SampledSlot, Shader, ShaderAccess, Stage, StorageSlot,
    Targets, UniformSlot, WriteSlot,
};

/// What a pass does, besides what the description says.
pub(super) enum Work<'f> {
    Compute {
        shader: &'static Shader,
        constants: Vec<(u32, gpu::Constant)>,
        bound: Vec<Bound>,
        push: Vec<u8>,
        groups: Groups,
    },
    Raster {
        programs: Vec<Program>,
        targets: Targets,
        attachments: Attachments,
        bound: Vec<Bound>,
        draw: DrawFn<'f>,
    },
    Fill {
        resource: ResourceId,
        range: Range,
        value: u32,
    },
    Clear {
        resource: ResourceId,
        range: Range,
        value: vk::ClearColorValue,
    },
}

pub(super) type DrawFn<'f> = Box<dyn FnOnce(&mut Recorder) -> Result<()> + 'f>;

/// Workgroups of a dispatch.
pub(super) enum Groups {
    Direct([u32; 3]),
    Indirect(ResourceId, u64),
}

/// What lies behind a binding of set 0.
pub(super) struct Bound {
    pub(super) binding: Binding,
    pub(super) what: What,
}

#[derive(Clone)]
pub(super) enum What {
    /// Bytes of the frame's arena.
    Data(Data),
    /// A buffer that never changes while frames run.
    Buffer(Buffer),
    /// An image that never changes while frames run.
    Image(Image, SamplerInfo),
    /// A resource of the graph.
    Resource { resource: ResourceId, range: Range, layout: vk::ImageLayout, sampler: SamplerInfo },
}

/// Attachments of a raster pass.
#[derive(Default)]
pub(super) struct Attachments {
    /// By location; every place is filled when the description ends.
    pub(super) color: Vec<Option<Attachment>>,
    pub(super) depth: Option<Attachment>,
    pub(super) size: [u32; 2],
    pub(super) layers: u32,
}

pub(super) struct Attachment {
    pub(super) resource: ResourceId,
    pub(super) range: Range,
    pub(super) layout: vk::ImageLayout,
    pub(super) load: vk::AttachmentLoadOp,
    pub(super) store: vk::AttachmentStoreOp,
    pub(super) clear: vk::ClearValue,
}

/// What an attachment holds when a pass begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load<T> {
    /// This value everywhere.
    Clear(T),
    /// What it held before.
    Keep,
    /// Anything: the pass writes every pixel it is asked for.
    Discard,
}

/// Bindings and uses that both kinds of pass collect.
pub(super) struct Collected {
    pub(super) pass: PassId,
    pub(super) name: String,
    /// Set 0 over all shaders, with the stages that see each binding.
    table: Vec<(Binding, vk::PipelineStageFlags2, &'static str)>,
    bound: Vec<Bound>,
    uses: Vec<Use>,
}

impl Collected {
    fn new(pass: PassId, name: String, shaders: impl Iterator<Item = &'static Shader>) -> Self {
        let mut table: Vec<(Binding, vk::PipelineStageFlags2, &'static str)> = Vec::new();
        for shader in shaders {
            for binding in shader.bindings.iter().filter(|binding| binding.set == 0) {
                match table.iter_mut().find(|(known, ..)| known.binding == binding.binding) {
                    Some((known, stages, _)) => {
                        *stages |= stage(shader.stage);
                        if known.access != binding.access {
                            known.access = ShaderAccess::ReadWrite;
                        }
                    }
                    None => table.push((*binding, stage(shader.stage), shader.file)),
                }
            }
        }
        Self { pass, name, table, bound: Vec::new(), uses: Vec::new() }
    }

    /// The binding as this pass's shaders have it, with the stages that see it. A slot that none of them has is a
    /// mistake.
    fn find(&self, graph: &mut Graph, slot: &Binding) -> Option<(Binding, vk::PipelineStageFlags2)> {
        let found = self.table.iter().find(|(b, ..)| slot.set == 0 && b.binding == slot.binding && b.name == slot.name);
        if found.is_none() {
            let known: Vec<_> = self.table.iter().map(|(b, ..)| format!("`{}`", b.name)).collect();
            let wrong = "is bound, but the pass's shaders do not have it".into();
            graph.mistake(Some(&self.name), Some(slot.name), wrong, known.join(", "));
        }
        found.map(|&(binding, stages, _)| (binding, stages))
    }

    fn constant(&mut self, graph: &mut Graph, slot: &Binding, what: What) {
        if let Some((binding, _)) = self.find(graph, slot) {
            self.bound.push(Bound { binding, what });
        }
    }

    fn read<H: Handle>(&mut self, graph: &mut Graph, slot: &Binding, handle: &H, sampler: SamplerInfo) {
        let Some((binding, stages)) = self.find(graph, slot) else { return };
        let access = match binding.kind {
            BindingKind::UniformBuffer => Access::uniform(stages),
            BindingKind::StorageBuffer => Access::storage_buffer_read(stages),
            BindingKind::StorageImage => Access::storage_image_read(stages),
            BindingKind::CombinedImageSampler | BindingKind::SampledImage | BindingKind::Sampler => {
                Access::sampled(stages)
            }
        };
        let used = graph.used(binding.name, handle, access);
        self.uses.push(used);
        let what =
            What::Resource { resource: handle.resource(), range: handle.range(), layout: access.layout, sampler };
        self.bound.push(Bound { binding, what });
    }

    fn write<H: Handle>(&mut self, graph: &mut Graph, slot: &Binding, handle: H) -> H {
        let Some((binding, stages)) = self.find(graph, slot) else { return handle };
        let image = binding.kind == BindingKind::StorageImage;
        let access = match (image, binding.access) {
            (true, ShaderAccess::ReadWrite) => Access::storage_image_read_write(stages),
            (true, _) => Access::storage_image_write(stages),
            (false, ShaderAccess::ReadWrite) => Access::storage_buffer_read_write(stages),
            (false, _) => Access::storage_buffer_write(stages),
        };
        // A shader that only stores may store less than all: what was there before stays, unless nothing was.
        let reads = binding.access == ShaderAccess::ReadWrite || !graph.is_undefined(&handle);
        let what = What::Resource {
            resource: handle.resource(),
            range: handle.range(),
            layout: access.layout,
            sampler: SamplerInfo::nearest(),
        };
        let (used, next) = graph.written(self.pass, binding.name, handle, reads, access);
        self.uses.push(used);
        self.bound.push(Bound { binding, what });
        next
    }

    fn finish(self, graph: &mut Graph) -> (String, Vec<Use>, Vec<Bound>) {
        for (binding, _, file) in &self.table {
            let count = self.bound.iter().filter(|bound| bound.binding.binding == binding.binding).count();
            if count != 1 {
                let wrong = format!("is bound {count} times; {file} has it");
                graph.mistake(Some(&self.name), Some(binding.name), wrong, "once".into());
            }
        }
        (self.name, self.uses, self.bound)
    }
}

fn stage(stage: Stage) -> vk::PipelineStageFlags2 {
    match stage {
        Stage::Vertex => vk::PipelineStageFlags2::VERTEX_SHADER,
        Stage::Geometry => vk::PipelineStageFlags2::GEOMETRY_SHADER,
        Stage::Fragment => vk::PipelineStageFlags2::FRAGMENT_SHADER,
        Stage::Compute => vk::PipelineStageFlags2::COMPUTE_SHADER,
    }
}

/// A handle that fits a slot's kind of resource.
pub trait Fits<R>: Handle {}

impl Fits<shader::Image> for ImageHandle {}
impl<T> Fits<shader::Buffer<T>> for BufferHandle {}

/// Bytes that no pass of the frame writes: from the frame's arena, or a buffer of the application's.
pub trait Unchanging {
    #[doc(hidden)]
    fn what(self) -> Constant;
}

#[doc(hidden)]
pub struct Constant(What);

impl Unchanging for Data {
    fn what(self) -> Constant {
        Constant(What::Data(self))
    }
}

impl Unchanging for &Buffer {
    fn what(self) -> Constant {
        Constant(What::Buffer(self.clone()))
    }
}

/// The methods that bind, alike for both kinds of pass.
macro_rules! binding_methods {
    () => {
        /// Gives a uniform block its value.
        pub fn uniform<T: bytemuck::Pod>(&mut self, slot: UniformSlot<T>, value: &T) -> &mut Self {
            let data = self.graph.data(std::slice::from_ref(value));
            self.collected.constant(self.graph, &slot.binding(), What::Data(data));
            self
        }

        /// Binds bytes that do not change while the frame runs, so that nothing needs to be waited for.
        pub fn constant<T>(&mut self, slot: StorageSlot<T, shader::Read>, bytes: impl Unchanging) -> &mut Self {
            self.collected.constant(self.graph, &slot.binding(), bytes.what().0);
            self
        }

        /// Binds an image that does not change while frames run.
        pub fn texture(&mut self, slot: SampledSlot, image: &Image, sampler: SamplerInfo) -> &mut Self {
            self.collected.constant(self.graph, &slot.binding(), What::Image(image.clone(), sampler));
            self
        }

        /// Reads a resource. A slot with a sampler of its own takes the nearest texel; see `sample`.
        pub fn read<S: ReadSlot>(&mut self, slot: S, handle: &impl Fits<S::Resource>) -> &mut Self {
            self.collected.read(self.graph, &slot.binding(), handle, SamplerInfo::nearest());
            self
        }

        /// Reads an image through a sampler.
        pub fn sample(&mut self, slot: SampledSlot, handle: &ImageHandle, sampler: SamplerInfo) -> &mut Self {
            self.collected.read(self.graph, &slot.binding(), handle, sampler);
            self
        }

        /// Writes a resource, and gives its next version. What the shader leaves alone keeps its contents.
        pub fn write<S: WriteSlot, H: Fits<S::Resource>>(&mut self, slot: S, handle: H) -> H {
            self.collected.write(self.graph, &slot.binding(), handle)
        }
    };
}

/// A compute pass being described; [`ComputePass::dispatch`] ends it.
#[must_use = "a pass is recorded by `dispatch`"]
pub struct ComputePass<'g, 'f> {
    graph: &'g mut Graph<'f>,
    collected: Collected,
    shader: &'static Shader,
    constants: Vec<(u32, gpu::Constant)>,
    push: Vec<u8>,
}

impl<'g, 'f> ComputePass<'g, 'f> {
    pub(super) fn new(graph: &'g mut Graph<'f>, name: String, shader: &'static Shader) -> Self {
        let collected = Collected::new(graph.next_pass(), name, [shader].into_iter());
        Self { graph, collected, shader, constants: Vec::new(), push: Vec::new() }
    }

    binding_methods!();

    /// Push constants.
    pub fn push<T: bytemuck::Pod>(&mut self, value: &T) -> &mut Self {
        self.push = bytemuck::bytes_of(value).to_vec();
        self
    }

    /// Value of a specialisation constant.
    pub fn specialize(&mut self, id: u32, value: gpu::Constant) -> &mut Self {
        self.constants.push((id, value));
        self
    }

    /// Runs the shader over at least `invocations`, rounded up to whole workgroups.
    pub fn dispatch(self, invocations: [u32; 3]) {
        let size = self.shader.workgroup;
        let groups = std::array::from_fn(|axis| invocations[axis].div_ceil(size[axis].max(1)));
        self.finish(Groups::Direct(groups));
    }

    /// Runs as many workgroups as three `u32` at `offset` of a buffer say.
    pub fn dispatch_indirect(mut self, groups: &BufferHandle, offset: u64) {
        let used = self.graph.used("indirect dispatch", groups, Access::indirect());
        self.collected.uses.push(used);
        self.finish(Groups::Indirect(groups.resource, offset));
    }

    fn finish(self, groups: Groups) {
        let Self { graph, collected, shader, constants, push } = self;
        let expected = shader.push.map_or(0, |block| block.size as usize);
        if push.len() != expected {
            let wrong = format!("{} bytes are pushed", push.len());
            let allowed = format!("{expected} bytes, as {} takes", shader.file);
            graph.mistake(Some(&collected.name), Some("push constants"), wrong, allowed);
        }
        let (name, uses, bound) = collected.finish(graph);
        graph.push_pass(name, Queue::Compute, uses, Work::Compute { shader, constants, bound, push, groups });
    }
}

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
    pub(super) fn new(graph: &'g mut Graph<'f>, name: String, programs: Vec<Program>) -> Self {
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

    /// Ends the description: `draw` records the draws when the frame is executed.
    pub fn draw(self, draw: impl FnOnce(&mut Recorder) -> Result<()> + 'f) {
        let Self { graph, collected, programs, targets, attachments } = self;
        let name = &collected.name;
        if attachments.size == [0; 2] {
            graph.mistake(Some(name), None, "has no attachment".into(), "colour or depth".into());
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
        let first = self.attachments.size == [0; 2];
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

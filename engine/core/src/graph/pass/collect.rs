//! What both kinds of pass collect: bindings, and the uses that follow from them.

use std::ops::Range;

use ash::vk;

use super::{Bound, What};
use crate::gpu::{QueryKind, SamplerInfo};
use crate::graph::builder::Graph;
use crate::graph::description::{Access, PassId};
use crate::graph::execute::Asked;
use crate::graph::handle::{Handle, ImageHandle};
use crate::graph::name::Name;
use crate::shader::{Binding, BindingKind, Shader, ShaderAccess, Stage};

/// Bindings and uses that both kinds of pass collect.
pub(super) struct Collected {
    pub(super) pass: PassId,
    pub(super) name: Name,
    shaders: Shaders,
    /// The first of this pass, among those of the graph.
    first_bound: usize,
    /// What the device counts over it.
    pub(super) counted: Vec<QueryKind>,
}

/// A binding that shaders of a pass have.
struct Found {
    /// As the first of them has it.
    binding: &'static Binding,
    /// What all of them do to it.
    access: ShaderAccess,
    /// Those that see it.
    stages: vk::PipelineStageFlags2,
}

/// Shaders of a pass.
pub(super) enum Shaders {
    One(&'static Shader),
    Several(Vec<&'static Shader>),
}

impl Shaders {
    fn all(&self) -> &[&'static Shader] {
        match self {
            Self::One(shader) => std::slice::from_ref(shader),
            Self::Several(shaders) => shaders,
        }
    }

    /// Bindings of set 0, each once: as its first shader has it.
    fn bindings(&self) -> impl Iterator<Item = &'static Binding> {
        let of = |shader: &&'static Shader| shader.bindings.iter().filter(|binding| binding.set == 0);
        self.all().iter().enumerate().flat_map(move |(index, shader)| {
            let before = &self.all()[..index];
            let is_new = move |binding: &&Binding| !before.iter().flat_map(of).any(|b| b.binding == binding.binding);
            of(shader).filter(is_new)
        })
    }
}

impl Collected {
    pub(super) fn new(graph: &mut Graph, name: Name, shaders: Shaders) -> Self {
        let (pass, first_bound) = (graph.begin_pass(), graph.bound.len());
        Self { pass, name, shaders, first_bound, counted: Vec::new() }
    }

    /// The binding as this pass's shaders have it together. A slot that none of them has is a mistake.
    fn find(&self, graph: &mut Graph, slot: &Binding) -> Option<Found> {
        let mut found: Option<Found> = None;
        for shader in self.shaders.all() {
            let same = |binding: &&Binding| binding.set == 0 && binding.binding == slot.binding;
            let Some(binding) = shader.bindings.iter().find(same) else { continue };
            let stages = vk::PipelineStageFlags2::NONE;
            let known = found.get_or_insert(Found { binding, access: binding.access, stages });
            known.stages |= stage(shader.stage);
            if known.access != binding.access {
                known.access = ShaderAccess::ReadWrite;
            }
        }
        let same = |a: &str, b: &str| std::ptr::eq::<str>(a, b) || a == b;
        let found = found.filter(|found| slot.set == 0 && same(found.binding.name, slot.name));
        if found.is_none() {
            let known: Vec<_> = self.shaders.bindings().map(|b| format!("`{}`", b.name)).collect();
            let wrong = "is bound, but the pass's shaders do not have it".into();
            graph.mistake(Some(&self.name), Some(slot.name), wrong, known.join(", "));
        }
        found
    }

    pub(super) fn constant(&self, graph: &mut Graph, slot: &Binding, what: What) {
        if let Some(Found { binding, .. }) = self.find(graph, slot) {
            graph.bound.push(Bound { binding: binding.binding, what });
        }
    }

    pub(super) fn read<H: Handle>(
        &self,
        graph: &mut Graph,
        slot: &Binding,
        handle: &H,
        sampler: Option<Box<SamplerInfo>>,
    ) {
        let Some(Found { binding, stages, .. }) = self.find(graph, slot) else { return };
        let access = match binding.kind {
            BindingKind::UniformBuffer => Access::uniform(stages),
            BindingKind::StorageBuffer => Access::storage_buffer_read(stages),
            BindingKind::StorageImage => Access::storage_image_read(stages),
            BindingKind::InputAttachment => Access::ordered_attachment(),
            BindingKind::CombinedImageSampler | BindingKind::SampledImage | BindingKind::Sampler => {
                Access::sampled(stages)
            }
        };
        graph.used(binding.name, handle, access);
        let what =
            What::Resource { resource: handle.resource(), range: handle.range(), layout: access.layout, sampler };
        graph.bound.push(Bound { binding: binding.binding, what });
    }

    pub(super) fn write<H: Handle>(&self, graph: &mut Graph, slot: &Binding, handle: H) -> H {
        let Some(Found { binding, access, stages }) = self.find(graph, slot) else { return handle };
        let image = binding.kind == BindingKind::StorageImage;
        // A shader that only stores may store less than all: what was there before stays, unless nothing was.
        let reads = access == ShaderAccess::ReadWrite || !graph.is_undefined(&handle);
        let access = match (image, access) {
            (true, ShaderAccess::ReadWrite) => Access::storage_image_read_write(stages),
            (true, _) => Access::storage_image_write(stages),
            (false, ShaderAccess::ReadWrite) => Access::storage_buffer_read_write(stages),
            (false, _) => Access::storage_buffer_write(stages),
        };
        let what =
            What::Resource { resource: handle.resource(), range: handle.range(), layout: access.layout, sampler: None };
        let next = graph.written(self.pass, binding.name, handle, reads, access);
        graph.bound.push(Bound { binding: binding.binding, what });
        next
    }

    /// Binds the colour attachment that this pass's fragments read and write in order.
    pub(super) fn attached(&self, graph: &mut Graph, slot: &Binding, handle: &ImageHandle) {
        let Some(Found { binding, .. }) = self.find(graph, slot) else { return };
        let what = What::Resource {
            resource: handle.resource,
            range: handle.range,
            layout: Access::ordered_attachment().layout,
            sampler: None,
        };
        graph.bound.push(Bound { binding: binding.binding, what });
    }

    pub(super) fn finish(self, graph: &mut Graph) -> (Name, Range<usize>) {
        let (shaders, mine) = (self.shaders.all(), self.first_bound..graph.bound.len());
        for (index, shader) in shaders.iter().enumerate() {
            for binding in shader.bindings.iter().filter(|binding| binding.set == 0) {
                let bound = graph.bound[mine.clone()].iter();
                let count = bound.filter(|bound| bound.binding == binding.binding).count();
                let known =
                    |earlier: &&Shader| earlier.bindings.iter().any(|b| b.set == 0 && b.binding == binding.binding);
                if count != 1 && !shaders[..index].iter().any(known) {
                    let wrong = format!("is bound {count} times; {} has it", shader.file);
                    graph.mistake(Some(&self.name), Some(binding.name), wrong, "once".into());
                }
            }
        }
        if !self.counted.is_empty() {
            graph.queries.extend(self.counted.into_iter().map(|kind| Asked { pass: self.pass, kind }));
        }
        (self.name, mine)
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

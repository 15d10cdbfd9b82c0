//! Compute passes.

use smallvec::SmallVec;

use super::bind::{Fits, Unchanging, binding_methods};
use super::collect::{Collected, Shaders};
use super::{Groups, Push, What, Work};
use crate::gpu::{self, Image, SamplerInfo};
use crate::graph::builder::{Data, Graph};
use crate::graph::description::{Access, Queue};
use crate::graph::handle::{BufferHandle, ImageHandle};
use crate::graph::name::Name;
use crate::shader::{self, ConstantSlot, ReadSlot, SampledSlot, Shader, StorageSlot, UniformSlot, WriteSlot};

/// A compute pass being described; [`ComputePass::dispatch`] ends it.
#[must_use = "a pass is recorded by `dispatch`"]
pub struct ComputePass<'g, 'f> {
    graph: &'g mut Graph<'f>,
    collected: Collected,
    shader: &'static Shader,
    constants: Vec<(u32, gpu::Constant)>,
    push: Push<'f>,
}

impl<'g, 'f> ComputePass<'g, 'f> {
    pub(in crate::graph) fn new(graph: &'g mut Graph<'f>, name: Name, shader: &'static Shader) -> Self {
        let collected = Collected::new(graph, name, Shaders::One(shader));
        Self { graph, collected, shader, constants: Vec::new(), push: Push::Bytes(SmallVec::new()) }
    }

    binding_methods!();

    /// Push constants.
    pub fn push<T: bytemuck::Pod>(&mut self, value: &T) -> &mut Self {
        self.push = Push::Bytes(SmallVec::from_slice(bytemuck::bytes_of(value)));
        self
    }

    /// Push constants that are asked for each time the pass is recorded: they may change from run to run of a
    /// [`crate::graph::Prepared`] frame.
    pub fn push_with<T: bytemuck::Pod>(&mut self, mut value: impl FnMut() -> T + 'f) -> &mut Self {
        let write = move |bytes: &mut [u8]| bytes.copy_from_slice(bytemuck::bytes_of(&value()));
        self.push = Push::Asked(size_of::<T>(), Box::new(write));
        self
    }

    /// Value of a specialisation constant.
    pub fn specialize<T: Into<gpu::Constant>>(&mut self, slot: ConstantSlot<T>, value: T) -> &mut Self {
        self.constants.push((slot.id(), value.into()));
        self
    }

    /// Runs the shader over at least `invocations`, rounded up to whole workgroups.
    pub fn dispatch(self, invocations: [u32; 3]) {
        let size = self.shader.workgroup;
        let groups: [u32; 3] = std::array::from_fn(|axis| invocations[axis].div_ceil(size[axis].max(1)));
        let most = self.graph.caps.limits.max_compute_workgroup_count;
        if groups.iter().zip(most).any(|(&groups, most)| groups > most && most > 0) {
            let wrong = format!("{groups:?} workgroups are dispatched");
            let allowed = format!("at most {most:?} on this device: put them into rows along y");
            self.graph.mistake(Some(&self.collected.name), None, wrong, allowed);
        }
        self.finish(Groups::Direct(groups));
    }

    /// Runs as many workgroups as three `u32` at `offset` of a buffer say.
    pub fn dispatch_indirect(self, groups: &BufferHandle, offset: u64) {
        if !offset.is_multiple_of(4) || offset.checked_add(12).is_none_or(|end| end > groups.size()) {
            let wrong = format!("12 bytes at {offset} of {} are dispatched", groups.size());
            let allowed = "three u32 within the buffer, at a multiple of 4".into();
            self.graph.mistake(Some(&self.collected.name), Some("indirect dispatch"), wrong, allowed);
        }
        self.graph.used("indirect dispatch", groups, Access::indirect());
        self.finish(Groups::Indirect { buffer: groups.resource, version: groups.version, offset });
    }

    #[inline]
    fn finish(self, groups: Groups) {
        let Self { graph, collected, shader, constants, push } = self;
        let expected = shader.push.map_or(0, |block| block.size as usize);
        if push.size() != expected {
            let wrong = format!("{} bytes are pushed", push.size());
            let allowed = format!("{expected} bytes, as {} takes", shader.file);
            graph.mistake(Some(&collected.name), Some("push constants"), wrong, allowed);
        }
        let (name, bound) = collected.finish(graph);
        graph.push_pass(name, Queue::Compute, Work::Compute { shader, constants, bound, push, groups });
    }
}

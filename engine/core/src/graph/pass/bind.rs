//! Binding resources to slots, alike for both kinds of pass.

use super::What;
use crate::gpu::Buffer;
use crate::graph::builder::Data;
use crate::graph::handle::{BufferHandle, Handle, ImageHandle};
use crate::shader;

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
pub struct Constant(pub(super) What);

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
        /// Counts what the pipeline does over this pass, which therefore runs whoever reads what it writes
        /// ([`crate::graph::Executed::statistic`]). Once a pass; needs `pipelineStatisticsQuery`.
        pub fn statistics(&mut self, counters: ash::vk::QueryPipelineStatisticFlags) -> &mut Self {
            self.collected.counted.push(crate::gpu::QueryKind::Statistics(counters));
            self
        }

        /// Gives a uniform block its value.
        pub fn uniform<T: bytemuck::Pod>(&mut self, slot: UniformSlot<T>, value: &T) -> &mut Self {
            let data = self.graph.data(std::slice::from_ref(value));
            self.collected.constant(self.graph, &slot.binding(), What::Data(data));
            self
        }

        /// Gives a uniform block its value from the frame's arena: one that follows from a checkpoint.
        pub fn uniform_data<T>(&mut self, slot: UniformSlot<T>, data: Data) -> &mut Self {
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
            self.collected.constant(self.graph, &slot.binding(), What::Image(image.clone(), Box::new(sampler)));
            self
        }

        /// Reads a resource. A slot with a sampler of its own takes the nearest texel; see `sample`.
        pub fn read<S: ReadSlot>(&mut self, slot: S, handle: &impl Fits<S::Resource>) -> &mut Self {
            self.collected.read(self.graph, &slot.binding(), handle, None);
            self
        }

        /// Reads an image through a sampler.
        pub fn sample(&mut self, slot: SampledSlot, handle: &ImageHandle, sampler: SamplerInfo) -> &mut Self {
            self.collected.read(self.graph, &slot.binding(), handle, Some(Box::new(sampler)));
            self
        }

        /// Writes a resource, and gives its next version. What the shader leaves alone keeps its contents.
        pub fn write<S: WriteSlot, H: Fits<S::Resource>>(&mut self, slot: S, handle: H) -> H {
            self.collected.write(self.graph, &slot.binding(), handle)
        }
    };
}

pub(super) use binding_methods;

//! What a build script says of shaders: SPIR-V, reflected bindings, and typed slots; and programs made of them.

mod binding;
mod program;
mod slot;
mod specialize;

pub use binding::{Binding, BindingKind, ImageType, Input, Output, OutputScalar, Push, Shader, ShaderAccess, Stage};
pub use program::{Pipelines, Program, Targets, Wanted};
pub use slot::{
    Access, Buffer, ColorSlot, ConstantSlot, Image, ImageSlot, InputSlot, Read, ReadSlot, ReadWrite, SampledSlot,
    SamplerSlot, Slot, StorageSlot, UniformSlot, WithTail, Write, WriteSlot,
};
pub(crate) use specialize::specialized;

//! Typed names of what a shader binds: using one for what it is not does not compile.
//!
//! ```
//! use shadowgraph_core::shader::{Buffer, ImageSlot, Read, ReadSlot, ReadWrite, SampledSlot, Slot, StorageSlot, UniformSlot, Write, WriteSlot};
//!
//! fn read(_: impl ReadSlot) {}
//! fn write(_: impl WriteSlot) {}
//! fn buffer_of_words(_: impl Slot<Resource = Buffer<u32>>) {}
//!
//! fn fits(a: SampledSlot, b: ImageSlot<Write>, c: StorageSlot<u32, Read>, d: StorageSlot<u32, ReadWrite>, e: UniformSlot<f32>) {
//!     read(a);
//!     write(b);
//!     read(c);
//!     write(d);
//!     read(e);
//!     buffer_of_words(c);
//! }
//! ```
//!
//! A slot that the shader writes through is not read by a pass, nor the other way round; contents count:
//!
//! ```compile_fail,E0277
//! # use shadowgraph_core::shader::{ImageSlot, ReadSlot, ReadWrite};
//! # fn read(_: impl ReadSlot) {}
//! fn misuse(slot: ImageSlot<ReadWrite>) {
//!     read(slot);
//! }
//! ```
//!
//! ```compile_fail,E0277
//! # use shadowgraph_core::shader::{SampledSlot, WriteSlot};
//! # fn write(_: impl WriteSlot) {}
//! fn misuse(slot: SampledSlot) {
//!     write(slot);
//! }
//! ```
//!
//! ```compile_fail,E0271
//! # use shadowgraph_core::shader::{Buffer, Read, Slot, StorageSlot};
//! # fn buffer_of_words(_: impl Slot<Resource = Buffer<u32>>) {}
//! fn misuse(slot: StorageSlot<f32, Read>) {
//!     buffer_of_words(slot);
//! }
//! ```

use std::fmt;
use std::marker::PhantomData;

use super::{Binding, Output, Shader, ShaderAccess};

/// Marker: the shader only loads.
#[derive(Clone, Copy, Debug)]
pub enum Read {}
/// Marker: the shader only stores, so the old contents do not matter.
#[derive(Clone, Copy, Debug)]
pub enum Write {}
/// Marker: the shader loads and stores, or has atomics.
#[derive(Clone, Copy, Debug)]
pub enum ReadWrite {}

/// [`Read`], [`Write`] or [`ReadWrite`].
pub trait Access {
    /// The marker as a value.
    const ACCESS: ShaderAccess;
}

impl Access for Read {
    const ACCESS: ShaderAccess = ShaderAccess::Read;
}
impl Access for Write {
    const ACCESS: ShaderAccess = ShaderAccess::Write;
}
impl Access for ReadWrite {
    const ACCESS: ShaderAccess = ShaderAccess::ReadWrite;
}

/// Marker of slots that take an image.
#[derive(Clone, Copy, Debug)]
pub enum Image {}

/// Marker of slots that take a buffer of `T`.
pub struct Buffer<T>(PhantomData<fn() -> T>);

/// Contents of a storage block with a fixed part and, after it, a run-time array.
pub struct WithTail<Head, Element>(PhantomData<fn() -> (Head, Element)>);

/// A slot that is bound to a resource.
pub trait Slot: Copy {
    /// [`Image`], or [`Buffer`] of the block's struct (of the element, where the block is but a run-time array).
    type Resource;
    /// Where it is bound, and how.
    fn binding(&self) -> Binding;
    /// The shader whose slot it is.
    fn shader(&self) -> &'static Shader;
}

/// A slot that a pass only reads through.
pub trait ReadSlot: Slot {}

/// A slot that a pass writes through. Whether it reads as well is in its binding's access.
pub trait WriteSlot: Slot {}

macro_rules! slot {
    ($(#[$doc:meta])* $name:ident $(<$($parameter:ident),+>)?) => {
        $(#[$doc])*
        pub struct $name $(<$($parameter),+>)? {
            binding: Binding,
            shader: &'static Shader,
            content: PhantomData<fn() -> ($($($parameter,)+)?)>,
        }

        impl $(<$($parameter),+>)? $name $(<$($parameter),+>)? {
            /// A slot of `shader`; for generated code.
            pub const fn new(binding: Binding, shader: &'static Shader) -> Self {
                Self { binding, shader, content: PhantomData }
            }

            /// Where it is bound, and how.
            pub const fn binding(&self) -> Binding {
                self.binding
            }

            /// The shader whose slot it is.
            pub const fn shader(&self) -> &'static Shader {
                self.shader
            }
        }

        impl $(<$($parameter),+>)? Clone for $name $(<$($parameter),+>)? {
            fn clone(&self) -> Self {
                *self
            }
        }

        impl $(<$($parameter),+>)? Copy for $name $(<$($parameter),+>)? {}

        impl $(<$($parameter),+>)? fmt::Debug for $name $(<$($parameter),+>)? {
            fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
                write!(f, "{} of {}", self.binding.name, self.shader.file)
            }
        }
    };
}

slot! {
    /// Typed name of a uniform block: `T` is the generated struct.
    UniformSlot<T>
}
slot! {
    /// Typed name of a storage block: `T` is the generated struct of its fixed part, its element where it is nothing
    /// but a run-time array, or [`WithTail`] of both; `A` is what the shader does to it.
    StorageSlot<T, A>
}
slot! {
    /// Typed name of an image to be sampled, with its sampler or without.
    SampledSlot
}
slot! {
    /// Typed name of a storage image; `A` is what the shader does to it.
    ImageSlot<A>
}
slot! {
    /// Typed name of an input attachment: the pass's colour attachment as the pixel's earlier fragments left it.
    InputSlot
}
slot! {
    /// Typed name of a sampler without an image.
    SamplerSlot
}

macro_rules! resource {
    ($resource:ty, $name:ty $(, $parameter:ident)*) => {
        impl<$($parameter),*> Slot for $name {
            type Resource = $resource;

            fn binding(&self) -> Binding {
                self.binding
            }

            fn shader(&self) -> &'static Shader {
                self.shader
            }
        }
    };
}

resource!(Buffer<T>, UniformSlot<T>, T);
resource!(Buffer<T>, StorageSlot<T, A>, T, A);
resource!(Image, SampledSlot);
resource!(Image, ImageSlot<A>, A);

impl<T> ReadSlot for UniformSlot<T> {}
impl<T> ReadSlot for StorageSlot<T, Read> {}
impl ReadSlot for SampledSlot {}
impl ReadSlot for ImageSlot<Read> {}

impl<T> WriteSlot for StorageSlot<T, Write> {}
impl<T> WriteSlot for StorageSlot<T, ReadWrite> {}
impl WriteSlot for ImageSlot<Write> {}
impl WriteSlot for ImageSlot<ReadWrite> {}

/// Typed name of a fragment shader's colour output.
#[derive(Clone, Copy)]
pub struct ColorSlot {
    output: Output,
    shader: &'static Shader,
}

impl ColorSlot {
    /// A slot of `shader`; for generated code.
    pub const fn new(output: Output, shader: &'static Shader) -> Self {
        Self { output, shader }
    }

    /// Its location and type.
    pub const fn output(&self) -> Output {
        self.output
    }

    /// The shader whose slot it is.
    pub const fn shader(&self) -> &'static Shader {
        self.shader
    }
}

impl fmt::Debug for ColorSlot {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} of {}", self.output.name, self.shader.file)
    }
}

/// Typed name of a specialization constant of a `bool`, `i32`, `u32` or `f32`.
pub struct ConstantSlot<T> {
    id: u32,
    shader: &'static Shader,
    value: PhantomData<fn(T)>,
}

impl<T> ConstantSlot<T> {
    /// A slot of `shader`; for generated code.
    pub const fn new(id: u32, shader: &'static Shader) -> Self {
        Self { id, shader, value: PhantomData }
    }

    /// `layout(constant_id = …)`.
    pub const fn id(&self) -> u32 {
        self.id
    }

    /// The shader whose slot it is.
    pub const fn shader(&self) -> &'static Shader {
        self.shader
    }
}

impl<T> Clone for ConstantSlot<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for ConstantSlot<T> {}

impl<T> fmt::Debug for ConstantSlot<T> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "constant {} of {}", self.id, self.shader.file)
    }
}

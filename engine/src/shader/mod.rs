//! Shaders as the build script makes them: SPIR-V, reflected bindings, and typed slots.
//!
//! [`generated`] has one module a folder of `shaders_glsl/` and one a shader file in it, named after the file
//! with the dot turned into an underscore (`depth.vert` is `depth_vert`). Such a module has
//!
//! - `SHADER`, the [`Shader`];
//! - a typed slot a binding, a fragment output and a specialization constant, in capitals: `shadowMap` is
//!   `SHADOW_MAP`. Bindings that the compiler finds unused are no slots;
//! - `Push`, the type of its push constants, where it has some.
//!
//! Every block and struct is a plain struct of [`generated::blocks`], with the shader's offsets: `vec2` and `vec3` are
//! `glam`'s, wider ones and matrices are arrays (`[f32; 4]`, `[[f32; 4]; 4]` by columns), into which `glam`'s convert
//! by `to_array` and `to_cols_array_2d`. A device address is a `u64`. A block of an include is one type for all.
//! [`generated::ALL`] lists every shader.

mod binding;
mod program;
mod slot;

pub use binding::{Binding, BindingKind, ImageType, Input, Output, OutputScalar, Push, Shader, ShaderAccess, Stage};
pub use program::{Pipelines, Program, Targets, Wanted};
pub use slot::{
    Access, Buffer, ColorSlot, ConstantSlot, Image, ImageSlot, Read, ReadSlot, ReadWrite, SampledSlot, SamplerSlot,
    Slot, StorageSlot, UniformSlot, WithTail, Write, WriteSlot,
};

/// Modules generated from `shaders_glsl/`.
#[allow(missing_docs, clippy::all)]
#[rustfmt::skip]
pub mod generated {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}

/// SPIR-V, little-endian in a file, as aligned words.
const fn words<const N: usize>(bytes: &[u8]) -> [u32; N] {
    let mut words = [0; N];
    let mut i = 0;
    while i < N {
        words[i] = u32::from_le_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]]);
        i += 1;
    }
    words
}

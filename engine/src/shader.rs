//! Shaders as the build script makes them: SPIR-V, reflected bindings, and typed slots; and programs made of them.
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

pub use shadowgraph_core::shader::*;

/// Modules generated from `shaders_glsl/`.
#[allow(missing_docs, clippy::all)]
#[rustfmt::skip]
pub mod generated {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}

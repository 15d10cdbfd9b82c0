//! Shaders as the build script makes them: SPIR-V, reflected bindings, and typed slots.
//!
//! [`generated`] has one module a folder of `shaders_glsl/` and one a shader file in it, named after the file
//! with the dot turned into an underscore (`depth.vert` is `depth_vert`).

mod binding;

pub use binding::{
    Binding, BindingKind, ColorSlot, ImageSlot, Output, OutputScalar, Push, Shader, ShaderAccess, Stage, StorageSlot,
    UniformSlot,
};

/// Modules generated from `shaders_glsl/`.
#[allow(missing_docs, clippy::all)]
pub mod generated {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}

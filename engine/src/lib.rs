//! Explicit Vulkan rendering with a render graph, made to answer visibility questions.
#![deny(unsafe_code)]
pub mod error;
pub mod gpu;
pub mod graph;
pub mod scene;
pub mod shader;
pub use error::{Error, Result};

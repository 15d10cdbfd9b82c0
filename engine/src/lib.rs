//! Explicit Vulkan rendering with a render graph, made to answer visibility questions.
#![deny(unsafe_code)]
pub mod capture;
pub mod error;
pub mod frame;
pub mod geometry;
pub mod gpu;
pub mod graph;
pub mod scene;
pub mod shader;
pub mod techniques;
pub use error::{Error, Result};

//! The render graph: describe, plan, execute, report.
mod access;
mod builder;
pub mod description;
mod handle;
mod pass;
mod record;

pub use builder::{Data, Graph};
pub use description::ImageShape;
pub use handle::{BufferHandle, Handle, ImageHandle};
pub use pass::{ComputePass, Load, RasterPass};
pub use record::Recorder;

/// All that is wrong with a graph.
#[derive(Debug, thiserror::Error)]
#[error("placeholder")]
pub struct GraphErrors;

//! The render graph: describe, plan, execute, report.
mod access;
mod builder;
mod checkpoint;
mod debug;
pub mod description;
mod errors;
mod execute;
mod handle;
mod history;
mod name;
mod parts;
mod pass;
pub mod plan;
mod record;
pub mod report;

pub use builder::{Data, Graph};
pub use checkpoint::Checkpoint;
pub use description::ImageShape;
pub use errors::{ErrorKind, GraphError, GraphErrors};
pub use execute::{Capture, Counts, Executed, Executor, PassCount, PassTime, Prepared};
pub use handle::{BufferHandle, Handle, ImageHandle};
pub use history::{First, History};
pub use name::Name;
pub use pass::{ComputePass, Fits, Load, RasterPass, Unchanging};
pub use record::Recorder;

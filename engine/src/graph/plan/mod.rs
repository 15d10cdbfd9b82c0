//! Planning: from a description to a plan. Pure functions over plain data.

mod device;
mod output;
mod reason;

pub use device::{DeviceModel, Requirements, Usage};
pub use output::{
    Barriers, Batch, BufferBarrier, Heap, ImageBarrier, Lifetime, MemoryBarrier, Ownership, Placement, Plan,
    Statistics, Step, Wait, Work,
};
pub use reason::{CullReason, Hazard, Reason};

use super::description::Description;
use super::errors::GraphErrors;

/// Plans a frame for a device.
///
/// # Errors
/// All that is wrong with the description, at once.
pub fn plan(_description: &Description, _device: &dyn DeviceModel) -> Result<Plan, GraphErrors> {
    Ok(Plan::default())
}

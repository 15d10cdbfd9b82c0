//! The harness of the tests that compare what the engine renders with the references.

#![cfg_attr(test, allow(clippy::unwrap_used))]

pub use shadowgraph_references::{compare, exr_file, flip, hazard, judge, packing, parallel, tiny, twin};

pub mod browser;
pub mod device;
pub mod figures;
pub mod harness;
pub mod kitchen;
pub mod marched;
pub mod panes;
pub mod peeled;
pub mod plot;
pub mod render;
pub mod solids;
pub mod soup;
pub mod voxel_pictures;

//! CPU references ("twins") of what the engine computes, in double precision and written from papers and
//! specifications, and the harness of the tests that compare the two.

#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod browser;
pub mod compare;
pub mod device;
pub mod exr_file;
pub mod figures;
pub mod flip;
pub mod harness;
pub mod hazard;
pub mod judge;
pub mod kitchen;
pub mod marched;
pub mod packing;
pub mod panes;
pub mod parallel;
pub mod peeled;
pub mod plot;
pub mod render;
pub mod solids;
pub mod soup;
pub mod tiny;
pub mod twin;
pub mod voxel_pictures;

//! CPU references ("twins") of what the engine computes, in double precision and written from papers and
//! specifications; how pictures are compared with them; and a checker of plans that knows nothing of the planner.

#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod compare;
pub mod exr_file;
pub mod flip;
pub mod hazard;
pub mod judge;
pub mod packing;
pub mod parallel;
pub mod tiny;
pub mod twin;

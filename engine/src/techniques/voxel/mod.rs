//! Which points lie inside the scene's solids, and which on its surfaces? Every technique of this family turns triangles
//! into the bits of one regular grid, by the conventions of [`Grid`].

pub mod bitmask;
pub mod conservative;
mod grid;
pub mod six_separating;
mod surface;

pub use grid::{Axis, Grid, MAX_RESOLUTION, VoxelBits, Voxels};

//! Which points lie inside the scene's solids, and which on its surfaces? Every technique of this family turns triangles
//! into the bits of one regular grid, by the conventions of [`Grid`].

pub mod attributes;
pub mod bitmask;
pub mod bricks;
mod columns;
pub mod conservative;
mod cover;
mod grid;
mod ranks;
pub mod ray_marching;
pub mod six_separating;
pub mod stencil;
mod surface;
pub mod vote;
mod voxels;
pub mod winding;

pub use columns::FillRule;
pub use grid::{Axis, Grid, MAX_RESOLUTION, VoxelBits};
pub use voxels::Voxels;

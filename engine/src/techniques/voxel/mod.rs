//! Which points lie inside the scene's solids, and which on its surfaces? Every technique of this family turns triangles
//! into the bits of one regular grid, by the conventions of [`Grid`].

pub mod ambient_occlusion;
pub mod atlas;
pub mod attributes;
pub mod bitmask;
mod columns;
pub mod conservative;
mod cover;
mod grid;
mod pyramid;
pub mod ray_marching;
pub mod six_separating;
pub mod stencil;
mod surface;
pub mod vote;
pub mod winding;

pub use columns::FillRule;
pub use grid::{Axis, Grid, MAX_RESOLUTION, VoxelBits, Voxels};
pub use pyramid::{Level, Occluders, Pyramid};
pub use surface::Surfaces;

/// How far from a plane, in voxels, a point is in none of the voxels that [`six_separating`] sets for it. Those have
/// their centre within half a voxel along the plane's main axis, and a point of one is within half a voxel of its centre
/// along each axis: together √6 / 2 at most, for normals along (2, 1, 1).
pub const CLEAR_OF_SURFACE: f32 = 1.25;

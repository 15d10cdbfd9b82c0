//! Which points lie inside the scene's solids, and which on its surfaces? Every technique of this family turns triangles
//! into the bits of one regular grid, by the conventions of [`Grid`].

pub mod ambient_occlusion;
pub mod atlas;
pub mod attributes;
pub mod bitmask;
pub mod bricks;
mod columns;
pub mod conservative;
mod cover;
mod frustum;
mod grid;
mod image;
mod pyramid;
mod ranks;
pub mod ray_marching;
pub mod six_separating;
mod slabs;
pub mod stencil;
mod surface;
pub mod vote;
mod voxel_set;
mod voxels;
pub mod winding;

pub use columns::FillRule;
pub use frustum::{FrustumBits, FrustumGrid};
pub use grid::{Axis, Grid, MAX_RESOLUTION, VoxelBits};
pub use image::{TEXEL, Tiles, tiled_image, volume_image};
pub use pyramid::{Level, Occluders, Pyramid};
pub use surface::Surfaces;
pub use voxel_set::VoxelSet;
pub use voxels::Voxels;

/// How far from a plane, in voxels, a point is in none of the voxels that [`six_separating`] sets for it. Those have
/// their centre within half a voxel along the plane's main axis, and a point of one is within half a voxel of its centre
/// along each axis: together √6 / 2 at most, for normals along (2, 1, 1).
pub const CLEAR_OF_SURFACE: f32 = 1.25;

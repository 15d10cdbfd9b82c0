//! Drawing a scene's triangles into the columns of a grid: what the techniques share that look along an axis.

use super::{Axis, Grid};
use crate::gpu::Caps;
use crate::graph::RasterPass;
use crate::scene::{GpuScene, POSITIONS};
use crate::shader::generated::voxel::bitmask::columns_vert;
use crate::shader::{Program, Shader};

/// What is inside, of the points that a surface encloses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FillRule {
    /// What the surface winds around: before it lie more crossings one way than the other. Solids that overlap are one.
    #[default]
    NonZero,
    /// What lies behind an odd number of crossings, whichever way the surface faces. Solids that overlap cancel out.
    EvenOdd,
}

/// A program whose vertex shader is made of `common/voxel_columns.glsl`.
pub(super) fn program(caps: &Caps, vertex: &'static Shader, fragment: &'static Shader) -> Program {
    let subpixels = 1 << caps.limits.sub_pixel_bits;
    Program::new(vertex, Some(fragment)).vertex_buffers(POSITIONS).constant(columns_vert::SUBPIXELS, subpixels)
}

/// Binds what its vertex shader reads.
pub(super) fn bind(pass: &mut RasterPass, scene: &GpuScene, grid: &Grid, axis: Axis) {
    pass.uniform(columns_vert::VOXEL_GRID, &grid.block(axis)).constant(columns_vert::INSTANCES, &scene.instances);
}

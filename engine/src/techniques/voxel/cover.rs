//! Drawing a scene's triangles over every row of voxels they may touch: for programs with the vertex shader of
//! `common/voxel_cover.glsl`, whose vertices are pulled.

use super::{Axis, Grid, surface};
use crate::graph::RasterPass;
use crate::scene::GpuScene;
use crate::shader::generated::voxel::conservative::cover_vert;

/// Binds what that shader reads; the pass has a pixel a row of voxels, along whichever axis.
pub(super) fn bind(pass: &mut RasterPass, scene: &GpuScene, grid: &Grid, axis: Axis) {
    let side = grid.size().into_iter().max().unwrap_or(1);
    pass.area([side; 2])
        .uniform(cover_vert::VOXEL_GRID, &grid.block(axis))
        .uniform(
            cover_vert::TOUCH,
            &surface::touch(scene, grid, &surface::triangle_starts(scene, surface::Surfaces::All)),
        )
        .constant(cover_vert::INSTANCES, &scene.instances)
        .constant(cover_vert::INDICES, &scene.indices)
        .constant(cover_vert::POSITIONS, &scene.positions);
}

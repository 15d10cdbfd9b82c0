//! Drawing a scene's triangles over every row of voxels they may touch: for programs with the vertex shader of
//! `common/voxel_cover.glsl`, whose vertices are pulled.

use super::{Axis, Grid, surface};
use crate::Result;
use crate::graph::RasterPass;
use crate::scene::{Faces, GpuScene};
use crate::shader::generated::blocks;
use crate::shader::generated::voxel::conservative::cover_vert;

/// Binds what that shader reads; the pass has a pixel a row of voxels, along whichever axis. Voxels are grown by `spare` on
/// every side, in voxels, beside what rounding asks for.
///
/// # Errors
/// As [`surface::triangle_count`].
pub(super) fn bind(pass: &mut RasterPass, scene: &GpuScene, grid: &Grid, axis: Axis, spare: f32) -> Result<()> {
    let touch = surface::touch(scene, grid, surface::Surfaces::All)?;
    let side = grid.size().into_iter().max().unwrap_or(1);
    pass.area([side; 2])
        .uniform(cover_vert::VOXEL_GRID, &grid.block(axis))
        .uniform(cover_vert::TOUCH, &blocks::Touch { reach: touch.reach + spare, ..touch })
        .constant(cover_vert::INSTANCES, &scene.instances)
        .constant(cover_vert::INDICES, &scene.indices)
        .constant(cover_vert::POSITIONS, &scene.positions);
    Ok(())
}

/// Draws every triangle, and ends the pass.
pub(super) fn draw<'f>(pass: RasterPass<'_, 'f>, scene: &'f GpuScene) {
    pass.draw(move |recorder| {
        scene.draw_pulled(recorder, Faces::Both, scene.draws.draws());
        Ok(())
    });
}

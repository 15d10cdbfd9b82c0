//! Conservative surface voxelization: every voxel whose closed box a triangle touches.
//!
//! Source: Akenine-Möller 2001, "Fast 3D Triangle-Box Overlap Testing", for the axes; Schwarz and Seidel 2010, "Fast
//! Parallel Surface and Solid Voxelization on GPUs", section 3, for a triangle an invocation and columns of voxels;
//! Hasselgren, Akenine-Möller and Ohlsson 2005, "Conservative Rasterization", GPU Gems 2, for triangles moved apart.

use super::{Axis, Grid, Surfaces, VoxelBits, cover, surface};
use crate::Result;
use crate::geometry::Aabb;
use crate::graph::Graph;
use crate::scene::GpuScene;
use crate::shader::Program;
use crate::shader::generated::voxel::conservative::{cover_frag, cover_vert, large_comp, small_comp};

/// Conservative surface voxelization. Surfaces need not be closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Conservative {
    /// The axis that columns of bits run along.
    pub axis: Axis,
    /// What finds the voxels; both ways give the same bits.
    pub pipeline: Pipeline,
}

/// What finds the voxels that a triangle touches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pipeline {
    /// Compute shaders: a triangle an invocation, a large one dealt out over many.
    #[default]
    Compute,
    /// The rasteriser, along the axis that a triangle faces most: a row of voxels a fragment.
    Raster,
}

impl Conservative {
    /// Sets the voxels whose closed boxes, grown by [`Conservative::margin`], a triangle touches. No voxel whose own box
    /// is touched is missed.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the device cannot bind so many bits at once.
    pub fn record<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid) -> Result<VoxelBits> {
        match self.pipeline {
            Pipeline::Compute => surface::record(
                graph,
                scene,
                grid,
                self.axis,
                Surfaces::All,
                [&small_comp::SHADER, &large_comp::SHADER],
            ),
            Pipeline::Raster => self.rasterize(graph, scene, grid),
        }
    }

    fn rasterize<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid) -> Result<VoxelBits> {
        let VoxelBits { bits, grid, axis } = VoxelBits::new(graph, "voxel.bits", grid, self.axis)?;
        let bits = graph.fill("voxel.clear", bits, 0);
        let program = Program::new(&cover_vert::SHADER, Some(&cover_frag::SHADER));
        let mut pass = graph.raster("voxel.surface.cover", vec![program]);
        cover::bind(&mut pass, scene, &grid, axis, 0.0)?;
        let bits = pass.write(cover_frag::BITS, bits);
        cover::draw(pass, scene);
        Ok(VoxelBits { bits, grid, axis })
    }

    /// ε, by which voxels are grown on every side so that rounding loses none: 1e-4 voxel, or four units in the last
    /// place of the largest coordinate, in voxels.
    pub fn margin(grid: &Grid, scene: &Aabb) -> f32 {
        surface::margin(grid, scene)
    }
}

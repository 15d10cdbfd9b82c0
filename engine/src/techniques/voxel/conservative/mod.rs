//! Conservative surface voxelization: every voxel whose closed box a triangle touches.
//!
//! Source: Akenine-Möller 2001, "Fast 3D Triangle-Box Overlap Testing", for the axes; Schwarz and Seidel 2010, "Fast
//! Parallel Surface and Solid Voxelization on GPUs", section 3, for a triangle an invocation and columns of voxels.

use super::{Axis, Grid, VoxelBits, surface};
use crate::Result;
use crate::geometry::Aabb;
use crate::graph::Graph;
use crate::scene::GpuScene;
use crate::shader::generated::voxel::conservative::{large_comp, small_comp};

/// Conservative surface voxelization. Surfaces need not be closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Conservative {
    /// The axis that columns of bits run along.
    pub axis: Axis,
}

impl Conservative {
    /// Sets the voxels whose closed boxes, grown by [`Conservative::margin`], a triangle touches. No voxel whose own box
    /// is touched is missed.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the device cannot bind so many bits at once.
    pub fn record<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid) -> Result<VoxelBits> {
        let shaders = [&small_comp::SHADER, &large_comp::SHADER];
        surface::record(graph, scene, grid, self.axis, shaders)
    }

    /// ε, by which voxels are grown on every side so that rounding loses none: 1e-4 voxel, or four units in the last
    /// place of the largest coordinate, in voxels.
    pub fn margin(grid: &Grid, scene: &Aabb) -> f32 {
        surface::margin(grid, scene)
    }
}

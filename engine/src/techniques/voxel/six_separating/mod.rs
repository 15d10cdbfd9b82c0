//! Thin surface voxelization: as few voxels as no path from face to face of voxels slips through.
//!
//! Source: Schwarz and Seidel 2010, "Fast Parallel Surface and Solid Voxelization on GPUs", section 4: a voxel stands for
//! the three segments that join the centres of its opposite faces.

use super::{Axis, Grid, Surfaces, VoxelBits, surface};
use crate::Result;
use crate::graph::Graph;
use crate::scene::GpuScene;
use crate::shader::generated::voxel::six_separating::{large_comp, small_comp};

/// 6-separating surface voxelization. Surfaces need not be closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SixSeparating {
    /// The axis that columns of bits run along.
    pub axis: Axis,
    /// Which surfaces count.
    pub surfaces: Surfaces,
}

impl SixSeparating {
    /// Sets the voxels of a thin surface. All of them are among those of
    /// [`Conservative`](super::conservative::Conservative).
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the device cannot bind so many bits at once.
    pub fn record<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid) -> Result<VoxelBits> {
        let shaders = [&small_comp::SHADER, &large_comp::SHADER];
        surface::record(graph, scene, grid, self.axis, self.surfaces, shaders)
    }
}

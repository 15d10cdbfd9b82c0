//! Bits of voxels on the device, as a whole or in bricks: what reads them takes either.

use super::bricks::BrickBits;
use super::ranks::Ranks;
use super::{Axis, Grid, VoxelBits};
use crate::graph::{BufferHandle, ComputePass, Graph};
use crate::shader::generated::voxel::ray_marching::march_comp;

/// Bits of a grid on the device: of all of it ([`VoxelBits`]), or in bricks where some are set ([`BrickBits`]).
pub trait VoxelSet {
    /// Where the voxels are.
    fn grid(&self) -> &Grid;

    /// The axis that columns run along; of bricks z.
    fn axis(&self) -> Axis;

    /// The words with the voxels' bits.
    fn words(&self) -> &BufferHandle;

    /// The bricks that they are in.
    fn bricks(&self) -> Option<&BrickBits>;
}

/// A place for each set voxel.
pub(super) fn ranks(graph: &mut Graph, name: &str, voxels: &impl VoxelSet) -> Ranks {
    match voxels.bricks() {
        Some(BrickBits { bricks, count, .. }) => Ranks::of_bricks(graph, name, bricks, count),
        None => Ranks::of_grid(graph, name, voxels.words(), voxels.grid().words(voxels.axis())),
    }
}

impl VoxelSet for VoxelBits {
    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn axis(&self) -> Axis {
        self.axis
    }

    fn words(&self) -> &BufferHandle {
        &self.bits
    }

    fn bricks(&self) -> Option<&BrickBits> {
        None
    }
}

impl VoxelSet for BrickBits {
    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn axis(&self) -> Axis {
        self.coarse.axis
    }

    fn words(&self) -> &BufferHandle {
        &self.bricks
    }

    fn bricks(&self) -> Option<&BrickBits> {
        Some(self)
    }
}

/// Binds what `common/voxel_bits.glsl` reads.
pub(super) fn bind(pass: &mut ComputePass, voxels: &impl VoxelSet) {
    let words = voxels.words();
    let [coarse, firsts] = voxels.bricks().map_or([words; 2], |bricks| [&bricks.coarse.bits, &bricks.firsts]);
    pass.read(march_comp::BITS, words)
        .read(march_comp::COARSE, coarse)
        .read(march_comp::BRICK_FIRSTS, firsts)
        .specialize(march_comp::IN_BRICKS, voxels.bricks().is_some());
}

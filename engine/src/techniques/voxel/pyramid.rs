//! Coarser and coarser bits of a grid, for walks that skip what is empty.

use super::bricks::BRICK;
use super::{VoxelBits, VoxelSet, voxel_set};
use crate::graph::{BufferHandle, ComputePass, Graph};
use crate::shader::generated::blocks;
use crate::shader::generated::voxel::ray_marching::march_comp;
use crate::shader::generated::voxel::{reduce_bits_comp, reduce_comp};

/// Levels 1 and above of a pyramid of bits on the device; level 0 are the voxels themselves. A voxel of a level is set
/// where any of the 2×2×2 below it is.
pub struct Pyramid {
    /// The words of all levels, one behind the other; each lies as [`VoxelBits::bits`] do.
    pub words: BufferHandle,
    levels: Vec<Level>,
}

/// Where a level lies, and its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// In words, from the beginning of the buffer. 0 for level 0, which is not in it.
    pub begin: u32,
    /// Voxels in column coordinates: columns across, and voxels in one.
    pub size: [u32; 3],
}

impl Level {
    fn words(&self) -> u32 {
        self.size[0] * self.size[1] * self.size[2].div_ceil(32)
    }
}

impl Pyramid {
    /// Makes the levels up to a single voxel.
    pub fn record(graph: &mut Graph, voxels: &VoxelBits) -> Self {
        Self::over(graph, voxels.grid.columns(voxels.axis), &voxels.bits)
    }

    /// Over so many voxels in column coordinates.
    fn over(graph: &mut Graph, size: [u32; 3], bits: &BufferHandle) -> Self {
        // 1. Where they lie.
        let mut levels = vec![Level { begin: 0, size }];
        let mut end = 0;
        while let Some(finer) = levels.last().filter(|level| level.size != [1; 3]) {
            let level = Level { begin: end, size: finer.size.map(|n| n.div_ceil(2)) };
            end += level.words();
            levels.push(level);
        }
        // 2. Each from the one below.
        let mut words = graph.buffer("voxel.pyramid", 4 * u64::from(end.max(1)));
        for (number, pair) in levels.windows(2).enumerate() {
            let [finer, coarser] = [pair[0], pair[1]];
            let from_bits = number == 0;
            let shader = if from_bits { &reduce_bits_comp::SHADER } else { &reduce_comp::SHADER };
            let mut pass = graph.compute(format!("voxel.pyramid.{}", number + 1), shader);
            pass.push(&blocks::ReducePush { size: finer.size, finer: finer.begin, coarser: coarser.begin });
            if from_bits {
                pass.read(reduce_bits_comp::BITS, bits);
                words = pass.write(reduce_bits_comp::PYRAMID, words);
            } else {
                words = pass.write(reduce_comp::PYRAMID, words);
            }
            let [width, height, depth] = coarser.size;
            pass.dispatch([width, height, depth.div_ceil(32)]);
        }
        if levels.len() == 1 {
            words = graph.fill("voxel.pyramid.none", words, 0);
        }
        Self { words, levels }
    }

    /// Levels, from the voxels themselves to a single one.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }
}

/// What blocks the way from point to point: the bits of a grid, as a whole or in bricks, and a pyramid to skip what is empty.
pub struct Occluders<V = VoxelBits> {
    /// The bits, by any technique of this family.
    pub voxels: V,
    /// Over them; of bricks, over their grid.
    pub pyramid: Pyramid,
}

impl<V: VoxelSet> Occluders<V> {
    /// Makes the pyramid.
    pub fn record(graph: &mut Graph, voxels: V) -> Self {
        let pyramid = match voxels.bricks() {
            Some(bricks) => Pyramid::record(graph, &bricks.coarse),
            None => Pyramid::over(graph, voxels.grid().columns(voxels.axis()), voxels.words()),
        };
        Self { voxels, pyramid }
    }

    /// Gives a pass the bindings of `voxel/visibility.glsl`, to skip by at most so many levels.
    pub(in crate::techniques) fn bind(&self, pass: &mut ComputePass, levels: u32) {
        let Self { voxels, pyramid } = self;
        // The grid of bricks is level 3.
        let below = if voxels.bricks().is_some() { BRICK.ilog2() } else { 0 };
        let mut level_begins = [0; 12];
        for (begin, level) in level_begins.iter_mut().skip(below as usize).zip(&pyramid.levels) {
            *begin = level.begin;
        }
        let coarsest = levels.min(below + pyramid.levels.len() as u32 - 1);
        pass.uniform(march_comp::VOXEL_GRID, &voxels.grid().block(voxels.axis()))
            .uniform(march_comp::PYRAMID_LEVELS, &blocks::PyramidLevels { level_begins, coarsest })
            .read(march_comp::PYRAMID, &pyramid.words);
        voxel_set::bind(pass, voxels);
    }
}

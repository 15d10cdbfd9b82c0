//! A place for each set voxel: how many come before it.

use crate::Result;
use crate::graph::{BufferHandle, Checkpoint, Graph};
use crate::shader::generated::blocks;
use crate::shader::generated::voxel::attributes::{count_comp, first_comp, total_comp};
use crate::techniques::voxel::VoxelBits;

/// Words of a chunk: `ranks.glsl`.
const CHUNK: u64 = 1024;

/// Prefix sums over the words of a grid.
pub(super) struct Ranks {
    /// Set bits before each word.
    pub(super) firsts: BufferHandle,
    /// The block `Total`.
    pub(super) total: BufferHandle,
    /// The same, on the host.
    pub(super) told: Checkpoint<blocks::Total>,
}

impl Ranks {
    /// Counts chunk by chunk, and again word by word.
    pub(super) fn record(graph: &mut Graph, voxels: &VoxelBits) -> Result<Self> {
        let VoxelBits { bits: firsts, .. } = VoxelBits::new(graph, "voxel.firsts", &voxels.grid, voxels.axis)?;
        let words = voxels.grid.words(voxels.axis);
        let chunk_count = words.div_ceil(CHUNK) as u32;
        let chunks = graph.buffer("voxel.ranks.chunks", 4 * u64::from(chunk_count));
        let total = graph.buffer("voxel.ranks.total", size_of::<blocks::Total>() as u64);

        let mut pass = graph.compute("voxel.ranks.count", &count_comp::SHADER);
        pass.push(&blocks::RanksPush { words: words as u32 }).read(count_comp::BITS, &voxels.bits);
        let chunks = pass.write(count_comp::CHUNKS, chunks);
        pass.dispatch([chunk_count, 1, 1]);

        let mut pass = graph.compute("voxel.ranks.total", &total_comp::SHADER);
        pass.push(&blocks::TotalPush { chunk_count });
        let chunks = pass.write(total_comp::CHUNKS, chunks);
        let total = pass.write(total_comp::TOTAL, total);
        pass.dispatch([1, 1, 1]);

        let mut pass = graph.compute("voxel.ranks.first", &first_comp::SHADER);
        pass.push(&blocks::RanksPush { words: words as u32 });
        pass.read(first_comp::BITS, &voxels.bits).read(first_comp::CHUNKS, &chunks);
        let firsts = pass.write(first_comp::FIRSTS, firsts);
        pass.dispatch([chunk_count, 1, 1]);
        let told = graph.checkpoint("voxel.ranks.total", &total);
        Ok(Self { firsts, total, told })
    }
}

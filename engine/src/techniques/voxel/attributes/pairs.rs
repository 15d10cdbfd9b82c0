//! Which triangle has a part in which voxel: lists of pairs, draw by draw, for a pass with a pixel a pair.

use super::super::surface::{Surfaces, Visit};
use super::super::{VoxelSet, voxel_set};
use crate::Result;
use crate::graph::{BufferHandle, Checkpoint, Graph};
use crate::scene::GpuScene;
use crate::shader::generated::voxel::attributes::{
    count_large_comp, count_small_comp, list_large_comp, list_small_comp,
};

/// Pairs of a triangle and a set voxel that it touches.
pub(super) struct Pairs {
    /// Two words a pair: where the triangle's indices begin, and its instance.
    pub(super) triangles: BufferHandle,
    /// Two words a pair: the voxel, and its place among the set ones.
    pub(super) voxels: BufferHandle,
    /// How many pairs each draw has; they lie in the order of draws.
    pub(super) counts: Checkpoint<u32>,
}

impl Pairs {
    /// Counts them, and lists them as the host has read how many there are. `firsts`: set bits before each word. Of a scene
    /// with a triangle.
    pub(super) fn record<'f>(
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        voxels: &impl VoxelSet,
        firsts: &BufferHandle,
    ) -> Result<Self> {
        let draws = scene.draws.draws();
        let draw_of_instance: Vec<u32> =
            (0..).zip(draws).flat_map(|(index, draw)| draw.instances.clone().map(move |_| index)).collect();
        let draw_of_instance = graph.data(&draw_of_instance);
        let visit =
            |name, shaders| Visit { name, grid: *voxels.grid(), axis: voxels.axis(), surfaces: Surfaces::All, shaders };

        // 1. How many.
        let counts = graph.buffer("voxel.attributes.pairs.counts", 4 * draws.len().max(1) as u64);
        let counts = graph.fill("voxel.attributes.pairs.counts.clear", counts, 0);
        let count = visit("voxel.attributes.count", [&count_small_comp::SHADER, &count_large_comp::SHADER]);
        let counts = count.record(graph, scene, counts, |pass, counts| {
            voxel_set::bind(pass, voxels);
            pass.constant(count_small_comp::DRAW_OF_INSTANCE, draw_of_instance);
            pass.write(count_small_comp::PAIR_COUNTS, counts)
        })?;
        let told = graph.checkpoint::<u32>("voxel.attributes.pairs", &counts);

        // 2. A place for each.
        let bytes = |counts: &[u32]| 8 * counts.iter().map(|&count| u64::from(count)).sum::<u64>();
        let [triangles, pair_voxels] =
            ["triangles", "voxels"].map(|of| graph.buffer_after(&told, format!("voxel.attributes.pairs.{of}"), bytes));
        let starts = graph.data_slice_after(&told, draws.len().max(1), starts);
        let listed = graph.fill("voxel.attributes.pairs.listed.clear", counts, 0);
        let list = visit("voxel.attributes.list", [&list_small_comp::SHADER, &list_large_comp::SHADER]);
        let state = (listed, triangles, pair_voxels);
        let (_, triangles, pair_voxels) =
            list.record(graph, scene, state, |pass, (listed, triangles, pair_voxels)| {
                voxel_set::bind(pass, voxels);
                pass.constant(list_small_comp::DRAW_OF_INSTANCE, draw_of_instance)
                    .constant(list_small_comp::PAIR_STARTS, starts)
                    .read(list_small_comp::FIRSTS, firsts);
                let listed = pass.write(list_small_comp::PAIR_COUNTS, listed);
                let triangles = pass.write(list_small_comp::PAIR_TRIANGLES, triangles);
                (listed, triangles, pass.write(list_small_comp::PAIR_VOXELS, pair_voxels))
            })?;
        Ok(Self { triangles, voxels: pair_voxels, counts: told })
    }
}

/// By draw, how many pairs come before.
pub(super) fn starts(counts: &[u32]) -> Vec<u32> {
    let before = counts.iter().scan(0_u32, |sum, &count| {
        let before = *sum;
        *sum = sum.saturating_add(count);
        Some(before)
    });
    before.collect()
}

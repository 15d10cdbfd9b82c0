//! Prefix sums over the pixels' counts: how many nodes there are, and how much work that is.

use super::LongSort;
use crate::graph::{BufferHandle, Data, Graph, ImageHandle};
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::abuffer::{scan_chunks_comp, scan_groups_comp, scan_total_comp};

/// Pixels of a chunk, and chunks of a group: `scan.glsl`.
const CHUNK: u64 = 256;
const GROUP: u64 = 256;

/// Sums over the pixels' counts.
pub(super) struct Scanned {
    pub(super) chunks: BufferHandle,
    pub(super) groups: BufferHandle,
    pub(super) totals: BufferHandle,
}

/// Chunks of a picture.
pub(super) fn chunks_of(size: [u32; 2]) -> u64 {
    (u64::from(size[0]) * u64::from(size[1])).div_ceil(CHUNK)
}

/// Sums up `count` over the picture or the band that `frame` says.
pub(super) fn scan(graph: &mut Graph, name: &str, count: &ImageHandle, frame: Data, long_sort: LongSort) -> Scanned {
    let chunk_count = chunks_of(count.size());
    let group_count = chunk_count.div_ceil(GROUP);
    let stride = size_of::<blocks::Sums>() as u64;
    let chunks = graph.buffer(format!("{name}.chunks"), chunk_count * stride);
    let groups = graph.buffer(format!("{name}.groups"), group_count * stride);
    let totals = graph.buffer(format!("{name}.totals"), size_of::<blocks::Totals>() as u64);

    let mut pass = graph.compute(format!("{name}.scan.chunks"), &scan_chunks_comp::SHADER);
    pass.uniform_data(scan_chunks_comp::ABUFFER, frame).read(scan_chunks_comp::COUNTS, count);
    let chunks = pass.write(scan_chunks_comp::CHUNKS, chunks);
    pass.dispatch([chunk_count as u32, 1, 1]);

    let mut pass = graph.compute(format!("{name}.scan.groups"), &scan_groups_comp::SHADER);
    let chunks = pass.write(scan_groups_comp::CHUNKS, chunks);
    let groups = pass.write(scan_groups_comp::GROUPS, groups);
    pass.dispatch([group_count as u32, 1, 1]);

    let mut pass = graph.compute(format!("{name}.scan.total"), &scan_total_comp::SHADER);
    pass.specialize(scan_total_comp::LONG_SORT, long_sort.number());
    let groups = pass.write(scan_total_comp::GROUPS, groups);
    let totals = pass.write(scan_total_comp::TOTALS, totals);
    pass.dispatch([1, 1, 1]);
    Scanned { chunks, groups, totals }
}

//! A place for each set voxel: how many come before it.

use super::bricks::BRICK_WORDS;
use crate::graph::{BufferHandle, Checkpoint, ComputePass, Graph};
use crate::shader::generated::blocks;
use crate::shader::generated::voxel::attributes::{count_comp, first_comp, total_comp};

/// Words of a chunk: `attributes/ranks.glsl`.
const CHUNK: u64 = 1024;

/// Prefix sums over words of bits.
pub(super) struct Ranks {
    /// Set bits before each word.
    pub(super) firsts: BufferHandle,
    /// Of all set bits.
    pub(super) count: Count,
}

/// A number that the device counts and the host reads.
pub(super) struct Count {
    /// The block `Total`.
    pub(super) total: BufferHandle,
    /// The same, on the host.
    pub(super) told: Checkpoint<blocks::Total>,
}

/// How many words there are.
enum Words<'r> {
    Known(u64),
    /// Those of bricks, which the host counts while the frame runs.
    OfBricks(&'r Count),
}

impl Words<'_> {
    fn of_bricks(total: &[blocks::Total]) -> u64 {
        BRICK_WORDS as u64 * u64::from(total.first().map_or(0, |total| total.total).max(1))
    }

    /// A buffer with so many bytes a word, or a chunk of words.
    fn buffer(&self, graph: &mut Graph, name: String, bytes: u64, words: u64) -> BufferHandle {
        match self {
            Self::Known(count) => graph.buffer(name, bytes * count.div_ceil(words)),
            Self::OfBricks(bricks) => {
                graph.buffer_after(&bricks.told, name, move |total| bytes * Self::of_bricks(total).div_ceil(words))
            }
        }
    }

    /// Pushes something that follows from their number.
    fn push<T: bytemuck::Pod>(&self, pass: &mut ComputePass, value: impl Fn(u64) -> T + 'static) {
        match self {
            Self::Known(count) => {
                pass.push(&value(*count));
            }
            Self::OfBricks(bricks) => {
                let told = bricks.told.clone();
                pass.push_with(move || value(told.values().map_or(0, Self::of_bricks)));
            }
        }
    }

    /// Runs over all chunks, and for bricks some more.
    fn dispatch(&self, pass: ComputePass) {
        match self {
            Self::Known(count) => pass.dispatch([count.div_ceil(CHUNK) as u32, 1, 1]),
            Self::OfBricks(bricks) => pass.dispatch_indirect(&bricks.total, 4),
        }
    }
}

impl Ranks {
    /// Of so many words.
    pub(super) fn of_grid(graph: &mut Graph, name: &str, bits: &BufferHandle, words: u64) -> Self {
        Self::of(graph, name, bits, &Words::Known(words))
    }

    /// Of the words of so many bricks.
    pub(super) fn of_bricks(graph: &mut Graph, name: &str, bricks: &BufferHandle, count: &Count) -> Self {
        Self::of(graph, name, bricks, &Words::OfBricks(count))
    }

    /// Counts chunk by chunk, and again word by word.
    fn of(graph: &mut Graph, name: &str, bits: &BufferHandle, words: &Words) -> Self {
        let firsts = words.buffer(graph, format!("{name}.firsts"), 4, 1);
        let chunks = words.buffer(graph, format!("{name}.ranks.chunks"), 4, CHUNK);
        let total = graph.buffer(format!("{name}.ranks.total"), size_of::<blocks::Total>() as u64);
        let push = |count: u64| blocks::RanksPush { words: count as u32 };

        let mut pass = graph.compute(format!("{name}.ranks.count"), &count_comp::SHADER);
        words.push(&mut pass, push);
        pass.read(count_comp::BITS, bits);
        let chunks = pass.write(count_comp::CHUNKS, chunks);
        words.dispatch(pass);

        let mut pass = graph.compute(format!("{name}.ranks.total"), &total_comp::SHADER);
        words.push(&mut pass, |count| blocks::TotalPush { chunk_count: count.div_ceil(CHUNK) as u32 });
        let chunks = pass.write(total_comp::CHUNKS, chunks);
        let total = pass.write(total_comp::TOTAL, total);
        pass.dispatch([1, 1, 1]);

        let mut pass = graph.compute(format!("{name}.ranks.first"), &first_comp::SHADER);
        words.push(&mut pass, push);
        pass.read(first_comp::BITS, bits).read(first_comp::CHUNKS, &chunks);
        let firsts = pass.write(first_comp::FIRSTS, firsts);
        words.dispatch(pass);
        let told = graph.checkpoint(format!("{name}.ranks.total"), &total);
        Self { firsts, count: Count { total, told } }
    }
}

//! Leaves out execution dependencies that follow from others.
//!
//! A barrier orders everything in its first stages before everything in its second ones, whichever resource it is
//! for, and barriers chain where the second stages of one and the first stages of a later one have one in common. So
//! a write that must wait for reads often does already.

use ash::vk::{AccessFlags2 as Mask, PipelineStageFlags2 as Stages};

use super::{Barriers, MemoryBarrier, Ownership, Work};
use crate::graph::description::Access;

/// Stages in the order that the graphics pipeline goes through them, then those outside of it.
const STAGES: [Stages; 18] = [
    Stages::DRAW_INDIRECT,
    Stages::INDEX_INPUT,
    Stages::VERTEX_ATTRIBUTE_INPUT,
    Stages::VERTEX_SHADER,
    Stages::TESSELLATION_CONTROL_SHADER,
    Stages::TESSELLATION_EVALUATION_SHADER,
    Stages::GEOMETRY_SHADER,
    Stages::EARLY_FRAGMENT_TESTS,
    Stages::FRAGMENT_SHADER,
    Stages::LATE_FRAGMENT_TESTS,
    Stages::COLOR_ATTACHMENT_OUTPUT,
    Stages::COMPUTE_SHADER,
    Stages::COPY,
    Stages::BLIT,
    Stages::RESOLVE,
    Stages::CLEAR,
    Stages::HOST,
    // Anything else: never taken to be ordered.
    Stages::NONE,
];
const COUNT: usize = STAGES.len();
/// Stages of the graphics pipeline.
const PIPELINE: usize = 11;

/// Whether scopes hold all of other scopes.
fn holds(a: &Access, b: &Access) -> bool {
    set(b.stages) & !set(a.stages) == 0 && a.mask.contains(b.mask)
}

/// Whether a barrier does more than to order.
fn is_strong(barrier: &MemoryBarrier) -> bool {
    barrier.from.mask != Mask::NONE || barrier.to.mask != Mask::NONE
}

/// Takes out memory barriers that do less than another one of the same call; not those that only order, which are
/// judged one by one.
fn subsumed(barriers: &mut Vec<MemoryBarrier>) {
    let mut kept: Vec<MemoryBarrier> = Vec::with_capacity(barriers.len());
    for barrier in barriers.drain(..) {
        if is_strong(&barrier) {
            if kept.iter().any(|other| holds(&other.from, &barrier.from) && holds(&other.to, &barrier.to)) {
                continue;
            }
            let less = |other: &MemoryBarrier| holds(&barrier.from, &other.from) && holds(&barrier.to, &other.to);
            kept.retain(|other| !(is_strong(other) && less(other)));
        }
        kept.push(barrier);
    }
    *barriers = kept;
}

/// Stages as bits of their places above.
type Set = u32;

fn set(stages: Stages) -> Set {
    if stages.contains(Stages::ALL_COMMANDS) {
        return (1 << COUNT) - 1;
    }
    let mut rest = stages;
    let mut set = 0;
    if stages.contains(Stages::ALL_TRANSFER) {
        rest &= !Stages::ALL_TRANSFER;
        set |= [12, 13, 14, 15].iter().fold(0, |all, place| all | 1 << place);
    }
    for (place, stage) in STAGES.iter().enumerate().filter(|(_, stage)| !stage.is_empty()) {
        if rest.contains(*stage) {
            set |= 1 << place;
            rest &= !*stage;
        }
    }
    if rest.is_empty() { set } else { set | 1 << (COUNT - 1) }
}

fn members(set: Set) -> impl Iterator<Item = usize> {
    (0..COUNT).filter(move |place| set & (1 << place) != 0)
}

/// With the stages that come before them in the pipeline: the first scope of a dependency has them too.
fn with_earlier(set: Set) -> Set {
    let last = members(set).filter(|place| *place < PIPELINE).last();
    set | last.map_or(0, |last| (1 << (last + 1)) - 1) | Set::from(set & (1 << PIPELINE) != 0)
}

/// With the stages that come after them in the pipeline: the second scope of a dependency has them too.
fn with_later(set: Set) -> Set {
    let pipeline: Set = (1 << PIPELINE) - 1;
    let first = members(set).find(|place| *place < PIPELINE);
    let compute = if set & 1 != 0 { 1 << PIPELINE } else { 0 };
    set | first.map_or(0, |first| pipeline & !((1 << first) - 1)) | compute
}

/// What is ordered on one queue: before any later work in stage `b` begins, `done[a][b] - 1` steps, from the queue's
/// first on, have all their work in stage `a` done, and where it is not 0, so has what came before the frame.
#[derive(Clone, Default)]
pub(super) struct Ordered {
    done: [[u32; COUNT]; COUNT],
}

impl Ordered {
    /// Takes out what follows from other barriers, and remembers what the rest orders. `step`: how many steps of the
    /// queue stand before; `last`: at which place of the queue some work stands, 1 for the first step, 0 for what came
    /// before the frame.
    pub(super) fn filter(&mut self, barriers: &mut Barriers, step: u32, last: impl Fn(Option<Work>) -> Option<u32>) {
        subsumed(&mut barriers.memory);
        let Barriers { images, buffers, memory } = barriers;
        let covered = |from: &Access, to: &Access, ownership: &Option<Ownership>| {
            let same = from.layout == to.layout && ownership.is_none();
            same && memory.iter().any(|barrier| holds(&barrier.from, from) && holds(&barrier.to, to))
        };
        images.retain(|barrier| !covered(&barrier.from, &barrier.to, &barrier.ownership));
        buffers.retain(|barrier| !covered(&barrier.from, &barrier.to, &barrier.ownership));
        let known = self.clone();
        let mut apply = |from: &Access, to: &Access| self.apply(&known, from.stages, to.stages, step);
        barriers.images.iter().for_each(|barrier| apply(&barrier.from, &barrier.to));
        barriers.buffers.iter().for_each(|barrier| apply(&barrier.from, &barrier.to));
        barriers
            .memory
            .iter()
            .filter(|barrier| is_strong(barrier))
            .for_each(|barrier| apply(&barrier.from, &barrier.to));
        barriers.memory.retain_mut(|barrier| {
            if is_strong(barrier) {
                return true;
            }
            if let Some(before) = last(barrier.reason.before) {
                barrier.from.stages = self.missing(barrier.from.stages, barrier.to.stages, before);
            }
            let keep = !barrier.from.stages.is_empty();
            if keep {
                self.apply(&known, barrier.from.stages, barrier.to.stages, step);
            }
            keep
        });
    }

    fn apply(&mut self, known: &Ordered, from: Stages, to: Stages, step: u32) {
        let (from, to) = (with_earlier(set(from)), with_later(set(to)));
        for a in 0..COUNT - 1 {
            let chained = members(from).map(|via| known.done[a][via]).max().unwrap_or(0);
            let done = if from & (1 << a) != 0 { step + 1 } else { chained };
            for b in members(to) {
                self.done[a][b] = self.done[a][b].max(done);
            }
        }
    }

    /// The first stages that some second stage does not wait for yet, up to the place `before`.
    fn missing(&self, from: Stages, to: Stages, before: u32) -> Stages {
        let to = set(to);
        let ordered = |a: usize| members(to).all(|b| a < COUNT - 1 && self.done[a][b] > before);
        let single = STAGES.iter().enumerate().filter(|(a, stage)| !stage.is_empty() && ordered(*a));
        let done = single.fold(Stages::NONE, |all, (_, stage)| all | *stage);
        let rest = from & !done;
        let transfers = [12, 13, 14, 15];
        if rest.contains(Stages::ALL_TRANSFER) && transfers.into_iter().all(ordered) {
            return rest & !Stages::ALL_TRANSFER;
        }
        rest
    }
}

//! Leaves out execution dependencies that follow from others.
//!
//! A barrier orders everything in its first stages before everything in its second ones, whichever resource it is
//! for, and barriers chain where the second stages of one and the first stages of a later one have one in common. So
//! a write that must wait for reads often does already.

use std::collections::VecDeque;

use ash::vk::{AccessFlags2 as Mask, PipelineStageFlags2 as Stages};

use super::done::Done;
use super::history::Schedule;
use super::queues::RoundTrip;
use super::stages::{Set, any, both, holds, members, set, single, with_earlier, with_later};
use super::{Barriers, Hazard, ImageBarrier, MemoryBarrier, Ownership, Reason, Work};
use crate::graph::description::{Access, Queue, ResourceId};

/// Whether a barrier does more than to order.
fn is_strong(barrier: &MemoryBarrier) -> bool {
    barrier.from.mask != Mask::NONE || barrier.to.mask != Mask::NONE
}

/// Whether it is several stages, and no memory.
fn is_set_of_stages(access: &Access) -> bool {
    let stages = access.stages.as_raw();
    access.mask.is_empty() && stages & stages.wrapping_sub(1) != 0
}

/// Takes out memory barriers that do less than another one of the same call; not those that only order, which are
/// judged one by one.
fn subsumed(barriers: &mut Vec<MemoryBarrier>) {
    if barriers.len() < 2 {
        return;
    }
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

/// Has the first transition of an image wait for the earlier tenants of its memory, as the barriers for all memory that
/// stand beside it do. These are left out where they made nothing available. The masks are here as well because
/// synchronisation validation judges each transition by its own barrier.
fn tenants(images: &mut [ImageBarrier], memory: &mut Vec<MemoryBarrier>) {
    let is_tenant = |reason: &Reason| matches!(reason.hazard, Hazard::Alias { .. });
    for image in images.iter_mut().filter(|image| is_tenant(&image.reason)) {
        let resource = Some(image.resource);
        for barrier in memory.iter().filter(|other| is_tenant(&other.reason) && other.reason.resource == resource) {
            image.from.stages = both(image.from.stages, barrier.from.stages);
            image.from.mask |= barrier.from.mask;
        }
    }
    let transitions = |barrier: &MemoryBarrier| {
        images.iter().any(|image| is_tenant(&image.reason) && Some(image.resource) == barrier.reason.resource)
    };
    memory.retain(|barrier| !(is_tenant(&barrier.reason) && barrier.from.mask.is_empty() && transitions(barrier)));
}

/// Whether barriers for all memory of one call do what the barrier of a resource does. What of its accesses they make
/// visible is left out.
fn is_covered(from: &Access, to: &mut Access, ownership: Option<Ownership>, memory: &[MemoryBarrier]) -> bool {
    if from.layout != to.layout || ownership.is_some() {
        return false;
    }
    let asked = to.mask;
    for other in memory.iter().filter(|other| holds(&other.from, from)) {
        if holds(&other.to, to) {
            return true;
        }
        if set(to.stages) & !set(other.to.stages) == 0 {
            to.mask &= !other.to.mask;
        }
    }
    to.mask.is_empty() && !asked.is_empty()
}

/// Barriers less those that follow from others, step by step.
pub(super) struct Redundant<'a> {
    schedule: &'a Schedule,
    /// By step: its batch. Nothing where there is but one.
    batch_of: &'a [usize],
    /// Of batches that have not begun.
    trips: Vec<RoundTrip>,
    /// By queue.
    ordered: [Ordered<'a>; 3],
    /// By queue: how many of its steps there were.
    counts: [u32; 3],
    /// By pass, then by root: where it stands on its queue, from 1 on; 0: nowhere yet.
    places: Vec<(Queue, u32)>,
}

impl<'a> Redundant<'a> {
    /// `chained`: images with barriers that come behind semaphores, ascending.
    pub(super) fn new(
        schedule: &'a Schedule,
        batch_of: &'a [usize],
        trips: &[RoundTrip],
        chained: &'a [ResourceId],
    ) -> Self {
        let nodes = schedule.nodes.iter().max().map_or(0, |last| *last as usize + 1);
        let (ordered, trips) = ([(); 3].map(|()| Ordered::new(chained)), trips.to_vec());
        Self { schedule, batch_of, trips, ordered, counts: [0; 3], places: vec![(Queue::Graphics, 0); nodes] }
    }

    /// Takes out of the barriers before a step, the next one, what follows from others.
    pub(super) fn step(&mut self, step: usize, barriers: &mut Barriers) {
        let queue = self.schedule.queues[step];
        if !self.trips.is_empty() {
            let batch = self.batch_of[step];
            self.begin(|trip| trip.batch == batch, queue);
        }
        self.filter(queue, barriers);
        self.counts[queue as usize] += 1;
        self.places[self.schedule.nodes[step] as usize] = (queue, self.counts[queue as usize]);
    }

    /// As [`Redundant::step`], of the barriers at the end of the frame, on graphics.
    pub(super) fn end(&mut self, barriers: &mut Barriers) {
        // A batch without steps comes last.
        self.begin(|_| true, Queue::Graphics);
        self.filter(Queue::Graphics, barriers);
    }

    /// Batches of a queue begin, behind semaphores that came round.
    fn begin(&mut self, begins: impl Fn(&RoundTrip) -> bool, queue: Queue) {
        for trip in self.trips.extract_if(.., |trip| begins(trip)) {
            self.ordered[queue as usize].wait(trip.stages, trip.steps);
        }
    }

    fn filter(&mut self, queue: Queue, barriers: &mut Barriers) {
        if barriers.is_empty() {
            return;
        }
        let (places, schedule) = (&self.places, self.schedule);
        // What came before the frame stands at 0, all of it on graphics.
        let place = |work: Option<Work>| match work {
            None => (queue == Queue::Graphics).then_some(0),
            Some(work) => {
                let place = places.get(schedule.node(work)).filter(|place| place.0 == queue && place.1 > 0);
                place.map(|place| place.1)
            }
        };
        self.ordered[queue as usize].filter(barriers, self.counts[queue as usize], place);
    }
}

/// What is ordered on one queue.
struct Ordered<'a> {
    /// Images with barriers whose first stages are chained to semaphores, ascending.
    chained: &'a [ResourceId],
    done: Done,
    /// What barriers ordered that nobody has asked about yet: stages, and the step. Most frames never ask.
    unasked: Vec<(Set, Set, u32)>,
    /// The last barriers for all memory.
    for_all: VecDeque<ForAll>,
    /// Stages that stand behind each of them.
    behind_all: Set,
}

/// How many barriers for all memory are remembered: bounds the cost of frames with many.
const REMEMBERED: usize = 32;

/// A barrier for all memory, or a semaphore.
struct ForAll {
    /// How many steps of the queue stand before it.
    step: u32,
    from: Access,
    to: Access,
    /// Stages whose later work comes behind it, and those that the call of barriers looked at adds.
    behind: Set,
    more: Set,
}

impl<'a> Ordered<'a> {
    fn new(chained: &'a [ResourceId]) -> Self {
        let (done, unasked, for_all) = Default::default();
        Self { chained, done, unasked, for_all, behind_all: !0 }
    }

    /// Takes out what follows from other barriers, and remembers what the rest orders. `step`: how many steps of the
    /// queue stand before; `last`: at which place of the queue some work stands, 1 for the first step, 0 for what came
    /// before the frame.
    fn filter(&mut self, barriers: &mut Barriers, step: u32, last: impl Fn(Option<Work>) -> Option<u32>) {
        let Barriers { images, buffers, memory } = barriers;

        // 1. First stages that come before others of the same barrier anyway.
        for barrier in images.iter_mut().filter(|barrier| is_set_of_stages(&barrier.from)) {
            if self.chained.binary_search(&barrier.resource).is_err() {
                self.unchain(&mut barrier.from, last(barrier.reason.before), step);
            }
        }
        for barrier in buffers.iter_mut().filter(|barrier| is_set_of_stages(&barrier.from)) {
            self.unchain(&mut barrier.from, last(barrier.reason.before), step);
        }

        // 2. What earlier barriers for all memory made available and visible.
        images.iter_mut().filter(|barrier| barrier.from.layout != barrier.to.layout).for_each(|barrier| {
            barrier.follows = barrier.from;
        });
        if !self.for_all.is_empty() {
            let known = |from: &mut Access, to: &Access, before: Option<Work>| {
                !from.mask.is_empty() && last(before).is_some_and(|before| self.made_available(from, to, before))
            };
            memory.retain_mut(|barrier| !known(&mut barrier.from, &barrier.to, barrier.reason.before));
            images.retain_mut(|barrier| {
                !known(&mut barrier.from, &barrier.to, barrier.reason.before) || barrier.ownership.is_some()
            });
            buffers.retain_mut(|barrier| {
                !known(&mut barrier.from, &barrier.to, barrier.reason.before) || barrier.ownership.is_some()
            });
        }

        // 3. What barriers for all memory of this call do as well.
        if !memory.is_empty() {
            tenants(images, memory);
            subsumed(memory);
            images.retain(|barrier| !is_covered(&barrier.from, &mut barrier.to, barrier.ownership, memory));
            buffers.retain_mut(|barrier| !is_covered(&barrier.from, &mut barrier.to, barrier.ownership, memory));
        }

        // 4. What the rest orders. Most barriers of a call order alike, and nothing comes of the second.
        let mut applied = Default::default();
        let mut apply = |from: &Access, to: &Access| {
            let stages = (from.stages, to.stages);
            if std::mem::replace(&mut applied, stages) != stages {
                self.apply(from.stages, to.stages, step);
            }
        };
        let waits_alone = |image: &ImageBarrier| image.from.mask.is_empty() && image.from.layout == image.to.layout;
        images.iter().filter(|barrier| !waits_alone(barrier)).for_each(|barrier| apply(&barrier.from, &barrier.to));
        buffers.iter().filter(|barrier| !barrier.from.mask.is_empty()).for_each(|b| apply(&b.from, &b.to));
        memory.iter().filter(|barrier| is_strong(barrier)).for_each(|barrier| apply(&barrier.from, &barrier.to));
        for barrier in images.iter_mut().filter(|barrier| waits_alone(barrier)) {
            if barrier.ownership.is_none() && self.chained.binary_search(&barrier.resource).is_err() {
                self.leave_missing(&mut barrier.from, &barrier.to, last(barrier.reason.before), step);
            }
            self.apply(barrier.from.stages, barrier.to.stages, step);
        }
        for barrier in buffers.iter_mut().filter(|barrier| barrier.from.mask.is_empty()) {
            if barrier.ownership.is_none() && self.chained.binary_search(&barrier.resource).is_err() {
                self.leave_missing(&mut barrier.from, &barrier.to, last(barrier.reason.before), step);
            }
            self.apply(barrier.from.stages, barrier.to.stages, step);
        }

        // 5. What only orders, one by one.
        memory.retain_mut(|barrier| {
            if is_strong(barrier) {
                self.remember(step, barrier.from, barrier.to);
                return true;
            }
            if let Some(before) = last(barrier.reason.before) {
                let done = self.done_before(step);
                let missing = done.missing(barrier.from.stages, barrier.to.stages, before);
                barrier.from.stages = done.unchained(missing, before);
            }
            let keep = !barrier.from.stages.is_empty();
            if keep {
                self.apply(barrier.from.stages, barrier.to.stages, step);
            }
            keep
        });
        if self.for_all.iter().any(|other| other.more != 0) {
            self.for_all.iter_mut().for_each(|other| other.behind |= std::mem::take(&mut other.more));
            self.behind_all = self.for_all.iter().fold(!0, |all, other| all & other.behind);
        }
    }

    /// What is ordered before a step, with what barriers of its call ordered so far.
    fn done_before(&mut self, step: u32) -> &Done {
        for (from, to, step) in self.unasked.drain(..) {
            self.done.at(step);
            self.done.barrier(from, to, step);
        }
        self.done.at(step);
        &self.done
    }

    /// Leaves out first stages that come before others of them anyway.
    fn unchain(&mut self, from: &mut Access, before: Option<u32>, step: u32) {
        if let Some(before) = before {
            from.stages = self.done_before(step).unchained(from.stages, before);
        }
    }

    /// Leaves of first scopes without memory what nothing else orders, and one stage at least: what it is chained to.
    fn leave_missing(&mut self, from: &mut Access, to: &Access, before: Option<u32>, step: u32) {
        if let Some(before) = before.filter(|_| !from.stages.as_raw().is_power_of_two()) {
            let missing = self.done_before(step).missing(from.stages, to.stages, before);
            from.stages = if missing.is_empty() { any(from.stages) } else { missing };
        }
    }

    /// Whether a barrier for all memory made writes available and visible that were over at the place `before`. Where
    /// it only made them available, to what they are to be chained with, that is left of the first scopes.
    fn made_available(&self, from: &mut Access, to: &Access, before: u32) -> bool {
        let later = self.for_all.iter().rev().take_while(|other| other.step >= before);
        for other in later.filter(|other| holds(&other.from, from)) {
            if holds(&other.to, to) && from.layout == to.layout && !to.mask.is_empty() {
                return true;
            }
            // A transition may as well come behind the stages that it stands before.
            let stages = set(from.stages) | if to.mask.is_empty() { set(to.stages) } else { 0 };
            let mut chained = members(stages).filter(|&stage| with_earlier(1 << stage) & other.behind != 0);
            if let Some(stage) = chained.next() {
                *from = Access { stages: single(stage), mask: Mask::NONE, ..*from };
                return false;
            }
        }
        false
    }

    fn remember(&mut self, step: u32, from: Access, to: Access) {
        if self.for_all.len() == REMEMBERED {
            self.for_all.pop_front();
        }
        let behind = with_later(set(to.stages));
        self.behind_all &= behind;
        self.for_all.push_back(ForAll { step, from, to, behind, more: 0 });
    }

    /// A semaphore came round from this queue by way of another: `steps` of the queue are done, and visible to these
    /// stages.
    fn wait(&mut self, stages: Stages, steps: u32) {
        let all = Access { stages: Stages::ALL_COMMANDS, mask: Mask::from_raw(!0), ..Access::NONE };
        self.remember(steps, all, Access { stages, ..all });
        self.done_before(steps);
        self.done.steps(with_later(set(stages)), steps);
    }

    fn apply(&mut self, from: Stages, to: Stages, step: u32) {
        if from.is_empty() {
            return;
        }
        let (from, to) = (with_earlier(set(from)), with_later(set(to)));
        if to & !self.behind_all != 0 {
            for other in self.for_all.iter_mut().filter(|other| other.step < step && other.behind & from != 0) {
                other.more |= to;
            }
        }
        self.unasked.push((from, to, step));
    }
}

//! What is done before what, by the stages of one queue.

use ash::vk::PipelineStageFlags2 as Stages;

use super::stages::{COUNT, Set, bits, members, set, with_earlier, without};

/// By two stages `b` and `a`, `d`: before any later work in `b` begins, `d - 1` steps, from the queue's first on, have all
/// their work in `a` done, and where `d` is not 0, so has what came before the frame.
#[derive(Default)]
pub(super) struct Done {
    now: Table,
    /// Rows as they were before the call of barriers looked at, of those that it changed.
    before: Table,
    changed: Set,
    /// The step that this call stands before.
    step: Option<u32>,
    /// Stages `a` that any barrier waited for yet.
    waited_for: Set,
}

type Table = [[u32; COUNT]; COUNT];

impl Done {
    /// Comes to the call of barriers before a step.
    pub(super) fn at(&mut self, step: u32) {
        if self.step.replace(step) != Some(step) {
            self.changed = 0;
        }
    }

    /// The row of a stage before this call.
    fn before(&self, b: usize) -> &[u32; COUNT] {
        if self.changed >> b & 1 == 0 { &self.now[b] } else { &self.before[b] }
    }

    /// A barrier between these stages, each with those that its scopes have too, behind so many steps.
    pub(super) fn barrier(&mut self, from: Set, to: Set, step: u32) {
        self.waited_for |= from;
        let mut chained = [0; COUNT];
        for via in members(from) {
            let known = self.before(via);
            members(self.waited_for).for_each(|a| chained[a] = known[a].max(chained[a]));
        }
        members(from).for_each(|a| chained[a] = step + 1);
        for b in members(to) {
            if self.changed >> b & 1 == 0 {
                self.changed |= 1 << b;
                self.before[b] = self.now[b];
            }
            let row = &mut self.now[b];
            members(self.waited_for).for_each(|a| row[a] = row[a].max(chained[a]));
        }
    }

    /// So many steps are done before these stages begin.
    pub(super) fn steps(&mut self, to: Set, steps: u32) {
        self.waited_for = (1 << COUNT) - 1;
        for b in members(to) {
            self.now[b].iter_mut().for_each(|done| *done = (*done).max(steps + 1));
        }
    }

    /// The first stages that some second stage does not wait for yet, up to the place `last`.
    pub(super) fn missing(&self, from: Stages, to: Stages, last: u32) -> Stages {
        let to = set(to);
        let ordered = |a: &usize| members(to).all(|b| self.now[b][*a] > last);
        without(from, members(set(from)).filter(|&a| a < COUNT - 1).filter(ordered).fold(0, |done, a| done | 1 << a))
    }

    /// First stages without those that come before another one of them, which stays, up to the place `last`.
    pub(super) fn unchained(&self, from: Stages, last: u32) -> Stages {
        let (mut left, mut stays) = (from, Stages::NONE);
        for stage in bits(from.as_raw()).map(Stages::from_raw) {
            let ordered = |other: &Stages| {
                let behind = with_earlier(set(*other));
                let chained = |a: usize| a < COUNT - 1 && members(behind).any(|b| self.before(b)[a] > last);
                members(set(stage)).all(chained)
            };
            let mut others = bits((left & !stage).as_raw()).map(Stages::from_raw);
            if let Some(other) = others.find(ordered).filter(|_| !stays.contains(stage)) {
                left &= !stage;
                stays |= other;
            }
        }
        left
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vertex shaders come before copies, and copies, but not those, before compute shaders.
    #[test]
    fn a_stage_that_others_come_before_stays() {
        let place = |stage| members(set(stage)).next().unwrap_or(COUNT);
        let (vertex, compute, copy) = (Stages::VERTEX_SHADER, Stages::COMPUTE_SHADER, Stages::COPY);
        let mut done = Done::default();
        done.now[place(copy)][place(vertex)] = 5;
        done.now[place(compute)][place(copy)] = 5;
        assert_eq!(done.unchained(vertex | copy | compute, 1), copy | compute);
        assert_eq!(done.unchained(copy | compute, 1), compute);
        assert_eq!(done.unchained(copy | compute, 5), copy | compute);
    }
}

//! When resources and their parts are in use, and which uses are done before which.

use super::history::{At, History, Schedule};
use super::queues::{Crossing, QUEUES};
use super::versions::Versions;
use super::{Lifetime, Plan};
use crate::graph::description::{Description, Queue, ResourceId};

/// First and last step of something in use; `NEVER`: of nothing.
type Steps = [u32; 2];

const NEVER: Steps = [u32::MAX, 0];

/// First and last use of each resource on each queue, and what each step knows to be done.
pub(super) struct Lifetimes {
    /// By resource and queue.
    steps: Vec<[Steps; 3]>,
    /// By resource, over all queues; what is kept lives to the end of the frame.
    spans: Vec<Steps>,
    /// By resource: kept to the end of the frame.
    kept: Vec<bool>,
    /// By step (then the end) and queue: the first step that may still be running on that queue.
    done: Vec<[usize; 3]>,
    queues: Vec<Queue>,
    one_queue: bool,
}

impl Lifetimes {
    pub(super) fn new(
        description: &Description,
        versions: &Versions,
        history: &History,
        schedule: &Schedule,
        crossings: &[Crossing],
    ) -> Self {
        let mut steps = vec![[NEVER; 3]; description.resources.len()];
        for cell in 0..versions.cells.len() as u32 {
            let known = &mut steps[versions.cells.resource(cell).0 as usize];
            for group in history.of(cell) {
                let Some(first) = group.first.index() else { continue };
                let last = group.last.index().unwrap_or(schedule.nodes.len());
                let [from, to] = &mut known[group.queue as usize];
                (*from, *to) = ((*from).min(first as u32), (*to).max(last as u32));
            }
        }
        let mut kept = vec![false; description.resources.len()];
        for root in description.roots.iter().filter(|root| !root.read_back) {
            kept[description.versions[root.version.0 as usize].resource.0 as usize] = true;
        }
        let end = schedule.nodes.len().saturating_sub(1) as u32;
        let span = |(known, kept): (&[Steps; 3], &bool)| {
            let all = known.iter().fold(NEVER, |all, [from, to]| [all[0].min(*from), all[1].max(*to)]);
            if *kept && all != NEVER { [all[0], end] } else { all }
        };
        let spans = steps.iter().zip(&kept).map(span).collect();
        let queues = schedule.queues.clone();
        let one_queue = queues.iter().all(|queue| *queue == queues[0]);
        let done = if one_queue && queues.first().is_none_or(|queue| *queue == Queue::Graphics) {
            Vec::new()
        } else {
            done(schedule, crossings)
        };
        Self { steps, spans, kept, done, queues, one_queue }
    }

    /// First and last step over all queues.
    pub(super) fn span(&self, resource: ResourceId) -> Option<Steps> {
        Some(self.spans[resource.0 as usize]).filter(|span| *span != NEVER)
    }

    /// Whether all steps run on one queue.
    pub(super) fn one_queue(&self) -> bool {
        self.one_queue
    }

    /// Whether semaphores order all work of a queue up to `prev` before `next`, and make it visible.
    pub(super) fn is_done(&self, prev: At, queue: Queue, next: At) -> bool {
        // Without other queues nobody waits for a semaphore.
        if self.done.is_empty() {
            return false;
        }
        let end = self.queues.len();
        let done = self.done[next.index().unwrap_or(end)][queue as usize];
        prev.index().map_or(prev == At::START && done > 0, |step| done > step)
    }

    /// Whether every use of `a` is done, by the order of its queue or by semaphores, when `b` begins.
    pub(super) fn before(&self, a: ResourceId, b: ResourceId) -> bool {
        let used = |resource: ResourceId| {
            self.steps[resource.0 as usize].iter().enumerate().filter(|(_, steps)| **steps != NEVER)
        };
        let ends = used(a).map(|(queue, steps)| (queue, steps[1] as usize));
        let starts = used(b).map(|(_, steps)| steps[0] as usize);
        !self.kept[a.0 as usize]
            && starts.into_iter().all(|start| {
                ends.clone().all(|(queue, end)| {
                    let done = || self.done.get(start).is_some_and(|done| done[queue] > end);
                    end < start && (self.queues[start] as usize == queue || done())
                })
            })
    }
}

/// What each step, and the end of the frame, knows to be done, from the semaphores that it and those before it waited
/// for.
fn done(schedule: &Schedule, crossings: &[Crossing]) -> Vec<[usize; 3]> {
    let steps = schedule.nodes.len();
    let mut sorted = crossings.to_vec();
    for queue in QUEUES.into_iter().filter(|queue| *queue != Queue::Graphics) {
        // The end of the frame waits for every queue.
        let last = schedule.queues.iter().rposition(|other| *other == queue);
        sorted.extend(last.map(|from| Crossing { from, to: steps }));
    }
    sorted.sort_unstable();
    let mut crossings = sorted.into_iter().peekable();
    let mut latest = [[0; 3]; 3];
    let mut done = vec![[0; 3]; steps + 1];
    for step in 0..=steps {
        let mine = &mut latest[schedule.queues.get(step).copied().unwrap_or_default() as usize];
        while let Some(crossing) = crossings.next_if(|crossing| crossing.to == step) {
            let from = schedule.queues[crossing.from] as usize;
            mine[from] = mine[from].max(crossing.from + 1);
            let known = done[crossing.from];
            (0..3).for_each(|queue| mine[queue] = mine[queue].max(known[queue]));
        }
        done[step] = *mine;
    }
    done
}

/// When each part of each resource is in use by the steps of a plan, parts of equal lifetime together; by resource and
/// range. `description`: the one that the plan was made for.
pub fn lifetimes(description: &Description, plan: &Plan) -> Vec<Lifetime> {
    // 1. First and last step that use each cell.
    let cells = Versions::of_right(description).cells;
    let mut used: Vec<Option<[usize; 2]>> = vec![None; cells.len()];
    for (index, step) in plan.steps.iter().enumerate() {
        for &cell in step.work.uses(description).flat_map(|(version, _)| cells.covered(version.0 as usize)) {
            let used = &mut used[cell as usize];
            *used = Some([used.map_or(index, |[first, _]| first), index]);
        }
    }

    // 2. Cells of equal lifetime become ranges.
    let mut lifetimes = Vec::new();
    for resource in (0..description.resources.len() as u32).map(ResourceId) {
        let mut spans: Vec<([usize; 2], Vec<u32>)> = Vec::new();
        for (cell, steps) in cells.of(resource).filter_map(|cell| Some((cell, used[cell as usize]?))) {
            match spans.iter_mut().find(|(known, _)| *known == steps) {
                Some((_, cells)) => cells.push(cell),
                None => spans.push((steps, vec![cell])),
            }
        }
        for (steps, mine) in spans {
            let ranges = cells.ranges(&mine).into_iter();
            lifetimes.extend(ranges.map(|range| Lifetime { resource, range, steps }));
        }
    }
    lifetimes
}

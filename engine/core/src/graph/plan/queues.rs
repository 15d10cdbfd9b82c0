//! Which queue each step runs on, and how steps are put together into submissions.

use ash::vk::PipelineStageFlags2 as Stages;

use super::dependencies::Node;
use super::history::{At, Schedule};
use super::stages::{any, both, set, with_later, without};
use super::versions::Versions;
use super::{Barriers, Batch, DeviceModel, Wait};
use crate::graph::description::{Description, Queue, VersionId};

/// All kinds of queues, by their number.
pub(super) const QUEUES: [Queue; 3] = [Queue::Graphics, Queue::Compute, Queue::Transfer];

/// Queue families of a device.
#[derive(Clone, Copy)]
pub(super) struct Families([Option<u32>; 3]);

impl Families {
    pub(super) fn new(device: &dyn DeviceModel) -> Self {
        Self(QUEUES.map(|queue| device.family(queue)))
    }

    /// The family of a queue that steps run on.
    pub(super) fn of(&self, queue: Queue) -> u32 {
        self.0[queue as usize].or(self.0[0]).unwrap_or(0)
    }

    /// The queue that work for `queue` runs on.
    fn actual(&self, queue: Queue) -> Queue {
        if self.0[queue as usize].is_some() { queue } else { Queue::Graphics }
    }
}

/// The queue of each step: the one its pass would like, where there is such a queue. Read-backs run on graphics.
/// Unordered writers run on one queue, since they all own the resource at once.
pub(super) fn assign(
    description: &Description,
    versions: &Versions,
    nodes: Vec<Node>,
    families: &Families,
) -> Schedule {
    let passes = description.passes.len();
    let mut queues: Vec<Queue> = Vec::with_capacity(nodes.len());
    for &node in &nodes {
        let queue = description.passes.get(node as usize).map_or(Queue::Graphics, |pass| pass.queue);
        queues.push(families.actual(queue));
    }
    let mut writers: Vec<(VersionId, usize)> = Vec::new();
    let forked = nodes.iter().enumerate().filter(|(_, node)| versions.are_forked() && (**node as usize) < passes);
    for (step, &node) in forked {
        let made = description.uses_of(&description.passes[node as usize]).iter().filter_map(|used| used.makes);
        writers.extend(made.filter_map(|made| versions.fork(made)).map(|fork| (fork, step)));
    }
    writers.sort_unstable();
    // A writer of two forks may draw the one to graphics after the other was looked at: until nothing changes.
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for group in writers.chunk_by(|a, b| a.0 == b.0) {
            let first = queues[group[0].1];
            if group.iter().any(|&(_, step)| queues[step] != first) {
                changed = true;
                group.iter().for_each(|&(_, step)| queues[step] = Queue::Graphics);
            }
        }
    }
    Schedule { nodes, queues, passes }
}

/// A step that waits for a step of another queue. The end of the frame is a step of its own, after all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Crossing {
    /// Who waits.
    pub(super) to: usize,
    /// For whom.
    pub(super) from: usize,
}

/// Stages of a step that come behind a step of another queue, or of its own queue by way of another, by a semaphore.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reliance {
    /// The earlier use.
    pub(super) prev: At,
    /// Its queue.
    pub(super) queue: Queue,
    /// The later one.
    pub(super) next: At,
    /// Stages of the later one.
    pub(super) stages: Stages,
    /// Whether they see what the earlier one wrote, with no barrier; else a barrier is chained to the semaphore.
    pub(super) memory: bool,
}

/// Puts steps together: a batch ends behind a step that another queue waits for, and begins before one that waits.
/// Where there are `takers`, a batch of graphics goes first, to give imported resources to these steps.
pub(super) fn batches(schedule: &Schedule, mut crossings: Vec<Crossing>, takers: &[usize]) -> Vec<Batch> {
    if takers.is_empty() && schedule.queues.iter().all(|queue| *queue == Queue::Graphics) {
        let (steps, waits, release) = ((0..schedule.nodes.len()).collect(), Vec::new(), Barriers::default());
        return vec![Batch { queue: Queue::Graphics, steps, waits, release, signal: 1 }];
    }
    crossings.sort_unstable();
    crossings.dedup();
    let steps = schedule.nodes.len();
    let mut signals = vec![false; steps];
    crossings.iter().for_each(|crossing| signals[crossing.from] = true);

    let mut batches: Vec<Batch> = Vec::new();
    // By queue: the batch that still takes steps, batches begun, and the last value waited for of each other queue.
    let mut open: [Option<usize>; 3] = [None; 3];
    let mut begun = [0; 3];
    let mut waited = [[0; 3]; 3];
    // By queue and batch: what its queue had waited for when it began.
    let mut known: [Vec<[u64; 3]>; 3] = Default::default();
    // By step: the value its queue signals behind it.
    let mut values = vec![0; steps];
    let begin = |queue: Queue, begun: &mut [u64; 3], known: &mut [Vec<[u64; 3]>; 3], waited: [u64; 3], waits| {
        begun[queue as usize] += 1;
        known[queue as usize].push(waited);
        Batch { queue, steps: Vec::new(), waits, release: Barriers::default(), signal: begun[queue as usize] }
    };
    if !takers.is_empty() {
        batches.push(begin(Queue::Graphics, &mut begun, &mut known, [0; 3], Vec::new()));
    }
    let mut crossings = crossings.into_iter().peekable();
    for step in 0..=steps {
        let queue = schedule.queues.get(step).copied().unwrap_or_default();
        let mut needed = [0; 3];
        while let Some(crossing) = crossings.next_if(|crossing| crossing.to == step) {
            let other = schedule.queues[crossing.from] as usize;
            needed[other] = values[crossing.from].max(needed[other]);
        }
        if takers.binary_search(&step).is_ok() {
            needed[0] = needed[0].max(1);
        }
        if step == steps {
            // The frame ends when every queue is done.
            needed = begun;
            needed[0] = 0;
        }
        let waits = waits(needed, &mut waited[queue as usize], &known);
        let place = match open[queue as usize] {
            Some(place) if waits.is_empty() => place,
            _ if step == steps && waits.is_empty() && batches.last().is_some_and(|last| last.queue == queue) => break,
            _ => {
                batches.push(begin(queue, &mut begun, &mut known, waited[queue as usize], waits));
                batches.len() - 1
            }
        };
        if step == steps {
            // Its place is behind all others.
            if place + 1 != batches.len() {
                batches.push(begin(queue, &mut begun, &mut known, waited[queue as usize], Vec::new()));
            }
            break;
        }
        batches[place].steps.push(step);
        values[step] = batches[place].signal;
        open[queue as usize] = (!signals[step]).then_some(place);
    }
    batches
}

/// By step: its batch. Nothing where there is but one.
pub(super) fn batch_of(batches: &[Batch], schedule: &Schedule) -> Vec<usize> {
    let mut batch_of = vec![0; if batches.len() == 1 { 0 } else { schedule.nodes.len() }];
    for (index, batch) in batches.iter().enumerate().skip(1) {
        batch.steps.iter().for_each(|&step| batch_of[step] = index);
    }
    batch_of
}

/// Waits for the values needed that are not waited for yet, by this queue or by a batch that it waits for.
fn waits(needed: [u64; 3], waited: &mut [u64; 3], known: &[Vec<[u64; 3]>; 3]) -> Vec<Wait> {
    let missing = QUEUES.into_iter().filter(|queue| needed[*queue as usize] > waited[*queue as usize]);
    let missing: Vec<Queue> = missing.collect();
    let knows = |other: Queue| known[other as usize][needed[other as usize] as usize - 1];
    let waits = missing.iter().filter(|&&queue| {
        let mut others = missing.iter().filter(|&&other| other != queue);
        !others.any(|&other| knows(other)[queue as usize] >= needed[queue as usize])
    });
    let wait = |&queue: &Queue| Wait { queue, value: needed[queue as usize], stages: Stages::NONE };
    let waits: Vec<Wait> = waits.map(wait).collect();
    for &other in &missing {
        waited.iter_mut().zip(knows(other)).for_each(|(mine, theirs)| *mine = theirs.max(*mine));
        waited[other as usize] = waited[other as usize].max(needed[other as usize]);
    }
    waits
}

/// Steps of a batch's own queue that are done when the batch begins, as another queue waited for them.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoundTrip {
    /// The batch.
    pub(super) batch: usize,
    /// Stages of it that wait.
    pub(super) stages: Stages,
    /// How many steps of the queue, from its first on.
    pub(super) steps: u32,
}

/// How many semaphores are looked at for each use that relies on one: bounds the cost of frames with many.
const LOOKED_AT: usize = 8;

/// Has each semaphore hold up only stages that rely on it. The one by which the frame ends may hold up all. Gives, by
/// reliance, the stages that a barrier chained to the semaphore begins with.
pub(super) fn narrow(
    batches: &mut [Batch],
    schedule: &Schedule,
    reliances: &[Reliance],
) -> (Vec<Stages>, Vec<RoundTrip>) {
    if batches.iter().all(|batch| batch.waits.is_empty()) {
        return Default::default();
    }
    // By queue and value: the batch, and up to which value of each queue it knows all to be done when it begins.
    let mut places: [Vec<(usize, [u64; 3])>; 3] = Default::default();
    let mut values = vec![0; schedule.nodes.len()];
    for (index, batch) in batches.iter().enumerate() {
        batch.steps.iter().for_each(|&step| values[step] = batch.signal);
        let mut known = places[batch.queue as usize].last().map_or([0; 3], |last| last.1);
        for wait in &batch.waits {
            let theirs = knows(&places, wait);
            (0..3).for_each(|queue| known[queue] = known[queue].max(theirs[queue]));
        }
        places[batch.queue as usize].push((index, known));
    }
    let value = |at: At| at.index().map_or(1, |step| values[step]);
    let end = batches.last().map_or((0, 0), |batch| (batch.queue as usize, batch.signal));
    // By reliance: the waits that will do. Those with the least choice come first, and barriers after memory.
    let mut choices: Vec<(usize, Vec<(usize, usize)>)> = Vec::with_capacity(reliances.len());
    for (index, reliance) in reliances.iter().enumerate() {
        let own = reliance.next.index().map_or(end, |step| (schedule.queues[step] as usize, values[step]));
        let needed = value(reliance.prev);
        let before = places[own.0][..own.1 as usize].iter().rev();
        let waits = before.flat_map(|&(batch, _)| (0..batches[batch].waits.len()).map(move |wait| (batch, wait)));
        let will_do = |&(batch, wait): &(usize, usize)| {
            knows(&places, &batches[batch].waits[wait])[reliance.queue as usize] >= needed
        };
        choices.push((index, waits.filter(will_do).take(LOOKED_AT).collect()));
    }
    choices.sort_by_key(|(index, waits)| {
        let Reliance { memory, stages, .. } = reliances[*index];
        (!memory, waits.len(), set(stages).trailing_zeros())
    });
    let mut chained: Vec<Stages> = reliances.iter().map(|reliance| reliance.stages).collect();
    for (index, waits) in choices {
        let Reliance { stages, memory, .. } = reliances[index];
        if stages == Stages::ALL_COMMANDS {
            continue;
        }
        let known = waits.iter().map(|&(batch, wait)| batches[batch].waits[wait].stages);
        let held = known.clone().fold(0, |held, stages| held | set(stages));
        let missing = without(stages, if memory { held } else { with_later(held) });
        let other = known.map(any).find(|stages| !memory && !stages.is_empty());
        match (other, waits.first()) {
            _ if missing.is_empty() => {}
            // A barrier may come behind any stage that is held up anyway.
            (Some(other), _) => chained[index] = other,
            // The last semaphore holds up the fewest steps.
            (None, Some(&(batch, wait))) => {
                let stages = &mut batches[batch].waits[wait].stages;
                *stages = both(*stages, missing);
            }
            (None, None) => {}
        }
    }
    for wait in batches.iter_mut().flat_map(|batch| &mut batch.waits).filter(|wait| wait.stages.is_empty()) {
        wait.stages = Stages::ALL_COMMANDS;
    }

    // By queue and value: how many of its steps are done.
    let mut counts: [Vec<u32>; 3] = Default::default();
    for batch in batches.iter() {
        let counts = &mut counts[batch.queue as usize];
        counts.push(counts.last().unwrap_or(&0) + batch.steps.len() as u32);
    }
    let mut trips = Vec::new();
    for (index, batch) in batches.iter().enumerate() {
        for wait in &batch.waits {
            if let Some(value) = (knows(&places, wait)[batch.queue as usize] as usize).checked_sub(1) {
                let steps = counts[batch.queue as usize][value];
                trips.push(RoundTrip { batch: index, stages: wait.stages, steps });
            }
        }
    }
    (chained, trips)
}

/// Up to which value of each queue all is done when a wait is over.
fn knows(places: &[Vec<(usize, [u64; 3])>; 3], wait: &Wait) -> [u64; 3] {
    let mut known = places[wait.queue as usize][wait.value as usize - 1].1;
    known[wait.queue as usize] = wait.value;
    known
}

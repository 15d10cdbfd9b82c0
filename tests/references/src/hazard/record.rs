//! Records of accesses, and how barriers and semaphores move them along.

use ash::vk::{AccessFlags2 as Mask, PipelineStageFlags2 as Stages};
use shadowgraph::graph::description::{Access, Queue, VersionId};

/// A set of single stages.
pub type StageSet = u64;

/// Stages of the graphics pipeline, in logical order.
const PIPELINE: [Stages; 11] = [
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
];

/// Single stages that a mask stands for.
pub fn single(stages: Stages) -> StageSet {
    if stages.contains(Stages::ALL_COMMANDS) {
        // The host runs no commands.
        return StageSet::MAX & !Stages::HOST.as_raw();
    }
    let mut set = stages.as_raw();
    if stages.contains(Stages::ALL_TRANSFER) {
        set &= !Stages::ALL_TRANSFER.as_raw();
        set |= (Stages::COPY | Stages::BLIT | Stages::RESOLVE | Stages::CLEAR).as_raw();
    }
    set
}

pub fn each(set: StageSet) -> impl Iterator<Item = StageSet> {
    (0..64).map(|bit| 1 << bit).filter(move |bit| set & bit != 0)
}

/// With logically earlier stages.
fn earlier(set: StageSet) -> StageSet {
    let last = PIPELINE.iter().rposition(|stage| set & stage.as_raw() != 0);
    let graphics = PIPELINE.iter().take(last.map_or(0, |last| last + 1)).fold(0, |all, stage| all | stage.as_raw());
    let compute = if set & Stages::COMPUTE_SHADER.as_raw() != 0 { Stages::DRAW_INDIRECT.as_raw() } else { 0 };
    set | graphics | compute
}

/// With logically later stages.
fn later(set: StageSet) -> StageSet {
    let first = PIPELINE.iter().position(|stage| set & stage.as_raw() != 0).unwrap_or(PIPELINE.len());
    let graphics = PIPELINE.iter().skip(first).fold(0, |all, stage| all | stage.as_raw());
    let compute = if set & Stages::DRAW_INDIRECT.as_raw() != 0 { Stages::COMPUTE_SHADER.as_raw() } else { 0 };
    set | graphics | compute
}

/// What left the record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Read,
    Write,
    /// A layout transition, or either half of an ownership transfer.
    Transition,
}

/// An access that later ones are held against.
#[derive(Clone, Debug)]
pub struct Record {
    pub kind: Kind,
    /// For messages.
    pub who: String,
    /// Where and when it ran.
    pub queue: Queue,
    pub batch: u64,
    /// One stage; none for a transition.
    pub stage: StageSet,
    pub mask: Mask,
    /// What an unordered writer started from.
    pub fork: Option<VersionId>,
    /// By queue: stages whose later work comes behind it.
    ordered: [StageSet; 3],
    /// By queue: the first batch in which some stage's did.
    since: [Option<u64>; 3],
    /// By queue: stages whose later work comes behind an operation that made it available.
    available: [StageSet; 3],
    /// Queue, stages and accesses that it is visible to.
    visible: Vec<(Queue, StageSet, Mask)>,
}

/// Scopes of a barrier on a queue.
#[derive(Clone, Copy, Debug)]
pub struct Scopes {
    pub queue: Queue,
    pub batch: u64,
    pub from: Access,
    pub to: Access,
}

impl Record {
    pub fn new(kind: Kind, who: String, queue: Queue, batch: u64, stage: StageSet, mask: Mask) -> Self {
        let (fork, ordered, since, available, visible) = (None, [0; 3], [None; 3], [0; 3], Vec::new());
        Self { kind, who, queue, batch, stage, mask, fork, ordered, since, available, visible }
    }

    /// A transition by a barrier: available at once, and visible to the barrier's second scopes.
    pub fn transition(who: String, scopes: &Scopes) -> Self {
        let mut record = Self::new(Kind::Transition, who, scopes.queue, scopes.batch, 0, Mask::NONE);
        record.order(scopes.queue, scopes.batch, later(single(scopes.to.stages)));
        record.available = record.ordered;
        record.show(scopes.queue, single(scopes.to.stages), scopes.to.mask);
        record
    }

    /// An earlier frame's write that is known to be visible to these accesses.
    pub fn arrived(access: &Access) -> Self {
        let mut record = Self::new(Kind::Transition, "before the frame".into(), Queue::Graphics, 0, 0, Mask::NONE);
        record.order(Queue::Graphics, 0, later(single(access.stages)));
        record.available = record.ordered;
        record.show(Queue::Graphics, single(access.stages), access.mask);
        record
    }

    pub fn writes(&self) -> bool {
        self.kind != Kind::Read
    }

    /// Whether it is in a barrier's first synchronisation scope, directly or by a chain.
    pub fn in_first_scope(&self, scopes: &Scopes) -> bool {
        let first = earlier(single(scopes.from.stages));
        let runs = self.queue == scopes.queue && self.stage & first != 0;
        runs || self.ordered[scopes.queue as usize] & first != 0
    }

    /// Whether a barrier in whose first synchronisation scope it is makes it available.
    pub fn in_first_access_scope(&self, scopes: &Scopes) -> bool {
        let stage = self.stage & single(scopes.from.stages) != 0;
        self.queue == scopes.queue && stage && scopes.from.mask.contains(self.mask)
    }

    /// Whether what made it available comes before a barrier. A transition is available at once.
    pub fn is_available_to(&self, scopes: &Scopes) -> bool {
        let chained = self.available[scopes.queue as usize] & earlier(single(scopes.from.stages)) != 0;
        chained || (self.kind == Kind::Transition && self.queue == scopes.queue)
    }

    pub fn second_scope(&mut self, scopes: &Scopes) {
        self.order(scopes.queue, scopes.batch, later(single(scopes.to.stages)));
    }

    pub fn make_available(&mut self, scopes: &Scopes) {
        self.available[scopes.queue as usize] |= later(single(scopes.to.stages));
    }

    pub fn second_access_scope(&mut self, scopes: &Scopes) {
        self.show(scopes.queue, single(scopes.to.stages), scopes.to.mask);
    }

    fn order(&mut self, queue: Queue, batch: u64, stages: StageSet) {
        if stages != 0 {
            self.ordered[queue as usize] |= stages;
            self.since[queue as usize].get_or_insert(batch);
        }
    }

    fn show(&mut self, queue: Queue, stages: StageSet, mask: Mask) {
        if stages != 0 && !mask.is_empty() {
            self.visible.push((queue, stages, mask));
        }
    }

    /// A batch waits for the semaphore of `other` to reach `value`.
    pub fn wait(&mut self, queue: Queue, batch: u64, other: Queue, value: u64, stages: Stages) {
        let ran = self.queue == other && self.batch <= value;
        if ran || self.since[other as usize].is_some_and(|since| since <= value) {
            self.order(queue, batch, later(single(stages)));
            self.available[queue as usize] |= later(single(stages));
            self.show(queue, single(stages), Mask::from_raw(u64::MAX));
        }
    }

    /// Whether later work of a stage comes behind it.
    pub fn is_before(&self, queue: Queue, stage: StageSet) -> bool {
        self.ordered[queue as usize] & stage == stage
    }

    /// Whether it is visible to an access of a stage.
    pub fn is_visible(&self, queue: Queue, stage: StageSet, mask: Mask) -> bool {
        self.visible.iter().any(|seen| seen.0 == queue && seen.1 & stage == stage && seen.2.contains(mask))
    }

    /// Whether it is available when later work of a stage begins.
    pub fn is_available(&self, queue: Queue, stage: StageSet) -> bool {
        self.available[queue as usize] & stage == stage
    }

    /// The record as the next frame finds it: counts of submissions begin anew.
    pub fn of_the_frame_before(&self) -> Self {
        let since = self.since.map(|since| since.map(|_| 0));
        Self { batch: 0, since, ..self.clone() }
    }

    /// Whether a queue knows of it at all.
    pub fn is_known(&self, queue: Queue) -> bool {
        self.queue == queue || self.since[queue as usize].is_some()
    }
}

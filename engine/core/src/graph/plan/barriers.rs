//! Barriers between the groups of each cell.

use ash::vk::{AccessFlags2 as Mask, ImageLayout as Layout, PipelineStageFlags2 as Stages};

use super::history::{At, Group, History, Schedule};
use super::lifetimes::Lifetimes;
use super::lists::Lists;
use super::place::Placed;
use super::queues::{Crossing, Families, Reliance};
use super::stages::{any, both, earliest, latest, set, with_later, without};
use super::usage::reads;
use super::versions::Versions;
use super::{Hazard, Ownership};
use crate::graph::description::{Access, Description, Queue, ResourceId, Shape};

/// A barrier of one cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    pub(super) cell: u32,
    /// The step that it stands before or, where it releases, behind.
    pub(super) at: At,
    pub(super) release: bool,
    /// The last use that it stands behind.
    pub(super) behind: At,
    /// First and end of the reliances on semaphores that it is chained to.
    relies: [u32; 2],
    pub(super) kind: Kind,
}

/// All barriers, by cell.
pub(super) struct AllPending {
    pub(super) list: Vec<Pending>,
    /// Numbers of barriers by the place where they stand, there by cell.
    pub(super) order: Vec<u32>,
}

impl AllPending {
    /// Puts them in order again. `steps`: how many there are.
    pub(super) fn sort(&mut self, steps: usize) {
        let place = |barrier: &Pending| 2 * barrier.at.place(steps) + usize::from(barrier.release);
        // Those of a chain come in order.
        if self.list.is_sorted_by_key(place) {
            self.order = (0..self.list.len() as u32).collect();
            return;
        }
        let places = (0..).zip(&self.list).map(|(index, barrier)| (place(barrier), index));
        self.order = Lists::new(2 * (steps + 2), places).into_all();
    }
}

/// Has barriers that are chained to semaphores begin with stages that these hold up; by reliance. Gives the resources
/// they are for, ascending.
pub(super) fn chain(context: &Context, pending: &mut [Pending], held: &[Stages]) -> Vec<ResourceId> {
    let mut chained = Vec::new();
    for barrier in pending.iter_mut().filter(|_| !held.is_empty()) {
        let [first, end] = barrier.relies.map(|place| place as usize);
        if let Some(held) = held.get(first..end).filter(|held| !held.is_empty()) {
            barrier.kind.from.stages = held.iter().fold(barrier.kind.from.stages, |all, &stages| both(all, stages));
            chained.push(context.resource(barrier));
        }
    }
    chained.sort_unstable();
    chained
}

impl Pending {
    /// Whether no memory depends on it.
    pub(super) fn only_orders(&self) -> bool {
        let Kind { scope, from, to, .. } = &self.kind;
        *scope == Scope::Memory && from.mask.is_empty() && to.mask.is_empty()
    }
}

/// All that must be alike for cells to share a barrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kind {
    pub(super) scope: Scope,
    pub(super) from: Access,
    pub(super) to: Access,
    pub(super) ownership: Option<Ownership>,
    pub(super) hazard: Hazard,
    /// The last use before it and the first one after it.
    pub(super) before: At,
    pub(super) after: At,
}

/// Which of Vulkan's barriers it becomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scope {
    /// `VkImageMemoryBarrier2` or `VkBufferMemoryBarrier2`.
    Resource,
    /// `VkMemoryBarrier2`.
    Memory,
}

/// What barriers are made from.
pub(super) struct Context<'a> {
    pub(super) description: &'a Description,
    pub(super) versions: &'a Versions,
    pub(super) history: &'a History,
    pub(super) schedule: &'a Schedule,
    pub(super) lifetimes: &'a Lifetimes,
    pub(super) families: Families,
}

/// Steps of one queue that wait for steps of another one.
pub(super) fn crossings(history: &History, cells: usize, schedule: &Schedule) -> Vec<Crossing> {
    let mut crossings = Vec::new();
    let steps = schedule.nodes.len();
    if schedule.queues.iter().all(|queue| *queue == Queue::Graphics) {
        return crossings;
    }
    for cell in 0..cells as u32 {
        for pair in history.of(cell).windows(2).filter(|pair| pair[0].queue != pair[1].queue) {
            if let Some(from) = pair[0].last.index() {
                crossings.push(Crossing { from, to: pair[1].first.index().unwrap_or(steps) });
            }
        }
    }
    crossings
}

/// Every barrier of every cell, and what is left to semaphores.
pub(super) fn pending(context: &Context, placed: &Placed) -> (AllPending, Vec<Reliance>) {
    let mut found = Found { pending: Vec::with_capacity(context.history.len()), ..Found::default() };
    // What the contents of a cell were made visible to since they were written.
    let mut visible: Vec<Seen> = Vec::new();
    for cell in 0..context.versions.cells.len() as u32 {
        found.cell = cell;
        let groups = context.history.of(cell);
        if let Some(first) = groups.first().filter(|group| group.first != At::START) {
            found.first_use(context, placed, first);
        }
        visible.clear();
        if let Some(arrived) = groups.first().filter(|group| group.first == At::START && !group.write) {
            let Access { stages, mask, .. } = arrived.access;
            let all = (Queue::Graphics, Stages::from_raw(!0), Mask::from_raw(!0));
            visible.push(if stages.is_empty() { all } else { (Queue::Graphics, stages, mask) });
        }
        for pair in groups.windows(2) {
            found.between(context, &pair[0], &pair[1], &mut visible);
        }
    }
    let mut pending = AllPending { list: found.pending, order: Vec::new() };
    pending.sort(context.schedule.nodes.len());
    (pending, found.reliances)
}

/// To what the contents of a cell are visible.
type Seen = (Queue, Stages, Mask);

/// What was found so far.
#[derive(Default)]
struct Found {
    /// Looked at now.
    cell: u32,
    pending: Vec<Pending>,
    reliances: Vec<Reliance>,
}

impl Found {
    fn push(&mut self, at: At, release: bool, kind: Kind) {
        self.pending.push(Pending { cell: self.cell, at, release, behind: kind.before, relies: [0; 2], kind });
    }

    /// Some stages of `next` come behind `prev` by a semaphore; `memory`: and see what it wrote.
    fn rely(&mut self, prev: &Group, next: &Group, stages: Stages, memory: bool) {
        self.reliances.push(Reliance { prev: prev.last, queue: prev.queue, next: next.first, stages, memory });
    }

    /// The last barrier is chained to the reliances from this one on.
    fn chained_from(&mut self, first: usize) {
        if let Some(barrier) = self.pending.last_mut() {
            barrier.relies = [first as u32, self.reliances.len() as u32];
        }
    }

    /// The first use of a transient: its image gets a layout, its memory comes from others.
    fn first_use(&mut self, context: &Context, placed: &Placed, first: &Group) {
        let resource = context.versions.cells.resource(self.cell);
        let is_image = context.is_image(resource);
        let (to, after) = (first.needs(), first.first);
        // What another resource wrote is out of reach of an image's own scopes: it takes a barrier for all memory to
        // make it available. The transition, a write as well, stands between that and the first use.
        let over = if is_image { execution(to) } else { Access { layout: Layout::UNDEFINED, ..to } };
        let (mut readers, mut semaphores) = (Stages::NONE, Vec::new());
        let mut old: Option<(At, ResourceId)> = None;
        let start = self.pending.len();
        for &tenant in placed.earlier(resource) {
            for group in context.versions.cells.of(tenant).filter_map(|cell| context.history.of(cell).last()) {
                old = old.max(Some((group.last, tenant)));
                let done = || !is_image && context.lifetimes.is_done(group.last, group.queue, first.first);
                if group.queue != first.queue || done() {
                    semaphores.push(group);
                } else if group.write {
                    let from = Access { mask: group.access.writes(), layout: Layout::UNDEFINED, ..group.access };
                    let (hazard, before) = (Hazard::Alias { old: tenant }, group.last);
                    let kind = Kind { scope: Scope::Memory, from, to: over, ownership: None, hazard, before, after };
                    self.push(first.first, false, kind);
                } else {
                    readers = both(readers, group.access.stages);
                }
            }
        }
        let from = Access { stages: latest(readers), ..Access::NONE };
        let relies = self.reliances.len();
        if !semaphores.is_empty() {
            // A semaphore made all of it available; a transition has to come behind the semaphore.
            let relying = match (is_image, from.stages.is_empty()) {
                (false, _) => first.access.stages,
                (true, true) => any(first.access.stages),
                (true, false) => any(from.stages),
            };
            semaphores.iter().for_each(|group| self.rely(group, first, relying, !is_image));
        }
        let hazard = old.map_or(Hazard::First, |(_, old)| Hazard::Alias { old });
        let before = old.map_or(At::START, |(at, _)| at);
        let kind = Kind { scope: Scope::Resource, from, to, ownership: None, hazard, before, after };
        if is_image {
            self.push(first.first, false, kind);
            self.chained_from(relies);
        } else if !from.stages.is_empty() {
            self.push(first.first, false, Kind { scope: Scope::Memory, to: execution(to), ..kind });
        }
        // They stay together.
        self.pending[start..].iter_mut().for_each(|barrier| barrier.behind = before);
    }

    /// What stands between two groups of a cell.
    fn between(&mut self, context: &Context, prev: &Group, next: &Group, visible: &mut Vec<Seen>) {
        let is_image = context.is_image(context.versions.cells.resource(self.cell));
        let crosses = prev.queue != next.queue;
        let keeps = next.reads && !(is_image && prev.access.layout == Layout::UNDEFINED);
        let [old, new] = [prev, next].map(|group| context.families.of(group.queue));
        let ownership = (crosses && keeps && old != new).then_some(Ownership { from: old, to: new });
        let lost = is_image && crosses && old != new && !keeps;
        let transition = is_image && (prev.access.layout != next.access.layout || lost);
        // What arrives idle waits for nobody.
        let idle = prev.first == At::START && prev.access.stages.is_empty() && ownership.is_none();
        let done = || !transition && context.lifetimes.is_done(prev.last, prev.queue, next.first);
        let synced = !idle && (crosses || done());

        let hazard = match (prev.write, next.write) {
            _ if ownership.is_some() => Hazard::Ownership,
            _ if next.first == At::END => Hazard::Final,
            _ if prev.first == At::START && prev.access == Access::NONE && is_image => Hazard::First,
            (true, false) => Hazard::ReadAfterWrite,
            (true, true) => Hazard::WriteAfterWrite,
            (false, true) => Hazard::WriteAfterRead,
            (false, false) if transition => Hazard::Layout,
            (false, false) => Hazard::ReadAfterWrite,
        };
        let layout = if keeps || !transition { prev.access.layout } else { Layout::UNDEFINED };
        let from = match prev.write {
            true => Access { mask: prev.access.writes(), layout, ..prev.access },
            false => Access { stages: latest(prev.access.stages), mask: Mask::NONE, layout },
        };
        let (before, after) = (prev.last, next.first);
        let to = next.needs();
        let kind = Kind { scope: Scope::Resource, from, to, ownership, hazard, before, after };

        if ownership.is_some() {
            let to = Access { layout: to.layout, ..Access::NONE };
            self.push(prev.last, true, Kind { to, ..kind });
        }
        let unseen = |visible: &[Seen]| if next.reads { unseen(next.queue, &to, visible) } else { Access::NONE };
        if synced {
            // The semaphore made everything visible. What stands here has to come behind it.
            if transition || ownership.is_some() {
                let stages = if next.first == At::END { Stages::ALL_COMMANDS } else { any(to.stages) };
                let from = Access { layout, ..Access::NONE };
                self.push(next.first, false, Kind { from, ..kind });
                self.rely(prev, next, stages, false);
                self.chained_from(self.reliances.len() - 1);
                visible.clear();
            } else if next.first != At::END || !to.stages.is_empty() {
                self.rely(prev, next, to.stages, true);
                visible.push((next.queue, to.stages, Mask::from_raw(!0)));
            }
        } else if transition || prev.write {
            self.push(next.first, false, kind);
            visible.clear();
        } else if let unseen = unseen(visible)
            && !unseen.mask.is_empty()
        {
            // Made available by what made the earlier readers see it. A writer waits for those in all of its stages.
            let others = if next.write { without(to.stages, with_later(set(unseen.stages))) } else { Stages::NONE };
            let to = Access { stages: unseen.stages | earliest(others), ..unseen };
            self.push(next.first, false, Kind { to, ..kind });
        } else if next.write && !prev.access.stages.is_empty() {
            self.push(
                next.first,
                false,
                Kind { scope: Scope::Memory, from: execution(from), to: execution(to), ..kind },
            );
        }
        if next.write {
            visible.clear();
        } else {
            visible.push((next.queue, to.stages, to.mask));
        }
    }
}

impl Group {
    /// What has to be visible to it: its own writes alone, where what was there before does not matter.
    fn needs(&self) -> Access {
        if self.reads { self.access } else { Access { mask: self.access.writes(), ..self.access } }
    }
}

/// Stages and accesses that read what is not visible to them.
fn unseen(queue: Queue, access: &Access, visible: &[Seen]) -> Access {
    let sees = |stage: Stages, mask: Mask| {
        visible.iter().any(|seen| seen.0 == queue && seen.1.contains(stage) && seen.2.contains(mask))
    };
    let mut unseen = Access { layout: access.layout, ..Access::NONE };
    for (stage, mask) in reads(access).filter(|&(stage, mask)| !sees(stage, mask)) {
        unseen.stages |= stage;
        unseen.mask |= mask;
    }
    unseen
}

/// Only the stages.
fn execution(access: Access) -> Access {
    Access { stages: earliest(access.stages), ..Access::NONE }
}

impl Context<'_> {
    pub(super) fn is_image(&self, resource: ResourceId) -> bool {
        matches!(self.description.resources[resource.0 as usize].shape, Shape::Image(_))
    }

    pub(super) fn resource(&self, pending: &Pending) -> ResourceId {
        self.versions.cells.resource(pending.cell)
    }

    /// Steps on other queues than graphics that use imported resources first: they wait for what graphics did to them
    /// before the frame, and for their release.
    pub(super) fn takers(&self, pending: &[Pending]) -> Vec<usize> {
        if self.schedule.queues.iter().all(|queue| *queue == Queue::Graphics) {
            return Vec::new();
        }
        let cells = 0..self.versions.cells.len() as u32;
        let arrived = cells.filter_map(|cell| match self.history.of(cell) {
            [first, next, ..] if first.first == At::START && !first.access.stages.is_empty() => next.first.index(),
            _ => None,
        });
        let releases = pending.iter().filter(|barrier| barrier.release && barrier.at == At::START);
        let released = releases.filter_map(|barrier| barrier.kind.after.index());
        let takers = arrived.chain(released).filter(|&step| self.schedule.queues[step] != Queue::Graphics);
        let mut takers: Vec<usize> = takers.collect();
        takers.sort_unstable();
        takers
    }
}

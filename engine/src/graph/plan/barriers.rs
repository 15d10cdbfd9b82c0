//! Barriers between the groups of each cell, put together by range and by step.

use ash::vk::{AccessFlags2 as Mask, ImageLayout as Layout, PipelineStageFlags2 as Stages};

use super::history::{At, Group, History, Schedule};
use super::lifetimes::Lifetimes;
use super::place::Placed;
use super::queues::{Crossing, Families};
use super::versions::Versions;
use super::{Barriers, BufferBarrier, Hazard, ImageBarrier, MemoryBarrier, Ownership, Reason};
use crate::graph::description::{Access, Description, Queue, ResourceId, Shape};

/// A barrier of one cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    pub(super) cell: u32,
    /// The step that it stands before or, where it releases, behind.
    pub(super) at: At,
    pub(super) release: bool,
    kind: Kind,
}

impl Pending {
    /// The last use that it stands behind.
    pub(super) fn before(&self) -> At {
        self.kind.before
    }
}

/// All that must be alike for cells to share a barrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Kind {
    scope: Scope,
    from: Access,
    to: Access,
    ownership: Option<Ownership>,
    hazard: Hazard,
    /// The last use before it and the first one after it.
    before: At,
    after: At,
}

/// Which of Vulkan's barriers it becomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scope {
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
pub(super) fn crossings(history: &History, cells: usize, steps: usize) -> Vec<Crossing> {
    let mut crossings = Vec::new();
    for cell in 0..cells as u32 {
        for pair in history.of(cell).windows(2).filter(|pair| pair[0].queue != pair[1].queue) {
            if let Some(from) = pair[0].last.index() {
                crossings.push(Crossing { from, to: pair[1].first.index().unwrap_or(steps) });
            }
        }
    }
    crossings
}

/// Every barrier of every cell.
pub(super) fn pending(context: &Context, placed: &Placed) -> Vec<Pending> {
    let mut pending = Vec::new();
    for cell in 0..context.versions.cells.len() as u32 {
        let groups = context.history.of(cell);
        if let Some(first) = groups.first().filter(|group| group.first != At::START) {
            first_use(context, placed, cell, first, &mut pending);
        }
        // What the contents were made visible to since they were written.
        let mut visible: Vec<(Stages, Mask)> = Vec::new();
        if let Some(arrived) = groups.first().filter(|group| group.first == At::START && !group.write) {
            let Access { stages, mask, .. } = arrived.access;
            let idle = stages.is_empty();
            visible.push(if idle { (Stages::from_raw(!0), Mask::from_raw(!0)) } else { (stages, mask) });
        }
        for pair in groups.windows(2) {
            between(context, cell, &pair[0], &pair[1], &mut visible, &mut pending);
        }
    }
    pending.sort_by_key(|barrier| (barrier.at, barrier.release));
    pending
}

/// The first use of a transient: its image gets a layout, its memory comes from others.
fn first_use(context: &Context, placed: &Placed, cell: u32, first: &Group, pending: &mut Vec<Pending>) {
    let resource = context.versions.cells.resource(cell);
    let is_image = context.is_image(resource);
    let (mut from, mut writers) = (Access::NONE, Access::NONE);
    let mut old: Option<(At, ResourceId)> = None;
    for &tenant in &placed.earlier[resource.0 as usize] {
        for group in context.versions.cells.of(tenant).filter_map(|cell| context.history.of(cell).last()) {
            old = old.max(Some((group.last, tenant)));
            if group.queue != first.queue || context.lifetimes.is_done(group.last, group.queue, first.first) {
                // A semaphore made all of it available; a transition has to come behind the semaphore.
                from.stages |= if is_image { first.access.stages } else { Stages::NONE };
            } else {
                from.stages |= group.access.stages;
                if group.write {
                    writers.stages |= group.access.stages;
                    writers.mask |= group.access.writes();
                }
            }
        }
    }
    let hazard = old.map_or(Hazard::First, |(_, old)| Hazard::Alias { old });
    let before = old.map_or(At::START, |(at, _)| at);
    from.mask = writers.mask;
    let (scope, to, ownership, after) = (Scope::Memory, first.access, None, first.first);
    let kind = Kind { scope, from, to, ownership, hazard, before, after };
    let mut push = |kind: Kind| pending.push(Pending { cell, at: first.first, release: false, kind });
    if is_image {
        // Its own scopes do not reach what was written through another resource: that takes a barrier for all memory.
        // The mask is here as well because synchronisation validation judges each transition by its own barrier.
        push(Kind { scope: Scope::Resource, ..kind });
    }
    if !writers.mask.is_empty() {
        let from = if is_image { writers } else { from };
        push(Kind { from, to: Access { layout: Layout::UNDEFINED, ..first.access }, ..kind });
    } else if !is_image && !from.stages.is_empty() {
        push(Kind { to: execution(first.access), ..kind });
    }
}

/// What stands between two groups of a cell.
fn between(
    context: &Context,
    cell: u32,
    prev: &Group,
    next: &Group,
    visible: &mut Vec<(Stages, Mask)>,
    pending: &mut Vec<Pending>,
) {
    let is_image = context.is_image(context.versions.cells.resource(cell));
    let crosses = prev.queue != next.queue;
    let synced = crosses || context.lifetimes.is_done(prev.last, prev.queue, next.first);
    let keeps = next.reads && !(is_image && prev.access.layout == Layout::UNDEFINED);
    let [old, new] = [prev, next].map(|group| context.families.of(group.queue));
    let ownership = (crosses && keeps && old != new).then_some(Ownership { from: old, to: new });
    let lost = is_image && crosses && old != new && !keeps;
    let transition = is_image && (prev.access.layout != next.access.layout || lost);
    let written = if prev.write { prev.access.writes() } else { Mask::NONE };

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
    let layout = if keeps { prev.access.layout } else { Layout::UNDEFINED };
    let from = Access { stages: prev.access.stages, mask: written, layout };
    let (before, after) = (prev.last, next.first);
    let kind = Kind { scope: Scope::Resource, from, to: next.access, ownership, hazard, before, after };
    let mut push = |at: At, release: bool, kind: Kind| pending.push(Pending { cell, at, release, kind });

    if ownership.is_some() {
        let to = Access { layout: next.access.layout, ..Access::NONE };
        push(prev.last, true, Kind { to, ..kind });
    }
    let seen = |mask: Mask| visible.iter().any(|known| known.0.contains(next.access.stages) && known.1.contains(mask));
    if synced {
        // The semaphore made everything visible. What stands here has to come behind it.
        if transition || ownership.is_some() {
            let stages = if next.access.stages.is_empty() { Stages::ALL_COMMANDS } else { next.access.stages };
            let from = Access { stages, mask: Mask::NONE, layout };
            push(next.first, false, Kind { from, ..kind });
        }
        visible.clear();
        if !transition && ownership.is_none() {
            visible.push((Stages::from_raw(!0), Mask::from_raw(!0)));
        }
    } else if transition || prev.write {
        push(next.first, false, kind);
        visible.clear();
    } else if next.reads && !next.access.reads().is_empty() && !seen(next.access.reads()) {
        // Made available by what made the earlier readers see it.
        let to = Access { mask: next.access.reads(), ..next.access };
        push(next.first, false, Kind { to, ..kind });
    } else if next.write && !prev.access.stages.is_empty() {
        let (from, to) = (execution(from), execution(next.access));
        push(next.first, false, Kind { scope: Scope::Memory, from, to, ..kind });
    }
    if next.write {
        visible.clear();
    } else {
        visible.push((next.access.stages, next.access.mask));
    }
}

/// Only the stages.
fn execution(access: Access) -> Access {
    Access { stages: access.stages, ..Access::NONE }
}

/// Puts barriers of one place together: cells that share one become ranges. `pending`: all of one `at`.
pub(super) fn together(context: &Context, pending: &[Pending], barriers: &mut Barriers) {
    let mut alike: Vec<(Kind, Vec<u32>)> = Vec::new();
    for resource in pending.chunk_by(|a, b| context.resource(a) == context.resource(b)) {
        alike.clear();
        for barrier in resource {
            match alike.iter_mut().find(|(kind, _)| *kind == barrier.kind) {
                Some((_, cells)) => cells.push(barrier.cell),
                None => alike.push((barrier.kind, vec![barrier.cell])),
            }
        }
        let resource = context.resource(&resource[0]);
        for (kind, cells) in &alike {
            let reason = Reason {
                hazard: kind.hazard,
                resource: Some(resource),
                before: kind.before.index().map(|step| context.schedule.work(step)),
                after: kind.after.index().map(|step| context.schedule.work(step)),
            };
            let Kind { from, to, ownership, .. } = *kind;
            match kind.scope {
                Scope::Memory => barriers.memory.push(MemoryBarrier { from, to, reason }),
                Scope::Resource => {
                    for range in context.versions.cells.ranges(cells) {
                        if context.is_image(resource) {
                            barriers.images.push(ImageBarrier { resource, range, from, to, ownership, reason });
                        } else {
                            barriers.buffers.push(BufferBarrier { resource, range, from, to, ownership, reason });
                        }
                    }
                }
            }
        }
    }
}

impl Context<'_> {
    fn is_image(&self, resource: ResourceId) -> bool {
        matches!(self.description.resources[resource.0 as usize].shape, Shape::Image(_))
    }

    fn resource(&self, pending: &Pending) -> ResourceId {
        self.versions.cells.resource(pending.cell)
    }

    /// Queues that use imported resources first: they wait for what graphics did to them before the frame, and for
    /// their release.
    pub(super) fn takers(&self, pending: &[Pending]) -> Vec<Queue> {
        let cells = 0..self.versions.cells.len() as u32;
        let arrived = cells.filter_map(|cell| match self.history.of(cell) {
            [first, next, ..] if first.first == At::START && !first.access.stages.is_empty() => Some(next.queue),
            _ => None,
        });
        let releases = pending.iter().filter(|barrier| barrier.release && barrier.at == At::START);
        let released = releases.filter_map(|barrier| barrier.kind.after.index());
        let takers = arrived.chain(released.map(|step| self.schedule.queues[step]));
        takers.filter(|queue| *queue != Queue::Graphics).collect()
    }
}

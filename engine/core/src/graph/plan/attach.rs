//! From what is pending to Vulkan's barriers: cells that share one become ranges, and each stands in its place.

use ash::vk::ImageLayout as Layout;

use super::barriers::{AllPending, Context, Kind, Pending, Scope};
use super::history::At;
use super::{Barriers, Batch, BufferBarrier, Hazard, ImageBarrier, MemoryBarrier, Plan, Reason, Work};
use crate::graph::description::{Access, Range, ResourceId};

/// Barriers on their way to their places.
pub(super) struct Attach<'a> {
    context: &'a Context<'a>,
    all: &'a [Pending],
    /// Those that are not in their places yet, in order.
    rest: &'a [u32],
    /// By step: its batch. Nothing where there is but one.
    batch_of: &'a [usize],
    alike: Alike,
}

impl<'a> Attach<'a> {
    pub(super) fn new(context: &'a Context<'a>, pending: &'a AllPending, batch_of: &'a [usize]) -> Self {
        Self { context, all: &pending.list, rest: &pending.order, batch_of, alike: Vec::new() }
    }

    /// Puts those up to a moment in their places: before it, or at the end of the batch of a step that they release
    /// behind.
    pub(super) fn up_to(&mut self, at: At, before: &mut Barriers, batches: &mut [Batch]) {
        while let Some((&first, others)) = self.rest.split_first() {
            let first = &self.all[first as usize];
            if first.at > at {
                return;
            }
            let resource = self.context.resource(first);
            let is_same = |other: &&u32| {
                let other = &self.all[**other as usize];
                (other.at, other.release) == (first.at, first.release) && self.context.resource(other) == resource
            };
            let (same, rest) = self.rest.split_at(1 + others.iter().take_while(is_same).count());
            let barriers = match first.release {
                true => {
                    let batch = first.at.index().and_then(|step| self.batch_of.get(step)).copied();
                    &mut batches[batch.unwrap_or(0)].release
                }
                false => &mut *before,
            };
            together(self.context, self.all, (resource, same), &mut self.alike, barriers);
            self.rest = rest;
        }
    }
}

/// Makes read-backs visible to the host.
pub(super) fn show_host(plan: &mut Plan) {
    let is_read_back = |work: &Work| matches!(work, Work::ReadBack(_));
    if let Some(before) = plan.steps.iter().rev().map(|step| step.work).find(is_read_back) {
        let reason = Reason { hazard: Hazard::Host, resource: None, before: Some(before), after: None };
        let no_layout = |access: Access| Access { layout: Layout::UNDEFINED, ..access };
        let (from, to) = (no_layout(Access::copy_write()), no_layout(Access::host_read()));
        plan.finally.memory.push(MemoryBarrier { from, to, reason });
    }
}

/// Barriers of one resource, each with its cells.
type Alike = Vec<(Kind, Vec<u32>)>;

/// Puts barriers of one resource and place together: cells that share one become ranges. `same`: their numbers among
/// all. `alike`: room for what is alike.
fn together(
    context: &Context,
    all: &[Pending],
    (resource, same): (ResourceId, &[u32]),
    alike: &mut Alike,
    barriers: &mut Barriers,
) {
    let kind = |index: u32| &all[index as usize].kind;
    if context.versions.cells.of(resource).len() == 1 {
        for (place, &index) in same.iter().enumerate() {
            if !same[..place].iter().any(|&known| kind(known) == kind(index)) {
                add(context, resource, kind(index), context.versions.cells.whole(resource), barriers);
            }
        }
        return;
    }
    alike.clear();
    for &index in same {
        let cell = all[index as usize].cell;
        match alike.iter_mut().find(|(known, _)| known == kind(index)) {
            Some((_, cells)) => cells.push(cell),
            None => alike.push((*kind(index), vec![cell])),
        }
    }
    for (kind, cells) in &*alike {
        let ranges = context.versions.cells.ranges(cells);
        // One for all memory does for all parts.
        let count = if kind.scope == Scope::Memory { 1 } else { ranges.len() };
        ranges.into_iter().take(count).for_each(|range| add(context, resource, kind, range, barriers));
    }
}

/// Adds Vulkan's barrier for a range of a resource.
fn add(context: &Context, resource: ResourceId, kind: &Kind, range: Range, barriers: &mut Barriers) {
    let Kind { scope, from, to, ownership, hazard, before, after } = *kind;
    let work = |at: At| at.index().map(|step| context.schedule.work(step));
    let reason = Reason { hazard, resource: Some(resource), before: work(before), after: work(after) };
    match scope {
        Scope::Memory => barriers.memory.push(MemoryBarrier { from, to, reason }),
        Scope::Resource if context.is_image(resource) => {
            let follows = Access::NONE;
            barriers.images.push(ImageBarrier { resource, range, from, follows, to, ownership, reason });
        }
        Scope::Resource => barriers.buffers.push(BufferBarrier { resource, range, from, to, ownership, reason }),
    }
}

//! From what is pending to Vulkan's barriers: cells that share one become ranges, and each stands in its place.

use ash::vk::ImageLayout as Layout;

use super::barriers::{AllPending, Context, Kind, Pending, Scope};
use super::history::At;
use super::{Barriers, BufferBarrier, Hazard, ImageBarrier, MemoryBarrier, Plan, Reason, Work};
use crate::graph::description::{Access, Range, ResourceId};

/// Puts each barrier before its step, at the end of its batch, or at the end of the frame.
pub(super) fn attach(plan: &mut Plan, context: &Context, pending: &AllPending) {
    let mut batch_of = vec![0; if plan.is_single_queue() { 0 } else { plan.steps.len() }];
    for (index, batch) in plan.batches.iter().enumerate().skip(1) {
        batch.steps.iter().for_each(|&step| batch_of[step] = index);
    }
    let mut alike = Vec::new();
    let key = |&index: &u32| (pending.place(index), context.resource(&pending.list[index as usize]));
    for same in pending.order.chunk_by(|a, b| key(a) == key(b)) {
        let ((at, release), resource) = key(&same[0]);
        let barriers = match (release, at.index()) {
            (true, step) => &mut plan.batches[step.and_then(|step| batch_of.get(step)).copied().unwrap_or(0)].release,
            (false, Some(step)) => &mut plan.steps[step].barriers,
            (false, None) => &mut plan.finally,
        };
        together(context, &pending.list, (resource, same), &mut alike, barriers);
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

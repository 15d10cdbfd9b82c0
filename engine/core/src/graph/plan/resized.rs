//! Plans of frames that are described as an earlier one was, but for sizes: validation, culling, order, queues and lifetimes
//! are not found again, and barriers are where memory changes hands as it did before.

use std::sync::Arc;

use super::lists::Lists;
use super::outline::Outline;
use super::place::place;
use super::{Barriers, DeviceModel, Plan, choose, complete, plan_chosen, segment, validate};
use crate::graph::description::{Description, ImageShape, Origin, Range, ResourceId, Shape, Version};
use crate::graph::errors::GraphErrors;

/// A plan, with all that planning it for other sizes goes on from.
pub struct Planned {
    /// The plan.
    pub plan: Arc<Plan>,
    /// None of a frame with checkpoints, whose plan is that of its first segment.
    kept: Option<Arc<Kept>>,
}

/// What a plan's sizes had no part in, and whose memory passed to whom.
pub(super) struct Kept {
    pub(super) outline: Arc<Outline>,
    /// By resource: those whose memory it takes over.
    pub(super) earlier: Lists<ResourceId>,
}

impl Planned {
    /// Plans a frame from nothing, as [`super::plan`] does.
    ///
    /// # Errors
    /// As [`super::plan`].
    pub fn new(description: &Description, device: &dyn DeviceModel) -> Result<Self, GraphErrors> {
        if !description.checkpoints.is_empty() {
            return Ok(Self { plan: Arc::new(segment(description, 0, &[], device)?.plan), kept: None });
        }
        let (plan, kept) = plan_chosen(description, choose(description, device)?, device)?;
        Ok(Self::of(plan, kept))
    }

    fn of(plan: Plan, kept: Kept) -> Self {
        Self { plan: Arc::new(plan), kept: Some(Arc::new(kept)) }
    }

    /// With the fingerprint of the description that it is for.
    pub(in crate::graph) fn with_fingerprint(mut self, fingerprint: u64) -> Self {
        Arc::make_mut(&mut self.plan).fingerprint = fingerprint;
        self
    }

    /// Plans the frame `to`, for the same device. It is `from`, that this plan was made for, but for extents of images and
    /// lengths of whole buffers. The plan is the one that [`Planned::new`] finds. Nothing where more differs, where the sizes
    /// are wrong, or where steps would come in another order: then [`Planned::new`] does.
    pub fn resized(&self, from: &Description, to: &Description, device: &dyn DeviceModel) -> Option<Self> {
        let Kept { outline, earlier } = &**self.kept.as_ref()?;
        // 1. Nothing but sizes differs, and these can be.
        let resized = sizes(outline, from, to)?;
        if !validate::shapes_are_right(to) {
            return None;
        }
        // 2. The memory that resources take, with steps in their order.
        let needs = outline.needs_of(to, device)?;
        let mut placed = place(to, device, &needs, &outline.lifetimes);
        // 3. Barriers: those there are, where memory changes hands as before.
        let mut plan = if placed.earlier == *earlier {
            let mut plan = (*self.plan).clone();
            plan.takes(&mut placed);
            plan
        } else {
            complete(to, outline, &mut placed)
        };
        lengthen(&mut plan, &resized, to);
        Some(Self::of(plan, Kept { outline: outline.clone(), earlier: placed.earlier }))
    }
}

/// The buffers that have another length, ascending, if nothing but sizes differs, and no part of these is told apart.
fn sizes(outline: &Outline, from: &Description, to: &Description) -> Option<Vec<ResourceId>> {
    let same = from.counts() == to.counts()
        && from.name == to.name
        && from.passes == to.passes
        && from.uses == to.uses
        && from.roots == to.roots
        && from.checkpoints == to.checkpoints;
    if !same {
        return None;
    }
    let mut resized = Vec::new();
    for (index, (a, b)) in from.resources.iter().zip(&to.resources).enumerate() {
        let id = ResourceId(index as u32);
        let fits = match (&a.shape, &b.shape) {
            (Shape::Image(a), Shape::Image(b)) => ImageShape { extent: b.extent, ..*a } == *b,
            (Shape::Buffer { size: a }, Shape::Buffer { size: b }) if a == b => true,
            (Shape::Buffer { .. }, Shape::Buffer { .. }) => {
                resized.push(id);
                outline.is_whole(id) && !matches!(b.origin, Origin::Kept { .. })
            }
            _ => false,
        };
        if !fits || a.name != b.name || a.origin != b.origin {
            return None;
        }
    }
    // What covered all of a buffer does so again.
    let covers = |a: &Version, b: &Version| match resized.binary_search(&a.resource) {
        Ok(_) => b.range == to.resources[a.resource.0 as usize].shape.whole(),
        Err(_) => b.range == a.range,
    };
    let alike = |(a, b): (&Version, &Version)| a.resource == b.resource && a.source == b.source && covers(a, b);
    from.versions.iter().zip(&to.versions).all(alike).then_some(resized)
}

/// Gives buffers their length wherever the plan tells it.
fn lengthen(plan: &mut Plan, resized: &[ResourceId], to: &Description) {
    if resized.is_empty() {
        return;
    }
    let set = |resource: ResourceId, range: &mut Range| {
        if resized.binary_search(&resource).is_ok() {
            *range = to.resources[resource.0 as usize].shape.whole();
        }
    };
    let Plan { steps, batches, finally, ends, .. } = plan;
    let steps = steps.iter_mut().map(|step| &mut step.barriers);
    let all = steps.chain(batches.iter_mut().map(|batch| &mut batch.release)).chain([finally]);
    for Barriers { buffers, .. } in all {
        buffers.iter_mut().for_each(|barrier| set(barrier.resource, &mut barrier.range));
    }
    ends.iter_mut().for_each(|end| set(end.resource, &mut end.state.range));
}

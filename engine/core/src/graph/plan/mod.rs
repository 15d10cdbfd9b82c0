//! Planning: from a description to a plan. Pure functions over plain data.

mod apart;
mod attach;
mod barriers;
mod cells;
mod cull;
mod dependencies;
mod device;
mod done;
mod gather;
mod history;
mod lifetimes;
mod lists;
mod memo;
mod order;
mod outline;
mod output;
mod pack;
mod place;
mod queues;
mod reason;
mod redundant;
mod resized;
mod segments;
mod stages;
mod usage;
mod validate;
mod versions;

pub use apart::{Apart, apart};
pub use device::{DeviceModel, Requirements, Usage};
pub use lifetimes::lifetimes;
pub use output::{
    Barriers, Batch, BufferBarrier, End, Heap, ImageBarrier, ImageBarriers, Lifetime, MemoryBarrier, Ownership,
    Placement, Plan, Statistics, Step, Wait, Work,
};
pub use reason::{CullReason, Hazard, Reason};
pub use resized::Planned;
pub use segments::{Segment, segment};
pub(super) use segments::{first_segment, states};
pub(super) use versions::held_at_the_end;

use std::hash::{Hash, Hasher};
use std::sync::Arc;

use self::attach::Attach;
use self::barriers::Context;
use self::dependencies::{Dependencies, Events};
use self::history::At;
use self::memo::Memo;
use self::outline::Outline;
use self::place::{Placed, place};
use self::redundant::Redundant;
use self::resized::Kept;
use self::versions::Versions;
use super::description::{Description, Origin, PassId, Shape};
use super::errors::{ErrorKind, GraphError, GraphErrors};

/// Plans a frame for a device; of a frame with checkpoints, what comes before the first one ([`segment`]).
///
/// # Errors
/// All that is wrong with the description, at once.
pub fn plan(description: &Description, device: &dyn DeviceModel) -> Result<Plan, GraphErrors> {
    if !description.checkpoints.is_empty() {
        return Ok(segment(description, 0, &[], device)?.plan);
    }
    let chosen = choose(description, device)?;
    Ok(plan_chosen(description, chosen, device)?.0)
}

/// What runs of a description that is right.
struct Chosen {
    versions: Versions,
    /// By pass.
    live: Vec<bool>,
    culled: Vec<(PassId, CullReason)>,
    /// What happens to each cell.
    events: Events,
    /// Who waits for whom.
    dependencies: Dependencies,
}

fn choose(description: &Description, device: &dyn DeviceModel) -> Result<Chosen, GraphErrors> {
    // 1. Find everything that is wrong.
    let (versions, mut events, mut dependencies) = validate::validate(description, device)?;

    // 2. Leave out what no root and no side effect needs.
    let (live, culled) = cull::cull(description, &versions);
    cull::check_kept(description, &versions, &live)?;
    if !culled.is_empty() {
        events.retain(|node| live.get(node as usize).is_none_or(|live| *live));
        dependencies = Dependencies::new(&events, description.passes.len() + description.roots.len());
    }
    Ok(Chosen { versions, live, culled, events, dependencies })
}

/// The plan, and what planning it for other sizes goes on from.
fn plan_chosen(
    description: &Description,
    chosen: Chosen,
    device: &dyn DeviceModel,
) -> Result<(Plan, Kept), GraphErrors> {
    // 3. Order, queues, and when each resource is alive.
    let (outline, needs) = Outline::new(description, chosen, device)?;

    // 4. Give transients their memory.
    let mut placed = place(description, device, &needs, &outline.lifetimes);

    // 5. Barriers.
    let plan = complete(description, &outline, &mut placed);
    Ok((plan, Kept { outline: Arc::new(outline), earlier: placed.earlier }))
}

/// Puts barriers between, and steps together. The plan takes the placements.
fn complete(description: &Description, outline: &Outline, placed: &mut Placed) -> Plan {
    let Outline { versions, history, schedule, crossings, lifetimes, .. } = outline;
    let context = Context { description, versions, history, schedule, lifetimes, families: outline.families };
    // 1. What has to stand between uses, moved together.
    let (mut pending, reliances) = barriers::pending(&context, placed);
    let takers = context.takers(&pending.list);
    gather::gather(&mut pending, schedule, crossings, &takers);

    // 2. Submissions, and which stages their semaphores hold up.
    let mut batches = queues::batches(schedule, crossings.clone(), &takers);
    let (held, trips) = queues::narrow(&mut batches, schedule, &reliances);
    let chained = barriers::chain(&context, &mut pending.list, &held);
    let batch_of = queues::batch_of(&batches, schedule);

    // 3. Step by step: its barriers, less those that follow from others.
    let steps = (0..schedule.nodes.len())
        .map(|step| Step { work: schedule.work(step), queue: schedule.queues[step], barriers: Barriers::default() })
        .collect();

    let mut plan = Plan {
        steps,
        batches,
        finally: Barriers::default(),
        culled: outline.culled.clone(),
        placements: Vec::new(),
        heaps: Vec::new(),
        usages: outline.usages.clone(),
        ends: history::ends(description, versions, history),
        statistics: Statistics::default(),
        fingerprint: 0,
    };
    let mut attach = Attach::new(&context, &pending, &batch_of);
    let mut redundant = Redundant::new(schedule, &batch_of, &trips, &chained);
    for (step, Step { barriers, .. }) in plan.steps.iter_mut().enumerate() {
        attach.up_to(At::step(step), barriers, &mut plan.batches);
        redundant.step(step, barriers);
        plan.statistics.count(barriers);
    }
    attach.up_to(At::END, &mut plan.finally, &mut plan.batches);
    attach::show_host(&mut plan);
    redundant.end(&mut plan.finally);
    plan.statistics.count(&plan.finally);
    plan.batches.iter().for_each(|batch| plan.statistics.count(&batch.release));
    plan.takes(placed);
    plan
}

/// A transient takes at most so many bytes: no device has as many, and sums of them do not overflow.
const MOST_BYTES: u64 = 1 << 40;

/// Memory of every transient that is used.
///
/// # Errors
/// One for each that takes more than any device has.
fn requirements(
    description: &Description,
    device: &dyn DeviceModel,
    usages: &[Option<Usage>],
) -> Result<Vec<Option<Requirements>>, GraphErrors> {
    let mut errors = Vec::new();
    let mut all = Vec::with_capacity(usages.len());
    // A device is asked once for resources that are alike.
    let mut known: Memo<Alike, Requirements> = Memo::new();
    for (resource, usage) in description.resources.iter().zip(usages) {
        let usage = usage.filter(|_| resource.origin == Origin::Transient);
        let shape = &resource.shape;
        let needs = usage.map(|usage| {
            let ask = || (device.requirements(shape, usage), true);
            known.get(Alike { shape, usage }, ask)
        });
        if let Some(Requirements { size, alignment, .. }) = needs
            && size.max(alignment) > MOST_BYTES
        {
            errors.push(GraphError {
                kind: ErrorKind::BadShape,
                pass: None,
                slot: None,
                resource: Some(resource.name.to_string()),
                wrong: format!("takes {size} bytes, aligned to {alignment}"),
                allowed: format!("at most {MOST_BYTES} are allowed"),
            });
        }
        all.push(needs);
    }
    if errors.is_empty() { Ok(all) } else { Err(GraphErrors { graph: description.name.clone(), errors }) }
}

/// What the memory that a resource takes follows from.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Alike<'a> {
    shape: &'a Shape,
    usage: Usage,
}

impl Hash for Alike<'_> {
    /// Sizes alone tell most resources apart.
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u64(match self.shape {
            Shape::Image(shape) => u64::from(shape.extent[0]) << 32 | u64::from(shape.format.as_raw() as u32),
            Shape::Buffer { size } => *size,
        });
    }
}

impl Plan {
    /// Takes its memory from what was placed.
    fn takes(&mut self, placed: &mut Placed) {
        self.placements = std::mem::take(&mut placed.placements);
        self.heaps = std::mem::take(&mut placed.heaps);
        self.statistics.heap_bytes = self.heaps.iter().map(|heap| heap.size).sum();
        self.statistics.lower_bound_bytes = placed.lower_bound;
        self.statistics.unaliased_bytes = placed.unaliased;
    }
}

impl Statistics {
    fn count(&mut self, barriers: &Barriers) {
        self.barrier_calls += usize::from(!barriers.is_empty());
        self.image_barriers += barriers.images.len();
        self.buffer_barriers += barriers.buffers.len();
        self.memory_barriers += barriers.memory.len();
    }
}

//! A plan with all of its names, to be serialised.

use serde::Serialize;

use super::path::{DependencyReport, critical_path, dependencies};
use super::resource::{ResourceReport, resources};
use crate::graph::PassTime;
use crate::graph::description::{Access, Description, Range, Resource, ResourceId, Shape, Use};
use crate::graph::plan::{Barriers, Batch, Ownership, Plan, Reason, Segment, Statistics, Wait, Work, apart};

/// Name of the form of [`Report`], with its version.
pub const SCHEMA: &str = "shadowgraph.graph/1.3";

/// A description and its plan.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// Name of the graph.
    pub graph: String,
    /// Passes and read-backs that run, in order.
    pub steps: Vec<StepReport>,
    /// Submissions, in order.
    pub batches: Vec<BatchReport>,
    /// The longest chain of steps that wait for one another's results, by index into `steps`.
    pub critical_path: Vec<usize>,
    /// Barriers after the last step.
    pub finally: Vec<BarrierReport>,
    /// Passes that do not run.
    pub culled: Vec<CulledReport>,
    /// Resources that a step uses.
    pub resources: Vec<ResourceReport>,
    /// Memory of transients.
    pub memory: MemoryReport,
    /// Figures.
    pub statistics: Statistics,
    /// Of a segment that follows another one: the checkpoint before it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
    /// Segments after the frame's first checkpoint, where it ran: their sizes follow from what the host read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub later: Vec<Report>,
}

/// A pass or a read-back.
#[derive(Clone, Debug, Serialize)]
pub struct StepReport {
    /// Name of the pass, or of the root.
    pub name: String,
    /// `pass` or `read-back`.
    pub kind: &'static str,
    /// Queue it runs on.
    pub queue: String,
    /// Index of its submission.
    pub batch: usize,
    /// Barriers before it.
    pub barriers: Vec<BarrierReport>,
    /// What it reads.
    pub reads: Vec<UseReport>,
    /// What it writes.
    pub writes: Vec<UseReport>,
    /// Earlier steps whose results it uses.
    pub depends: Vec<DependencyReport>,
    /// Why it runs although nobody reads what it writes.
    pub side_effect: Option<String>,
    /// Time on the device, where the frame ran and the device tells.
    pub milliseconds: Option<f64>,
}

/// A submission.
#[derive(Clone, Debug, Serialize)]
pub struct BatchReport {
    /// Queue it is submitted to.
    pub queue: String,
    /// Value that its queue's timeline semaphore is set to when it is done.
    pub signal: u64,
    /// What it waits for.
    pub waits: Vec<WaitReport>,
    /// Barriers after its steps: resources given to other queues' families.
    pub release: Vec<BarrierReport>,
}

/// A wait for another queue's timeline semaphore.
#[derive(Clone, Debug, Serialize)]
pub struct WaitReport {
    /// The other queue.
    pub queue: String,
    /// Value waited for.
    pub value: u64,
    /// Pipeline stages that wait.
    pub stages: String,
}

/// A use of a resource.
#[derive(Clone, Debug, Serialize)]
pub struct UseReport {
    /// What the pass calls it.
    pub slot: String,
    /// Name of the resource.
    pub resource: String,
    /// Which part of it, in words; empty where it is all.
    pub part: String,
    /// Version that is read, or written over.
    pub version: u32,
    /// Version that is made.
    pub makes: Option<u32>,
    /// Pipeline stages.
    pub stages: String,
    /// Memory accesses.
    pub access: String,
    /// Image layout.
    pub layout: Option<String>,
}

/// A barrier.
#[derive(Clone, Debug, Serialize)]
pub struct BarrierReport {
    /// `image`, `buffer` or `memory`.
    pub kind: &'static str,
    /// Name of the resource.
    pub resource: Option<String>,
    /// Which part of it, in words; empty where it is all.
    pub part: String,
    /// First stages and accesses.
    pub from: [String; 2],
    /// Second stages and accesses.
    pub to: [String; 2],
    /// Layouts before and after, of an image.
    pub layouts: Option<[String; 2]>,
    /// Queue families that it is handed over from and to.
    pub families: Option<[u32; 2]>,
    /// Why it stands.
    pub reason: String,
}

/// A pass that does not run.
#[derive(Clone, Debug, Serialize)]
pub struct CulledReport {
    /// Name of the pass.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// Memory of transients.
#[derive(Clone, Debug, Serialize)]
pub struct MemoryReport {
    /// Heaps.
    pub heaps: Vec<HeapReport>,
    /// Bytes of all heaps.
    pub bytes: u64,
    /// Bytes if no two transients shared memory.
    pub unaliased_bytes: u64,
    /// Bytes that sharing saves.
    pub saved_bytes: u64,
    /// The most bytes alive at once in this order.
    pub lower_bound_bytes: u64,
    /// Heaps over lower bound; 1 is perfect.
    pub over_lower_bound: f64,
    /// Share of the bytes without sharing that sharing saves.
    pub saved_share: f64,
    /// Why resources do not share memory, two by two, of the largest of each heap.
    pub apart: Vec<ApartReport>,
}

/// Why two resources do not share memory.
#[derive(Clone, Debug, Serialize)]
pub struct ApartReport {
    /// Names of both.
    pub resources: [String; 2],
    /// Why.
    pub reason: String,
}

/// Of how many resources all pairs are explained, the largest first.
const EXPLAINED: usize = 24;

/// A heap and who lies in it.
#[derive(Clone, Debug, Serialize)]
pub struct HeapReport {
    /// Bytes.
    pub bytes: u64,
    /// Memory types that will do.
    pub type_bits: u32,
    /// By offset, then by time.
    pub placements: Vec<PlacementReport>,
}

/// Where a transient lies.
#[derive(Clone, Debug, Serialize)]
pub struct PlacementReport {
    /// Name of the resource.
    pub resource: String,
    /// Bytes from the heap's start.
    pub offset: u64,
    /// Bytes.
    pub bytes: u64,
    /// First and last step that use it.
    pub steps: [usize; 2],
}

impl Report {
    /// Of a description and its plan.
    pub fn new(description: &Description, plan: &Plan) -> Self {
        let mut batch_of = vec![0; plan.steps.len()];
        for (index, batch) in plan.batches.iter().enumerate() {
            batch.steps.iter().for_each(|&step| batch_of[step] = index);
        }
        let steps = plan.steps.iter().zip(batch_of).zip(dependencies(description, plan));
        let step = |((step, batch), depends): ((&crate::graph::plan::Step, usize), _)| StepReport {
            depends,
            queue: format!("{:?}", step.queue),
            batch,
            barriers: barriers(description, &step.barriers),
            ..self::step(description, step.work)
        };
        let culled = plan.culled.iter().map(|(pass, reason)| CulledReport {
            name: description.passes[pass.0 as usize].name.to_string(),
            reason: reason.explain(description),
        });
        Self {
            schema: SCHEMA,
            graph: description.name.clone(),
            steps: steps.map(step).collect(),
            batches: plan.batches.iter().map(|batch| batch_report(description, batch)).collect(),
            critical_path: critical_path(description, plan, |_| 1.0),
            finally: barriers(description, &plan.finally),
            culled: culled.collect(),
            resources: resources(description, plan),
            memory: memory(description, plan),
            statistics: plan.statistics,
            after: None,
            later: Vec::new(),
        }
    }

    /// Adds the segments after the first checkpoint of a frame that ran ([`Executed::later`](crate::graph::Executed::later)).
    /// `whole`: the frame's description.
    pub fn add_segments(&mut self, whole: &Description, later: &[Segment]) {
        let segments = later.iter().zip(&whole.checkpoints).map(|(segment, checkpoint)| {
            let after = Some(checkpoint.name.to_string());
            Self { after, ..Self::new(&segment.description, &segment.plan) }
        });
        self.later.extend(segments);
    }

    /// Adds what passes took when the plan ran ([`Executed::passes`](crate::graph::Executed::passes)), by name.
    pub fn add_times(&mut self, times: &[PassTime]) {
        for step in self.steps.iter_mut().filter(|step| step.kind == "pass") {
            let time = times.iter().find(|time| time.name == step.name);
            step.milliseconds = time.map(|time| time.seconds * 1e3).or(step.milliseconds);
        }
        self.later.iter_mut().for_each(|segment| segment.add_times(times));
    }

    /// As JSON.
    ///
    /// # Errors
    /// What the serialiser says; a report of finite times has no reason to fail.
    pub fn json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

fn batch_report(description: &Description, batch: &Batch) -> BatchReport {
    let wait = |wait: &Wait| WaitReport {
        queue: format!("{:?}", wait.queue),
        value: wait.value,
        stages: format!("{:?}", wait.stages),
    };
    BatchReport {
        queue: format!("{:?}", batch.queue),
        signal: batch.signal,
        waits: batch.waits.iter().map(wait).collect(),
        release: barriers(description, &batch.release),
    }
}

fn step(description: &Description, work: Work) -> StepReport {
    let empty = StepReport {
        name: String::new(),
        kind: "pass",
        queue: String::new(),
        batch: 0,
        barriers: Vec::new(),
        reads: Vec::new(),
        writes: Vec::new(),
        depends: Vec::new(),
        side_effect: None,
        milliseconds: None,
    };
    match work {
        Work::Pass(pass) => {
            let pass = &description.passes[pass.0 as usize];
            let uses = |writes: bool| {
                let uses = pass.uses.iter().filter(move |used| used.makes.is_some() == writes);
                uses.map(|used| used_report(description, used)).collect()
            };
            let side_effect = pass.side_effect.clone();
            StepReport { name: pass.name.to_string(), reads: uses(false), writes: uses(true), side_effect, ..empty }
        }
        Work::ReadBack(root) => {
            let root = &description.roots[root];
            let (version, access) = (root.version, Access::copy_read());
            let used = Use { slot: "source".into(), version, makes: None, reads: true, access };
            let reads = vec![used_report(description, &used)];
            StepReport { name: root.name.clone(), kind: "read-back", reads, ..empty }
        }
    }
}

fn used_report(description: &Description, used: &Use) -> UseReport {
    let version = &description.versions[used.version.0 as usize];
    let resource = &description.resources[version.resource.0 as usize];
    UseReport {
        slot: used.slot.to_string(),
        resource: resource.name.to_string(),
        part: part(&resource.shape, &version.range),
        version: used.version.0,
        makes: used.makes.map(|made| made.0),
        stages: format!("{:?}", used.access.stages),
        access: format!("{:?}", used.access.mask),
        layout: matches!(resource.shape, Shape::Image(_)).then(|| format!("{:?}", used.access.layout)),
    }
}

fn barriers(description: &Description, barriers: &Barriers) -> Vec<BarrierReport> {
    let scope = |access: &Access| [format!("{:?}", access.stages), format!("{:?}", access.mask)];
    let report = |kind, place: Option<(ResourceId, &Range)>, from: &Access, to: &Access, reason: &Reason| {
        let place = place.map(|(id, range)| (&description.resources[id.0 as usize], range));
        BarrierReport {
            kind,
            resource: place.map(|(resource, _): (&Resource, _)| resource.name.to_string()),
            part: place.map_or_else(String::new, |(resource, range)| part(&resource.shape, range)),
            from: scope(from),
            to: scope(to),
            layouts: None,
            families: None,
            reason: reason.explain(description),
        }
    };
    let families = |ownership: Option<Ownership>| ownership.map(|ownership| [ownership.from, ownership.to]);
    let memory = barriers.memory.iter().map(|b| report("memory", None, &b.from, &b.to, &b.reason));
    let buffers = barriers.buffers.iter().map(|b| {
        let place = Some((b.resource, &b.range));
        BarrierReport { families: families(b.ownership), ..report("buffer", place, &b.from, &b.to, &b.reason) }
    });
    let images = barriers.images.iter().map(|b| {
        let place = Some((b.resource, &b.range));
        let layouts = Some([b.from, b.to].map(|access| format!("{:?}", access.layout)));
        let families = families(b.ownership);
        BarrierReport { families, layouts, ..report("image", place, &b.from, &b.to, &b.reason) }
    });
    memory.chain(buffers).chain(images).collect()
}

fn memory(description: &Description, plan: &Plan) -> MemoryReport {
    let heap = |(index, heap): (usize, &crate::graph::plan::Heap)| {
        let mut placed: Vec<_> = plan.placements.iter().filter(|placement| placement.heap == index).collect();
        placed.sort_unstable_by_key(|placement| (placement.offset, placement.steps));
        let placements = placed.into_iter().map(|placement| PlacementReport {
            resource: description.resources[placement.resource.0 as usize].name.to_string(),
            offset: placement.offset,
            bytes: placement.size,
            steps: placement.steps,
        });
        HeapReport { bytes: heap.size, type_bits: heap.type_bits, placements: placements.collect() }
    };
    let Statistics { heap_bytes, unaliased_bytes, lower_bound_bytes, .. } = plan.statistics;
    MemoryReport {
        heaps: plan.heaps.iter().enumerate().map(heap).collect(),
        bytes: heap_bytes,
        unaliased_bytes,
        saved_bytes: unaliased_bytes.saturating_sub(heap_bytes),
        lower_bound_bytes,
        saved_share: unaliased_bytes.saturating_sub(heap_bytes) as f64 / unaliased_bytes.max(1) as f64,
        apart: why_apart(description, plan),
        over_lower_bound: if lower_bound_bytes == 0 { 1.0 } else { heap_bytes as f64 / lower_bound_bytes as f64 },
    }
}

/// Why the largest transients do not share memory, two by two.
fn why_apart(description: &Description, plan: &Plan) -> Vec<ApartReport> {
    let mut largest: Vec<_> = plan.placements.iter().collect();
    largest.sort_unstable_by_key(|placement| (u64::MAX - placement.size, placement.resource));
    largest.truncate(EXPLAINED);
    let name = |id: ResourceId| description.resources[id.0 as usize].name.to_string();
    let mut pairs = Vec::new();
    for (index, a) in largest.iter().enumerate() {
        for b in &largest[index + 1..] {
            if let Some(reason) = apart(description, plan, a.resource, b.resource) {
                let resources = [a, b].map(|placement| name(placement.resource));
                pairs.push(ApartReport { resources, reason: reason.explain(description) });
            }
        }
    }
    pairs
}

/// A range in words; empty where it is all.
pub(super) fn part(shape: &Shape, range: &Range) -> String {
    let span = |what: &str, part: &[u32; 2], all: [u32; 2]| {
        let [first, end] = part;
        (*part != all).then(|| format!("{what} {first}..{end}"))
    };
    match (shape.whole(), range) {
        (whole, range) if whole == *range => String::new(),
        (Range::Image { aspects: all, mips: ms, layers: ls }, Range::Image { aspects, mips, layers }) => {
            let aspects = (*aspects != all).then(|| format!("{aspects:?}"));
            let parts = [aspects, span("mips", mips, ms), span("layers", layers, ls)];
            parts.into_iter().flatten().collect::<Vec<_>>().join(" ")
        }
        (_, Range::Buffer([first, end])) => format!("bytes {first}..{end}"),
        _ => String::new(),
    }
}

//! From a description and its plan to the data of a report.

use super::data::{
    ApartReport, BarrierReport, BatchReport, CulledReport, HeapReport, MemoryReport, PlacementReport, Report, SCHEMA,
    StepReport, UseReport, WaitReport,
};
use super::path::{critical_path, dependencies};
use super::resource::resources;
use crate::graph::PassTime;
use crate::graph::description::{Access, Description, Range, Resource, ResourceId, Shape, Use};
use crate::graph::plan::{Barriers, Batch, Ownership, Plan, Reason, Segment, Statistics, Wait, Work, apart};

/// Of how many resources all pairs are explained, the largest first.
const EXPLAINED: usize = 24;

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
                let uses = description.uses_of(pass).iter().filter(move |used| used.makes.is_some() == writes);
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

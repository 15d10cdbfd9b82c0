//! Which steps wait for whose results, and the critical path: the longest chain of them.

use serde::Serialize;

use super::build::part;
use crate::graph::description::{Description, PassId, Source, VersionId};
use crate::graph::plan::{Plan, Work};

/// Steps of the longest chain, in order. `cost`: of each step, such as its time on the device; 1 counts steps.
pub fn critical_path(description: &Description, plan: &Plan, cost: impl Fn(usize) -> f64) -> Vec<usize> {
    let mut step_of = vec![usize::MAX; description.passes.len()];
    // By step: cost of the longest chain that ends with it, and the step before it.
    let mut chains: Vec<(f64, Option<usize>)> = Vec::with_capacity(plan.steps.len());
    for (index, step) in plan.steps.iter().enumerate() {
        let versions = step.work.uses(description).map(|(version, _)| version);
        let makers = versions.flat_map(|version| makers(description, version));
        let steps = makers.map(|pass| step_of[pass.0 as usize]).filter(|&step| step < index);
        let before = steps.max_by(|&a, &b| chains[a].0.total_cmp(&chains[b].0).then(b.cmp(&a)));
        chains.push((before.map_or(0.0, |step| chains[step].0) + cost(index), before));
        if let Work::Pass(pass) = step.work {
            step_of[pass.0 as usize] = index;
        }
    }
    let last = (0..chains.len()).max_by(|&a, &b| chains[a].0.total_cmp(&chains[b].0).then(b.cmp(&a)));
    let mut path: Vec<usize> = std::iter::successors(last, |&step| chains[step].1).collect();
    path.reverse();
    path
}

/// An earlier step whose result a step uses.
#[derive(Clone, Debug, Serialize)]
pub struct DependencyReport {
    /// The earlier one, by index into the report's steps.
    pub step: usize,
    /// Name of the resource.
    pub resource: String,
    /// Which part of it, in words; empty where it is all.
    pub part: String,
    /// Whether it is written over without being read.
    pub overwrites: bool,
}

/// By step of the plan, the steps whose results it uses.
pub(super) fn dependencies(description: &Description, plan: &Plan) -> Vec<Vec<DependencyReport>> {
    let mut step_of = vec![None; description.passes.len()];
    for (index, step) in plan.steps.iter().enumerate() {
        if let Work::Pass(pass) = step.work {
            step_of[pass.0 as usize] = Some(index);
        }
    }
    let of = |step: &crate::graph::plan::Step| {
        let mut found = Vec::new();
        for (id, overwrites) in step.work.uses(description) {
            let version = &description.versions[id.0 as usize];
            let resource = &description.resources[version.resource.0 as usize];
            let part = part(&resource.shape, &version.range);
            // Makers in an earlier segment of the frame are not steps of this plan.
            for step in makers(description, id).iter().filter_map(|pass| step_of[pass.0 as usize]) {
                let (resource, part) = (resource.name.to_string(), part.clone());
                found.push(DependencyReport { step, resource, part, overwrites });
            }
        }
        found
    };
    plan.steps.iter().map(of).collect()
}

/// Passes that wrote a version or its parts last.
pub(super) fn makers(description: &Description, version: VersionId) -> Vec<PassId> {
    let mut makers = Vec::new();
    let mut waiting = vec![version];
    while let Some(version) = waiting.pop() {
        match &description.versions[version.0 as usize].source {
            Source::Initial => {}
            Source::Pass { pass, .. } => makers.push(*pass),
            Source::Split { of } | Source::Fork { of } => waiting.push(*of),
            Source::Join { of } => waiting.extend(of),
        }
    }
    makers.sort_unstable();
    makers.dedup();
    makers
}

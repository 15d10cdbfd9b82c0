//! The critical path: the longest chain of steps that wait for one another's results.

use crate::graph::description::{Description, PassId, Source, VersionId};
use crate::graph::plan::{Plan, Work};

/// Steps of the longest chain, in order. `cost`: of each step, such as its time on the device; 1 counts steps.
pub fn critical_path(description: &Description, plan: &Plan, cost: impl Fn(usize) -> f64) -> Vec<usize> {
    let mut step_of = vec![usize::MAX; description.passes.len()];
    // By step: cost of the longest chain that ends with it, and the step before it.
    let mut chains: Vec<(f64, Option<usize>)> = Vec::with_capacity(plan.steps.len());
    for (index, step) in plan.steps.iter().enumerate() {
        let versions = used(description, step.work).into_iter().map(|(version, _)| version);
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

/// Versions that a step uses, and whether it only writes over them.
pub(super) fn used(description: &Description, work: Work) -> Vec<(VersionId, bool)> {
    match work {
        Work::Pass(pass) => {
            let uses = &description.passes[pass.0 as usize].uses;
            uses.iter().map(|used| (used.version, used.makes.is_some() && !used.reads)).collect()
        }
        Work::ReadBack(root) => vec![(description.roots[root].version, false)],
    }
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

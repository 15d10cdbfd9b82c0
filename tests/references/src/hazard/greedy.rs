//! A planner of barriers as one writes it first: right before each step, one call with a barrier for each part that
//! needs one. What a good planner is measured against.

use ash::vk::{AccessFlags2 as Mask, ImageLayout as Layout, PipelineStageFlags2 as Stages};
use shadowgraph::graph::description::{Access, Description, Origin, Shape, VersionId};
use shadowgraph::graph::plan::{DeviceModel, Plan, Work};

use super::atoms::Atoms;
use super::contents::forked_from;
use super::memory::sharers;

/// What a part of a resource has seen.
#[derive(Clone, Default)]
struct State {
    layout: Layout,
    used: bool,
    written: bool,
    /// What the last write is visible to.
    visible: Vec<(Stages, Mask)>,
    /// What unordered writers started from.
    fork: Option<VersionId>,
}

/// Calls of `vkCmdPipelineBarrier2` that it takes for the steps of a plan for one queue, in their order and with their
/// memory.
pub fn greedy_calls(description: &Description, plan: &Plan, device: &dyn DeviceModel) -> usize {
    let atoms = Atoms::new(description, &[plan]);
    let sharers = sharers(description, plan, device.granularity());
    let mut states: Vec<State> = (0..atoms.len()).map(|atom| arrival(description, &atoms, atom)).collect();
    let mut calls = 0;
    for step in &plan.steps {
        let uses: Vec<(VersionId, Option<VersionId>, Access)> = match step.work {
            Work::Pass(pass) => {
                let uses = description.uses_of(&description.passes[pass.0 as usize]);
                uses.iter().map(|used| (used.version, used.makes, used.access)).collect()
            }
            Work::ReadBack(root) => vec![(description.roots[root].version, None, Access::copy_read())],
        };
        let mut call = false;
        for (version, makes, access) in uses {
            let known = &description.versions[version.0 as usize];
            let taken = sharers[known.resource.0 as usize].iter().flat_map(|&other| atoms.all(other));
            let taken = taken.filter(|&atom| states[atom].used).count() > 0;
            let is_image = matches!(description.resources[known.resource.0 as usize].shape, Shape::Image(_));
            let fork = makes.and_then(|made| forked_from(description, made));
            for atom in atoms.of(known.resource, &known.range) {
                call |= states[atom].take(is_image, taken, &access, makes.is_some(), fork);
            }
        }
        calls += usize::from(call);
    }
    calls + usize::from(ends_with_barriers(description, plan, &atoms, &mut states))
}

fn arrival(description: &Description, atoms: &Atoms, atom: usize) -> State {
    match &description.resources[atoms.resource(atom).0 as usize].origin {
        Origin::Transient => State::default(),
        // Random graphs keep nothing from frame to frame where calls are counted.
        Origin::Kept { .. } => State::default(),
        Origin::Imported { before, .. } => State {
            layout: before.layout,
            used: !before.stages.is_empty(),
            written: !before.stages.is_empty(),
            visible: if before.writes().is_empty() { vec![(before.stages, before.mask)] } else { Vec::new() },
            fork: None,
        },
    }
}

fn ends_with_barriers(description: &Description, plan: &Plan, atoms: &Atoms, states: &mut [State]) -> bool {
    let mut needed = plan.steps.iter().any(|step| matches!(step.work, Work::ReadBack(_)));
    for (atom, state) in states.iter_mut().enumerate() {
        let resource = &description.resources[atoms.resource(atom).0 as usize];
        if let Origin::Imported { after: Some(after), .. } = resource.origin {
            let is_image = matches!(resource.shape, Shape::Image(_));
            needed |= state.take(is_image, false, &after, !after.writes().is_empty(), None);
        }
    }
    needed
}

impl State {
    /// Whether it takes a barrier before an access.
    fn take(&mut self, is_image: bool, taken: bool, access: &Access, write: bool, fork: Option<VersionId>) -> bool {
        let transition = is_image && self.layout != access.layout;
        let tenant = taken && !self.used;
        let sees = |seen: &(Stages, Mask)| seen.0.contains(access.stages) && seen.1.contains(access.mask);
        let unordered = fork.is_some() && self.fork == fork;
        let needed = match write {
            true => self.used && !unordered,
            false => self.written && !self.visible.iter().any(sees),
        };
        if transition || tenant || needed || write {
            self.visible.clear();
        }
        self.layout = access.layout;
        self.used = true;
        self.written |= write || transition;
        self.fork = if write { fork } else { None };
        if !write {
            self.visible.push((access.stages, access.mask));
        }
        transition || tenant || needed
    }
}

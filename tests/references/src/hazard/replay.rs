//! Replays a plan, access by access.

use ash::vk::{AccessFlags2 as Mask, ImageLayout as Layout, PipelineStageFlags2 as Stages};
use shadowgraph::graph::description::{Access, Description, Queue, Range, ResourceId, Use, Version, VersionId};
use shadowgraph::graph::plan::{Barriers, DeviceModel, Plan, Work};

use super::atoms::Atoms;
use super::contents::{Contents, contents, forked_from};
use super::memory;
use super::part::{Part, arrival};
use super::record::{Kind, Record, Scopes, each, single};
use super::rules::{Effect, apply, conflict, foreign_conflict, kind};

pub(super) struct Replay<'a> {
    pub(super) description: &'a Description,
    pub(super) plan: &'a Plan,
    pub(super) device: &'a dyn DeviceModel,
    pub(super) atoms: Atoms,
    pub(super) parts: Vec<Part>,
    sharers: Vec<Vec<ResourceId>>,
    /// By root: the copy's record in host memory.
    pub(super) copies: Vec<Option<Record>>,
    /// How many writes there were.
    writes: usize,
    pub(super) errors: Vec<String>,
}

/// Everything that is wrong with a plan for a description that is right.
pub fn check(description: &Description, plan: &Plan, device: &dyn DeviceModel) -> Vec<String> {
    let mut replay = Replay::new(description, plan, device);
    replay.run();
    replay.errors
}

impl<'a> Replay<'a> {
    pub(super) fn new(description: &'a Description, plan: &'a Plan, device: &'a dyn DeviceModel) -> Self {
        let mut replay = Self::over(description, &[plan], device);
        memory::placements(description, plan, device, &mut replay.errors);
        replay.begin(plan);
        replay
    }

    /// Over several plans in a row; [`Replay::begin`] takes each.
    pub(super) fn over(description: &'a Description, plans: &[&'a Plan], device: &'a dyn DeviceModel) -> Self {
        let atoms = Atoms::new(description, plans);
        Self {
            sharers: Vec::new(),
            parts: (0..atoms.len()).map(|atom| arrival(description, &atoms, device, atom)).collect(),
            copies: vec![None; description.roots.len()],
            writes: 0,
            description,
            plan: plans[0],
            device,
            atoms,
            errors: Vec::new(),
        }
    }

    /// Takes a plan up, behind what was replayed so far.
    pub(super) fn begin(&mut self, plan: &'a Plan) {
        self.plan = plan;
        self.sharers = memory::sharers(self.description, plan, self.device.granularity());
        for record in self.parts.iter_mut().flat_map(|part| &mut part.records) {
            *record = record.of_the_frame_before();
        }
    }

    pub(super) fn run(&mut self) {
        self.completeness(&[self.plan]);
        self.batches();
        self.settle();
        self.end();
    }

    fn name(&self, resource: ResourceId) -> &str {
        &self.description.resources[resource.0 as usize].name
    }

    fn family(&self, queue: Queue) -> Option<u32> {
        self.device.family(queue).or(self.device.family(Queue::Graphics))
    }

    /// Every pass runs once or is culled, every read-back runs once, every step is in one batch, in order.
    pub(super) fn completeness(&mut self, plans: &[&Plan]) {
        let culled = |pass| plans.iter().flat_map(|plan| &plan.culled).any(|(culled, _)| *culled == pass);
        let mut expected: Vec<Work> = (0..self.description.passes.len() as u32)
            .map(shadowgraph::graph::description::PassId)
            .filter(|pass| !culled(*pass))
            .map(Work::Pass)
            .collect();
        let roots = self.description.roots.iter().enumerate();
        expected.extend(roots.filter(|(_, root)| root.read_back).map(|(index, _)| Work::ReadBack(index)));
        let mut found: Vec<Work> = plans.iter().flat_map(|plan| &plan.steps).map(|step| step.work).collect();
        found.sort_unstable();
        if found != expected {
            self.errors.push(format!("steps are {found:?}, expected {expected:?}"));
        }
        for plan in plans {
            let mut steps: Vec<usize> = plan.batches.iter().flat_map(|batch| batch.steps.clone()).collect();
            steps.sort_unstable();
            if steps != (0..plan.steps.len()).collect::<Vec<_>>() {
                self.errors.push(format!("batches hold steps {steps:?}"));
            }
            if plan.batches.last().is_none_or(|batch| batch.queue != Queue::Graphics) {
                self.errors.push("the last batch is not on graphics".into());
            }
        }
    }

    pub(super) fn batches(&mut self) {
        let plan = self.plan;
        let mut signalled = [0; 3];
        for batch in &plan.batches {
            for wait in &batch.waits {
                if wait.value > signalled[wait.queue as usize] || wait.queue == batch.queue {
                    self.errors.push(format!("{wait:?} of a batch waits for what is not submitted before"));
                }
                let parts = self.parts.iter_mut().flat_map(|part| &mut part.records);
                for record in parts.chain(self.copies.iter_mut().flatten()) {
                    record.wait(batch.queue, batch.signal, wait.queue, wait.value, wait.stages);
                }
            }
            let mut last = None;
            for &step in &batch.steps {
                if plan.steps[step].queue != batch.queue || last > Some(step) {
                    self.errors.push(format!("step {step} does not belong into its batch"));
                }
                last = Some(step);
                self.barriers(&plan.steps[step].barriers, batch.queue, batch.signal);
                self.step(step, batch.queue, batch.signal);
            }
            self.barriers(&batch.release, batch.queue, batch.signal);
            signalled[batch.queue as usize] += 1;
            if signalled[batch.queue as usize] != batch.signal {
                self.errors.push(format!("a batch signals {}", batch.signal));
            }
        }
        if let Some(last) = plan.batches.last() {
            self.barriers(&plan.finally, last.queue, last.signal);
        }
    }

    /// One `vkCmdPipelineBarrier2`.
    fn barriers(&mut self, barriers: &Barriers, queue: Queue, batch: u64) {
        let scopes = |from, to| Scopes { queue, batch, from, to };
        let mut effects = Vec::new();
        for barrier in &barriers.memory {
            let who = format!("barrier {:?}", barrier.reason.hazard);
            effects.push(Effect { scopes: scopes(barrier.from, barrier.to), atoms: None, ownership: None, who });
        }
        for barrier in &barriers.buffers {
            let atoms = self.atoms.of(barrier.resource, &barrier.range);
            let who = format!("barrier of `{}`", self.name(barrier.resource));
            let (scopes, ownership) = (scopes(barrier.from, barrier.to), barrier.ownership);
            effects.push(Effect { scopes, atoms: Some(atoms), ownership, who });
        }
        let images = effects.len();
        for barrier in &barriers.images {
            let atoms = self.atoms.of(barrier.resource, &barrier.range);
            let who = format!("barrier of `{}`", self.name(barrier.resource));
            let (scopes, ownership) = (scopes(barrier.from, barrier.to), barrier.ownership);
            effects.push(Effect { scopes, atoms: Some(atoms), ownership, who });
        }

        // Who is in which first scope is judged by what was before the call.
        let before: Vec<Vec<Record>> = self.parts.iter().map(|part| part.records.clone()).collect();
        let copies = self.copies.clone();
        let hits = |effect: &Effect, atom: usize| effect.atoms.as_ref().is_none_or(|atoms| atoms.contains(&atom));
        for (atom, part) in self.parts.iter_mut().enumerate() {
            for (record, old) in part.records.iter_mut().zip(&before[atom]) {
                apply(record, old, effects.iter().filter(|effect| hits(effect, atom)), &effects);
            }
        }
        for (copy, old) in self.copies.iter_mut().zip(&copies) {
            if let (Some(record), Some(old)) = (copy, old) {
                apply(record, old, effects.iter().filter(|effect| effect.atoms.is_none()), &effects);
            }
        }
        for (index, effect) in effects.iter().enumerate() {
            let is_image = index >= images;
            for &atom in effect.atoms.iter().flatten() {
                let [from, to] = [effect.scopes.from.layout, effect.scopes.to.layout];
                if effect.ownership.is_some() || (is_image && from != to) {
                    self.transition(effect, atom, is_image, &before, &effects);
                }
            }
        }
    }

    /// A layout transition, or half of an ownership transfer.
    fn transition(&mut self, effect: &Effect, atom: usize, is_image: bool, before: &[Vec<Record>], all: &[Effect]) {
        // Its own barrier speaks of its own image alone ("Image Memory Barriers"): what another resource wrote to the
        // same memory is made available by a barrier for all memory. Synchronisation validation, though, looks for
        // it in the transition's own barrier.
        let for_all = |old: &Record| {
            let mut barriers = all.iter().filter(|effect| effect.atoms.is_none());
            barriers.any(|effect| old.in_first_scope(&effect.scopes) && old.in_first_access_scope(&effect.scopes))
        };
        let Effect { scopes, who, .. } = effect;
        let [from, to] = [scopes.from.layout, scopes.to.layout];
        let resource = self.atoms.resource(atom);
        let family = self.family(scopes.queue);
        let discards = is_image && from == Layout::UNDEFINED;
        let mut wrong = Vec::new();
        for other in std::iter::once(atom).chain(self.shared(resource)) {
            for (record, old) in self.parts[other].records.iter().zip(&before[other]) {
                if !old.in_first_scope(scopes) {
                    wrong.push(format!("{who} does not wait for {} of {}", kind(record), record.who));
                    continue;
                }
                let here = old.in_first_access_scope(scopes) && (other == atom || for_all(old));
                if record.writes() && !old.is_available_to(scopes) && !here {
                    wrong.push(format!("{who} comes before what {} wrote is available", record.who));
                }
            }
        }
        let part = &mut self.parts[atom];
        match effect.ownership {
            Some(ownership) if Some(ownership.from) == family => {
                if part.owner != family || part.released.is_some() {
                    wrong.push(format!("{who} gives away what {:?} owns", part.owner));
                }
                if part.layout != from {
                    wrong.push(format!("{who} expects layout {from:?}, it is {:?}", part.layout));
                }
                part.released = Some((ownership, from, to));
            }
            Some(ownership) => {
                if Some(ownership.to) != family || part.released.take() != Some((ownership, from, to)) {
                    wrong.push(format!("{who} takes what was not given like that"));
                }
                part.owner = family;
                part.layout = to;
            }
            None => {
                if !discards && (part.owner.is_some_and(|owner| Some(owner) != family) || part.released.is_some()) {
                    wrong.push(format!("{who} is on family {family:?}, the owner is {:?}", part.owner));
                }
                if !discards && part.layout != from {
                    wrong.push(format!("{who} expects layout {from:?}, it is {:?}", part.layout));
                }
                part.owner = family;
                part.released = None;
                part.layout = to;
                if discards {
                    part.contents = Contents::Nothing;
                }
            }
        }
        part.records = vec![Record::transition(who.clone(), scopes)];
        self.writes += 1;
        part.written = self.writes;
        self.errors.extend(wrong);
        self.clobber(resource);
    }

    /// Parts of resources that share memory with one.
    fn shared(&self, resource: ResourceId) -> impl Iterator<Item = usize> {
        self.sharers[resource.0 as usize].iter().flat_map(|&other| self.atoms.all(other))
    }

    /// Whether a part was the last to be written, and was not read since, of those whose memory a resource takes over.
    fn was_last(&self, part: usize, next: ResourceId) -> bool {
        let old = self.atoms.resource(part);
        let later = |other: usize| {
            let resource = self.atoms.resource(other);
            let between = resource != old && self.sharers[old.0 as usize].contains(&resource);
            between && self.parts[other].written > self.parts[part].written
        };
        let read = self.parts[part].records.iter().any(|record| record.kind == Kind::Read);
        !read && !self.shared(next).any(later)
    }

    /// Others lose what they held in memory that was written.
    fn clobber(&mut self, resource: ResourceId) {
        for atom in self.shared(resource).collect::<Vec<_>>() {
            let part = &mut self.parts[atom];
            part.contents = Contents::Nothing;
            part.layout = Layout::UNDEFINED;
            part.owner = None;
            part.released = None;
        }
    }

    fn step(&mut self, step: usize, queue: Queue, batch: u64) {
        let description = self.description;
        match self.plan.steps[step].work {
            Work::Pass(pass) => {
                let pass = &description.passes[pass.0 as usize];
                let who = format!("pass `{}`", pass.name);
                let uses = description.uses_of(pass);
                for (index, used) in uses.iter().enumerate() {
                    self.hold_against(used, &who, queue);
                    for other in &uses[..index] {
                        let [a, b] = [used, other].map(|used| description.versions[used.version.0 as usize].resource);
                        let writes = used.makes.is_some() || other.makes.is_some();
                        if writes && self.sharers[a.0 as usize].contains(&b) {
                            let what = format!("{who}: `{}` shares memory with `{}`", self.name(a), self.name(b));
                            self.errors.push(what);
                        }
                    }
                }
                for used in uses {
                    self.leave(used, &who, queue, batch);
                }
            }
            Work::ReadBack(root) => {
                let version = description.roots[root].version;
                let used = Use {
                    slot: "".into(),
                    version,
                    makes: None,
                    reads: true,
                    access: Access {
                        stages: Stages::COPY,
                        mask: Mask::TRANSFER_READ,
                        layout: Layout::TRANSFER_SRC_OPTIMAL,
                    },
                };
                let who = format!("read-back of `{}`", description.roots[root].name);
                self.hold_against(&used, &who, queue);
                self.leave(&used, &who, queue, batch);
                let stage = Stages::COPY.as_raw();
                let copy = Record::new(Kind::Write, who, queue, batch, stage, Mask::TRANSFER_WRITE);
                self.copies[root] = Some(copy);
            }
        }
    }

    /// Holds one use against what its memory has seen.
    fn hold_against(&mut self, used: &Use, who: &str, queue: Queue) {
        let Version { resource, range, .. } = self.description.versions[used.version.0 as usize];
        let name = self.name(resource).to_owned();
        let fork = used.makes.and_then(|made| forked_from(self.description, made));
        let family = self.family(queue);
        let is_image = matches!(range, Range::Image { .. });
        let reads = used.reads || used.makes.is_none();
        for atom in self.atoms.of(resource, &range) {
            let part = &self.parts[atom];
            let mut wrong = Vec::new();
            if is_image && part.layout != used.access.layout {
                wrong.push(format!("is in layout {:?}, needs {:?}", part.layout, used.access.layout));
            }
            let owned = part.owner.is_none_or(|owner| Some(owner) == family) && part.released.is_none();
            if (reads || is_image) && !owned {
                wrong.push(format!("belongs to family {:?}", part.owner));
            }
            if reads && !self.holds(part, used.version, atom, fork) {
                wrong.push(format!("holds {:?}, not version {}", part.contents, used.version.0));
            }
            let read = part.records.iter().any(|record| record.kind == Kind::Read);
            let writes_first = part.records.is_empty() && !used.access.writes().is_empty();
            for stage in each(single(used.access.stages)) {
                let records = part.records.iter();
                wrong.extend(records.filter_map(|record| conflict(record, used, fork, queue, stage, read)));
                for other in self.shared(resource) {
                    let next = writes_first && self.was_last(other, resource);
                    let records = self.parts[other].records.iter();
                    wrong.extend(records.filter_map(|record| foreign_conflict(record, used, queue, stage, next)));
                }
            }
            self.errors.extend(wrong.into_iter().map(|what| format!("{who}: `{name}` {what}")));
        }
    }

    /// Whether a part holds what a version says. Unordered writers may see each other's writes.
    pub(super) fn holds(&self, part: &Part, version: VersionId, atom: usize, fork: Option<VersionId>) -> bool {
        if part.contents == contents(self.description, &self.atoms, version, atom) {
            return part.contents != Contents::Nothing;
        }
        match &part.contents {
            Contents::Written(made) => {
                fork.is_some() && made.iter().all(|&made| forked_from(self.description, made) == fork)
            }
            _ => false,
        }
    }

    /// Leaves the records of one use.
    fn leave(&mut self, used: &Use, who: &str, queue: Queue, batch: u64) {
        let Version { resource, range, .. } = self.description.versions[used.version.0 as usize];
        let family = self.family(queue);
        let fork = used.makes.and_then(|made| forked_from(self.description, made));
        for atom in self.atoms.of(resource, &range) {
            let part = &mut self.parts[atom];
            part.owner =
                part.owner.filter(|_| part.released.is_none()).filter(|owner| Some(*owner) == family).or(family);
            part.released = None;
            let (kind, mask) = match used.makes {
                Some(_) => (Kind::Write, used.access.writes()),
                None => (Kind::Read, used.access.mask),
            };
            if let Some(made) = used.makes {
                self.writes += 1;
                part.written = self.writes;
                match (&mut part.contents, fork) {
                    (Contents::Written(known), Some(_))
                        if known.iter().all(|&other| forked_from(self.description, other) == fork) =>
                    {
                        known.insert(made);
                    }
                    (contents, _) => *contents = Contents::Written([made].into()),
                }
                if fork.is_none() {
                    // Whatever comes behind this write comes behind what was before it.
                    part.records.clear();
                }
            }
            for stage in each(single(used.access.stages)) {
                let mut record = Record::new(kind, who.into(), queue, batch, stage, mask);
                record.fork = fork;
                part.records.push(record);
            }
        }
        if used.makes.is_some() {
            self.clobber(resource);
        }
    }
}

//! Checkpoints: a frame in segments, planned one after the other.
//!
//! A segment is a description of its own, over the same resources and versions. What came before it is gone from it:
//! versions that earlier segments made are what its resources begin with, in the states that they were left in.

use std::ops::Range as Span;

use super::dependencies::{Dependencies, Events, Node};
use super::versions::Versions;
use super::{Chosen, DeviceModel, End, Plan, Work, choose, plan_chosen, usage};
use crate::graph::description::{
    Checkpoint, Description, Origin, Pass, PassId, Resource, ResourceId, Source, State, Version, VersionId,
};
use crate::graph::errors::{ErrorKind, GraphError, GraphErrors};

/// A part of a frame between two checkpoints.
#[derive(Clone, Debug)]
pub struct Segment {
    /// What it does: passes and roots are numbered anew, resources and versions as in the whole frame.
    pub description: Description,
    /// Its plan.
    pub plan: Plan,
    /// Its passes, by their numbers in the whole frame.
    pub passes: Span<usize>,
    /// Its roots, by their numbers in the whole frame.
    pub roots: Vec<usize>,
}

/// Plans one segment of a frame. `ends`: how the one before it left its resources ([`Plan::ends`]).
///
/// What is alive over a checkpoint is not placed in the segment's heaps: whoever executes it gives it memory of its own
/// when a segment uses it first.
///
/// # Errors
/// All that is wrong with the whole frame, at once; a segment that there is not.
pub fn segment(
    whole: &Description,
    index: usize,
    ends: &[End],
    device: &dyn DeviceModel,
) -> Result<Segment, GraphErrors> {
    // 1. What of the whole frame runs, and the segment's own description.
    let Part { chosen, description, passes, roots } = part(whole, index, ends, device)?;

    // 2. Its plan. Passes were chosen for the whole frame.
    let culled = chosen.culled.iter().filter(|(pass, _)| passes.contains(&(pass.0 as usize)));
    let culled = culled.map(|(pass, why)| (PassId(pass.0 - passes.start as u32), why.clone())).collect();
    let versions = Versions::of_right(&description);
    let live = chosen.live[passes.clone()].to_vec();
    let mut events = Events::new(&description, &versions);
    events.retain(|node| live.get(node as usize).is_none_or(|live| *live));
    let dependencies = Dependencies::new(&events, description.passes.len() + description.roots.len());
    let chosen_here = Chosen { versions, live, culled, events, dependencies };
    let (mut plan, _) = plan_chosen(&description, chosen_here, device)?;

    // 3. What is alive over a checkpoint is made once, for the uses of all segments.
    let usages = usage::usages(whole, &chosen.live);
    for (index, resource) in description.resources.iter().enumerate() {
        if plan.usages[index].is_some() && matches!(resource.origin, Origin::Kept { .. }) {
            plan.usages[index] = usages[index];
        }
    }
    Ok(Segment { description, plan, passes, roots })
}

/// The first segment of a frame, which was planned before; by pass of the whole frame, whether it runs.
///
/// # Errors
/// As [`segment`].
pub(in crate::graph) fn first_segment(
    whole: &Description,
    plan: Plan,
    device: &dyn DeviceModel,
) -> Result<(Segment, Vec<bool>), GraphErrors> {
    let Part { description, passes, roots, chosen } = part(whole, 0, &[], device)?;
    Ok((Segment { description, plan, passes, roots }, chosen.live))
}

/// A segment before it is planned.
struct Part {
    /// Of the whole frame.
    chosen: Chosen,
    description: Description,
    passes: Span<usize>,
    roots: Vec<usize>,
}

fn part(whole: &Description, index: usize, ends: &[End], device: &dyn DeviceModel) -> Result<Part, GraphErrors> {
    let chosen = choose(whole, device)?;
    let cuts = Cuts::new(whole);
    cuts.check(&chosen, index)?;
    let (roots, description) = cuts.describe(&chosen, index, ends);
    Ok(Part { passes: cuts.passes(index), chosen, description, roots })
}

/// Where a frame is cut.
struct Cuts<'a> {
    whole: &'a Description,
}

impl<'a> Cuts<'a> {
    fn new(whole: &'a Description) -> Self {
        Self { whole }
    }

    fn last(&self) -> usize {
        self.whole.checkpoints.len()
    }

    fn passes(&self, index: usize) -> Span<usize> {
        self.span(index, |checkpoint| checkpoint.passes, self.whole.passes.len())
    }

    fn versions(&self, index: usize) -> Span<usize> {
        self.span(index, |checkpoint| checkpoint.versions, self.whole.versions.len())
    }

    /// From one checkpoint to the next; `end`: where the last segment ends.
    fn span(&self, index: usize, before: impl Fn(&Checkpoint) -> usize, end: usize) -> Span<usize> {
        let at = |index: usize| self.whole.checkpoints.get(index).map(&before);
        index.checked_sub(1).and_then(at).unwrap_or(0)..at(index).unwrap_or(end)
    }

    /// The segment of a pass, or of the version that a root reads.
    fn of(&self, node: Node) -> usize {
        let (checkpoints, node) = (&self.whole.checkpoints, node as usize);
        match node.checked_sub(self.whole.passes.len()) {
            None => checkpoints.partition_point(|checkpoint| checkpoint.passes <= node),
            Some(root) => {
                let version = self.whole.roots[root].version.0 as usize;
                checkpoints.partition_point(|checkpoint| checkpoint.versions <= version)
            }
        }
    }

    /// Nothing waits for what comes behind a later checkpoint.
    fn check(&self, chosen: &Chosen, index: usize) -> Result<(), GraphErrors> {
        let whole = self.whole;
        let mut errors = Vec::new();
        let mut error = |wrong: String, allowed: &str| {
            let (pass, slot, resource) = (None, None, None);
            let kind = ErrorKind::BadCheckpoint;
            errors.push(GraphError { kind, pass, slot, resource, wrong, allowed: allowed.into() });
        };
        if index > self.last() {
            error(format!("there is no segment {index}"), &format!("the last one is {}", self.last()));
        }
        let nodes = whole.passes.len() + whole.roots.len();
        for node in 0..nodes as Node {
            for &(after, cell) in chosen.dependencies.after(node) {
                let (from, to) = (self.of(node), self.of(after));
                if from > to {
                    let name = |node: Node| self.work(node).describe(whole);
                    let resource = &whole.resources[chosen.versions.cells.resource(cell).0 as usize].name;
                    let checkpoint = &whole.checkpoints[from - 1].name;
                    let wrong = format!(
                        "{} comes before checkpoint `{checkpoint}` but waits for {}, which comes after it, because of \
                         `{resource}`",
                        name(after),
                        name(node)
                    );
                    error(wrong, "what is read after a checkpoint is not written over before it");
                }
            }
        }
        if errors.is_empty() { Ok(()) } else { Err(GraphErrors { graph: whole.name.clone(), errors }) }
    }

    fn work(&self, node: Node) -> Work {
        match (node as usize).checked_sub(self.whole.passes.len()) {
            None => Work::Pass(PassId(node)),
            Some(root) => Work::ReadBack(root),
        }
    }

    /// The segment's roots, and its description.
    fn describe(&self, chosen: &Chosen, index: usize, ends: &[End]) -> (Vec<usize>, Description) {
        let whole = self.whole;
        let (passes, versions) = (self.passes(index), self.versions(index));
        let spans = self.spans(chosen);
        let resources = whole.checkpoints.get(index).map_or(whole.resources.len(), |next| next.resources);
        let old = index.checked_sub(1).map_or(0, |before| whole.checkpoints[before].resources);
        let resources = (0..resources).map(|resource| {
            let ends = (resource < old).then(|| states(ends, ResourceId(resource as u32)));
            let known = &whole.resources[resource];
            Resource { origin: self.origin(known, spans[resource], index, ends), ..known.clone() }
        });
        let initial = initial(whole);
        let version = |(number, version): (usize, &Version)| {
            let source = match &version.source {
                Source::Pass { pass, from } if number >= versions.start => {
                    Source::Pass { pass: PassId(pass.0 - passes.start as u32), from: *from }
                }
                source if number >= versions.start => source.clone(),
                Source::Initial => Source::Initial,
                _ => begins_with(whole, &chosen.versions, &initial, number),
            };
            Version { source, ..version.clone() }
        };
        let first_root = whole.passes.len();
        let roots = (0..whole.roots.len()).filter(|&root| {
            let segment = self.of((first_root + root) as Node);
            if whole.roots[root].read_back { segment == index } else { segment <= index }
        });
        let roots: Vec<usize> = roots.collect();
        let (mut own, mut uses) = (Vec::with_capacity(passes.len()), Vec::new());
        for pass in &whole.passes[passes.clone()] {
            let first = uses.len() as u32;
            uses.extend_from_slice(whole.uses_of(pass));
            own.push(Pass { uses: first..uses.len() as u32, ..pass.clone() });
        }
        let description = Description {
            name: whole.name.clone(),
            resources: resources.collect(),
            versions: whole.versions[..versions.end].iter().enumerate().map(version).collect(),
            passes: own,
            uses,
            roots: roots.iter().map(|&root| whole.roots[root].clone()).collect(),
            checkpoints: Vec::new(),
        };
        (roots, description)
    }

    /// By resource: the first and the last segment that use it.
    fn spans(&self, chosen: &Chosen) -> Vec<Option<[usize; 2]>> {
        let whole = self.whole;
        let mut spans: Vec<Option<[usize; 2]>> = vec![None; whole.resources.len()];
        let mut add = |version: VersionId, segment: usize| {
            let span = &mut spans[whole.versions[version.0 as usize].resource.0 as usize];
            *span = Some(span.map_or([segment; 2], |[first, last]| [first.min(segment), last.max(segment)]));
        };
        for (index, pass) in whole.passes.iter().enumerate().filter(|(index, _)| chosen.live[*index]) {
            whole.uses_of(pass).iter().for_each(|used| add(used.version, self.of(index as Node)));
        }
        for (index, root) in whole.roots.iter().enumerate() {
            let segment = self.of((whole.passes.len() + index) as Node);
            add(root.version, if root.read_back { segment } else { self.last() });
        }
        spans
    }

    /// Where a segment has a resource from. `ends`: how the segment before left it, where there was one.
    fn origin(&self, resource: &Resource, span: Option<[usize; 2]>, index: usize, ends: Option<Vec<State>>) -> Origin {
        let last = index == self.last();
        match &resource.origin {
            Origin::Transient if span.is_some_and(|[first, last]| first < last) => {
                Origin::Kept { before: ends.unwrap_or_default(), after: None, needed: false }
            }
            Origin::Transient => Origin::Transient,
            Origin::Imported { before, after } => {
                let holds = before.has_contents(&resource.shape);
                let arrives = || vec![State { range: resource.shape.whole(), access: *before, holds }];
                let after = after.filter(|_| last);
                Origin::Kept { before: ends.unwrap_or_else(arrives), after, needed: false }
            }
            Origin::Kept { before, after, needed } => {
                let before = ends.unwrap_or_else(|| before.clone());
                Origin::Kept { before, after: after.filter(|_| last), needed: *needed }
            }
        }
    }
}

/// The states in which a plan leaves the parts of a resource.
pub(in crate::graph) fn states(ends: &[End], resource: ResourceId) -> Vec<State> {
    ends.iter().filter(|end| end.resource == resource).map(|end| end.state).collect()
}

/// By resource: its first version.
fn initial(whole: &Description) -> Vec<VersionId> {
    let mut initial = vec![VersionId(0); whole.resources.len()];
    for (index, version) in whole.versions.iter().enumerate() {
        if version.source == Source::Initial {
            initial[version.resource.0 as usize] = VersionId(index as u32);
        }
    }
    initial
}

/// A version that an earlier segment made, as a part of what the resource begins with; one that unordered writers have
/// not joined yet stays theirs.
fn begins_with(whole: &Description, versions: &Versions, initial: &[VersionId], number: usize) -> Source {
    let version = &whole.versions[number];
    let of = initial[version.resource.0 as usize];
    match versions.fork(VersionId(number as u32)) {
        Some(of) => Source::Fork { of },
        None if version.range == whole.versions[of.0 as usize].range => Source::Join { of: vec![of] },
        None => Source::Split { of },
    }
}

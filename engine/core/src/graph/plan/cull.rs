//! Which passes run: those that a root or a side effect needs, cell by cell.

use super::CullReason;
use super::versions::{Versions, last_of_needed};
use crate::graph::description::{Description, PassId, Source, Use, VersionId};
use crate::graph::errors::{ErrorKind, GraphError, GraphErrors};

/// Which passes are live, by pass, and why the others are not.
pub(super) fn cull(description: &Description, versions: &Versions) -> (Vec<bool>, Vec<(PassId, CullReason)>) {
    let live = if versions.plain { needed_of_plain(description) } else { needed(description, versions) };
    if live.iter().all(|live| *live) {
        return (live, Vec::new());
    }
    let readers = readers(description);
    let dead = (0..live.len()).filter(|&index| !live[index]);
    let culled = dead.map(|index| (PassId(index as u32), reason(description, &readers, &live, index))).collect();
    (live, culled)
}

/// By pass: whether it is live, where passes that others need are recorded before them.
fn needed_of_plain(description: &Description) -> Vec<bool> {
    let mut needed = vec![false; description.versions.len()];
    description.roots.iter().for_each(|root| needed[root.version.0 as usize] = true);
    let mut live = vec![false; description.passes.len()];
    for (live, pass) in live.iter_mut().zip(&description.passes).rev() {
        let uses = description.uses_of(pass);
        let makes = |used: &Use| used.makes.is_some_and(|made| needed[made.0 as usize]);
        *live = pass.side_effect.is_some() || uses.iter().any(makes);
        for used in uses.iter().filter(|used| *live && (used.reads || used.makes.is_none())) {
            needed[used.version.0 as usize] = true;
        }
    }
    live
}

/// By pass: whether it is live.
fn needed(description: &Description, versions: &Versions) -> Vec<bool> {
    let mut need = Need {
        description,
        versions,
        needed: vec![false; versions.cells.slot_count()],
        live: vec![false; description.passes.len()],
        waiting: Vec::new(),
    };
    for root in &description.roots {
        need.version(root.version);
    }
    for version in last_of_needed(description) {
        need.version(version);
    }
    for (index, _) in description.passes.iter().enumerate().filter(|(_, pass)| pass.side_effect.is_some()) {
        need.pass(index);
    }
    while let Some((version, slot)) = need.waiting.pop() {
        need.sources(version, slot);
    }
    need.live
}

struct Need<'a> {
    description: &'a Description,
    versions: &'a Versions,
    /// By slot.
    needed: Vec<bool>,
    /// By pass.
    live: Vec<bool>,
    waiting: Vec<(VersionId, usize)>,
}

impl Need<'_> {
    fn version(&mut self, version: VersionId) {
        for slot in self.versions.cells.slots(version.0 as usize) {
            self.slot(version, slot);
        }
    }

    fn slot(&mut self, version: VersionId, slot: usize) {
        if !std::mem::replace(&mut self.needed[slot], true) {
            self.waiting.push((version, slot));
        }
    }

    fn pass(&mut self, index: usize) {
        if !std::mem::replace(&mut self.live[index], true) {
            let description = self.description;
            for used in description.uses_of(&description.passes[index]) {
                if used.reads || used.makes.is_none() {
                    self.version(used.version);
                }
            }
        }
    }

    /// Marks what a cell of a version comes from.
    fn sources(&mut self, version: VersionId, slot: usize) {
        let description = self.description;
        let cell = self.versions.cells.cell(slot);
        let sources: &[VersionId] = match &description.versions[version.0 as usize].source {
            Source::Initial => &[],
            Source::Pass { pass, .. } => return self.pass(pass.0 as usize),
            Source::Split { of } | Source::Fork { of } => std::slice::from_ref(of),
            Source::Join { of } => of,
        };
        for &source in sources {
            if let Some(slot) = self.versions.cells.slot(source.0 as usize, cell) {
                self.slot(source, slot);
            }
        }
    }
}

/// By version: passes that use it, and versions split, forked or joined from it.
struct Readers {
    passes: Vec<Vec<u32>>,
    versions: Vec<Vec<u32>>,
}

fn readers(description: &Description) -> Readers {
    let count = description.versions.len();
    let mut readers = Readers { passes: vec![Vec::new(); count], versions: vec![Vec::new(); count] };
    for (index, pass) in description.passes.iter().enumerate() {
        description.uses_of(pass).iter().for_each(|used| readers.passes[used.version.0 as usize].push(index as u32));
    }
    for (index, version) in description.versions.iter().enumerate() {
        let sources = match &version.source {
            Source::Pass { .. } => &[],
            source => source.versions(),
        };
        sources.iter().for_each(|source| readers.versions[source.0 as usize].push(index as u32));
    }
    readers
}

/// Why a pass does not run, after the first of its outputs that somebody uses.
fn reason(description: &Description, readers: &Readers, live: &[bool], pass: usize) -> CullReason {
    let made: Vec<_> = description.uses_of(&description.passes[pass]).iter().filter_map(|used| used.makes).collect();
    if made.is_empty() {
        return CullReason::WritesNothing;
    }
    let mut overwritten = None;
    for &version in &made {
        let resource = description.versions[version.0 as usize].resource;
        let mut waiting = vec![version.0];
        while let Some(version) = waiting.pop() {
            waiting.extend(&readers.versions[version as usize]);
            for &user in &readers.passes[version as usize] {
                let uses = description.uses_of(&description.passes[user as usize]);
                let reads = uses.iter().any(|used| used.version.0 == version && (used.reads || used.makes.is_none()));
                if reads && !live[user as usize] {
                    return CullReason::OnlyCulledRead { resource, reader: PassId(user) };
                }
                if !reads && live[user as usize] {
                    overwritten = Some(CullReason::Overwritten { resource, by: PassId(user) });
                }
            }
        }
    }
    let mut resources: Vec<_> = made.iter().map(|made| description.versions[made.0 as usize].resource).collect();
    resources.dedup();
    overwritten.unwrap_or(CullReason::Unread { resources })
}

/// Roots that are kept but not read back are still there at the end: no live pass writes over them.
///
/// # Errors
/// One for each root that is written over.
pub(super) fn check_kept(description: &Description, versions: &Versions, live: &[bool]) -> Result<(), GraphErrors> {
    let mut errors = Vec::new();
    for root in description.roots.iter().filter(|root| !root.read_back) {
        let later = |pass: &&crate::graph::description::Pass| {
            description.uses_of(pass).iter().any(|used| {
                used.makes.is_some()
                    && versions.cells.slots(root.version.0 as usize).any(|slot| {
                        let other = versions.cells.slot(used.version.0 as usize, versions.cells.cell(slot));
                        other.is_some_and(|other| versions.epoch[other] >= versions.epoch[slot])
                    })
            })
        };
        let passes = description.passes.iter().zip(live).filter(|(_, live)| **live).map(|(pass, _)| pass);
        if let Some(pass) = passes.into_iter().find(|pass| later(pass)) {
            let resource = description.versions[root.version.0 as usize].resource;
            errors.push(GraphError {
                kind: ErrorKind::OverwrittenRoot,
                pass: Some(pass.name.to_string()),
                slot: None,
                resource: Some(description.resources[resource.0 as usize].name.to_string()),
                wrong: format!("writes over what root `{}` keeps", root.name),
                allowed: "keep the last version, or capture this one, which copies it before".into(),
            });
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(GraphErrors { graph: description.name.clone(), errors }) }
}

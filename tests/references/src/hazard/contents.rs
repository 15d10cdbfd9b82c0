//! What a version holds, by the description alone.

use std::collections::BTreeSet;

use ash::vk::ImageLayout;
use shadowgraph::graph::description::{Description, Origin, ResourceId, Shape, Source, State, VersionId};

use super::atoms::Atoms;

/// What a part of a resource holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Contents {
    /// Nothing that anybody may rely on.
    Nothing,
    /// What an imported resource came with.
    Arrived,
    /// What the makers of these versions wrote last: several where they are unordered.
    Written(BTreeSet<VersionId>),
}

/// What a version holds in one of its parts.
pub fn contents(description: &Description, atoms: &Atoms, version: VersionId, atom: usize) -> Contents {
    let known = &description.versions[version.0 as usize];
    match &known.source {
        Source::Initial => {
            let resource = &description.resources[known.resource.0 as usize];
            match (&resource.origin, &resource.shape) {
                (Origin::Transient, _) => Contents::Nothing,
                (Origin::Imported { before, .. }, Shape::Image(_)) if before.layout == ImageLayout::UNDEFINED => {
                    Contents::Nothing
                }
                (Origin::Imported { .. }, _) => Contents::Arrived,
                (Origin::Kept { before, .. }, _) => {
                    let here = |state: &&State| atoms.of(known.resource, &state.range).contains(&atom);
                    let holds = before.iter().find(here).is_some_and(|state| state.holds);
                    if holds { Contents::Arrived } else { Contents::Nothing }
                }
            }
        }
        Source::Pass { .. } => Contents::Written(BTreeSet::from([version])),
        Source::Split { of } | Source::Fork { of } => contents(description, atoms, *of, atom),
        Source::Join { of } => {
            let holds = |part: &&VersionId| {
                let range = description.versions[part.0 as usize].range;
                atoms.of(known.resource, &range).contains(&atom)
            };
            let parts: Vec<VersionId> = of.iter().filter(holds).copied().collect();
            let written: BTreeSet<_> = parts.iter().filter(|&&part| forked_from(description, part).is_some()).collect();
            if written.is_empty() {
                return parts.first().map_or(Contents::Nothing, |&part| contents(description, atoms, part, atom));
            }
            Contents::Written(written.into_iter().copied().collect())
        }
    }
}

/// Versions of a resource that no other version is made from: what it holds after all passes.
pub fn last_versions(description: &Description, resource: ResourceId) -> Vec<VersionId> {
    let ids = (0..description.versions.len() as u32).map(VersionId);
    let mine = ids.filter(|id| description.versions[id.0 as usize].resource == resource);
    let replaced = |id: &VersionId| description.versions.iter().any(|version| version.source.versions().contains(id));
    mine.filter(|id| !replaced(id)).collect()
}

/// What an unordered writer that makes this version started from.
pub fn forked_from(description: &Description, made: VersionId) -> Option<VersionId> {
    let Source::Pass { from, .. } = description.versions[made.0 as usize].source else { return None };
    match description.versions[from.0 as usize].source {
        Source::Fork { of } => Some(of),
        _ => None,
    }
}

//! What follows from how versions are made of one another, cell by cell: epochs and definedness.
//!
//! Each write of a cell begins an epoch of it: epoch 0 is what the frame began with. Splits, forks and joins begin
//! none. Unordered writers share one.

use rustc_hash::FxHashMap;

use super::cells::Cells;
use crate::graph::description::{Description, Origin, Range, ResourceId, Source, State, VersionId};

/// States that cells of kept resources arrive in.
fn arrival(description: &Description, cells: &Cells) -> FxHashMap<u32, State> {
    let mut arrival = FxHashMap::default();
    let mut covered = Vec::new();
    for (index, resource) in description.resources.iter().enumerate() {
        let Origin::Kept { before, .. } = &resource.origin else { continue };
        let id = ResourceId(index as u32);
        for state in before.iter().filter(|state| state.range.lies_in(&cells.whole(id))) {
            covered.clear();
            cells.cover(id, state.range, &mut covered);
            arrival.extend(covered.iter().map(|&cell| (cell, *state)));
        }
    }
    arrival
}

/// How much of a resource that is needed after the frame holds something then: as [`super::Plan::ends`] tells it, over
/// all segments of a frame that is right.
pub(in crate::graph) fn held_at_the_end(description: &Description, resource: ResourceId) -> u64 {
    let versions = Versions::of_right(description);
    let last = last_of_needed(description).into_iter().map(|version| version.0 as usize);
    let mine = last.filter(|&version| description.versions[version].resource == resource);
    let held = mine.flat_map(|version| versions.cells.slots(version)).filter(|&slot| versions.defined[slot]);
    let cells = held.map(|slot| versions.cells.cell(slot));
    cells.flat_map(|cell| versions.cells.ranges(&[cell])).map(|range| range.amount()).sum()
}

/// Versions of what is needed after the plan that no other version is made from.
pub(super) fn last_of_needed(description: &Description) -> Vec<VersionId> {
    let needed = |resource: ResourceId| {
        let resource = description.resources.get(resource.0 as usize);
        resource.is_some_and(|resource| matches!(resource.origin, Origin::Kept { needed: true, .. }))
    };
    if !(0..description.resources.len() as u32).any(|index| needed(ResourceId(index))) {
        return Vec::new();
    }
    let mut last: Vec<bool> = description.versions.iter().map(|version| needed(version.resource)).collect();
    for source in description.versions.iter().flat_map(|version| version.source.versions()) {
        if let Some(last) = last.get_mut(source.0 as usize) {
            *last = false;
        }
    }
    let ids = (0..last.len() as u32).map(VersionId);
    ids.zip(last).filter(|(_, last)| *last).map(|(id, _)| id).collect()
}

/// By resource: all of it.
pub(super) fn wholes(description: &Description) -> Vec<Range> {
    description.resources.iter().map(|resource| resource.shape.whole()).collect()
}

/// Facts of versions.
pub(super) struct Versions {
    /// Cells of resources, and slots of versions.
    pub(super) cells: Cells,
    /// By slot: the epoch whose contents the version is.
    pub(super) epoch: Vec<u32>,
    /// By slot: whether anybody ever wrote the contents.
    pub(super) defined: Vec<bool>,
    /// By version: what it was forked from, where it was and is not joined yet. Nothing where none was.
    forks: Vec<Option<VersionId>>,
    /// Versions that cannot be reasoned about.
    pub(super) broken: Vec<bool>,
    /// By cell of a kept resource: the state it arrives in.
    pub(super) arrival: FxHashMap<u32, State>,
    /// Whether each version is all of a resource, and passes use the last one before them alone.
    pub(super) plain: bool,
}

impl Versions {
    /// Of a description that is right.
    pub(super) fn of_right(description: &Description) -> Self {
        Self::new(description, wholes(description), vec![false; description.versions.len()])
    }

    /// Of versions that are each all of a resource. Passes use the last one before them alone, and kept resources there
    /// are none.
    pub(super) fn plain(cells: Cells, epoch: Vec<u32>, defined: Vec<bool>) -> Self {
        let broken = vec![false; defined.len()];
        Self { cells, epoch, defined, forks: Vec::new(), broken, arrival: FxHashMap::default(), plain: true }
    }

    /// Goes through versions in order; sources of a version that is not broken come before it. `wholes`: by resource, all
    /// of it.
    pub(super) fn new(description: &Description, wholes: Vec<Range>, broken: Vec<bool>) -> Self {
        let cells = Cells::new(description, wholes, &broken);
        let mut facts = Self {
            arrival: arrival(description, &cells),
            epoch: Vec::with_capacity(cells.slot_count()),
            defined: Vec::with_capacity(cells.slot_count()),
            forks: Vec::new(),
            cells,
            broken,
            plain: false,
        };
        for (index, version) in description.versions.iter().enumerate() {
            if facts.broken[index] {
                continue;
            }
            let fork = match &version.source {
                Source::Fork { of } => Some(*of),
                Source::Pass { from, .. } => facts.fork(*from),
                _ => None,
            };
            if fork.is_some() {
                facts.forks.resize(description.versions.len(), None);
                facts.forks[index] = fork;
            }
            // Slots come in order.
            for slot in facts.cells.slots(index) {
                let (epoch, defined) = facts.derive(description, &version.source, slot);
                facts.epoch.push(epoch);
                facts.defined.push(defined);
            }
        }
        facts
    }

    fn derive(&self, description: &Description, source: &Source, slot: usize) -> (u32, bool) {
        let cell = self.cells.cell(slot);
        let at = |version: VersionId| {
            let slot = self.cells.slot(version.0 as usize, cell);
            slot.map_or((0, false), |slot| (self.epoch[slot], self.defined[slot]))
        };
        match source {
            Source::Initial => {
                let resource = &description.resources[self.cells.resource(cell).0 as usize];
                let kept = match resource.origin {
                    Origin::Transient => false,
                    Origin::Imported { before, .. } => before.has_contents(&resource.shape),
                    Origin::Kept { .. } => self.arrival.get(&cell).is_some_and(|state| state.holds),
                };
                (0, kept)
            }
            Source::Pass { from, .. } => (at(*from).0 + 1, true),
            Source::Split { of } | Source::Fork { of } => at(*of),
            Source::Join { of } => of.iter().map(|&part| at(part)).fold((0, false), |a, b| (a.0.max(b.0), a.1 || b.1)),
        }
    }

    /// What a version was forked from, where it was and is not joined yet.
    pub(super) fn fork(&self, version: VersionId) -> Option<VersionId> {
        *self.forks.get(version.0 as usize)?
    }

    /// Whether any version was forked.
    pub(super) fn are_forked(&self) -> bool {
        !self.forks.is_empty()
    }

    /// Whether a version can be reasoned about.
    pub(super) fn is_known(&self, version: VersionId) -> bool {
        self.broken.get(version.0 as usize) == Some(&false)
    }

    /// Whether all of a version's contents were written.
    pub(super) fn is_defined(&self, version: VersionId) -> bool {
        self.cells.slots(version.0 as usize).all(|slot| self.defined[slot])
    }

    /// Whether two versions share a cell.
    pub(super) fn overlap(&self, a: VersionId, b: VersionId) -> bool {
        let (a, b) = (self.cells.covered(a.0 as usize), self.cells.covered(b.0 as usize));
        a.iter().any(|cell| b.binary_search(cell).is_ok())
    }

    /// Whether two versions share a cell but not its contents.
    pub(super) fn epochs_differ(&self, a: VersionId, b: VersionId) -> bool {
        self.cells.slots(a.0 as usize).any(|slot| {
            let other = self.cells.slot(b.0 as usize, self.cells.cell(slot));
            other.is_some_and(|other| self.epoch[slot] != self.epoch[other])
        })
    }
}

//! What happens to each cell, in order: groups of uses that need no dependency among themselves.

use ash::vk::{AccessFlags2 as Mask, ImageLayout, PipelineStageFlags2 as Stages};

use super::dependencies::{Events, Node};
use super::stages::holds;
use super::versions::Versions;
use super::{End, Work};
use crate::graph::description::{Access, Description, Origin, Queue, Resource, ResourceId, Shape, State, VersionId};

/// A moment of the frame: before it, a step, or after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct At(u32);

impl At {
    /// Before the first step.
    pub(super) const START: At = At(0);

    /// After the last step.
    pub(super) const END: At = At(u32::MAX);

    /// During a step.
    pub(super) fn step(step: usize) -> At {
        At(step as u32 + 1)
    }

    /// Its number among all moments of a frame of so many steps.
    pub(super) fn place(self, steps: usize) -> usize {
        (self.0 as usize).min(steps + 1)
    }

    /// The step, where it is one.
    pub(super) fn index(self) -> Option<usize> {
        (self != At::START && self != At::END).then(|| self.0 as usize - 1)
    }
}

/// What is to be done, in order, and where.
pub(super) struct Schedule {
    /// By step.
    pub(super) nodes: Vec<Node>,
    /// By step.
    pub(super) queues: Vec<Queue>,
    /// How many of the nodes' numbers are passes.
    pub(super) passes: usize,
}

impl Schedule {
    /// What a step does.
    pub(super) fn work(&self, step: usize) -> Work {
        match (self.nodes[step] as usize).checked_sub(self.passes) {
            None => Work::Pass(crate::graph::description::PassId(self.nodes[step])),
            Some(root) => Work::ReadBack(root),
        }
    }

    /// The node that does it.
    pub(super) fn node(&self, work: Work) -> usize {
        match work {
            Work::Pass(pass) => pass.0 as usize,
            Work::ReadBack(root) => self.passes + root,
        }
    }
}

/// Uses of one cell in a row: reads of the same contents in the same layout, one write, or unordered writes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    /// First and last use.
    pub(super) first: At,
    pub(super) last: At,
    /// Queue of all of them.
    pub(super) queue: Queue,
    /// Stages and masks of all of them, and their layout.
    pub(super) access: Access,
    /// Whether they write.
    pub(super) write: bool,
    /// Whether the contents before them matter.
    pub(super) reads: bool,
    /// What unordered writers forked from.
    fork: Option<VersionId>,
}

/// Groups of all cells.
pub(super) struct History {
    groups: Vec<Group>,
    /// By cell, then the total.
    first: Vec<u32>,
}

impl History {
    /// From the order of steps.
    pub(super) fn new(description: &Description, versions: &Versions, mut events: Events, schedule: &Schedule) -> Self {
        let mut steps = vec![0; description.passes.len() + description.roots.len()];
        schedule.nodes.iter().enumerate().for_each(|(step, &node)| steps[node as usize] = step as u32);
        // Where steps come as they were recorded, so do uses.
        let moved = !schedule.nodes.is_sorted();
        let cells = events.cells();
        let mut history =
            Self { groups: Vec::with_capacity(events.len()), first: Vec::with_capacity(cells as usize + 1) };
        history.first.push(0);
        for cell in 0..cells {
            let resource = versions.cells.resource(cell);
            let is_image = is_image(&description.resources[resource.0 as usize]);
            let from = history.groups.len();
            history.groups.extend(arrives(description, versions, cell));
            if moved {
                events.sort(cell, |event| steps[event.node as usize]);
            }
            for event in events.of(cell) {
                let step = steps[event.node as usize] as usize;
                let (at, queue) = (At::step(step), schedule.queues[step]);
                let (access, makes, reads) = match (event.node as usize) < description.passes.len() {
                    true => {
                        let used = &description.uses[event.used as usize];
                        (used.access, used.makes, used.reads)
                    }
                    false => (Access::copy_read(), None, true),
                };
                history.push(
                    from,
                    Group {
                        first: at,
                        last: at,
                        queue,
                        access: normal(access, is_image),
                        write: makes.is_some(),
                        reads: reads || makes.is_none(),
                        fork: makes.and_then(|made| versions.fork(made)),
                    },
                );
            }
            if let Some(end) = leaves(description, resource, &history.groups[from..]) {
                history.push(from, end);
            }
            history.first.push(history.groups.len() as u32);
        }
        history
    }

    /// Number of all groups.
    pub(super) fn len(&self) -> usize {
        self.groups.len()
    }

    /// Groups of a cell, in order.
    pub(super) fn of(&self, cell: u32) -> &[Group] {
        &self.groups[self.first[cell as usize] as usize..self.first[cell as usize + 1] as usize]
    }

    /// Puts a use to the last group of its cell where it belongs to it.
    fn push(&mut self, from: usize, group: Group) {
        if let Some(last) = self.groups[from..].last_mut()
            && last.takes(&group)
        {
            last.last = group.last;
            last.access = last.access.merge(group.access);
            last.reads |= group.reads;
        } else {
            self.groups.push(group);
        }
    }
}

impl Group {
    fn takes(&self, next: &Group) -> bool {
        let alike = match (self.write, next.write) {
            (false, false) => self.access.layout == next.access.layout,
            (true, true) => self.fork.is_some() && self.fork == next.fork,
            _ => false,
        };
        // What the frame began with is visible to no more than it says: only reads that it covers belong to it.
        let covered = || !self.write && holds(&self.access, &next.access);
        alike && self.queue == next.queue && (self.first != At::START || covered())
    }
}

/// The state that a cell of an imported or kept resource arrives in.
fn arrives(description: &Description, versions: &Versions, cell: u32) -> Option<Group> {
    let resource = &description.resources[versions.cells.resource(cell).0 as usize];
    let before = match resource.origin {
        Origin::Transient => return None,
        Origin::Imported { before, .. } => before,
        Origin::Kept { .. } => versions.arrival.get(&cell)?.access,
    };
    Some(outside(At::START, normal(before, is_image(resource))))
}

/// The state that an imported or kept resource is to be left in, where that asks for anything: it is left to graphics.
fn leaves(description: &Description, resource: ResourceId, groups: &[Group]) -> Option<Group> {
    let resource = &description.resources[resource.0 as usize];
    // Whoever has imported it waits for the frame; the next plan goes on behind the transfer, which is as a write.
    let taken = Access { stages: Stages::ALL_COMMANDS, mask: Mask::MEMORY_WRITE, ..Access::NONE };
    let (after, taken) = match resource.origin {
        Origin::Transient => return None,
        Origin::Imported { after, .. } => (after, Access::NONE),
        Origin::Kept { after, .. } => (after, taken),
    };
    let last = groups.last()?;
    match after {
        Some(after) => Some(outside(At::END, normal(after, is_image(resource)))),
        None if last.queue == Queue::Graphics => None,
        None => Some(outside(At::END, Access { layout: last.access.layout, ..taken })),
    }
}

/// The states in which the plan leaves imported and kept resources, parts in one state together.
pub(super) fn ends(description: &Description, versions: &Versions, history: &History) -> Vec<End> {
    let mut ends = Vec::new();
    for (index, resource) in description.resources.iter().enumerate() {
        if resource.origin == Origin::Transient {
            continue;
        }
        let id = ResourceId(index as u32);
        let mut alike: Vec<(Access, bool, Vec<u32>)> = Vec::new();
        for cell in versions.cells.of(id) {
            let groups = history.of(cell);
            let Some(last) = groups.last() else { continue };
            let written = groups.iter().any(|group| group.write && group.first.index().is_some());
            let holds = written
                || match resource.origin {
                    Origin::Imported { before, .. } => before.has_contents(&resource.shape),
                    _ => versions.arrival.get(&cell).is_some_and(|state| state.holds),
                };
            match alike.iter_mut().find(|known| (known.0, known.1) == (last.access, holds)) {
                Some((.., cells)) => cells.push(cell),
                None => alike.push((last.access, holds, vec![cell])),
            }
        }
        for (access, holds, cells) in alike {
            let ranges = versions.cells.ranges(&cells).into_iter();
            ends.extend(ranges.map(|range| End { resource: id, state: State { range, access, holds } }));
        }
    }
    ends
}

fn outside(at: At, access: Access) -> Group {
    let write = !access.writes().is_empty();
    Group { first: at, last: at, queue: Queue::Graphics, access, write, reads: true, fork: None }
}

/// Buffers have no layout.
fn normal(access: Access, is_image: bool) -> Access {
    if is_image { access } else { Access { layout: ImageLayout::UNDEFINED, ..access } }
}

fn is_image(resource: &Resource) -> bool {
    matches!(resource.shape, Shape::Image(_))
}

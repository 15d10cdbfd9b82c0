//! Random descriptions that are right: subresources, splits, forks, joins, imports, roots, several queues.

use ash::vk::{self, ImageAspectFlags as Aspects, PipelineStageFlags2 as Stages};
use proptest::prelude::*;
use shadowgraph::graph::ImageShape;
use shadowgraph::graph::description::{
    Access, Description, Origin, Queue, Range, ResourceId, Shape, Source, VersionId,
};

use super::choices::{accesses, halves};
use super::{Draft, MadeUpDevice};

/// Choices from which a description and a device are made. Every value makes a valid one, so shrinking stays valid.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// Queue families: 1 to 3; 4 is two queues of one family.
    pub queues: u8,
    /// Alignments, granularity, memory types.
    pub memory: u8,
    /// A resource each.
    pub resources: Vec<[u8; 4]>,
    /// A pass each, with choices for its uses.
    pub passes: Vec<(u8, Vec<[u8; 5]>)>,
    /// Roots.
    pub roots: Vec<[u8; 2]>,
}

/// Recipes with up to so many passes.
pub fn recipes(passes: usize) -> impl Strategy<Value = Recipe> {
    let resource = any::<[u8; 4]>();
    let pass = (any::<u8>(), prop::collection::vec(any::<[u8; 5]>(), 1..5));
    (
        any::<u8>(),
        any::<u8>(),
        prop::collection::vec(resource, 1..(4 + passes / 3)),
        prop::collection::vec(pass, 1..=passes),
        prop::collection::vec(any::<[u8; 2]>(), 1..5),
    )
        .prop_map(|(queues, memory, resources, passes, roots)| Recipe {
            queues: queues % 5,
            memory,
            resources,
            passes,
            roots,
        })
}

/// The parts of a resource that can be written, with the versions that can.
struct Parts {
    heads: Vec<VersionId>,
    shape: Shape,
}

pub(super) struct Maker {
    pub(super) draft: Draft,
    parts: Vec<Parts>,
    /// Versions that hold something, for late reads and for roots.
    written: Vec<VersionId>,
    passes: usize,
}

impl Recipe {
    /// The device.
    pub fn device(&self) -> MadeUpDevice {
        let families = match self.queues {
            0 | 1 => [Some(0), None, None],
            2 => [Some(0), Some(1), None],
            3 => [Some(0), Some(1), Some(2)],
            _ => [Some(0), Some(0), None],
        };
        MadeUpDevice {
            families,
            // One in eight frames is put into heaps of a few images.
            most_at_once: if self.memory % 8 == 5 { 1 << 18 } else { u64::MAX },
            granularity: [1, 64, 1024, 4096][usize::from(self.memory & 3)],
            image_alignment: [16, 256, 4096, 65536][usize::from(self.memory >> 2 & 3)],
            buffer_alignment: [1, 16, 256, 64][usize::from(self.memory >> 4 & 3)],
            type_bits: [[1, 1, 1], [3, 1, 3], [2, 1, 6], [7, 5, 4]][usize::from(self.memory >> 6 & 3)],
            forbidden: Vec::new(),
        }
    }

    /// The description.
    pub fn description(&self) -> Description {
        let mut maker = Maker::new();
        self.resources.iter().for_each(|choices| maker.resource(*choices));
        self.passes.iter().for_each(|(kind, uses)| maker.step(*kind, uses));
        maker.roots(&self.roots);
        maker.draft.description
    }
}

impl Recipe {
    /// The description, with a checkpoint behind some of its passes.
    pub fn description_with_checkpoints(&self, choices: &[u8]) -> Description {
        let mut maker = Maker::new();
        self.resources.iter().for_each(|choices| maker.resource(*choices));
        for (index, (kind, uses)) in self.passes.iter().enumerate() {
            maker.step(*kind, uses);
            if let Some(choice) = choices.iter().find(|choice| usize::from(**choice) % self.passes.len() == index) {
                maker.checkpoint(*choice);
            }
        }
        maker.roots(&self.roots);
        maker.draft.description
    }
}

const QUEUES: [Queue; 4] = [Queue::Graphics, Queue::Graphics, Queue::Compute, Queue::Transfer];

impl Maker {
    pub(super) fn new() -> Self {
        Self { draft: Draft::new("random"), parts: Vec::new(), written: Vec::new(), passes: 0 }
    }

    pub(super) fn step(&mut self, kind: u8, uses: &[[u8; 5]]) {
        match kind % 16 {
            0..=9 => self.pass(kind, uses),
            10 | 11 => self.split(uses[0]),
            12 => self.join(uses[0]),
            13 => self.forks(uses),
            14 => self.late_read(uses[0]),
            _ => self.side_effect(uses[0]),
        }
    }

    pub(super) fn resource(&mut self, [kind, size, cut, import]: [u8; 4]) {
        let shape = shape([kind, size, cut]);
        let is_image = matches!(shape, Shape::Image(_));
        let origin = match import % 4 {
            0 => {
                let state = |choice| state(choice, is_image);
                let after = Some(state(import >> 4)).filter(|after| import & 64 != 0 && *after != Access::NONE);
                Origin::Imported { before: state(import >> 2), after }
            }
            _ => Origin::Transient,
        };
        let holds = matches!(origin, Origin::Imported { before, .. } if before.has_contents(&shape));
        let name = format!("r{}", self.draft.description.resources.len());
        self.add(&name, shape, origin, holds);
    }

    /// A resource whose first version `holds` something or nothing.
    pub(super) fn add(&mut self, name: &str, shape: Shape, origin: Origin, holds: bool) -> ResourceId {
        let first = self.draft.resource(name, shape.clone(), origin);
        if holds {
            self.written.push(first);
        }
        self.parts.push(Parts { heads: vec![first], shape });
        self.draft.description.versions[first.0 as usize].resource
    }

    fn name(&mut self) -> String {
        self.passes += 1;
        format!("p{}", self.passes)
    }

    fn head(&self, resource: u8, part: u8) -> (usize, usize) {
        let index = usize::from(resource) % self.parts.len();
        (index, usize::from(part) % self.parts[index].heads.len())
    }

    /// An ordinary pass: each use reads or writes a head of a resource that it does not use yet.
    fn pass(&mut self, kind: u8, uses: &[[u8; 5]]) {
        let queue = QUEUES[usize::from(kind >> 4) % 4];
        let name = self.name();
        let mut used: Vec<(usize, usize)> = Vec::new();
        let mut planned = Vec::new();
        for &[resource, part, access, mode, _] in uses {
            let place = self.head(resource, part);
            if used.contains(&place) {
                continue;
            }
            let version = self.parts[place.0].heads[place.1];
            let holds = self.written.contains(&version);
            let shape = &self.parts[place.0].shape;
            let range = self.draft.description.versions[version.0 as usize].range;
            let mode = if holds { mode % 3 } else { 2 };
            let choices = accesses(shape, &range, queue, mode > 0);
            if choices.is_empty() {
                continue;
            }
            used.push(place);
            planned.push((place, version, mode, choices[usize::from(access) % choices.len()]));
        }
        if planned.is_empty() {
            return;
        }
        let made: Vec<_> = self.draft.pass(&name, queue, |pass| {
            let uses = planned.into_iter().enumerate();
            let made = uses.filter_map(|(slot, (place, version, mode, access))| {
                let slot = format!("s{slot}");
                match mode {
                    0 => {
                        pass.read(&slot, version, access);
                        None
                    }
                    1 => Some((place, pass.write(&slot, version, access))),
                    _ => Some((place, pass.overwrite(&slot, version, access))),
                }
            });
            made.collect()
        });
        for ((resource, part), version) in made {
            self.parts[resource].heads[part] = version;
            self.written.push(version);
        }
    }

    /// The host reads a version that holds something. From here on nobody reads what was written over before.
    fn checkpoint(&mut self, choice: u8) {
        if self.written.is_empty() {
            return;
        }
        let version = self.written[usize::from(choice / 3) % self.written.len()];
        let name = format!("c{}", self.draft.description.checkpoints.len());
        self.draft.checkpoint(&name, version);
        let heads: Vec<VersionId> = self.parts.iter().flat_map(|parts| &parts.heads).copied().collect();
        self.written.retain(|version| heads.contains(version));
    }

    /// Takes a head apart.
    fn split(&mut self, [resource, part, way, at, _]: [u8; 5]) {
        let (resource, part) = self.head(resource, part);
        let head = self.parts[resource].heads[part];
        let halves = halves(self.draft.description.versions[head.0 as usize].range, way, at);
        if halves.len() < 2 {
            return;
        }
        let holds = self.written.contains(&head);
        let parts: Vec<_> = halves.into_iter().map(|range| self.draft.split(head, range)).collect();
        if holds {
            self.written.extend(&parts);
        }
        self.parts[resource].heads.splice(part..=part, parts);
    }

    /// Puts all heads of a resource together.
    fn join(&mut self, [resource, ..]: [u8; 5]) {
        let (resource, _) = self.head(resource, 0);
        let heads = self.parts[resource].heads.clone();
        if heads.len() < 2 {
            return;
        }
        let joined = self.draft.join(&heads);
        if heads.iter().all(|head| self.written.contains(head)) {
            self.written.push(joined);
        }
        self.parts[resource].heads = vec![joined];
    }

    /// Unordered writers of a head, and their join.
    fn forks(&mut self, uses: &[[u8; 5]]) {
        let [resource, part, queues, _, _] = uses[0];
        let (resource, part) = self.head(resource, part);
        let head = self.parts[resource].heads[part];
        let range = self.draft.description.versions[head.0 as usize].range;
        let image = matches!(range, Range::Image { .. });
        if let Range::Image { aspects, .. } = range
            && aspects != Aspects::COLOR
        {
            return;
        }
        let forks = self.draft.fork(head, uses.len());
        let holds = self.written.contains(&head);
        let mut made = Vec::new();
        for (index, fork) in forks.into_iter().enumerate() {
            let compute = queues >> index & 1 == 0;
            let (queue, stages) = match compute {
                true => (Queue::Compute, Stages::COMPUTE_SHADER),
                false => (Queue::Graphics, Stages::FRAGMENT_SHADER),
            };
            let access = match image {
                true => Access::storage_image_read_write(stages),
                false => Access::storage_buffer_read_write(stages),
            };
            let name = self.name();
            made.push(self.draft.pass(&name, queue, |pass| match holds {
                true => pass.write("append", fork, access),
                false => pass.overwrite("append", fork, access),
            }));
        }
        let joined = self.draft.join(&made);
        self.parts[resource].heads[part] = joined;
        self.written.push(joined);
    }

    /// A pass recorded late that reads an old version, and so must run before those that wrote over it.
    fn late_read(&mut self, [which, access, queue, size, _]: [u8; 5]) {
        if self.written.is_empty() {
            return;
        }
        let version = self.written[usize::from(which) % self.written.len()];
        let known = &self.draft.description.versions[version.0 as usize];
        // A join of old and new parts may never be there all at once.
        if matches!(known.source, Source::Join { .. }) {
            return;
        }
        let queue = QUEUES[usize::from(queue) % 4];
        let shape = self.draft.description.resources[known.resource.0 as usize].shape.clone();
        let choices = accesses(&shape, &known.range, queue, false);
        if choices.is_empty() {
            return;
        }
        let access = choices[usize::from(access) % choices.len()];
        let buffer = self.draft.buffer(&format!("late{}", self.passes), 16 + u64::from(size));
        let name = self.name();
        let made = self.draft.pass(&name, queue, |pass| {
            pass.read("old", version, access);
            pass.overwrite("new", buffer, Access::transfer_write())
        });
        self.written.push(made);
        let shape = Shape::Buffer { size: 16 + u64::from(size) };
        self.parts.push(Parts { heads: vec![made], shape });
    }

    fn side_effect(&mut self, [resource, part, access, queue, _]: [u8; 5]) {
        let (resource, part) = self.head(resource, part);
        let head = self.parts[resource].heads[part];
        let range = self.draft.description.versions[head.0 as usize].range;
        let queue = QUEUES[usize::from(queue) % 4];
        let choices = accesses(&self.parts[resource].shape, &range, queue, false);
        if choices.is_empty() || !self.written.contains(&head) {
            return;
        }
        let access = choices[usize::from(access) % choices.len()];
        let name = self.name();
        self.draft.pass(&name, queue, |pass| pass.read("it", head, access));
        if let Some(pass) = self.draft.description.passes.last_mut() {
            pass.side_effect = Some("tells somebody".into());
        }
    }

    /// Captures of any version, and heads that are kept.
    pub(super) fn roots(&mut self, roots: &[[u8; 2]]) {
        for (index, &[which, keep]) in roots.iter().enumerate() {
            let heads: Vec<VersionId> = self.parts.iter().flat_map(|parts| &parts.heads).copied().collect();
            let kept: Vec<VersionId> = heads.into_iter().filter(|head| self.written.contains(head)).collect();
            let name = format!("root{index}");
            if keep % 4 == 0 && !kept.is_empty() {
                self.draft.keep(&name, kept[usize::from(which) % kept.len()]);
            } else if !self.written.is_empty() {
                // Late versions more often, so that less is culled.
                let back = usize::from(which) % self.written.len().min(8);
                self.draft.capture(&name, self.written[self.written.len() - 1 - back]);
            }
        }
    }
}

/// A small image or buffer.
pub(super) fn shape([kind, size, cut]: [u8; 3]) -> Shape {
    let format = match kind % 8 {
        0 | 1 => Some(vk::Format::R8G8B8A8_UNORM),
        2 => Some(vk::Format::R32_UINT),
        3 => Some(vk::Format::D32_SFLOAT),
        4 => Some(vk::Format::D32_SFLOAT_S8_UINT),
        _ => None,
    };
    match format {
        Some(format) => {
            let extent = [8 << (size % 4), 8 << (size / 4 % 3), 1];
            let (mips, layers) = (1 + u32::from(cut % 3), 1 + u32::from(cut / 3 % 3));
            Shape::Image(ImageShape { format, extent, mips, layers, samples: 1 })
        }
        None => Shape::Buffer { size: 16 + 64 * u64::from(size) },
    }
}

/// A state that a resource arrives or is left in.
pub(super) fn state(choice: u8, is_image: bool) -> Access {
    match (choice % 4, is_image) {
        (0, true) => Access::storage_image_read_write(Stages::COMPUTE_SHADER),
        (1, true) => Access::sampled(Stages::FRAGMENT_SHADER),
        (2, true) => Access::transfer_write(),
        (0, false) => Access::storage_buffer_read_write(Stages::COMPUTE_SHADER),
        (1, false) => Access::uniform(Stages::VERTEX_SHADER),
        (2, false) => Access::transfer_write(),
        _ => Access::NONE,
    }
}

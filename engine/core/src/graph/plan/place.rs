//! Where transients lie: which share a heap, where each lies in it, and whose memory it takes over.

use super::lifetimes::Lifetimes;
use super::lists::Lists;
use super::pack::{Block, Lives, pack};
use super::{DeviceModel, Heap, Placement, Requirements};
use crate::graph::description::{Description, ResourceId, Shape};

/// Placements with what lay there before.
#[derive(Default)]
pub(super) struct Placed {
    /// By resource.
    pub(super) placements: Vec<Placement>,
    pub(super) heaps: Vec<Heap>,
    /// By resource: those whose memory it takes over, ascending.
    pub(super) earlier: Lists<ResourceId>,
    /// Sum of the heaps' lower bounds.
    pub(super) lower_bound: u64,
    /// Bytes if nothing shared memory.
    pub(super) unaliased: u64,
}

impl Placed {
    /// Those whose memory a resource takes over.
    pub(super) fn earlier(&self, resource: ResourceId) -> &[ResourceId] {
        self.earlier.of(resource.0 as usize)
    }
}

/// A resource to place.
struct Item {
    resource: ResourceId,
    /// What the device asks for.
    bytes: u64,
}

/// Places all transients that are used. `requirements`: by resource.
pub(super) fn place(
    description: &Description,
    device: &dyn DeviceModel,
    requirements: &[Option<Requirements>],
    lifetimes: &Lifetimes,
) -> Placed {
    let (mut placed, mut earlier) = (Placed::default(), Vec::new());
    let mut groups = by_memory_type(requirements, lifetimes);
    groups.reverse();
    while let Some((type_bits, mut resources)) = groups.pop() {
        let (items, blocks) = items(description, device.granularity(), requirements, lifetimes, &resources);
        let lives = Lives::new(&blocks);
        let lower_bound = lower_bound(&items, &lives);
        let conflict = |earlier: usize, later: usize| !lifetimes.before(items[earlier].resource, items[later].resource);
        let offsets = pack(&blocks, &lives, lower_bound, (!lifetimes.one_queue()).then_some(&conflict));
        let heap = placed.heaps.len();
        let end = blocks.iter().zip(&offsets).map(|(block, offset)| offset + block.size).max().unwrap_or(0);
        // More than the device allocates at once becomes two heaps, each of about half of the bytes.
        if end > device.most_at_once() && resources.len() > 1 {
            let half = items.iter().map(|item| item.bytes).sum::<u64>() / 2;
            let mut before = 0;
            let first = items.iter().take_while(|item| {
                before += item.bytes;
                before <= half
            });
            let rest = resources.split_off(first.count().clamp(1, items.len() - 1));
            groups.extend([(type_bits, rest), (type_bits, resources)]);
            continue;
        }
        let alignment = blocks.iter().map(|block| block.alignment).max().unwrap_or(1);
        placed.heaps.push(Heap { size: end, alignment, type_bits });
        placed.lower_bound += lower_bound;
        placed.unaliased += items.iter().map(|item| item.bytes).sum::<u64>();
        tenants(&items, &blocks, &lives, &offsets, &mut earlier);
        placed.placements.reserve_exact(items.len());
        for ((item, block), &offset) in items.iter().zip(&blocks).zip(&offsets) {
            let steps = block.steps.map(|step| step as usize);
            placed.placements.push(Placement { resource: item.resource, heap, offset, size: item.bytes, steps });
        }
    }
    if placed.heaps.len() > 1 {
        placed.placements.sort_unstable_by_key(|placement| placement.resource);
    }
    if !earlier.is_sorted_by(|a, b| a < b) {
        earlier.sort_unstable();
        earlier.dedup();
    }
    let pairs = earlier.iter().map(|&[resource, earlier]: &[ResourceId; 2]| (resource.0 as usize, earlier));
    Placed { earlier: Lists::new(requirements.len(), pairs), ..placed }
}

/// Resources that can lie in one heap, with the memory types that suit all of them.
fn by_memory_type(requirements: &[Option<Requirements>], lifetimes: &Lifetimes) -> Vec<(u32, Vec<ResourceId>)> {
    let mut heaps: Vec<(u32, Vec<ResourceId>)> = Vec::new();
    for (index, requirements) in requirements.iter().enumerate() {
        let resource = ResourceId(index as u32);
        let Some(requirements) = requirements.filter(|_| lifetimes.span(resource).is_some()) else { continue };
        match heaps.iter_mut().find(|(bits, _)| bits & requirements.type_bits != 0) {
            Some((bits, resources)) => {
                *bits &= requirements.type_bits;
                resources.push(resource);
            }
            None => heaps.push((requirements.type_bits, vec![resource])),
        }
    }
    heaps
}

fn items(
    description: &Description,
    granularity: u64,
    requirements: &[Option<Requirements>],
    lifetimes: &Lifetimes,
    resources: &[ResourceId],
) -> (Vec<Item>, Vec<Block>) {
    let is_image = |id: &&ResourceId| matches!(description.resources[id.0 as usize].shape, Shape::Image(_));
    let mixed = granularity > 1 && {
        let images = resources.iter().filter(is_image).count();
        images > 0 && images < resources.len()
    };
    let granularity = if mixed { granularity } else { 1 };
    let (mut items, mut blocks) = (Vec::with_capacity(resources.len()), Vec::with_capacity(resources.len()));
    for &resource in resources {
        let Some((needs, steps)) = requirements[resource.0 as usize].zip(lifetimes.span(resource)) else { continue };
        let size = needs.size.max(1);
        let size = if mixed { size.next_multiple_of(granularity) } else { size };
        items.push(Item { resource, bytes: needs.size });
        blocks.push(Block { size, alignment: needs.alignment.max(granularity), steps });
    }
    (items, blocks)
}

/// The most bytes alive at once.
fn lower_bound(items: &[Item], lives: &Lives) -> u64 {
    let bytes = |indices: &[u32]| indices.iter().map(|&index| items[index as usize].bytes).sum::<u64>();
    let (mut alive, mut most) = (0, 0);
    for step in 0..lives.begin.count() {
        alive += bytes(lives.begin.of(step));
        most = most.max(alive);
        alive -= bytes(lives.end.of(step));
    }
    most
}

/// Finds out whose memory each item takes over, byte by byte the last one that had it.
fn tenants(items: &[Item], blocks: &[Block], lives: &Lives, offsets: &[u64], earlier: &mut Vec<[ResourceId; 2]>) {
    // Memory by its start: where it begins and ends, and who had it last.
    let mut memory: Vec<(u64, u64, ResourceId)> = Vec::with_capacity(items.len());
    earlier.reserve(items.len());
    for &index in lives.begin.all() {
        let resource = items[index as usize].resource;
        let start = offsets[index as usize];
        let end = start + blocks[index as usize].size;
        let first = memory.partition_point(|part| part.1 <= start);
        let last = first + memory[first..].iter().take_while(|part| part.0 < end).count();
        earlier.extend(memory[first..last].iter().map(|part| [resource, part.2]));
        match &mut memory[first..last] {
            [one] if one.0 == start && one.1 == end => one.2 = resource,
            parts => {
                let left = parts.first().filter(|part| part.0 < start).map(|part| (part.0, start, part.2));
                let right = parts.last().filter(|part| part.1 > end).map(|part| (end, part.1, part.2));
                memory.splice(first..last, left.into_iter().chain([(start, end, resource)]).chain(right));
            }
        }
    }
}

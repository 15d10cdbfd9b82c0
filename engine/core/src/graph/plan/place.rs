//! Where transients lie: which share a heap, where each lies in it, and whose memory it takes over.

use std::collections::BTreeMap;

use super::lifetimes::Lifetimes;
use super::pack::{Block, pack};
use super::{DeviceModel, Heap, Placement, Requirements};
use crate::graph::description::{Description, ResourceId, Shape};

/// Placements with what lay there before.
#[derive(Default)]
pub(super) struct Placed {
    /// By resource.
    pub(super) placements: Vec<Placement>,
    pub(super) heaps: Vec<Heap>,
    /// Resources, each with those whose memory it takes over; ascending.
    earlier: Vec<[ResourceId; 2]>,
    /// Sum of the heaps' lower bounds.
    pub(super) lower_bound: u64,
    /// Bytes if nothing shared memory.
    pub(super) unaliased: u64,
}

impl Placed {
    /// Those whose memory a resource takes over.
    pub(super) fn earlier(&self, resource: ResourceId) -> impl Iterator<Item = ResourceId> {
        let first = self.earlier.partition_point(|pair| pair[0] < resource);
        self.earlier[first..].iter().take_while(move |pair| pair[0] == resource).map(|pair| pair[1])
    }
}

/// A resource to place.
struct Item {
    resource: ResourceId,
    /// Its size is a multiple of the granularity where that matters.
    block: Block,
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
    let mut placed = Placed::default();
    for (type_bits, resources) in by_memory_type(requirements, lifetimes) {
        let items = items(description, device.granularity(), requirements, lifetimes, &resources);
        let lower_bound = lower_bound(&items);
        let blocks: Vec<Block> = items.iter().map(|item| item.block).collect();
        let conflict = |earlier: usize, later: usize| !lifetimes.before(items[earlier].resource, items[later].resource);
        let offsets = pack(&blocks, lower_bound, (!lifetimes.one_queue()).then_some(&conflict));
        let heap = placed.heaps.len();
        let end = items.iter().zip(&offsets).map(|(item, offset)| offset + item.block.size).max().unwrap_or(0);
        let alignment = items.iter().map(|item| item.block.alignment).max().unwrap_or(1);
        placed.heaps.push(Heap { size: end, alignment, type_bits });
        placed.lower_bound += lower_bound;
        placed.unaliased += items.iter().map(|item| item.bytes).sum::<u64>();
        tenants(&items, &offsets, &mut placed.earlier);
        placed.placements.extend(items.iter().zip(&offsets).map(|(item, &offset)| Placement {
            resource: item.resource,
            heap,
            offset,
            size: item.bytes,
            steps: item.block.steps,
        }));
    }
    placed.placements.sort_unstable_by_key(|placement| placement.resource);
    placed.earlier.sort_unstable();
    placed.earlier.dedup();
    placed
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
) -> Vec<Item> {
    let is_image = |id: &&ResourceId| matches!(description.resources[id.0 as usize].shape, Shape::Image(_));
    let images = resources.iter().filter(is_image).count();
    let mixed = images > 0 && images < resources.len();
    let granularity = if mixed { granularity.max(1) } else { 1 };
    let item = |&resource: &ResourceId| {
        let needs = requirements[resource.0 as usize]?;
        Some(Item {
            resource,
            block: Block {
                size: needs.size.max(1).next_multiple_of(granularity),
                alignment: needs.alignment.max(1).max(granularity),
                steps: lifetimes.span(resource)?,
            },
            bytes: needs.size,
        })
    };
    resources.iter().filter_map(item).collect()
}

/// The most bytes alive at once.
fn lower_bound(items: &[Item]) -> u64 {
    let births = items.iter().map(|item| (item.block.steps[0], 1, item.bytes));
    let deaths = items.iter().map(|item| (item.block.steps[1] + 1, 0, item.bytes));
    let mut changes: Vec<_> = births.chain(deaths).collect();
    // Both are in order for most frames, and are only merged.
    changes.sort();
    let mut alive = 0;
    changes.iter().fold(0, |most, &(_, birth, bytes)| {
        alive = if birth == 1 { alive + bytes } else { alive - bytes };
        most.max(alive)
    })
}

/// Finds out whose memory each item takes over, byte by byte the last one that had it.
fn tenants(items: &[Item], offsets: &[u64], earlier: &mut Vec<[ResourceId; 2]>) {
    let mut order: Vec<usize> = (0..items.len()).collect();
    order.sort_by_key(|&i| (items[i].block.steps[0], items[i].resource));
    // Memory by its start: where it ends and who had it last.
    let mut memory: BTreeMap<u64, (u64, ResourceId)> = BTreeMap::new();
    let mut overlapped = Vec::new();
    for index in order {
        let item = &items[index];
        let (start, end) = (offsets[index], offsets[index] + item.block.size);
        let before = memory.range(..end).rev().take_while(|(_, (stop, _))| *stop > start);
        overlapped.clear();
        overlapped.extend(before.map(|(&first, &(stop, who))| (first, stop, who)));
        for &(first, stop, who) in &overlapped {
            memory.remove(&first);
            if first < start {
                memory.insert(first, (start, who));
            }
            if stop > end {
                memory.insert(end, (stop, who));
            }
            earlier.push([item.resource, who]);
        }
        memory.insert(start, (end, item.resource));
    }
}

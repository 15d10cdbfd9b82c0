//! Where transients lie: an interval-packing problem, in memory over time.
//!
//! Resources are placed one by one at the lowest offset that is free for all of their life (first fit). How well that
//! does depends on the order, so several are tried (largest first, longest first, earliest first, most bytes times
//! steps first), and then resources at the top of the best placement are drawn to the front, a few times. It stops
//! where the lower bound is reached.

use std::collections::BTreeMap;

use super::lifetimes::Lifetimes;
use super::{DeviceModel, Heap, Placement, Requirements};
use crate::graph::description::{Description, ResourceId, Shape};

/// Resources of one heap up to which more than one order is tried: trying costs time, squared.
const TRY_UP_TO: usize = 512;

/// How often the top is drawn to the front.
const ROUNDS: usize = 24;

/// Placements with what lay there before.
#[derive(Default)]
pub(super) struct Placed {
    /// By resource.
    pub(super) placements: Vec<Placement>,
    pub(super) heaps: Vec<Heap>,
    /// By resource: those whose memory it takes over.
    pub(super) earlier: Vec<Vec<ResourceId>>,
    /// Sum of the heaps' lower bounds.
    pub(super) lower_bound: u64,
    /// Bytes if nothing shared memory.
    pub(super) unaliased: u64,
}

/// A resource to place.
struct Item {
    resource: ResourceId,
    /// A multiple of the granularity where it matters.
    size: u64,
    alignment: u64,
    steps: [usize; 2],
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
    let mut placed = Placed { earlier: vec![Vec::new(); description.resources.len()], ..Placed::default() };
    for (type_bits, resources) in by_memory_type(requirements, lifetimes) {
        let items = items(description, device.granularity(), requirements, lifetimes, &resources);
        let lower_bound = lower_bound(&items);
        let apart = |a: usize, b: usize| {
            let ([first, last], [other, end]) = (items[a].steps, items[b].steps);
            if lifetimes.one_queue() {
                return last < other || end < first;
            }
            let (a, b) = (items[a].resource, items[b].resource);
            (last < other && lifetimes.before(a, b)) || (end < first && lifetimes.before(b, a))
        };
        let offsets = pack(&items, lower_bound, lifetimes.one_queue(), apart);
        let heap = placed.heaps.len();
        let end = items.iter().zip(&offsets).map(|(item, offset)| offset + item.size).max().unwrap_or(0);
        let alignment = items.iter().map(|item| item.alignment).max().unwrap_or(1);
        placed.heaps.push(Heap { size: end, alignment, type_bits });
        placed.lower_bound += lower_bound;
        placed.unaliased += items.iter().map(|item| item.bytes).sum::<u64>();
        tenants(&items, &offsets, &mut placed.earlier);
        placed.placements.extend(items.iter().zip(&offsets).map(|(item, &offset)| Placement {
            resource: item.resource,
            heap,
            offset,
            size: item.bytes,
            steps: item.steps,
        }));
    }
    placed.placements.sort_unstable_by_key(|placement| placement.resource);
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
            size: needs.size.max(1).next_multiple_of(granularity),
            alignment: needs.alignment.max(1).max(granularity),
            steps: lifetimes.span(resource)?,
            bytes: needs.size,
        })
    };
    resources.iter().filter_map(item).collect()
}

/// The most bytes alive at once.
fn lower_bound(items: &[Item]) -> u64 {
    let births = items.iter().map(|item| (item.steps[0], 1, item.bytes));
    let deaths = items.iter().map(|item| (item.steps[1] + 1, 0, item.bytes));
    let mut changes: Vec<_> = births.chain(deaths).collect();
    changes.sort_unstable();
    let mut alive = 0;
    changes.iter().fold(0, |most, &(_, birth, bytes)| {
        alive = if birth == 1 { alive + bytes } else { alive - bytes };
        most.max(alive)
    })
}

/// Offsets of all items. `apart`: whether two of them may share memory; with one queue, where they live at
/// different times.
fn pack(items: &[Item], lower_bound: u64, one_queue: bool, apart: impl Fn(usize, usize) -> bool) -> Vec<u64> {
    let duration = |i: &usize| (items[*i].steps[1] - items[*i].steps[0] + 1) as u128;
    // By two keys, the largest first.
    let sorted = |key: &dyn Fn(&usize) -> [u128; 2]| {
        let mut order: Vec<usize> = (0..items.len()).collect();
        order.sort_by_key(|item| std::cmp::Reverse(key(item)));
        order
    };
    let size = |i: &usize| u128::from(items[*i].size);
    let earliest = |i: &usize| [u128::MAX - items[*i].steps[0] as u128, size(i)];
    let mut best = first_fit(items, &sorted(&earliest), one_queue, &apart);
    if items.len() > TRY_UP_TO || best.0 <= lower_bound {
        return best.1;
    }
    let orders: [&dyn Fn(&usize) -> _; 3] =
        [&|i| [size(i), duration(i)], &|i| [size(i) * duration(i), size(i)], &|i| [duration(i), size(i)]];
    let mut front = sorted(&earliest);
    for order in orders.iter().map(|key| sorted(key)) {
        let next = first_fit(items, &order, false, &apart);
        if next.0 < best.0 {
            (best, front) = (next, order);
        }
    }
    let (mut end, mut offsets) = best.clone();
    for _ in 0..ROUNDS {
        if best.0 <= lower_bound {
            break;
        }
        let (top, rest): (Vec<usize>, Vec<usize>) = front.iter().partition(|&&i| offsets[i] + items[i].size == end);
        front = [top, rest].concat();
        (end, offsets) = first_fit(items, &front, false, &apart);
        if end < best.0 {
            best = (end, offsets.clone());
        }
    }
    best.1
}

/// Places items in this order, each at the lowest offset that is free of those it may not share memory with. Gives
/// the end of the last byte, and the offsets. `sweep`: items come in the order of their first steps, so that those
/// whose last step is over need not be looked at again.
fn first_fit(items: &[Item], order: &[usize], sweep: bool, apart: impl Fn(usize, usize) -> bool) -> (u64, Vec<u64>) {
    let mut offsets = vec![0; items.len()];
    // By offset.
    let mut placed: Vec<usize> = Vec::with_capacity(items.len());
    let mut end = 0;
    for &index in order {
        let item = &items[index];
        if sweep {
            placed.retain(|&other| items[other].steps[1] >= item.steps[0]);
        }
        let mut offset: u64 = 0;
        for &other in placed.iter().filter(|&&other| !apart(index, other)) {
            if offset + item.size <= offsets[other] {
                break;
            }
            offset = offset.max((offsets[other] + items[other].size).next_multiple_of(item.alignment));
        }
        offsets[index] = offset;
        end = end.max(offset + item.size);
        let place = placed.partition_point(|&other| offsets[other] <= offset);
        placed.insert(place, index);
    }
    (end, offsets)
}

/// Finds out whose memory each item takes over, byte by byte the last one that had it.
fn tenants(items: &[Item], offsets: &[u64], earlier: &mut [Vec<ResourceId>]) {
    let mut order: Vec<usize> = (0..items.len()).collect();
    order.sort_by_key(|&i| (items[i].steps[0], items[i].resource));
    // Memory by its start: where it ends and who had it last.
    let mut memory: BTreeMap<u64, (u64, ResourceId)> = BTreeMap::new();
    for index in order {
        let item = &items[index];
        let (start, end) = (offsets[index], offsets[index] + item.size);
        let before = memory.range(..end).rev().take_while(|(_, (stop, _))| *stop > start);
        let overlapped: Vec<_> = before.map(|(&first, &(stop, who))| (first, stop, who)).collect();
        let known = &mut earlier[item.resource.0 as usize];
        for (first, stop, who) in overlapped {
            memory.remove(&first);
            if first < start {
                memory.insert(first, (start, who));
            }
            if stop > end {
                memory.insert(end, (stop, who));
            }
            known.push(who);
        }
        known.sort_unstable();
        known.dedup();
        memory.insert(start, (end, item.resource));
    }
}

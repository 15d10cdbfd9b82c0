//! Packs blocks that live for some steps each into as little memory as can be found: dynamic storage allocation, which
//! is hard to solve, and easy to solve well.
//!
//! 1. Sweeps over time, forwards and backwards, give each block the first or the tightest gap that is free at its first
//!    step. They cost next to nothing, and do for chains of passes.
//! 2. Blocks are put down one by one, each at the lowest place that is free for all of its life: the largest first, the
//!    longest-lived first, and so on.
//! 3. In the best of these orders, the block that sticks out at the top is drawn forward, again and again.
//!
//! It stops where the lower bound is reached, or a fixed amount of work is done. No clock and no chance decides: the
//! same blocks come to lie at the same places.

use std::cmp::Reverse;

use super::lists::Lists;

/// A block to place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub(super) size: u64,
    pub(super) alignment: u64,
    /// First and last step of its life.
    pub(super) steps: [u32; 2],
}

/// How many pairs of blocks the search looks at, all in all: a millisecond or two.
const WORK: usize = 1 << 18;

/// How many of the best orders it starts from, and how long it goes on without finding anything better.
const STARTS: usize = 3;
const PATIENCE: usize = 100;

/// How many pairs of blocks may be in each other's way for the search to begin.
const MOST_PAIRS: usize = 1 << 20;

/// Where blocks lie, and where the last one ends.
#[derive(Clone, Debug, Default)]
struct Packing {
    end: u64,
    offsets: Vec<u64>,
}

/// Offsets of all blocks. `bound`: no packing is smaller. `conflict`: whether two blocks whose lives do not overlap may
/// not share memory all the same; `None` where there are no such.
pub(super) fn pack(
    blocks: &[Block],
    lives: &Lives,
    bound: u64,
    conflict: Option<&dyn Fn(usize, usize) -> bool>,
) -> Vec<u64> {
    // 1. Sweep over time.
    let mut best = Packing { end: u64::MAX, offsets: Vec::new() };
    if conflict.is_none() {
        for (backwards, tightest) in [(false, false), (true, false), (false, true), (true, true)] {
            let next = sweep(blocks, lives, backwards, tightest);
            best = if next.end < best.end { next } else { best };
            if best.end <= bound {
                return best.offsets;
            }
        }
    }

    // 2. Try orders.
    let Some(conflicts) = Conflicts::new(blocks, conflict) else { return best.offsets };
    let mut orders: Vec<(u64, Vec<u32>)> = Vec::new();
    for order in orders_to_try(blocks) {
        let next = conflicts.first_fit(blocks, &order);
        orders.push((next.end, order));
        best = if next.end < best.end { next } else { best };
        if best.end <= bound {
            return best.offsets;
        }
    }
    orders.sort_by_key(|(end, _)| *end);
    orders.truncate(STARTS);

    // 3. Improve on them.
    search(blocks, &conflicts, &orders, bound, best).offsets
}

/// Blocks by the steps at which their lives begin and end, the largest first.
pub(super) struct Lives {
    pub(super) begin: Lists<u32>,
    pub(super) end: Lists<u32>,
}

impl Lives {
    pub(super) fn new(blocks: &[Block]) -> Self {
        let steps = blocks.iter().map(|block| block.steps[1] as usize + 1).max().unwrap_or(0);
        let [mut begin, mut end] = [0, 1].map(|side| by_step(blocks, steps, side));
        if blocks.iter().any(|block| block.size != blocks[0].size) {
            sort_by_size(&mut begin, blocks);
            sort_by_size(&mut end, blocks);
        }
        Self { begin, end }
    }
}

/// Blocks by their first step, or by their last one (`side` 1), of so many steps.
fn by_step(blocks: &[Block], steps: usize, side: usize) -> Lists<u32> {
    Lists::new(steps, (0..).zip(blocks).map(|(index, block)| (block.steps[side] as usize, index)))
}

fn sort_by_size(lists: &mut Lists<u32>, blocks: &[Block]) {
    for step in 0..lists.count() {
        lists.of_mut(step).sort_unstable_by_key(|&index| (Reverse(blocks[index as usize].size), index));
    }
}

/// Places blocks as they come to life, in what is free at that time. Backwards, lives begin at their ends.
fn sweep(blocks: &[Block], lives: &Lives, backwards: bool, tightest: bool) -> Packing {
    let (births, deaths) = if backwards { (&lives.end, &lives.begin) } else { (&lives.begin, &lives.end) };
    let mut free = Free { gaps: vec![[0, u64::MAX]] };
    let mut packing = Packing { end: 0, offsets: vec![0; blocks.len()] };
    let steps = births.count();
    for step in 0..steps {
        let step = if backwards { steps - 1 - step } else { step };
        for &index in births.of(step) {
            let block = &blocks[index as usize];
            let offset = free.take(block.size, block.alignment, tightest);
            packing.offsets[index as usize] = offset;
            packing.end = packing.end.max(offset + block.size);
        }
        for &index in deaths.of(step) {
            let start = packing.offsets[index as usize];
            free.give([start, start + blocks[index as usize].size]);
        }
    }
    packing
}

/// Memory that is free: gaps in ascending order, the last of which has no end.
struct Free {
    gaps: Vec<[u64; 2]>,
}

/// The next multiple of an alignment, mostly a power of two: dividing takes longer.
fn aligned(offset: u64, alignment: u64) -> u64 {
    match alignment.is_power_of_two() {
        true => (offset + (alignment - 1)) & !(alignment - 1),
        false => offset.next_multiple_of(alignment),
    }
}

impl Free {
    fn take(&mut self, size: u64, alignment: u64, tightest: bool) -> u64 {
        let start = |gap: &[u64; 2]| aligned(gap[0], alignment);
        let mut fitting =
            self.gaps.iter().enumerate().filter(|(_, gap)| gap[1] - gap[0] >= size && gap[1] - size >= start(gap));
        let found = if tightest { fitting.min_by_key(|(_, gap)| gap[1] - gap[0]) } else { fitting.next() };
        // The last gap holds anything that is smaller than all memory.
        let Some((place, &[first, end])) = found else { return 0 };
        let offset = start(&[first, end]);
        match (first < offset, offset + size < end) {
            (false, false) => {
                self.gaps.remove(place);
            }
            (false, true) => self.gaps[place][0] = offset + size,
            (true, false) => self.gaps[place][1] = offset,
            (true, true) => {
                self.gaps[place][1] = offset;
                self.gaps.insert(place + 1, [offset + size, end]);
            }
        }
        offset
    }

    fn give(&mut self, [first, end]: [u64; 2]) {
        let place = self.gaps.partition_point(|gap| gap[0] < first);
        let joins_before = place > 0 && self.gaps[place - 1][1] == first;
        let joins_after = self.gaps.get(place).is_some_and(|after| after[0] == end);
        match (joins_before, joins_after) {
            (true, true) => self.gaps[place - 1][1] = self.gaps.remove(place)[1],
            (true, false) => self.gaps[place - 1][1] = end,
            (false, true) => self.gaps[place][0] = first,
            (false, false) => self.gaps.insert(place, [first, end]),
        }
    }
}

/// Which blocks may not share memory with which.
struct Conflicts(Lists<u32>);

impl Conflicts {
    /// `None` where there are too many pairs to look at.
    fn new(blocks: &[Block], conflict: Option<&dyn Fn(usize, usize) -> bool>) -> Option<Self> {
        let mut births: Vec<usize> = (0..blocks.len()).collect();
        births.sort_unstable_by_key(|&index| blocks[index].steps[0]);
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        for (place, &one) in births.iter().enumerate() {
            for &other in &births[place + 1..] {
                let overlap = blocks[other].steps[0] <= blocks[one].steps[1];
                match conflict {
                    None if !overlap => break,
                    Some(conflict) if !overlap && !conflict(one, other) => continue,
                    _ => pairs.extend([[one as u32, other as u32], [other as u32, one as u32]]),
                }
            }
            if pairs.len() > MOST_PAIRS && conflict.is_none() {
                return None;
            }
        }
        pairs.sort_unstable();
        Some(Self(Lists::new(blocks.len(), pairs.iter().map(|&[one, other]| (one as usize, other)))))
    }

    fn of(&self, block: u32) -> &[u32] {
        self.0.of(block as usize)
    }

    /// Places blocks in this order, each as low as those before it allow.
    fn first_fit(&self, blocks: &[Block], order: &[u32]) -> Packing {
        let mut packing = Packing { end: 0, offsets: vec![u64::MAX; blocks.len()] };
        let mut taken: Vec<[u64; 2]> = Vec::new();
        for &index in order {
            let block = &blocks[index as usize];
            taken.clear();
            for &other in self.of(index) {
                let start = packing.offsets[other as usize];
                if start != u64::MAX {
                    taken.push([start, start + blocks[other as usize].size]);
                }
            }
            taken.sort_unstable();
            let mut offset: u64 = 0;
            for &[start, end] in &taken {
                if offset + block.size <= start {
                    break;
                }
                offset = offset.max(aligned(end, block.alignment));
            }
            packing.offsets[index as usize] = offset;
            packing.end = packing.end.max(offset + block.size);
        }
        packing
    }
}

/// Orders by two keys each, the largest first.
fn orders_to_try(blocks: &[Block]) -> impl Iterator<Item = Vec<u32>> {
    let key = |block: &Block, way: usize| -> [u128; 2] {
        let size = u128::from(block.size);
        let duration = u128::from(block.steps[1] - block.steps[0] + 1);
        match way {
            0 => [size, duration],
            1 => [size * duration, size],
            2 => [duration, size],
            3 => [block.alignment.into(), size],
            4 => [u128::MAX - u128::from(block.steps[0]), size],
            _ => [block.steps[1].into(), size],
        }
    };
    (0..6).map(move |way| {
        let mut order: Vec<u32> = (0..blocks.len() as u32).collect();
        order.sort_by_key(|&index| std::cmp::Reverse(key(&blocks[index as usize], way)));
        order
    })
}

/// Draws blocks at the top forward in the order, from the best orders on in turn, and keeps what is no worse.
fn search(
    blocks: &[Block],
    conflicts: &Conflicts,
    orders: &[(u64, Vec<u32>)],
    bound: u64,
    mut best: Packing,
) -> Packing {
    let rounds = WORK / (conflicts.0.all().len() + blocks.len()).max(1) / orders.len().max(1);
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for (_, order) in orders {
        let mut order = order.clone();
        let mut now = conflicts.first_fit(blocks, &order);
        let mut idle = 0;
        for _ in 0..rounds {
            idle += 1;
            if best.end <= bound {
                return best;
            }
            if idle > PATIENCE {
                break;
            }
            let is_top = |&index: &u32| now.offsets[index as usize] + blocks[index as usize].size == now.end;
            let Some(place) = order.iter().position(is_top) else { break };
            let to = random.below(place + 1);
            let mut tried = order.clone();
            // Half of the time it changes places, else it goes before.
            if random.below(2) == 0 {
                tried.swap(place, to);
            } else {
                tried[to..=place].rotate_right(1);
            }
            let next = conflicts.first_fit(blocks, &tried);
            if next.end < best.end {
                best = next.clone();
            }
            if next.end <= now.end {
                idle = if next.end < now.end { 0 } else { idle };
                (now, order) = (next, tried);
            }
        }
    }
    best
}

/// Numbers that look random, and are the same each time.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end.max(1) as u64) as usize
    }
}

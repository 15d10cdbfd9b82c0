//! Cells: the parts of resources that planning tells apart. Two ranges of a resource share either all of a cell or
//! nothing, so hazards, layouts and lifetimes are per cell.

use std::ops::Range as Span;

use ash::vk::ImageAspectFlags as Aspects;

use crate::graph::description::{Description, Origin, Range, ResourceId, Shape};

/// Cells of all resources, and which of them each version covers.
pub(super) struct Cells {
    /// By resource: all of it.
    wholes: Vec<Range>,
    /// By resource, then the total; nothing where no resource is cut: then each is the cell of its number, and each
    /// version has the slot of its number.
    first: Vec<u32>,
    /// How resources of more than one cell are cut, ascending.
    grids: Vec<(ResourceId, Grid)>,
    /// Resource of each cell; nothing where no resource is cut.
    resource: Vec<ResourceId>,
    /// By version, then the total: its slots; nothing where no resource is cut.
    first_slot: Vec<u32>,
    /// Cell of each slot, ascending within a version.
    slot_cells: Vec<u32>,
}

/// How a resource is cut into cells.
enum Grid {
    /// Aspects, then mips, then layers; ascending bounds.
    Image { aspects: Vec<Aspects>, mips: Vec<u32>, layers: Vec<u32> },
    /// Ascending bounds.
    Buffer(Vec<u64>),
}

impl Cells {
    /// Cuts resources where ranges of versions begin and end. Versions marked broken cover nothing. `wholes`: by
    /// resource, all of it.
    pub(super) fn new(description: &Description, wholes: Vec<Range>, broken: &[bool]) -> Self {
        // 1. Where resources are cut.
        let mut parts: Vec<(ResourceId, Range)> = Vec::new();
        for (version, _) in description.versions.iter().zip(broken).filter(|(_, broken)| !**broken) {
            if version.range != wholes[version.resource.0 as usize] {
                parts.push((version.resource, version.range));
            }
        }
        for (index, resource) in description.resources.iter().enumerate() {
            if let Origin::Kept { before, .. } = &resource.origin {
                let whole = &wholes[index];
                let arriving = before.iter().map(|state| state.range);
                let arriving = arriving.filter(|part| part != whole && part.lies_in(whole));
                parts.extend(arriving.map(|part| (ResourceId(index as u32), part)));
            }
        }
        if parts.is_empty() && !broken.contains(&true) {
            return Self::uncut(description, wholes);
        }
        parts.sort_by_key(|(resource, _)| *resource);

        // 2. Cells of each resource.
        let (resources, versions) = (description.resources.len(), description.versions.len());
        let mut cells = Self {
            wholes,
            first: Vec::with_capacity(resources + 1),
            grids: Vec::new(),
            resource: Vec::with_capacity(resources),
            first_slot: Vec::with_capacity(versions + 1),
            slot_cells: Vec::new(),
        };
        let mut parts = parts.chunk_by(|a, b| a.0 == b.0).peekable();
        cells.first.push(0);
        for (index, resource) in description.resources.iter().enumerate() {
            let id = ResourceId(index as u32);
            match parts.next_if(|parts| parts[0].0 == id) {
                None => cells.resource.push(id),
                Some(parts) => {
                    let grid = Grid::new(&resource.shape, parts);
                    cells.resource.resize(cells.resource.len() + grid.count(), id);
                    cells.grids.push((id, grid));
                }
            }
            cells.first.push(cells.resource.len() as u32);
        }

        // 3. Slots of each version.
        cells.first_slot.push(0);
        let mut slot_cells = Vec::with_capacity(versions);
        for (version, broken) in description.versions.iter().zip(broken) {
            if !broken {
                match cells.of(version.resource) {
                    one if one.len() == 1 => slot_cells.push(one.start),
                    _ => cells.cover(version.resource, version.range, &mut slot_cells),
                }
            }
            cells.first_slot.push(slot_cells.len() as u32);
        }
        Self { slot_cells, ..cells }
    }

    /// Of versions that are each all of a resource.
    pub(super) fn uncut(description: &Description, wholes: Vec<Range>) -> Self {
        let slot_cells = description.versions.iter().map(|version| version.resource.0).collect();
        let (first, grids, resource, first_slot) = Default::default();
        Self { wholes, first, grids, resource, first_slot, slot_cells }
    }

    /// All of a resource.
    pub(super) fn whole(&self, resource: ResourceId) -> Range {
        self.wholes[resource.0 as usize]
    }

    /// Whether no resource is cut.
    fn is_uncut(&self) -> bool {
        self.first.is_empty()
    }

    /// How a resource is cut; `None`: not at all.
    fn grid(&self, resource: ResourceId) -> Option<&Grid> {
        if self.of(resource).len() == 1 {
            return None;
        }
        let place = self.grids.binary_search_by_key(&resource, |(known, _)| *known).ok()?;
        Some(&self.grids[place].1)
    }

    /// Adds the cells of a range, which begins and ends where cells do, in ascending order.
    pub(super) fn cover(&self, resource: ResourceId, range: Range, covered: &mut Vec<u32>) {
        let first = self.of(resource).start;
        match (self.grid(resource), range) {
            (Some(Grid::Image { aspects, mips, layers }), Range::Image { aspects: a, mips: m, layers: l }) => {
                let (m, l) = (span(mips, m), span(layers, l));
                let (rows, columns) = (mips.len() as u32 - 1, layers.len() as u32 - 1);
                for aspect in (0..aspects.len() as u32).filter(|&i| a.contains(aspects[i as usize])) {
                    for mip in m.clone() {
                        covered.extend(l.clone().map(|layer| first + (aspect * rows + mip) * columns + layer));
                    }
                }
            }
            (Some(Grid::Buffer(bounds)), Range::Buffer(bytes)) => {
                covered.extend(span(bounds, bytes).map(|i| first + i));
            }
            _ => covered.push(first),
        }
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        if self.is_uncut() { self.wholes.len() } else { self.resource.len() }
    }

    /// Number of slots of all versions.
    pub(super) fn slot_count(&self) -> usize {
        self.slot_cells.len()
    }

    /// The resource that a cell is part of.
    pub(super) fn resource(&self, cell: u32) -> ResourceId {
        if self.is_uncut() { ResourceId(cell) } else { self.resource[cell as usize] }
    }

    /// Cells of a resource.
    pub(super) fn of(&self, resource: ResourceId) -> Span<u32> {
        if self.is_uncut() {
            return resource.0..resource.0 + 1;
        }
        self.first[resource.0 as usize]..self.first[resource.0 as usize + 1]
    }

    /// Slots of a version: one for each cell that it covers.
    pub(super) fn slots(&self, version: usize) -> Span<usize> {
        if self.is_uncut() {
            return version..version + 1;
        }
        self.first_slot[version] as usize..self.first_slot[version + 1] as usize
    }

    /// Cell of a slot.
    pub(super) fn cell(&self, slot: usize) -> u32 {
        self.slot_cells[slot]
    }

    /// Cells of a version, ascending.
    pub(super) fn covered(&self, version: usize) -> &[u32] {
        &self.slot_cells[self.slots(version)]
    }

    /// A version's slot for a cell.
    pub(super) fn slot(&self, version: usize, cell: u32) -> Option<usize> {
        let slots = self.slots(version);
        if slots.len() == 1 {
            return (self.slot_cells[slots.start] == cell).then_some(slots.start);
        }
        let index = self.slot_cells[slots.clone()].binary_search(&cell).ok()?;
        Some(slots.start + index)
    }

    /// Ranges that hold exactly these cells of one resource, given in ascending order.
    pub(super) fn ranges(&self, cells: &[u32]) -> Vec<Range> {
        let Some(&start) = cells.first() else { return Vec::new() };
        let resource = self.resource(start);
        let first = self.of(resource).start;
        match self.grid(resource) {
            None => vec![self.whole(resource)],
            Some(Grid::Buffer(bounds)) => {
                let runs = runs(cells.iter().map(|cell| cell - first));
                runs.map(|[a, b]| Range::Buffer([bounds[a as usize], bounds[b as usize]])).collect()
            }
            Some(Grid::Image { aspects, mips, layers }) => {
                boxes(cells.iter().map(|cell| cell - first), mips.len() as u32 - 1, layers.len() as u32 - 1)
                    .into_iter()
                    .map(|part| Range::Image {
                        aspects: (0..aspects.len())
                            .filter(|i| part.aspects & (1 << i) != 0)
                            .fold(Aspects::empty(), |all, i| all | aspects[i]),
                        mips: part.mips.map(|i| mips[i as usize]),
                        layers: part.layers.map(|i| layers[i as usize]),
                    })
                    .collect()
            }
        }
    }
}

impl Grid {
    fn new(shape: &Shape, parts: &[(ResourceId, Range)]) -> Self {
        match shape {
            Shape::Image(shape) => {
                let all = shape.aspects();
                let single = (0..32).map(|bit| Aspects::from_raw(1 << bit)).filter(|&bit| all.contains(bit));
                let mut mips = vec![0, shape.mips];
                let mut layers = vec![0, shape.layers];
                for (_, part) in parts {
                    if let Range::Image { mips: m, layers: l, .. } = part {
                        mips.extend(m);
                        layers.extend(l);
                    }
                }
                Grid::Image { aspects: single.collect(), mips: bounds(mips), layers: bounds(layers) }
            }
            Shape::Buffer { size } => {
                let ends = parts.iter().flat_map(|(_, part)| match part {
                    Range::Buffer(bytes) => bytes.to_vec(),
                    Range::Image { .. } => Vec::new(),
                });
                Grid::Buffer(bounds([0, *size].into_iter().chain(ends).collect()))
            }
        }
    }

    fn count(&self) -> usize {
        match self {
            Grid::Image { aspects, mips, layers } => aspects.len() * (mips.len() - 1) * (layers.len() - 1),
            Grid::Buffer(bounds) => bounds.len() - 1,
        }
    }
}

fn bounds<T: Ord>(mut all: Vec<T>) -> Vec<T> {
    all.sort_unstable();
    all.dedup();
    all
}

/// Places of the intervals that `range` holds; both its ends are among the bounds.
fn span<T: Ord>(bounds: &[T], range: [T; 2]) -> Span<u32> {
    let place = |value: &T| bounds.partition_point(|bound| bound < value) as u32;
    place(&range[0])..place(&range[1])
}

/// `[first, end)` of consecutive numbers.
fn runs(numbers: impl Iterator<Item = u32>) -> impl Iterator<Item = [u32; 2]> {
    let mut numbers = numbers.peekable();
    std::iter::from_fn(move || {
        let first = numbers.next()?;
        let mut end = first + 1;
        while numbers.next_if_eq(&end).is_some() {
            end += 1;
        }
        Some([first, end])
    })
}

/// A block of an image's cells; bit `i` of `aspects` is the image's aspect number `i`.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Block {
    aspects: u32,
    mips: [u32; 2],
    layers: [u32; 2],
}

/// Covers cells by blocks: runs of layers, then equal runs of successive mips, then equal blocks of several aspects.
fn boxes(cells: impl Iterator<Item = u32>, rows: u32, columns: u32) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    for cell in cells {
        let (row, layer) = (cell / columns, cell % columns);
        let (aspects, mip) = (1 << (row / rows), row % rows);
        match blocks.last_mut() {
            Some(last) if last.aspects == aspects && last.mips[0] == mip && last.layers[1] == layer => {
                last.layers[1] += 1;
            }
            _ => blocks.push(Block { aspects, mips: [mip, mip + 1], layers: [layer, layer + 1] }),
        }
    }
    let blocks = fold(blocks, |a, b| {
        let next = a.aspects == b.aspects && a.layers == b.layers && a.mips[1] == b.mips[0];
        next.then_some(Block { mips: [a.mips[0], b.mips[1]], ..*a })
    });
    fold(blocks, |a, b| {
        (a.mips == b.mips && a.layers == b.layers).then_some(Block { aspects: a.aspects | b.aspects, ..*a })
    })
}

/// Puts each block together with the first earlier one that it goes with.
fn fold(blocks: Vec<Block>, together: impl Fn(&Block, &Block) -> Option<Block>) -> Vec<Block> {
    let mut kept: Vec<Block> = Vec::new();
    for block in blocks {
        match kept.iter_mut().find_map(|known| together(known, &block).map(|sum| (known, sum))) {
            Some((known, sum)) => *known = sum,
            None => kept.push(block),
        }
    }
    kept
}

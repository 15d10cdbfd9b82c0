//! The smallest parts of resources: one aspect, mip and layer of an image; bytes of a buffer between two bounds.

use ash::vk::ImageAspectFlags as Aspects;
use shadowgraph::graph::description::{Description, Origin, Range, ResourceId, Shape};
use shadowgraph::graph::plan::Plan;

/// Numbers the parts of all resources.
pub struct Atoms {
    /// By resource: number of its first part, and how it is cut.
    cuts: Vec<(usize, Cut)>,
    /// By part.
    resources: Vec<ResourceId>,
}

enum Cut {
    Image { aspects: Vec<Aspects>, mips: u32, layers: u32 },
    Buffer(Vec<u64>),
}

impl Atoms {
    pub fn new(description: &Description, plans: &[&Plan]) -> Self {
        let steps = plans.iter().flat_map(|plan| &plan.steps).map(|step| &step.barriers);
        let batches = plans.iter().flat_map(|plan| &plan.batches).map(|batch| &batch.release);
        let all = steps.chain(batches).chain(plans.iter().map(|plan| &plan.finally));
        let ranges: Vec<(ResourceId, Range)> = all
            .flat_map(|barriers| &barriers.buffers)
            .map(|barrier| (barrier.resource, barrier.range))
            .chain(description.versions.iter().map(|version| (version.resource, version.range)))
            .chain(plans.iter().flat_map(|plan| &plan.ends).map(|end| (end.resource, end.state.range)))
            .collect();
        let mut atoms = Self { cuts: Vec::new(), resources: Vec::new() };
        for (index, resource) in description.resources.iter().enumerate() {
            let id = ResourceId(index as u32);
            let first = atoms.resources.len();
            let (cut, count) = match &resource.shape {
                Shape::Image(shape) => {
                    let all = [Aspects::COLOR, Aspects::DEPTH, Aspects::STENCIL];
                    let aspects: Vec<_> = all.into_iter().filter(|&bit| shape.aspects().contains(bit)).collect();
                    let count = aspects.len() as u32 * shape.mips * shape.layers;
                    (Cut::Image { aspects, mips: shape.mips, layers: shape.layers }, count as usize)
                }
                Shape::Buffer { size } => {
                    let mut bounds = vec![0, *size];
                    for (_, range) in ranges.iter().filter(|(other, _)| *other == id) {
                        if let Range::Buffer(bytes) = range {
                            bounds.extend(bytes);
                        }
                    }
                    if let Origin::Kept { before, .. } = &resource.origin {
                        for state in before {
                            if let Range::Buffer(bytes) = state.range {
                                bounds.extend(bytes);
                            }
                        }
                    }
                    bounds.sort_unstable();
                    bounds.dedup();
                    let count = bounds.len() - 1;
                    (Cut::Buffer(bounds), count)
                }
            };
            atoms.cuts.push((first, cut));
            atoms.resources.resize(first + count, id);
        }
        atoms
    }

    pub fn len(&self) -> usize {
        self.resources.len()
    }

    pub fn resource(&self, atom: usize) -> ResourceId {
        self.resources[atom]
    }

    /// Parts that lie in a range.
    pub fn of(&self, resource: ResourceId, range: &Range) -> Vec<usize> {
        let (first, cut) = &self.cuts[resource.0 as usize];
        let mut atoms = Vec::new();
        match (cut, range) {
            (Cut::Image { aspects, mips, layers }, Range::Image { aspects: a, mips: m, layers: l }) => {
                for (index, _) in aspects.iter().enumerate().filter(|(_, aspect)| a.contains(**aspect)) {
                    for mip in m[0]..m[1] {
                        for layer in l[0]..l[1] {
                            let place = (index as u32 * mips + mip) * layers + layer;
                            atoms.push(first + place as usize);
                        }
                    }
                }
            }
            (Cut::Buffer(bounds), Range::Buffer([start, end])) => {
                let inside = bounds.windows(2).enumerate().filter(|(_, part)| part[0] >= *start && part[1] <= *end);
                atoms.extend(inside.map(|(index, _)| first + index));
            }
            _ => {}
        }
        atoms
    }

    /// Parts of `other`, of a resource of the same shape, that have something of a part of this.
    pub fn same(&self, atom: usize, others: &Atoms, other: ResourceId) -> Vec<usize> {
        let (first, cut) = &self.cuts[self.resource(atom).0 as usize];
        let place = atom - first;
        match (cut, &others.cuts[other.0 as usize]) {
            (Cut::Buffer(bounds), (start, Cut::Buffer(old))) => {
                let [from, to] = [bounds[place], bounds[place + 1]];
                let common = old.windows(2).enumerate().filter(|(_, part)| part[0] < to && from < part[1]);
                common.map(|(index, _)| start + index).collect()
            }
            (_, (start, _)) => vec![start + place],
        }
    }

    /// All parts of a resource.
    pub fn all(&self, resource: ResourceId) -> std::ops::Range<usize> {
        let first = self.cuts[resource.0 as usize].0;
        let end = self.cuts.get(resource.0 as usize + 1).map_or(self.len(), |next| next.0);
        first..end
    }
}

//! Memory of transients, and the images and buffers in it, kept from frame to frame.

use rustc_hash::FxHashMap;

use super::resources::{self, Resources, image_info};
use crate::Result;
use crate::gpu::{BufferInfo, Gpu, Heap, Memory, Requirements};
use crate::graph::builder::External;
use crate::graph::description::{Description, Origin, Resource, Shape};
use crate::graph::name::Name;
use crate::graph::plan::{Placement, Plan, Usage};

/// Frames after which an object that no frame has used goes.
const KEPT_FRAMES: u64 = 4;

/// What frames lay their transients into.
#[derive(Default)]
pub(super) struct Transients {
    heaps: Vec<(Requirements, Heap)>,
    made: FxHashMap<Key, Made>,
    frame: u64,
}

/// What tells objects apart. Two resources that a frame has one after the other may be one object: the second begins
/// with undefined contents either way.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    heap: usize,
    offset: u64,
    shape: Shape,
    usage: Usage,
    /// Where messages are to name each resource.
    name: Option<Name>,
}

struct Made {
    object: External,
    last_used: u64,
}

impl Transients {
    /// Makes what is not there yet: transients where the plan placed them, and what is alive over a checkpoint.
    pub(super) fn make(
        &mut self,
        gpu: &Gpu,
        plan: &Plan,
        description: &Description,
        named: bool,
        into: &mut Resources,
    ) -> Result<()> {
        // 1. Heaps.
        for (index, heap) in plan.heaps.iter().enumerate() {
            let wanted = Requirements { size: heap.size, alignment: heap.alignment, type_bits: heap.type_bits };
            self.heap(gpu, index, wanted)?;
        }
        // 2. What has memory of its own.
        for (index, resource) in description.resources.iter().enumerate() {
            if let (Origin::Kept { .. }, None, Some(usage)) = (&resource.origin, &into.0[index], plan.usages[index]) {
                into.0[index] = Some(resources::alone(gpu, resource, usage)?);
            }
        }
        // 3. What lies in the heaps.
        self.frame += 1;
        for placement in &plan.placements {
            let index = placement.resource.0 as usize;
            if let Some(usage) = plan.usages[index] {
                into.0[index] = self.place(gpu, placement, &description.resources[index], usage, named)?;
            }
        }
        let frame = self.frame;
        self.made.retain(|_, made| made.last_used + KEPT_FRAMES > frame);
        Ok(())
    }

    /// The heap kept for this place where it fits, else a new one.
    fn heap(&mut self, gpu: &Gpu, index: usize, wanted: Requirements) -> Result<()> {
        let fits = |kept: &Requirements| {
            kept.size >= wanted.size && kept.alignment >= wanted.alignment && kept.type_bits == wanted.type_bits
        };
        if self.heaps.get(index).is_some_and(|(kept, _)| fits(kept)) {
            return Ok(());
        }
        self.heaps.truncate(index);
        self.made.retain(|key, _| key.heap < index);
        let heap = gpu.create_heap(&format!("transients {index}"), wanted, Memory::Device)?;
        self.heaps.push((wanted, heap));
        Ok(())
    }

    fn place(
        &mut self,
        gpu: &Gpu,
        placement: &Placement,
        resource: &Resource,
        usage: Usage,
        named: bool,
    ) -> Result<Option<External>> {
        let &Placement { heap, offset, .. } = placement;
        let key =
            Key { heap, offset, shape: resource.shape.clone(), usage, name: named.then(|| resource.name.clone()) };
        let last_used = self.frame;
        if let Some(made) = self.made.get_mut(&key) {
            made.last_used = last_used;
            return Ok(Some(made.object.clone()));
        }
        let heap = &self.heaps[heap].1;
        let object = match (&resource.shape, usage) {
            (Shape::Image(shape), Usage::Image(usage)) => {
                External::Image(gpu.place_image(heap, offset, &image_info(&resource.name, shape, usage))?)
            }
            (&Shape::Buffer { size }, Usage::Buffer(usage)) => {
                let info = BufferInfo { name: &resource.name, size, usage, memory: Memory::Device };
                External::Buffer(gpu.place_buffer(heap, offset, &info)?)
            }
            _ => return Ok(None),
        };
        self.made.insert(key, Made { object: object.clone(), last_used });
        Ok(Some(object))
    }
}

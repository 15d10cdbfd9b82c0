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
    /// By heap and offset.
    made: FxHashMap<(usize, u64), Vec<Made>>,
    frame: u64,
}

/// An object, and what tells it apart from others in the same place. Two resources that a frame has one after the other
/// may be one object: the second begins with undefined contents either way.
struct Made {
    shape: Shape,
    usage: Usage,
    /// Where messages are to name each resource.
    name: Option<Name>,
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
        // 1. Heaps. What the device cannot make at all has no memory type, and says why.
        let impossible = |placement: &&Placement| plan.heaps[placement.heap].type_bits == 0;
        for placement in plan.placements.iter().filter(impossible) {
            let index = placement.resource.0 as usize;
            let Resource { name, shape, .. } = &description.resources[index];
            match (shape, plan.usages[index]) {
                (Shape::Image(shape), Some(Usage::Image(usage))) => {
                    gpu.image_requirements(&image_info(name, shape, usage))?
                }
                (&Shape::Buffer { size }, Some(Usage::Buffer(usage))) => {
                    gpu.buffer_requirements(&BufferInfo { name, size, usage, memory: Memory::Device })?
                }
                _ => continue,
            };
        }
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
        for placement in &plan.placements {
            let index = placement.resource.0 as usize;
            if let Some(usage) = plan.usages[index] {
                into.0[index] = self.place(gpu, placement, &description.resources[index], usage, named)?;
            }
        }
        Ok(())
    }

    /// Begins a frame: what none of the last ones has used goes.
    pub(super) fn begin_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        self.made.retain(|_, made| {
            made.retain(|made| made.last_used + KEPT_FRAMES >= frame);
            !made.is_empty()
        });
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
        self.made.retain(|(heap, _), _| *heap < index);
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
        let last_used = self.frame;
        let made = self.made.entry((heap, offset)).or_default();
        let name = named.then_some(&resource.name);
        let same = |made: &&mut Made| made.usage == usage && made.shape == resource.shape && made.name.as_ref() == name;
        if let Some(made) = made.iter_mut().find(same) {
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
        let (shape, name) = (resource.shape.clone(), name.cloned());
        made.push(Made { shape, usage, name, object: object.clone(), last_used });
        Ok(Some(object))
    }
}

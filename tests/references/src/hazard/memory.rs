//! What can be said of placements without replaying: sizes, alignments, memory types; and who shares memory with whom.

use shadowgraph::graph::description::{Description, Origin, ResourceId, Shape};
use shadowgraph::graph::plan::{DeviceModel, Placement, Plan};

/// Checks placements one by one.
pub fn placements(description: &Description, plan: &Plan, device: &dyn DeviceModel, errors: &mut Vec<String>) {
    for (index, resource) in description.resources.iter().enumerate() {
        let id = ResourceId(index as u32);
        let placement = plan.placements.iter().find(|placement| placement.resource == id);
        let (Origin::Transient, Some(usage)) = (&resource.origin, plan.usages[index]) else {
            if placement.is_some() {
                errors.push(format!("`{}` needs no memory but is placed", resource.name));
            }
            continue;
        };
        let Some(placement) = placement else {
            errors.push(format!("`{}` is not placed", resource.name));
            continue;
        };
        let needs = device.requirements(&resource.shape, usage);
        let heap = &plan.heaps[placement.heap];
        let fits = placement.size >= needs.size && placement.offset + placement.size <= heap.size;
        let aligned =
            placement.offset.is_multiple_of(needs.alignment) && heap.alignment.is_multiple_of(needs.alignment);
        let typed = heap.type_bits != 0 && heap.type_bits & !needs.type_bits == 0;
        if !(fits && aligned && typed) {
            errors.push(format!("`{}` does not fit where it is placed: {placement:?} of {heap:?}", resource.name));
        }
    }
}

/// By resource: others that share some of its memory, at whatever time. A buffer and an image share a block of
/// `bufferImageGranularity` where both have a part of it.
pub fn sharers(description: &Description, plan: &Plan, granularity: u64) -> Vec<Vec<ResourceId>> {
    let is_image = |p: &Placement| matches!(description.resources[p.resource.0 as usize].shape, Shape::Image(_));
    let mut sharers = vec![Vec::new(); description.resources.len()];
    for a in &plan.placements {
        for b in plan.placements.iter().filter(|b| b.resource != a.resource && b.heap == a.heap) {
            let block = if is_image(a) == is_image(b) { 1 } else { granularity };
            let blocks = |p: &Placement| (p.offset / block, (p.offset + p.size).div_ceil(block));
            let ((start, end), (first, last)) = (blocks(a), blocks(b));
            if start < last && first < end {
                sharers[a.resource.0 as usize].push(b.resource);
            }
        }
    }
    sharers
}

//! Planning: from a description to a plan. Pure functions over plain data.

mod device;
mod output;
mod reason;

pub use device::{DeviceModel, Requirements, Usage};
pub use output::{
    Barriers, Batch, BufferBarrier, Heap, ImageBarrier, Lifetime, MemoryBarrier, Ownership, Placement, Plan,
    Statistics, Step, Wait, Work,
};
pub use reason::{CullReason, Hazard, Reason};

use super::description::Description;
use super::errors::GraphErrors;

/// Plans a frame for a device.
///
/// # Errors
/// All that is wrong with the description, at once.
pub fn plan(description: &Description, device: &dyn DeviceModel) -> Result<Plan, GraphErrors> {
    use crate::graph::description::*;
    use ash::vk;
    let mut plan = Plan::default();
    let n = description.resources.len();
    let mut usages: Vec<Option<Usage>> = vec![None; n];
    let mut add = |r: ResourceId, a: &Access| {
        let image = matches!(description.resources[r.0 as usize].shape, Shape::Image(_));
        let u = &mut usages[r.0 as usize];
        if image {
            let mut f = match u {
                Some(Usage::Image(f)) => *f,
                _ => vk::ImageUsageFlags::empty(),
            };
            let m = a.mask;
            if m.intersects(vk::AccessFlags2::COLOR_ATTACHMENT_WRITE) {
                f |= vk::ImageUsageFlags::COLOR_ATTACHMENT;
            }
            if m.intersects(vk::AccessFlags2::DEPTH_STENCIL_ATTACHMENT_READ) {
                f |= vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
            }
            if m.intersects(vk::AccessFlags2::SHADER_SAMPLED_READ) {
                f |= vk::ImageUsageFlags::SAMPLED;
            }
            if m.intersects(vk::AccessFlags2::SHADER_STORAGE_READ | vk::AccessFlags2::SHADER_STORAGE_WRITE) {
                f |= vk::ImageUsageFlags::STORAGE;
            }
            if m.intersects(vk::AccessFlags2::TRANSFER_READ) {
                f |= vk::ImageUsageFlags::TRANSFER_SRC;
            }
            if m.intersects(vk::AccessFlags2::TRANSFER_WRITE) {
                f |= vk::ImageUsageFlags::TRANSFER_DST;
            }
            *u = Some(Usage::Image(f));
        } else {
            *u = Some(Usage::Buffer(
                vk::BufferUsageFlags::STORAGE_BUFFER
                    | vk::BufferUsageFlags::TRANSFER_SRC
                    | vk::BufferUsageFlags::TRANSFER_DST
                    | vk::BufferUsageFlags::UNIFORM_BUFFER
                    | vk::BufferUsageFlags::INDIRECT_BUFFER,
            ));
        }
    };
    let mut layouts: std::collections::HashMap<(u32, u32, u32), vk::ImageLayout> = Default::default();
    let all = Access {
        stages: vk::PipelineStageFlags2::ALL_COMMANDS,
        mask: vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE,
        layout: vk::ImageLayout::UNDEFINED,
    };
    let reason = Reason { hazard: Hazard::First, resource: None, before: None, after: None };
    let mut barrier = |r: ResourceId, range: Range, a: &Access, b: &mut Barriers| {
        b.memory.push(MemoryBarrier { from: all, to: all, reason });
        if let Range::Image { aspects, mips, layers } = range {
            for m in mips[0]..mips[1] {
                for l in layers[0]..layers[1] {
                    let old = layouts.insert((r.0, m, l), a.layout).unwrap_or(vk::ImageLayout::UNDEFINED);
                    if old != a.layout {
                        b.images.push(ImageBarrier {
                            resource: r,
                            range: Range::Image { aspects, mips: [m, m + 1], layers: [l, l + 1] },
                            from: Access { layout: old, ..all },
                            to: Access { layout: a.layout, ..all },
                            ownership: None,
                            reason,
                        });
                    }
                }
            }
        }
    };
    for (i, pass) in description.passes.iter().enumerate() {
        let mut b = Barriers::default();
        for u in &pass.uses {
            let v = &description.versions[u.version.0 as usize];
            add(v.resource, &u.access);
            barrier(v.resource, v.range, &u.access, &mut b);
        }
        plan.steps.push(Step { work: Work::Pass(PassId(i as u32)), queue: Queue::Graphics, barriers: b });
        for (k, root) in description.roots.iter().enumerate() {
            if !root.read_back {
                continue;
            }
            // read back as soon as made, after the last pass of its chain
            fn last(d: &Description, v: VersionId) -> u32 {
                match &d.versions[v.0 as usize].source {
                    Source::Initial => 0,
                    Source::Pass { pass, .. } => pass.0,
                    Source::Split { of } | Source::Fork { of } => last(d, *of),
                    Source::Join { of } => of.iter().map(|v| last(d, *v)).max().unwrap_or(0),
                }
            }
            if last(description, root.version) == i as u32 {
                let v = &description.versions[root.version.0 as usize];
                let mut b = Barriers::default();
                let a = Access::transfer_read();
                add(v.resource, &a);
                barrier(v.resource, v.range, &a, &mut b);
                plan.steps.push(Step { work: Work::ReadBack(k), queue: Queue::Graphics, barriers: b });
            }
        }
    }
    let mut offset = 0u64;
    let (mut bits, mut align) = (!0u32, 1u64);
    for (i, r) in description.resources.iter().enumerate() {
        if r.origin != Origin::Transient {
            continue;
        }
        let Some(u) = usages[i] else { continue };
        let q = device.requirements(&r.shape, u);
        offset = offset.next_multiple_of(q.alignment.max(1));
        plan.placements.push(Placement {
            resource: ResourceId(i as u32),
            heap: 0,
            offset,
            size: q.size,
            steps: [0, 0],
        });
        offset += q.size;
        bits &= q.type_bits;
        align = align.max(q.alignment);
    }
    plan.heaps.push(Heap { size: offset.max(1), alignment: align, type_bits: bits });
    plan.finally.memory.push(MemoryBarrier {
        from: all,
        to: Access {
            stages: vk::PipelineStageFlags2::HOST,
            mask: vk::AccessFlags2::HOST_READ,
            layout: vk::ImageLayout::UNDEFINED,
        },
        reason,
    });
    plan.usages = usages;
    plan.batches.push(Batch {
        queue: Queue::Graphics,
        steps: (0..plan.steps.len()).collect(),
        waits: vec![],
        release: Barriers::default(),
        signal: 1,
    });
    Ok(plan)
}

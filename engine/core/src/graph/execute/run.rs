//! From a planned step to commands.

use ash::vk;

use super::resources::Resources;
use crate::gpu::{Commands, Target, ViewInfo};
use crate::graph::description::{Access, Range, ResourceId};
use crate::graph::pass::{Attachment, Attachments, DrawFn, Groups, Raster, Work};
use crate::graph::plan::Barriers;
use crate::graph::record::{self, Batches, BoundCompute, Ready, Recorder};
use crate::{Error, Result};

/// What a pass does.
pub(super) fn run(
    device: &ash::Device,
    commands: &Commands,
    work: &mut Work,
    (programs, bound): (&[Ready], &mut BoundCompute),
    memory: &Resources,
    asked: &mut Vec<u8>,
) -> Result<()> {
    match work {
        Work::Compute { push, groups, .. } => {
            let Some(ready) = programs.first() else { return Ok(()) };
            match *groups {
                Groups::Direct(groups) => {
                    record::dispatch(device, commands, (ready, bound), push.bytes(asked), groups, None)
                }
                Groups::Indirect { buffer, offset, .. } => {
                    let indirect = memory.buffer(buffer).map(|buffer| (buffer, offset));
                    record::dispatch(device, commands, (ready, bound), push.bytes(asked), [0; 3], indirect);
                }
            }
            Ok(())
        }
        Work::Raster(raster) => {
            let Raster { targets, attachments, draw, .. } = &mut **raster;
            render(device, commands, attachments, targets.view_mask, programs, draw, memory)
        }
        &mut Work::Fill { resource, range: Range::Buffer([first, end]), value } => {
            if let Some(buffer) = memory.buffer(resource) {
                // A size that a checkpoint told may be less than the description's.
                record::fill(device, commands, buffer, [first, end.min(buffer.size())], value);
            }
            Ok(())
        }
        &mut Work::Clear { resource, range, value } => {
            if let (Some(image), Some(range)) = (memory.image(resource), subresources(range)) {
                record::clear(device, commands, image, range, value);
            }
            Ok(())
        }
        &mut Work::ClearDepth { resource, range, value } => {
            if let (Some(image), Some(range)) = (memory.image(resource), subresources(range)) {
                record::clear_depth(device, commands, image, range, value);
            }
            Ok(())
        }
        Work::Zero(parts) => {
            parts.iter().for_each(|&(resource, range)| zero(device, commands, memory, resource, range));
            Ok(())
        }
        Work::Fill { .. } => Ok(()),
    }
}

fn zero(device: &ash::Device, commands: &Commands, memory: &Resources, resource: ResourceId, range: Range) {
    match (range, memory.image(resource), memory.buffer(resource), subresources(range)) {
        (Range::Buffer([first, end]), _, Some(buffer), _) => {
            record::fill(device, commands, buffer, [first, end.min(buffer.size())], 0);
        }
        (Range::Image { aspects, .. }, Some(image), _, Some(range)) => match aspects {
            vk::ImageAspectFlags::COLOR => {
                record::clear(device, commands, image, range, vk::ClearColorValue::default());
            }
            _ => record::clear_depth(device, commands, image, range, 0.0),
        },
        _ => {}
    }
}

fn render(
    device: &ash::Device,
    commands: &Commands,
    attachments: &Attachments,
    view_mask: u32,
    programs: &[Ready],
    draw: &mut DrawFn,
    memory: &Resources,
) -> Result<()> {
    let target = |attachment: &Attachment| -> Result<Target> {
        let image = memory.image(attachment.resource);
        let image = image.ok_or_else(|| Error::invalid("an attachment", "has no image behind it"))?;
        let Range::Image { aspects, mips, layers } = attachment.range else {
            return Err(Error::invalid("an attachment", "is a buffer"));
        };
        let array = layers[1] - layers[0] > 1;
        let kind = if array { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D };
        // Depth and stencil of one image are attached by one view, which shows both.
        let color = vk::ImageAspectFlags::COLOR;
        let aspects = if aspects == color { color } else { image.aspects() };
        let view = image.view(&ViewInfo { kind, aspects, mips, layers, ..image.whole() })?;
        let Attachment { layout, load, store, clear, .. } = *attachment;
        Ok(Target { view, format: image.info().format, layout, operations: (load, store), clear })
    };
    if let (true, Some(Some(color))) = (attachments.ordered, attachments.color.first()) {
        let depth = attachments.depth.as_ref().map(target).transpose()?;
        commands.begin_ordered(target(color)?, depth, attachments.size)?;
        let mut recorder = Recorder::new(device, commands, programs);
        let drawn = draw(&mut recorder);
        commands.end_ordered();
        return drawn.and_then(|()| recorder.finish());
    }
    let info = |attachment: &Attachment| -> Result<vk::RenderingAttachmentInfo<'static>> {
        let Target { view, layout, operations: (load, store), clear, .. } = target(attachment)?;
        let info = vk::RenderingAttachmentInfo::default().image_view(view).image_layout(layout);
        Ok(info.load_op(load).store_op(store).clear_value(clear))
    };
    let color = attachments.color.iter().flatten().map(info).collect::<Result<Vec<_>>>()?;
    let depth = attachments.depth.as_ref().map(info).transpose()?;
    let stencil = attachments.stencil.as_ref().map(info).transpose()?;
    let area = record::Area { size: attachments.size, layers: attachments.layers, view_mask };
    record::begin_rendering(device, commands, &color, [depth.as_ref(), stencil.as_ref()], area);
    let mut recorder = Recorder::new(device, commands, programs);
    let drawn = draw(&mut recorder);
    record::end_rendering(device, commands);
    drawn.and_then(|()| recorder.finish())
}

/// Adds Vulkan's barriers from the plan's, as a batch.
///
/// Buffers' are recorded as barriers for all memory, and images' have their order repeated as one without memory where
/// validation may be watching. That is the same to a driver and to Vulkan, where a barrier orders all commands of its
/// stages. Synchronisation validation takes it to order those of its own buffer or image alone, and would miss the order
/// of others that lie in the same memory.
pub(super) fn batch(batches: &mut Batches, barriers: &Barriers, memory: &Resources, validated: bool) {
    let buffers = barriers.buffers.iter().map(|barrier| (barrier.from, barrier.to));
    for (from, to) in barriers.memory.iter().map(|barrier| (barrier.from, barrier.to)).chain(buffers) {
        add_memory(batches, from, to);
    }
    for barrier in &barriers.images {
        let (Some(image), Some(range)) = (memory.image(barrier.resource), subresources(barrier.range)) else {
            continue;
        };
        if validated {
            let order = [barrier.from, barrier.to].map(|access| Access { stages: access.stages, ..Access::NONE });
            add_memory(batches, order[0], order[1]);
        }
        batches.images.push(
            vk::ImageMemoryBarrier2::default()
                .src_stage_mask(barrier.from.stages | barrier.follows.stages)
                .src_access_mask(barrier.from.mask | barrier.follows.mask)
                .dst_stage_mask(barrier.to.stages)
                .dst_access_mask(barrier.to.mask)
                .old_layout(barrier.from.layout)
                .new_layout(barrier.to.layout)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .image(image.raw())
                .subresource_range(range),
        );
    }
    batches.end();
}

/// A barrier for all memory, where no other one of the batch does as much.
fn add_memory(batches: &mut Batches, from: Access, to: Access) {
    let holds = |known: &vk::MemoryBarrier2| {
        known.src_stage_mask.contains(from.stages)
            && known.src_access_mask.contains(from.mask)
            && known.dst_stage_mask.contains(to.stages)
            && known.dst_access_mask.contains(to.mask)
    };
    if from.stages.is_empty() || to.stages.is_empty() || batches.open_memory().iter().any(holds) {
        return;
    }
    batches.memory.push(
        vk::MemoryBarrier2::default()
            .src_stage_mask(from.stages)
            .src_access_mask(from.mask)
            .dst_stage_mask(to.stages)
            .dst_access_mask(to.mask),
    );
}

pub(super) fn subresources(range: Range) -> Option<vk::ImageSubresourceRange> {
    let Range::Image { aspects, mips, layers } = range else { return None };
    Some(vk::ImageSubresourceRange {
        aspect_mask: aspects,
        base_mip_level: mips[0],
        level_count: mips[1] - mips[0],
        base_array_layer: layers[0],
        layer_count: layers[1] - layers[0],
    })
}

//! Checking and writing the contents of descriptor sets.

use std::sync::Arc;

use ash::vk;

use super::descriptor::SetLayout;
use super::device::Device;
use super::layout::descriptor_type;
use super::{Buffer, Descriptor, Image, PipelineBinding, ViewInfo};
use crate::shader::{Binding, BindingKind};
use crate::{Error, Result};

/// Checked contents of a set.
pub(super) struct Writes {
    /// Binding, element, kind, and index into `buffers` or `images`.
    entries: Vec<(u32, u32, BindingKind, usize)>,
    buffers: Vec<vk::DescriptorBufferInfo>,
    images: Vec<vk::DescriptorImageInfo>,
}

impl Writes {
    /// Checks that every element of every binding is given once and is of the right kind.
    pub(super) fn check(
        device: &Arc<Device>,
        who: &dyn Fn() -> String,
        layout: &SetLayout,
        given: &[(u32, Descriptor)],
    ) -> Result<Writes> {
        let mut writes = Writes { entries: Vec::new(), buffers: Vec::new(), images: Vec::new() };
        let mut problems = Vec::new();
        for PipelineBinding { binding, .. } in layout.bindings.iter() {
            let elements = || given.iter().filter(|g| g.0 == binding.binding).map(|g| &g.1);
            let what = || format!("binding {} {:?}", binding.binding, binding.name);
            let (count, wanted) = (elements().count(), binding.count.max(1));
            if count as u32 != wanted {
                problems.push(format!("{} ({:?}) takes {wanted}, given are {count}", what(), binding.kind));
                continue;
            }
            for (element, descriptor) in elements().enumerate() {
                match writes.push(device, binding, element as u32, descriptor) {
                    Ok(()) => {}
                    Err(Error::Invalid { what: object, why }) => problems.push(format!("{}: {object}: {why}", what())),
                    Err(e) => return Err(e),
                }
            }
        }
        for (number, _) in given {
            if !layout.bindings.iter().any(|b| b.binding.binding == *number) {
                problems.push(format!("there is no binding {number}"));
            }
        }
        if problems.is_empty() { Ok(writes) } else { Err(Error::invalid(who(), problems.join("; "))) }
    }

    fn push(&mut self, device: &Arc<Device>, binding: &Binding, element: u32, given: &Descriptor) -> Result<()> {
        use BindingKind as K;
        let image = |image: &Image, view: &ViewInfo, layout, sampler| -> Result<vk::DescriptorImageInfo> {
            if !image.is_of(device) {
                return Err(image.invalid("it is of another device"));
            }
            check_image(binding, image, view)?;
            Ok(vk::DescriptorImageInfo { image_view: image.view(view)?, image_layout: layout, sampler })
        };
        let index = match (binding.kind, given) {
            (K::UniformBuffer | K::StorageBuffer, Descriptor::Buffer { buffer, offset, size }) => {
                if !buffer.is_of(device) {
                    return Err(buffer.invalid("it is of another device"));
                }
                check_range(device, binding, buffer, *offset, *size)?;
                self.buffers.push(vk::DescriptorBufferInfo { buffer: buffer.raw(), offset: *offset, range: *size });
                self.buffers.len() - 1
            }
            (K::SampledImage | K::StorageImage | K::InputAttachment, Descriptor::Image { image: i, view, layout }) => {
                self.images.push(image(i, view, *layout, vk::Sampler::null())?);
                self.images.len() - 1
            }
            (K::CombinedImageSampler, Descriptor::Sampled { image: i, view, layout, sampler }) => {
                self.images.push(image(i, view, *layout, sampler.raw())?);
                self.images.len() - 1
            }
            (K::Sampler, Descriptor::Sampler(sampler)) => {
                self.images.push(vk::DescriptorImageInfo { sampler: sampler.raw(), ..Default::default() });
                self.images.len() - 1
            }
            (kind, given) => {
                return Err(Error::invalid(given.kind(), format!("it cannot be bound as {kind:?}")));
            }
        };
        self.entries.push((binding.binding, element, binding.kind, index));
        Ok(())
    }

    pub(super) fn write(&self, device: &Device, set: vk::DescriptorSet) {
        let write = |&(binding, element, kind, index): &(u32, u32, BindingKind, usize)| {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .dst_binding(binding)
                .dst_array_element(element)
                .descriptor_type(descriptor_type(kind));
            match kind {
                BindingKind::UniformBuffer | BindingKind::StorageBuffer => {
                    write.buffer_info(std::slice::from_ref(&self.buffers[index]))
                }
                _ => write.image_info(std::slice::from_ref(&self.images[index])),
            }
        };
        let writes: Vec<_> = self.entries.iter().map(write).collect();
        // SAFETY: a set that nothing uses yet; live objects of the kinds that its layout has.
        unsafe { device.raw.update_descriptor_sets(&writes, &[]) };
    }
}

/// Whether a view of an image is what the shader takes it for.
fn check_image(binding: &Binding, image: &Image, view: &ViewInfo) -> Result<()> {
    let Some(wanted) = binding.image else { return Ok(()) };
    let info = image.info();
    let format = if view.format == vk::Format::UNDEFINED { info.format } else { view.format };
    let usage = match binding.kind {
        BindingKind::StorageImage => vk::ImageUsageFlags::STORAGE,
        BindingKind::InputAttachment => vk::ImageUsageFlags::INPUT_ATTACHMENT,
        _ => vk::ImageUsageFlags::SAMPLED,
    };
    let why = if view.kind != wanted.view {
        format!("it is viewed as {:?}, the shader takes {:?}", view.kind, wanted.view)
    } else if (info.samples > 1) != wanted.multisampled {
        let shader = if wanted.multisampled { "several" } else { "one" };
        format!("it has {} samples a texel, the shader takes {shader}", info.samples)
    } else if wanted.format != vk::Format::UNDEFINED && wanted.format != format {
        format!("it is viewed as {format:?}, the shader takes {:?}", wanted.format)
    } else if !info.usage.contains(usage) {
        format!("it was made without the usage {usage:?}")
    } else {
        return Ok(());
    };
    Err(image.invalid(why))
}

/// Whether a part of a buffer can be bound.
fn check_range(device: &Device, binding: &Binding, buffer: &Buffer, offset: u64, size: u64) -> Result<()> {
    let limits = &device.caps.limits;
    let (align, most, usage) = if binding.kind == BindingKind::UniformBuffer {
        let most = limits.max_uniform_buffer_range;
        (limits.min_uniform_buffer_offset_alignment, most, vk::BufferUsageFlags::UNIFORM_BUFFER)
    } else {
        let most = limits.max_storage_buffer_range;
        (limits.min_storage_buffer_offset_alignment, most, vk::BufferUsageFlags::STORAGE_BUFFER)
    };
    let left = buffer.size().saturating_sub(offset);
    let bytes = if size == vk::WHOLE_SIZE { left } else { size };
    let why = if !buffer.usage().contains(usage) {
        format!("it was made without the usage {usage:?}")
    } else if bytes == 0 || bytes > left {
        format!("{bytes} bytes at {offset} are not in its {}", buffer.size())
    } else if !offset.is_multiple_of(align.max(1)) {
        format!("offset {offset} is no multiple of the device's {align}")
    } else if bytes > u64::from(most) {
        format!("{bytes} bytes are more than the device binds at once ({most}); bind a part, or use its address")
    } else if bytes < u64::from(binding.size) {
        format!("{bytes} bytes are fewer than the shader's {}", binding.size)
    } else {
        return Ok(());
    };
    Err(buffer.invalid(why))
}

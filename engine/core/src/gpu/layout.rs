//! Descriptor set layouts and pipeline layouts, from what reflection knows.

use std::collections::BTreeMap;
use std::sync::Arc;

use ash::vk;

use super::descriptor::SetLayout;
use super::device::Device;
use super::{Gpu, PipelineBinding, lock};
use crate::shader::{Binding, BindingKind, Shader, ShaderAccess, Stage};
use crate::{Error, Result};

/// Number, kind and count of each binding: equal ones share a Vulkan object.
pub(super) type LayoutKey = Vec<(u32, vk::DescriptorType, u32)>;

/// Every stage may see every set: so a set's layout does not depend on which stage of which pipeline reads it, and
/// pipelines that agree about a set's bindings can share it. Input attachments are for fragments alone.
fn set_stages(kind: vk::DescriptorType) -> vk::ShaderStageFlags {
    match kind {
        vk::DescriptorType::INPUT_ATTACHMENT => vk::ShaderStageFlags::FRAGMENT,
        _ => vk::ShaderStageFlags::ALL_GRAPHICS | vk::ShaderStageFlags::COMPUTE,
    }
}

pub(super) fn stage_flag(stage: Stage) -> vk::ShaderStageFlags {
    match stage {
        Stage::Vertex => vk::ShaderStageFlags::VERTEX,
        Stage::Geometry => vk::ShaderStageFlags::GEOMETRY,
        Stage::Fragment => vk::ShaderStageFlags::FRAGMENT,
        Stage::Compute => vk::ShaderStageFlags::COMPUTE,
    }
}

pub(super) fn descriptor_type(kind: BindingKind) -> vk::DescriptorType {
    match kind {
        BindingKind::UniformBuffer => vk::DescriptorType::UNIFORM_BUFFER,
        BindingKind::StorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
        BindingKind::CombinedImageSampler => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
        BindingKind::SampledImage => vk::DescriptorType::SAMPLED_IMAGE,
        BindingKind::Sampler => vk::DescriptorType::SAMPLER,
        BindingKind::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
        BindingKind::InputAttachment => vk::DescriptorType::INPUT_ATTACHMENT,
    }
}

/// The bindings of several shaders together, by set and number.
pub(super) fn merge_bindings(shaders: &[&'static Shader]) -> Result<Vec<PipelineBinding>> {
    let mut merged: BTreeMap<(u32, u32), PipelineBinding> = BTreeMap::new();
    for shader in shaders {
        for binding in shader.bindings {
            let Some(known) = merged.get_mut(&(binding.set, binding.binding)) else {
                let first =
                    PipelineBinding { binding: *binding, stages: stage_flag(shader.stage), files: vec![shader.file] };
                merged.insert((binding.set, binding.binding), first);
                continue;
            };
            if let Some(difference) = difference(&known.binding, binding) {
                return Err(Error::invalid(
                    format!("set {} binding {}", binding.set, binding.binding),
                    format!("{} and {} disagree: {difference}", known.files.join(", "), shader.file),
                ));
            }
            if known.binding.access != binding.access {
                known.binding.access = ShaderAccess::ReadWrite;
            }
            known.stages |= stage_flag(shader.stage);
            if !known.files.contains(&shader.file) {
                known.files.push(shader.file);
            }
        }
    }
    Ok(merged.into_values().collect())
}

/// What is different between two shaders' declarations of one binding; the access may be.
fn difference(a: &Binding, b: &Binding) -> Option<String> {
    if a.kind != b.kind {
        Some(format!("{:?} {:?} and {:?} {:?}", a.kind, a.name, b.kind, b.name))
    } else if a.name != b.name {
        Some(format!("it is called {:?} and {:?}", a.name, b.name))
    } else if a.count != b.count {
        Some(format!("{:?} has {} and {} elements", a.name, a.count, b.count))
    } else if a.size != b.size {
        Some(format!("{:?} has {} and {} bytes", a.name, a.size, b.size))
    } else if a.image != b.image {
        Some(format!("{:?} is {:?} and {:?}", a.name, a.image, b.image))
    } else {
        None
    }
}

/// The push constants of several shaders together: stages and bytes.
pub(super) fn merge_push(shaders: &[&'static Shader]) -> Result<Option<(vk::ShaderStageFlags, u32)>> {
    let mut merged: Option<(&Shader, &str, vk::ShaderStageFlags, u32)> = None;
    for shader in shaders {
        let Some(push) = shader.push else { continue };
        merged = Some(match merged {
            Some((first, name, ..)) if name != push.name || first.push.map(|p| p.size) != Some(push.size) => {
                return Err(Error::invalid(
                    "push constants",
                    format!(
                        "{} and {} disagree: {name:?} of {} bytes and {:?} of {} bytes",
                        first.file,
                        shader.file,
                        first.push.map_or(0, |p| p.size),
                        push.name,
                        push.size
                    ),
                ));
            }
            Some((first, name, stages, size)) => (first, name, stages | stage_flag(shader.stage), size),
            // Vulkan wants a multiple of 4.
            None => (shader, push.name, stage_flag(shader.stage), push.size.next_multiple_of(4)),
        });
    }
    Ok(merged.map(|(_, _, stages, size)| (stages, size)))
}

/// The layout of one set.
pub(super) fn set_layout(device: &Device, set: u32, bindings: &[PipelineBinding]) -> Result<SetLayout> {
    let bindings: Vec<PipelineBinding> = bindings.iter().filter(|b| b.binding.set == set).cloned().collect();
    let key: LayoutKey =
        bindings.iter().map(|b| (b.binding.binding, descriptor_type(b.binding.kind), b.binding.count.max(1))).collect();
    let mut layouts = lock(&device.set_layouts);
    let raw = match layouts.get(&key) {
        Some(&known) => known,
        None => {
            let entries: Vec<_> = key
                .iter()
                .map(|&(binding, kind, count)| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(binding)
                        .descriptor_type(kind)
                        .descriptor_count(count)
                        .stage_flags(set_stages(kind))
                })
                .collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&entries);
            // SAFETY: a valid structure.
            let made = unsafe { device.raw.create_descriptor_set_layout(&info, None) };
            let made = made.map_err(|e| device.error("vkCreateDescriptorSetLayout", "a descriptor set", e))?;
            let names: Vec<_> = bindings.iter().map(|b| b.binding.name).collect();
            device.name(made, &format!("set layout ({})", names.join(", ")));
            layouts.insert(key.clone(), made);
            made
        }
    };
    Ok(SetLayout { raw, set, bindings: bindings.into() })
}

/// All that a pipeline's layout is.
pub(super) struct Layout {
    pub raw: vk::PipelineLayout,
    pub sets: Vec<SetLayout>,
    pub bindings: Vec<PipelineBinding>,
    pub push: Option<(vk::ShaderStageFlags, u32)>,
}

/// The layout of a pipeline with these shaders, where `shared` sets keep the layouts that are given.
pub(super) fn pipeline_layout(
    device: &Arc<Device>,
    name: &str,
    shaders: &[&'static Shader],
    shared: &[(u32, &SetLayout)],
) -> Result<Layout> {
    // 1. What the stages have.
    let mut bindings = merge_bindings(shaders)?;
    let push = merge_push(shaders)?;

    // 2. A shared layout may hold more, but not less.
    for (set, layout) in shared {
        for wanted in bindings.iter().filter(|b| b.binding.set == *set) {
            let given = layout.bindings.iter().find(|b| b.binding.binding == wanted.binding.binding);
            let why = match given {
                None => format!("the given layout of set {set} lacks {:?}", wanted.binding.name),
                Some(given) => match difference(&given.binding, &wanted.binding) {
                    Some(difference) => format!("the given layout of set {set} is another: {difference}"),
                    None => continue,
                },
            };
            let files = wanted.files.join(", ");
            return Err(Error::invalid(format!("pipeline {name:?} ({files})"), why));
        }
    }

    // 3. One layout a set, without a gap.
    let in_shaders = bindings.iter().map(|b| b.binding.set + 1).max().unwrap_or(0);
    let count = shared.iter().map(|s| s.0 + 1).max().unwrap_or(0).max(in_shaders);
    let mut sets = Vec::new();
    for set in 0..count {
        sets.push(match shared.iter().find(|s| s.0 == set) {
            Some((_, layout)) => SetLayout { set, ..(*layout).clone() },
            None => set_layout(device, set, &bindings)?,
        });
    }
    check_limits(device, name, &sets, push)?;
    bindings.sort_by_key(|b| (b.binding.set, b.binding.binding));

    // 4. The whole.
    let raw_sets: Vec<_> = sets.iter().map(|s| s.raw).collect();
    let ranges: Vec<_> =
        push.iter().map(|&(stages, size)| vk::PushConstantRange { stage_flags: stages, offset: 0, size }).collect();
    let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&raw_sets).push_constant_ranges(&ranges);
    // SAFETY: live set layouts; the limits were checked.
    let raw = unsafe { device.raw.create_pipeline_layout(&info, None) };
    let raw = raw.map_err(|e| device.error("vkCreatePipelineLayout", name, e))?;
    device.name(raw, &format!("{name}.layout"));
    Ok(Layout { raw, sets, bindings, push })
}

/// Whether the device takes so many sets, descriptors and push constants.
fn check_limits(
    device: &Device,
    name: &str,
    sets: &[SetLayout],
    push: Option<(vk::ShaderStageFlags, u32)>,
) -> Result<()> {
    use BindingKind as K;
    let l = &device.caps.limits;
    let count = |kinds: &[BindingKind]| -> u32 {
        let all = sets.iter().flat_map(|s| s.bindings.iter());
        all.filter(|b| kinds.contains(&b.binding.kind)).map(|b| b.binding.count.max(1)).sum()
    };
    let wanted = [
        ("descriptor sets", sets.len() as u32, l.max_bound_descriptor_sets),
        ("uniform buffers", count(&[K::UniformBuffer]), l.max_per_stage_uniform_buffers),
        ("storage buffers", count(&[K::StorageBuffer]), l.max_per_stage_storage_buffers),
        ("sampled images", count(&[K::SampledImage, K::CombinedImageSampler]), l.max_per_stage_sampled_images),
        ("samplers", count(&[K::Sampler, K::CombinedImageSampler]), l.max_per_stage_samplers),
        ("storage images", count(&[K::StorageImage]), l.max_per_stage_storage_images),
        ("bytes of push constants", push.map_or(0, |p| p.1), l.max_push_constants_size),
    ];
    let missing: Vec<String> = wanted
        .iter()
        .filter(|(_, wants, has)| wants > has)
        .map(|(what, wants, has)| format!("{wants} {what} (it has {has})"))
        .collect();
    if missing.is_empty() {
        return Ok(());
    }
    Err(Error::Missing { device: device.caps.title(), who: format!("pipeline {name:?}"), missing })
}

impl Gpu {
    /// The layout of set number `set` that fits all of these shaders: for a set (a material's) that pipelines with
    /// different shaders share; give it to each of them in [`super::GraphicsPipelineInfo::set_layouts`].
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] naming both files where two shaders disagree about a binding.
    pub fn set_layout(&self, set: u32, shaders: &[&'static Shader]) -> Result<SetLayout> {
        set_layout(&self.device, set, &merge_bindings(shaders)?)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::shader::Push;

    const fn binding(binding: u32, name: &'static str, kind: BindingKind, access: ShaderAccess) -> Binding {
        Binding { set: 0, binding, name, kind, access, count: 1, size: 0, image: None }
    }

    const fn shader(file: &'static str, stage: Stage, bindings: &'static [Binding], push: Option<Push>) -> Shader {
        Shader {
            file,
            stage,
            spirv: &[],
            bindings,
            push,
            inputs: &[],
            outputs: &[],
            workgroup: [0; 3],
            capabilities: &[],
        }
    }

    static VERTEX: Shader = shader(
        "a.vert",
        Stage::Vertex,
        &[binding(0, "view", BindingKind::UniformBuffer, ShaderAccess::Read)],
        Some(Push { name: "Draw", size: 18 }),
    );
    static FRAGMENT: Shader = shader(
        "a.frag",
        Stage::Fragment,
        &[
            binding(0, "view", BindingKind::UniformBuffer, ShaderAccess::Read),
            binding(1, "list", BindingKind::StorageBuffer, ShaderAccess::Write),
        ],
        Some(Push { name: "Draw", size: 18 }),
    );
    static OTHER: Shader = shader(
        "b.frag",
        Stage::Fragment,
        &[binding(0, "view", BindingKind::StorageBuffer, ShaderAccess::Read)],
        Some(Push { name: "Other", size: 18 }),
    );
    static READER: Shader =
        shader("c.frag", Stage::Fragment, &[binding(1, "list", BindingKind::StorageBuffer, ShaderAccess::Read)], None);

    #[test]
    fn stages_are_merged() {
        let merged = merge_bindings(&[&VERTEX, &FRAGMENT, &READER]).unwrap();
        assert_eq!(merged.len(), 2);
        assert_eq!(merged[0].stages, vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT);
        assert_eq!(merged[0].files, ["a.vert", "a.frag"]);
        assert_eq!(merged[1].binding.access, ShaderAccess::ReadWrite);
        let (stages, size) = merge_push(&[&VERTEX, &FRAGMENT, &READER]).unwrap().unwrap();
        assert_eq!((stages, size), (vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT, 20));
    }

    #[test]
    fn disagreement_names_both_files() {
        for error in [merge_bindings(&[&VERTEX, &OTHER]).unwrap_err(), merge_push(&[&VERTEX, &OTHER]).unwrap_err()] {
            let text = error.to_string();
            assert!(text.contains("a.vert") && text.contains("b.frag"), "{text}");
        }
    }
}

//! Which device, and what it can do.

use std::ffi::{CStr, CString};

use ash::vk;

use super::features::{Features, Offer};
use super::{Caps, DeviceKind, Feature, GpuOptions, Limits, QueueFamily};
use crate::{Error, Result};

/// A device that may be opened.
pub(super) struct Candidate {
    pub physical: vk::PhysicalDevice,
    pub caps: Caps,
    pub offer: Offer,
}

/// The best device that has what the engine needs, or the one that is asked for.
pub(super) fn choose(instance: &ash::Instance, options: &GpuOptions) -> Result<Candidate> {
    // 1. All there are.
    // SAFETY: a plain query of a live instance.
    let devices = unsafe { instance.enumerate_physical_devices() }.map_err(|result| Error::Vulkan {
        call: "vkEnumeratePhysicalDevices",
        object: "the instance".into(),
        result,
    })?;
    let mut found = devices.into_iter().map(|d| inspect(instance, d)).collect::<Result<Vec<_>>>()?;
    let names = found.iter().map(|c| c.caps.title()).collect::<Vec<_>>().join("; ");

    // 2. Those asked for.
    let wanted = options.device.clone().or_else(|| std::env::var("SHADOWGRAPH_DEVICE").ok()).filter(|w| !w.is_empty());
    if let Some(wanted) = &wanted {
        let part = wanted.to_lowercase();
        found.retain(|c| c.caps.title().to_lowercase().contains(&part));
    }
    // 3. The best first: complete ones, then by kind; equal ones in the loader's order.
    for candidate in &mut found {
        let wanted = &options.device_extensions;
        let lacks = wanted.iter().filter(|w| !candidate.offer.extensions.iter().any(|e| e.to_bytes() == w.as_bytes()));
        let lacks: Vec<String> = lacks.map(|w| format!("extension {w}")).collect();
        candidate.offer.missing.extend(lacks);
    }
    found.sort_by_key(|c| (!c.offer.missing.is_empty(), std::cmp::Reverse(c.caps.kind)));
    let Some(best) = found.into_iter().next() else {
        return Err(match wanted {
            Some(wanted) => Error::NoDevice {
                why: format!("none has {wanted:?} in its name (device option or SHADOWGRAPH_DEVICE)"),
                hint: format!("there are: {}", if names.is_empty() { "none" } else { &names }),
            },
            None => Error::NoDevice {
                why: "the Vulkan loader finds no device".into(),
                hint: "install a driver (Debian, Ubuntu: `apt-get install mesa-vulkan-drivers`)".into(),
            },
        });
    };
    complete(best)
}

/// The device of an application.
pub(super) fn inspect_raw(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Result<Candidate> {
    inspect(instance, physical).and_then(complete)
}

fn complete(candidate: Candidate) -> Result<Candidate> {
    if candidate.offer.missing.is_empty() {
        return Ok(candidate);
    }
    Err(Error::Missing { device: candidate.caps.title(), who: "the engine".into(), missing: candidate.offer.missing })
}

fn inspect(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Result<Candidate> {
    let fail = |call, result| Error::Vulkan { call, object: "a physical device".into(), result };
    // SAFETY: plain queries of a live instance.
    let (basic, extensions) = unsafe {
        (
            instance.get_physical_device_properties(physical),
            instance
                .enumerate_device_extension_properties(physical)
                .map_err(|e| fail("vkEnumerateDeviceExtensionProperties", e))?,
        )
    };
    let extensions: Vec<CString> =
        extensions.iter().filter_map(|e| e.extension_name_as_c_str().ok().map(CString::from)).collect();
    let mut caps = Caps {
        device: text(basic.device_name_as_c_str()),
        kind: match basic.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
            vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
            vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
            vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
            _ => DeviceKind::Other,
        },
        driver_version: basic.driver_version,
        api_version: [
            vk::api_version_major(basic.api_version),
            vk::api_version_minor(basic.api_version),
            vk::api_version_patch(basic.api_version),
        ],
        ids: [basic.vendor_id, basic.device_id],
        ..Caps::default()
    };
    if basic.api_version < vk::API_VERSION_1_3 {
        let [major, minor, _] = caps.api_version;
        let missing = vec![format!("Vulkan 1.3 (it has {major}.{minor})")];
        return Ok(Candidate { physical, caps, offer: Offer { missing, optional: [].into(), extensions } });
    }

    // 1. Names and limits.
    let mut v11 = vk::PhysicalDeviceVulkan11Properties::default();
    let mut v12 = vk::PhysicalDeviceVulkan12Properties::default();
    let mut v13 = vk::PhysicalDeviceVulkan13Properties::default();
    let mut chain =
        vk::PhysicalDeviceProperties2::default().push_next(&mut v11).push_next(&mut v12).push_next(&mut v13);
    // SAFETY: structures of 1.3 on a device of 1.3.
    let families = unsafe {
        instance.get_physical_device_properties2(physical, &mut chain);
        instance.get_physical_device_queue_family_properties(physical)
    };
    caps.driver = text(v12.driver_name_as_c_str());
    caps.driver_info = text(v12.driver_info_as_c_str());
    caps.limits = limits(&basic.limits, &v11, &v13);

    // 2. Queues.
    caps.queue_families = families
        .iter()
        .map(|f| {
            let has = |flag| f.queue_flags.contains(flag);
            let (graphics, compute) = (has(vk::QueueFlags::GRAPHICS), has(vk::QueueFlags::COMPUTE));
            QueueFamily {
                graphics,
                compute,
                // Queues that draw or dispatch copy too, whether they say so or not.
                transfer: graphics || compute || has(vk::QueueFlags::TRANSFER),
                count: f.queue_count,
                timestamp_bits: f.timestamp_valid_bits,
            }
        })
        .collect();

    // 3. Features.
    let mut offer = Features::offer(instance, physical, extensions);
    match caps.queue_families.iter().position(|f| f.graphics && f.compute) {
        Some(index) => {
            caps.queue_family = index as u32;
            if caps.queue_families[index].timestamp_bits > 0 {
                offer.optional.insert(Feature::Timestamps);
            }
        }
        None => offer.missing.push("a queue family with graphics and compute".into()),
    }
    let ballot = vk::SubgroupFeatureFlags::BASIC | vk::SubgroupFeatureFlags::BALLOT;
    // SwiftShader elects fragments that failed the early depth test, whose atomics do nothing.
    if !caps.driver.contains("SwiftShader")
        && v11.subgroup_supported_stages.contains(vk::ShaderStageFlags::FRAGMENT)
        && v11.subgroup_supported_operations.contains(ballot)
    {
        offer.optional.insert(Feature::FragmentBallot);
    }
    caps.features = offer.optional.clone();
    Ok(Candidate { physical, caps, offer })
}

fn text<E>(name: Result<&CStr, E>) -> String {
    name.map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

fn limits(
    l: &vk::PhysicalDeviceLimits,
    v11: &vk::PhysicalDeviceVulkan11Properties<'_>,
    v13: &vk::PhysicalDeviceVulkan13Properties<'_>,
) -> Limits {
    let samples = l.framebuffer_color_sample_counts & l.framebuffer_depth_sample_counts;
    Limits {
        max_image_dimension_2d: l.max_image_dimension2_d,
        max_image_dimension_3d: l.max_image_dimension3_d,
        max_image_array_layers: l.max_image_array_layers,
        max_framebuffer_layers: l.max_framebuffer_layers,
        max_multiview_views: v11.max_multiview_view_count,
        max_buffer_size: v13.max_buffer_size,
        max_allocation_size: v11.max_memory_allocation_size,
        max_uniform_buffer_range: l.max_uniform_buffer_range,
        max_storage_buffer_range: l.max_storage_buffer_range,
        max_push_constants_size: l.max_push_constants_size,
        max_bound_descriptor_sets: l.max_bound_descriptor_sets,
        max_per_stage_uniform_buffers: l.max_per_stage_descriptor_uniform_buffers,
        max_per_stage_storage_buffers: l.max_per_stage_descriptor_storage_buffers,
        max_per_stage_sampled_images: l.max_per_stage_descriptor_sampled_images,
        max_per_stage_storage_images: l.max_per_stage_descriptor_storage_images,
        max_per_stage_samplers: l.max_per_stage_descriptor_samplers,
        max_per_stage_resources: l.max_per_stage_resources,
        max_vertex_attributes: l.max_vertex_input_attributes,
        max_geometry_output_vertices: l.max_geometry_output_vertices,
        max_color_attachments: l.max_color_attachments,
        max_fragment_combined_output_resources: l.max_fragment_combined_output_resources,
        max_compute_shared_memory_size: l.max_compute_shared_memory_size,
        max_compute_workgroup_count: l.max_compute_work_group_count,
        max_compute_workgroup_invocations: l.max_compute_work_group_invocations,
        max_compute_workgroup_size: l.max_compute_work_group_size,
        max_draw_indirect_count: l.max_draw_indirect_count,
        max_clip_distances: l.max_clip_distances,
        max_viewports: l.max_viewports,
        min_uniform_buffer_offset_alignment: l.min_uniform_buffer_offset_alignment,
        min_storage_buffer_offset_alignment: l.min_storage_buffer_offset_alignment,
        optimal_buffer_copy_offset_alignment: l.optimal_buffer_copy_offset_alignment,
        buffer_image_granularity: l.buffer_image_granularity,
        non_coherent_atom_size: l.non_coherent_atom_size,
        subgroup_size: v11.subgroup_size,
        sub_pixel_bits: l.sub_pixel_precision_bits,
        timestamp_period: l.timestamp_period,
        framebuffer_sample_counts: samples.as_raw(),
        standard_sample_locations: l.standard_sample_locations == vk::TRUE,
    }
}

//! Which features a device has, and enabling them: one table for both.

use std::collections::BTreeSet;
use std::ffi::{CStr, CString};

use ash::vk;

use super::Feature;

/// Feature structures, to be filled by a query or handed to the device's creation.
#[derive(Default)]
pub(super) struct Features {
    pub core: vk::PhysicalDeviceFeatures,
    v11: vk::PhysicalDeviceVulkan11Features<'static>,
    v12: vk::PhysicalDeviceVulkan12Features<'static>,
    v13: vk::PhysicalDeviceVulkan13Features<'static>,
    atomic_float: vk::PhysicalDeviceShaderAtomicFloatFeaturesEXT<'static>,
    interlock: vk::PhysicalDeviceFragmentShaderInterlockFeaturesEXT<'static>,
    ordered: vk::PhysicalDeviceRasterizationOrderAttachmentAccessFeaturesEXT<'static>,
    depth_clip: vk::PhysicalDeviceDepthClipEnableFeaturesEXT<'static>,
    portability: vk::PhysicalDevicePortabilitySubsetFeaturesKHR<'static>,
}

type Field = fn(&mut Features) -> &mut vk::Bool32;

/// Without these the engine does not run.
const REQUIRED: &[(&str, Field)] = &[
    ("robustBufferAccess", |f| &mut f.core.robust_buffer_access),
    ("independentBlend", |f| &mut f.core.independent_blend),
    ("imageCubeArray", |f| &mut f.core.image_cube_array),
    ("fullDrawIndexUint32", |f| &mut f.core.full_draw_index_uint32),
    ("drawIndirectFirstInstance", |f| &mut f.core.draw_indirect_first_instance),
    ("fragmentStoresAndAtomics", |f| &mut f.core.fragment_stores_and_atomics),
    ("multiview", |f| &mut f.v11.multiview),
    ("timelineSemaphore", |f| &mut f.v12.timeline_semaphore),
    ("scalarBlockLayout", |f| &mut f.v12.scalar_block_layout),
    ("hostQueryReset", |f| &mut f.v12.host_query_reset),
    ("bufferDeviceAddress", |f| &mut f.v12.buffer_device_address),
    ("separateDepthStencilLayouts", |f| &mut f.v12.separate_depth_stencil_layouts),
    ("dynamicRendering", |f| &mut f.v13.dynamic_rendering),
    ("synchronization2", |f| &mut f.v13.synchronization2),
    ("maintenance4", |f| &mut f.v13.maintenance4),
    ("shaderDemoteToHelperInvocation", |f| &mut f.v13.shader_demote_to_helper_invocation),
    ("shaderTerminateInvocation", |f| &mut f.v13.shader_terminate_invocation),
];

/// Names of the required features.
pub(super) const REQUIRED_NAMES: &[&str] = &{
    let mut names = [""; REQUIRED.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = REQUIRED[i].0;
        i += 1;
    }
    names
};

/// Optional features that are booleans of Vulkan, with the extension they need beyond 1.3.
#[rustfmt::skip]
const OPTIONAL: &[(Feature, Option<&CStr>, Field)] = &[
    (Feature::GeometryShader, None, |f| &mut f.core.geometry_shader),
    (Feature::TessellationShader, None, |f| &mut f.core.tessellation_shader),
    (Feature::LogicOp, None, |f| &mut f.core.logic_op),
    (Feature::LayerFromVertexShader, None, |f| &mut f.v12.shader_output_layer),
    (Feature::ViewportFromVertexShader, None, |f| &mut f.v12.shader_output_viewport_index),
    (Feature::DrawParameters, None, |f| &mut f.v11.shader_draw_parameters),
    (Feature::Int64, None, |f| &mut f.core.shader_int64),
    (Feature::Float64, None, |f| &mut f.core.shader_float64),
    (Feature::Int64BufferAtomics, None, |f| &mut f.v12.shader_buffer_int64_atomics),
    (Feature::Int64SharedAtomics, None, |f| &mut f.v12.shader_shared_int64_atomics),
    (Feature::FloatBufferAtomicAdd, Some(ash::ext::shader_atomic_float::NAME), |f| &mut f.atomic_float.shader_buffer_float32_atomic_add),
    (Feature::FloatImageAtomicAdd, Some(ash::ext::shader_atomic_float::NAME), |f| &mut f.atomic_float.shader_image_float32_atomic_add),
    (Feature::VertexStores, None, |f| &mut f.core.vertex_pipeline_stores_and_atomics),
    (Feature::OcclusionQueryPrecise, None, |f| &mut f.core.occlusion_query_precise),
    (Feature::PipelineStatistics, None, |f| &mut f.core.pipeline_statistics_query),
    (Feature::DepthClamp, None, |f| &mut f.core.depth_clamp),
    (Feature::DepthBounds, None, |f| &mut f.core.depth_bounds),
    (Feature::DepthBiasClamp, None, |f| &mut f.core.depth_bias_clamp),
    (Feature::ClipDistance, None, |f| &mut f.core.shader_clip_distance),
    (Feature::CullDistance, None, |f| &mut f.core.shader_cull_distance),
    (Feature::SampledImageDynamicIndexing, None, |f| &mut f.core.shader_sampled_image_array_dynamic_indexing),
    (Feature::SampledImageNonUniformIndexing, None, |f| &mut f.v12.shader_sampled_image_array_non_uniform_indexing),
    (Feature::StorageImageDynamicIndexing, None, |f| &mut f.core.shader_storage_image_array_dynamic_indexing),
    (Feature::StorageBufferDynamicIndexing, None, |f| &mut f.core.shader_storage_buffer_array_dynamic_indexing),
    (Feature::UniformBufferDynamicIndexing, None, |f| &mut f.core.shader_uniform_buffer_array_dynamic_indexing),
    (Feature::RuntimeDescriptorArray, None, |f| &mut f.v12.runtime_descriptor_array),
    (Feature::PartiallyBound, None, |f| &mut f.v12.descriptor_binding_partially_bound),
    (Feature::SamplerFilterMinmax, None, |f| &mut f.v12.sampler_filter_minmax),
    (Feature::SamplerAnisotropy, None, |f| &mut f.core.sampler_anisotropy),
    (Feature::DrawIndirectCount, None, |f| &mut f.v12.draw_indirect_count),
    (Feature::MultiDrawIndirect, None, |f| &mut f.core.multi_draw_indirect),
    (Feature::StorageReadWithoutFormat, None, |f| &mut f.core.shader_storage_image_read_without_format),
    (Feature::StorageWriteWithoutFormat, None, |f| &mut f.core.shader_storage_image_write_without_format),
    (Feature::StorageImageExtendedFormats, None, |f| &mut f.core.shader_storage_image_extended_formats),
    (Feature::StorageImageMultisample, None, |f| &mut f.core.shader_storage_image_multisample),
    (Feature::ImageGatherExtended, None, |f| &mut f.core.shader_image_gather_extended),
    (Feature::DualSourceBlend, None, |f| &mut f.core.dual_src_blend),
    (Feature::SampleRateShading, None, |f| &mut f.core.sample_rate_shading),
    (Feature::MultiViewport, None, |f| &mut f.core.multi_viewport),
    (Feature::FillModeNonSolid, None, |f| &mut f.core.fill_mode_non_solid),
    (Feature::WideLines, None, |f| &mut f.core.wide_lines),
    (Feature::LargePoints, None, |f| &mut f.core.large_points),
    (Feature::MultiviewGeometryShader, None, |f| &mut f.v11.multiview_geometry_shader),
    (Feature::Float16, None, |f| &mut f.v12.shader_float16),
    (Feature::Int16, None, |f| &mut f.core.shader_int16),
    (Feature::Int8, None, |f| &mut f.v12.shader_int8),
    (Feature::StorageBuffer16Bit, None, |f| &mut f.v11.storage_buffer16_bit_access),
    (Feature::StorageBuffer8Bit, None, |f| &mut f.v12.storage_buffer8_bit_access),
    (Feature::TextureCompressionBc, None, |f| &mut f.core.texture_compression_bc),
    (Feature::SubgroupSizeControl, None, |f| &mut f.v13.subgroup_size_control),
    (Feature::VulkanMemoryModel, None, |f| &mut f.v12.vulkan_memory_model),
    (Feature::VulkanMemoryModelDeviceScope, None, |f| &mut f.v12.vulkan_memory_model_device_scope),
    (Feature::FragmentShaderInterlock, Some(ash::ext::fragment_shader_interlock::NAME), |f| &mut f.interlock.fragment_shader_pixel_interlock),
    (Feature::OrderedAttachments, Some(ash::ext::rasterization_order_attachment_access::NAME), |f| &mut f.ordered.rasterization_order_color_attachment_access),
    (Feature::DepthClipEnable, Some(ash::ext::depth_clip_enable::NAME), |f| &mut f.depth_clip.depth_clip_enable),
    (Feature::TriangleFans, Some(ash::khr::portability_subset::NAME), |f| &mut f.portability.triangle_fans),
    (Feature::ImageView2DOn3D, Some(ash::khr::portability_subset::NAME), |f| &mut f.portability.image_view2_d_on3_d_image),
    (Feature::MutableComparisonSamplers, Some(ash::khr::portability_subset::NAME), |f| &mut f.portability.mutable_comparison_samplers),
    (Feature::SeparateStencilReference, Some(ash::khr::portability_subset::NAME), |f| &mut f.portability.separate_stencil_mask_ref),
];

/// Optional features that are an extension and nothing else.
const EXTENSIONS: &[(Feature, &CStr)] = &[
    (Feature::PushDescriptors, ash::khr::push_descriptor::NAME),
    (Feature::StencilExport, ash::ext::shader_stencil_export::NAME),
    (Feature::ConservativeRasterization, ash::ext::conservative_rasterization::NAME),
    (Feature::PostDepthCoverage, ash::ext::post_depth_coverage::NAME),
    (Feature::MemoryBudget, ash::ext::memory_budget::NAME),
    (Feature::CalibratedTimestamps, ash::ext::calibrated_timestamps::NAME),
];

/// What of all this a device has.
pub(super) struct Offer {
    pub missing: Vec<String>,
    pub optional: BTreeSet<Feature>,
    /// Device extensions by name.
    pub extensions: Vec<CString>,
}

impl Features {
    /// Asks a device.
    pub(super) fn offer(instance: &ash::Instance, physical: vk::PhysicalDevice, extensions: Vec<CString>) -> Offer {
        let has = |name: &CStr| extensions.iter().any(|e| e.as_c_str() == name);
        let mut features = Features::default();
        let mut chain = features.chain(&has);
        // SAFETY: the chain holds structures of 1.3 and of extensions that the device has.
        unsafe { instance.get_physical_device_features2(physical, &mut chain) };
        features.core = chain.features;

        let missing =
            REQUIRED.iter().filter(|(_, field)| *field(&mut features) == 0).map(|(n, _)| (*n).into()).collect();
        let mut optional = BTreeSet::new();
        for (feature, extension, field) in OPTIONAL {
            let there = match extension {
                // Where Vulkan is not a portability subset, what that one may lack is there.
                Some(e) if *e == ash::khr::portability_subset::NAME && !has(e) => true,
                Some(e) if !has(e) => false,
                _ => *field(&mut features) != 0,
            };
            if there {
                optional.insert(*feature);
            }
        }
        optional.extend(EXTENSIONS.iter().filter(|(_, e)| has(e)).map(|(f, _)| *f));
        // With the memory model but not this, GLSL's atomics, which are of device scope, would be forbidden.
        if !optional.contains(&Feature::VulkanMemoryModelDeviceScope) {
            optional.remove(&Feature::VulkanMemoryModel);
        }
        Offer { missing, optional, extensions }
    }

    /// Everything required, and these optional ones; with the extensions to enable.
    pub(super) fn enable(optional: &BTreeSet<Feature>, portability: bool) -> (Features, Vec<CString>) {
        let mut features = Features::default();
        let mut extensions: BTreeSet<CString> = BTreeSet::new();
        for (_, field) in REQUIRED {
            *field(&mut features) = vk::TRUE;
        }
        for (_, extension, field) in OPTIONAL.iter().filter(|(f, ..)| optional.contains(f)) {
            if let Some(e) = extension.filter(|e| portability || *e != ash::khr::portability_subset::NAME) {
                extensions.insert(e.into());
            }
            *field(&mut features) = vk::TRUE;
        }
        extensions.extend(EXTENSIONS.iter().filter(|(f, _)| optional.contains(f)).map(|(_, e)| CString::from(*e)));
        if portability {
            extensions.insert(ash::khr::portability_subset::NAME.into());
        }
        (features, extensions.into_iter().collect())
    }

    /// The structures as a chain: those of extensions only where `has` says so.
    pub(super) fn chain(&mut self, has: &dyn Fn(&CStr) -> bool) -> vk::PhysicalDeviceFeatures2<'_> {
        let mut chain = vk::PhysicalDeviceFeatures2::default()
            .features(self.core)
            .push_next(&mut self.v11)
            .push_next(&mut self.v12)
            .push_next(&mut self.v13);
        if has(ash::ext::shader_atomic_float::NAME) {
            chain = chain.push_next(&mut self.atomic_float);
        }
        if has(ash::ext::fragment_shader_interlock::NAME) {
            chain = chain.push_next(&mut self.interlock);
        }
        if has(ash::ext::rasterization_order_attachment_access::NAME) {
            chain = chain.push_next(&mut self.ordered);
        }
        if has(ash::ext::depth_clip_enable::NAME) {
            chain = chain.push_next(&mut self.depth_clip);
        }
        if has(ash::khr::portability_subset::NAME) {
            chain = chain.push_next(&mut self.portability);
        }
        chain
    }
}

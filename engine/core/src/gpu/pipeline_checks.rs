//! What can be told to be wrong with a pipeline before Vulkan sees it.

use ash::vk;

use super::device::Device;
use super::{Feature, FormatInfo, GraphicsPipelineInfo, Numeric};
use crate::shader::{OutputScalar, Shader, Stage};
use crate::{Error, Result};

/// The shader is of the stage that it is given for.
pub(super) fn check_stage(name: &str, shader: &Shader, stage: Stage) -> Result<()> {
    if shader.stage == stage {
        return Ok(());
    }
    let why = format!("{} is a {:?} shader, not a {stage:?} shader", shader.file, shader.stage);
    Err(Error::invalid(format!("pipeline {name:?}"), why))
}

/// The device can run the shader.
pub(super) fn check_shader(device: &Device, name: &str, shader: &Shader) -> Result<()> {
    let caps = &device.caps;
    let mut missing: Vec<String> = shader
        .capabilities
        .iter()
        .filter_map(|c| feature_of(c).filter(|f| !caps.has(*f)).map(|f| format!("{} for {c}", f.describe())))
        .collect();
    let limits = &caps.limits;
    let invocations: u32 = shader.workgroup.iter().product();
    if invocations > limits.max_compute_workgroup_invocations {
        let most = limits.max_compute_workgroup_invocations;
        missing.push(format!("workgroups of {invocations} invocations (it has {most})"));
    }
    if shader.workgroup.iter().zip(limits.max_compute_workgroup_size).any(|(&w, m)| w > m) {
        let most = limits.max_compute_workgroup_size;
        missing.push(format!("workgroups of {:?} (it has {most:?})", shader.workgroup));
    }
    if missing.is_empty() {
        return Ok(());
    }
    Err(Error::Missing { device: caps.title(), who: format!("{} of pipeline {name:?}", shader.file), missing })
}

/// The feature that a SPIR-V capability stands for; `None` for one that the engine requires or does not know.
fn feature_of(capability: &str) -> Option<Feature> {
    Some(match capability {
        "Geometry" => Feature::GeometryShader,
        "Tessellation" => Feature::TessellationShader,
        "ShaderLayer" | "ShaderViewportIndexLayerEXT" => Feature::LayerFromVertexShader,
        "ShaderViewportIndex" => Feature::ViewportFromVertexShader,
        "DrawParameters" => Feature::DrawParameters,
        "Int64" => Feature::Int64,
        "Int64Atomics" => Feature::Int64BufferAtomics,
        "Float64" => Feature::Float64,
        "Float16" => Feature::Float16,
        "Int16" => Feature::Int16,
        "Int8" => Feature::Int8,
        "AtomicFloat32AddEXT" => Feature::FloatBufferAtomicAdd,
        "StorageBuffer16BitAccess" | "StorageUniformBufferBlock16" => Feature::StorageBuffer16Bit,
        "StorageBuffer8BitAccess" => Feature::StorageBuffer8Bit,
        "ClipDistance" => Feature::ClipDistance,
        "CullDistance" => Feature::CullDistance,
        "SampleRateShading" => Feature::SampleRateShading,
        "MultiViewport" => Feature::MultiViewport,
        "SampledImageArrayDynamicIndexing" => Feature::SampledImageDynamicIndexing,
        "StorageImageArrayDynamicIndexing" => Feature::StorageImageDynamicIndexing,
        "StorageBufferArrayDynamicIndexing" => Feature::StorageBufferDynamicIndexing,
        "UniformBufferArrayDynamicIndexing" => Feature::UniformBufferDynamicIndexing,
        "SampledImageArrayNonUniformIndexing" => Feature::SampledImageNonUniformIndexing,
        "RuntimeDescriptorArray" => Feature::RuntimeDescriptorArray,
        "StorageImageReadWithoutFormat" => Feature::StorageReadWithoutFormat,
        "StorageImageWriteWithoutFormat" => Feature::StorageWriteWithoutFormat,
        "StorageImageExtendedFormats" => Feature::StorageImageExtendedFormats,
        "StorageImageMultisample" => Feature::StorageImageMultisample,
        "ImageGatherExtended" => Feature::ImageGatherExtended,
        "StencilExportEXT" => Feature::StencilExport,
        "FragmentShaderPixelInterlockEXT" => Feature::FragmentShaderInterlock,
        "GroupNonUniformBallot" => Feature::FragmentBallot,
        "SampleMaskPostDepthCoverage" => Feature::PostDepthCoverage,
        "VulkanMemoryModel" => Feature::VulkanMemoryModel,
        "VulkanMemoryModelDeviceScope" => Feature::VulkanMemoryModelDeviceScope,
        _ => return None,
    })
}

/// The device has the fixed functions that are asked for.
pub(super) fn check_state(device: &Device, info: &GraphicsPipelineInfo) -> Result<()> {
    let caps = &device.caps;
    let writes = |s: &Shader| s.bindings.iter().any(|b| b.access != crate::shader::ShaderAccess::Read);
    let fan = info.topology == vk::PrimitiveTopology::TRIANGLE_FAN;
    let wants = [
        (info.geometry.is_some(), Feature::GeometryShader),
        (info.geometry.is_some() && info.view_mask != 0, Feature::MultiviewGeometryShader),
        (info.depth_clamp, Feature::DepthClamp),
        (info.logic_op.is_some(), Feature::LogicOp),
        (fan, Feature::TriangleFans),
        (info.is_ordered(), Feature::OrderedAttachments),
        (writes(info.vertex) || info.geometry.is_some_and(writes), Feature::VertexStores),
    ];
    let mut missing: Vec<String> =
        wants.iter().filter(|(wanted, f)| *wanted && !caps.has(*f)).map(|(_, f)| f.describe()).collect();
    let limits = &caps.limits;
    let views = 32 - info.view_mask.leading_zeros();
    if views > limits.max_multiview_views {
        missing.push(format!("multiview of {views} views (it has {})", limits.max_multiview_views));
    }
    let colors = info.color.len() as u32;
    if colors > limits.max_color_attachments {
        missing.push(format!("{colors} colour attachments (it has {})", limits.max_color_attachments));
    }
    if info.samples & limits.framebuffer_sample_counts == 0 {
        missing.push(format!("{} samples (it has the bits {:#b})", info.samples, limits.framebuffer_sample_counts));
    }
    if missing.is_empty() {
        return Ok(());
    }
    Err(Error::Missing { device: caps.title(), who: format!("pipeline {:?}", info.name), missing })
}

/// Each output of the fragment shader has an attachment of its kind, and each attachment that is written an output.
pub(super) fn check_outputs(info: &GraphicsPipelineInfo) -> Result<()> {
    let mut problems = Vec::new();
    let outputs = info.fragment.map_or(&[][..], |f| f.outputs);
    let file = info.fragment.map_or("(no fragment shader)", |f| f.file);
    for output in outputs {
        let Some(target) = info.color.get(output.location as usize) else {
            problems.push(format!(
                "{file} writes {:?} to location {}, which has no attachment",
                output.name, output.location
            ));
            continue;
        };
        let wants = numeric(output.scalar);
        if FormatInfo::of(target.format).is_some_and(|f| f.numeric != wants) {
            problems
                .push(format!("{file} writes {:?} as {wants:?} to an attachment of {:?}", output.name, target.format));
        }
    }
    for (location, target) in info.color.iter().enumerate() {
        let written = !target.blend.color_write_mask.is_empty();
        if written && !outputs.iter().any(|o| o.location as usize == location) {
            problems.push(format!("{file} does not write attachment {location}; mask it out with blend::none()"));
        }
    }
    if info.is_ordered() && (info.color.len() != 1 || info.samples != 1 || info.view_mask != 0) {
        problems.push(format!("{file} reads its attachment in order: one of one sample, without multiview, can be"));
    }
    if problems.is_empty() {
        return Ok(());
    }
    Err(Error::invalid(format!("pipeline {:?}", info.name), problems.join("; ")))
}

/// Depth and stencil are of formats that have them, and of one image.
pub(super) fn check_tests(info: &GraphicsPipelineInfo) -> Result<()> {
    let (depth, stencil) = (info.depth.map(|d| d.format), info.stencil.map(|s| s.format));
    let mut problems = Vec::new();
    let asked = [(depth, vk::ImageAspectFlags::DEPTH), (stencil, vk::ImageAspectFlags::STENCIL)];
    for (format, aspect) in asked.into_iter().filter_map(|(format, aspect)| Some((format?, aspect))) {
        if FormatInfo::of(format).is_none_or(|known| !known.aspects.contains(aspect)) {
            problems.push(format!("{format:?} has no {aspect:?}"));
        }
    }
    if let (Some(depth), Some(stencil)) = (depth, stencil)
        && depth != stencil
    {
        problems.push(format!("depth is {depth:?} and the stencil {stencil:?}; both are of one image"));
    }
    if problems.is_empty() {
        return Ok(());
    }
    Err(Error::invalid(format!("pipeline {:?}", info.name), problems.join("; ")))
}

/// Each input of the vertex shader has an attribute of its kind, which lies within its vertex.
pub(super) fn check_inputs(info: &GraphicsPipelineInfo) -> Result<()> {
    let mut problems = Vec::new();
    let attributes: Vec<_> =
        info.vertex_buffers.iter().flat_map(|b| b.attributes.iter().map(move |a| (b, a))).collect();
    for input in info.vertex.inputs {
        let Some((_, attribute)) = attributes.iter().find(|(_, a)| a.location == input.location) else {
            problems.push(format!(
                "{} takes {:?} from location {}, which no vertex buffer has",
                info.vertex.file, input.name, input.location
            ));
            continue;
        };
        let wants = numeric(input.scalar);
        if FormatInfo::of(attribute.format).is_some_and(|f| f.numeric != wants) {
            problems.push(format!(
                "{} takes {:?} as {wants:?}, the attribute is {:?}",
                info.vertex.file, input.name, attribute.format
            ));
        }
    }
    for (buffer, attribute) in attributes {
        let size = FormatInfo::of(attribute.format).map_or(0, |f| f.block_bytes);
        if buffer.stride != 0 && attribute.offset.saturating_add(size) > buffer.stride {
            problems
                .push(format!("vertex attribute {} ends beyond the stride of {}", attribute.location, buffer.stride));
        }
    }
    if problems.is_empty() {
        return Ok(());
    }
    Err(Error::invalid(format!("pipeline {:?}", info.name), problems.join("; ")))
}

fn numeric(scalar: OutputScalar) -> Numeric {
    match scalar {
        OutputScalar::Float => Numeric::Float,
        OutputScalar::Uint => Numeric::Uint,
        OutputScalar::Int => Numeric::Sint,
    }
}

//! A graphics pipeline's fixed state in Vulkan's structures.

use ash::vk;

use super::GraphicsPipelineInfo;
use super::device::Device;
use super::render_pass::{Target, ordered_pass};
use crate::Result;

/// Makes the pipeline of these stages.
pub(super) fn create_graphics(
    device: &Device,
    info: &GraphicsPipelineInfo,
    stages: &[vk::PipelineShaderStageCreateInfo<'_>],
    layout: vk::PipelineLayout,
) -> Result<vk::Pipeline> {
    // 1. What goes in.
    let (mut buffers, mut attributes) = (Vec::new(), Vec::new());
    for (binding, buffer) in info.vertex_buffers.iter().enumerate() {
        let rate = if buffer.per_instance { vk::VertexInputRate::INSTANCE } else { vk::VertexInputRate::VERTEX };
        let binding = binding as u32;
        buffers.push(vk::VertexInputBindingDescription { binding, stride: buffer.stride, input_rate: rate });
        attributes.extend(buffer.attributes.iter().map(|a| vk::VertexInputAttributeDescription {
            location: a.location,
            binding,
            format: a.format,
            offset: a.offset,
        }));
    }
    let input = vk::PipelineVertexInputStateCreateInfo::default()
        .vertex_binding_descriptions(&buffers)
        .vertex_attribute_descriptions(&attributes);
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(info.topology);

    // 2. From primitives to fragments.
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let raster = vk::PipelineRasterizationStateCreateInfo::default()
        .depth_clamp_enable(info.depth_clamp)
        .polygon_mode(vk::PolygonMode::FILL)
        .depth_bias_enable(info.depth_bias)
        .line_width(1.0);
    let samples = vk::PipelineMultisampleStateCreateInfo::default()
        .rasterization_samples(vk::SampleCountFlags::from_raw(info.samples));

    // 3. From fragments to attachments.
    let mut depth_stencil = vk::PipelineDepthStencilStateCreateInfo::default();
    if let Some(depth) = info.depth {
        depth_stencil =
            depth_stencil.depth_test_enable(true).depth_write_enable(depth.write).depth_compare_op(depth.compare);
    }
    if let Some(stencil) = info.stencil {
        depth_stencil = depth_stencil.stencil_test_enable(true).front(stencil.front).back(stencil.back);
    }
    let targets: Vec<_> = info.color.iter().map(|c| c.blend).collect();
    let mut blending = vk::PipelineColorBlendStateCreateInfo::default().attachments(&targets);
    if let Some(op) = info.logic_op {
        blending = blending.logic_op_enable(true).logic_op(op);
    }
    let formats: Vec<_> = info.color.iter().map(|c| c.format).collect();
    let mut rendering = vk::PipelineRenderingCreateInfo::default()
        .view_mask(info.view_mask)
        .color_attachment_formats(&formats)
        .depth_attachment_format(info.depth.map_or(vk::Format::UNDEFINED, |d| d.format))
        .stencil_attachment_format(info.stencil.map_or(vk::Format::UNDEFINED, |s| s.format));

    // Ordered attachments ask for a render pass.
    let ordered = info.is_ordered();
    let pass = match (ordered, info.color.first()) {
        (true, Some(color)) => {
            blending =
                blending.flags(vk::PipelineColorBlendStateCreateFlags::RASTERIZATION_ORDER_ATTACHMENT_ACCESS_EXT);
            ordered_pass(device, Target::of(color.format), info.depth.map(|depth| Target::of(depth.format)))?
        }
        _ => vk::RenderPass::null(),
    };

    // 4. The pipeline.
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&[
        vk::DynamicState::VIEWPORT,
        vk::DynamicState::SCISSOR,
        vk::DynamicState::CULL_MODE,
        vk::DynamicState::FRONT_FACE,
        vk::DynamicState::DEPTH_BIAS,
        vk::DynamicState::STENCIL_REFERENCE,
    ]);
    let mut create = vk::GraphicsPipelineCreateInfo::default()
        .stages(stages)
        .vertex_input_state(&input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&samples)
        .depth_stencil_state(&depth_stencil)
        .color_blend_state(&blending)
        .dynamic_state(&dynamic)
        .layout(layout)
        .render_pass(pass);
    if !ordered {
        create = create.push_next(&mut rendering);
    }
    // SAFETY: valid structures whose features were checked; what they point at lives to the end of this function.
    let made = unsafe { device.raw.create_graphics_pipelines(device.pipeline_cache.cache, &[create], None) };
    // SAFETY: a pipeline does not keep its render pass.
    unsafe { device.raw.destroy_render_pass(pass, None) };
    Ok(made.map_err(|e| device.error("vkCreateGraphicsPipelines", info.name, e.1))?[0])
}

//! What a graphics pipeline is made of.

use ash::vk;

use super::{Constant, SetLayout};
use crate::shader::{BindingKind, Shader};

/// A graphics pipeline. Dynamic are viewport and scissor (one each), cull mode, front face, the values of the depth
/// bias (needed where `depth_bias` is set), and the stencil reference (needed where `stencil` is given).
#[derive(Clone, Copy)]
pub struct GraphicsPipelineInfo<'a> {
    /// Debug name.
    pub name: &'a str,
    /// Vertex shader.
    pub vertex: &'static Shader,
    /// Geometry shader ([`super::Feature::GeometryShader`]).
    pub geometry: Option<&'static Shader>,
    /// Fragment shader. SwiftShader draws nothing without one where clip distances are used.
    pub fragment: Option<&'static Shader>,
    /// Vertex buffers, by binding number.
    pub vertex_buffers: &'a [VertexBuffer<'a>],
    /// Points, lines, triangles.
    pub topology: vk::PrimitiveTopology,
    /// Colour attachments, by location.
    pub color: &'a [ColorTarget],
    /// Depth attachment.
    pub depth: Option<DepthState>,
    /// Stencil attachment.
    pub stencil: Option<StencilState>,
    /// Bit `i` set: view `i` is drawn (multiview). 0: no multiview.
    pub view_mask: u32,
    /// Samples a pixel.
    pub samples: u32,
    /// Depth is clamped, not clipped, at the near and far plane ([`super::Feature::DepthClamp`]).
    pub depth_clamp: bool,
    /// Depth bias is on; its values are dynamic.
    pub depth_bias: bool,
    /// Logic operation of all colour attachments, in place of blending ([`super::Feature::LogicOp`]).
    pub logic_op: Option<vk::LogicOp>,
    /// Specialisation constants of all stages, by `constant_id`.
    pub constants: &'a [(u32, Constant)],
    /// Layouts of sets that are shared with other pipelines; each must hold all bindings that the shaders have in
    /// that set.
    pub set_layouts: &'a [(u32, &'a SetLayout)],
}

impl<'a> GraphicsPipelineInfo<'a> {
    /// Triangles, one sample, no attachment, no fragment shader.
    pub fn new(name: &'a str, vertex: &'static Shader) -> Self {
        Self {
            name,
            vertex,
            geometry: None,
            fragment: None,
            vertex_buffers: &[],
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            color: &[],
            depth: None,
            stencil: None,
            view_mask: 0,
            samples: 1,
            depth_clamp: false,
            depth_bias: false,
            logic_op: None,
            constants: &[],
            set_layouts: &[],
        }
    }
}

impl GraphicsPipelineInfo<'_> {
    /// Whether fragments read the colour attachment that they write, in primitive order.
    pub(super) fn is_ordered(&self) -> bool {
        let reads = |shader: &Shader| shader.bindings.iter().any(|b| b.kind == BindingKind::InputAttachment);
        self.fragment.is_some_and(reads)
    }
}

/// One vertex buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VertexBuffer<'a> {
    /// Bytes from one vertex (or instance) to the next.
    pub stride: u32,
    /// Advances once an instance, not once a vertex.
    pub per_instance: bool,
    /// What lies in it.
    pub attributes: &'a [VertexAttribute],
}

/// One vertex attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VertexAttribute {
    /// `layout(location = …)` of the vertex shader's input.
    pub location: u32,
    /// Format.
    pub format: vk::Format,
    /// Bytes from the start of the vertex.
    pub offset: u32,
}

/// One colour attachment.
#[derive(Clone, Copy, Debug)]
pub struct ColorTarget {
    /// Format.
    pub format: vk::Format,
    /// Blending and write mask; see [`blend`].
    pub blend: vk::PipelineColorBlendAttachmentState,
}

impl ColorTarget {
    /// Overwrites all components.
    pub fn new(format: vk::Format) -> Self {
        Self { format, blend: blend::replace() }
    }
}

/// Common blend states.
pub mod blend {
    use ash::vk;

    /// Overwrites.
    pub fn replace() -> vk::PipelineColorBlendAttachmentState {
        vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA)
    }

    /// Writes nothing.
    pub fn none() -> vk::PipelineColorBlendAttachmentState {
        vk::PipelineColorBlendAttachmentState::default()
    }

    /// Premultiplied "over": `s + (1 - s.a) d`.
    pub fn over() -> vk::PipelineColorBlendAttachmentState {
        with(vk::BlendFactor::ONE, vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
    }

    /// `s + d`.
    pub fn add() -> vk::PipelineColorBlendAttachmentState {
        with(vk::BlendFactor::ONE, vk::BlendFactor::ONE)
    }

    /// `s + d` in colour, `(1 - s.a) d` in alpha: sums of what layers add, and the product of what they let through.
    pub fn add_and_hide() -> vk::PipelineColorBlendAttachmentState {
        add().src_alpha_blend_factor(vk::BlendFactor::ZERO).dst_alpha_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
    }

    /// `s_factor s + d_factor d`, in colour and alpha.
    pub fn with(s_factor: vk::BlendFactor, d_factor: vk::BlendFactor) -> vk::PipelineColorBlendAttachmentState {
        replace()
            .blend_enable(true)
            .src_color_blend_factor(s_factor)
            .dst_color_blend_factor(d_factor)
            .color_blend_op(vk::BlendOp::ADD)
            .src_alpha_blend_factor(s_factor)
            .dst_alpha_blend_factor(d_factor)
            .alpha_blend_op(vk::BlendOp::ADD)
    }
}

/// Depth attachment and test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DepthState {
    /// Format.
    pub format: vk::Format,
    /// New depth against the stored one.
    pub compare: vk::CompareOp,
    /// Whether it is written.
    pub write: bool,
}

/// Stencil attachment and test. The reference is dynamic.
#[derive(Clone, Copy, Debug)]
pub struct StencilState {
    /// Format.
    pub format: vk::Format,
    /// For triangles that face front.
    pub front: vk::StencilOpState,
    /// For those that face back.
    pub back: vk::StencilOpState,
}

/// Common stencil states.
pub mod stencil {
    use ash::vk;

    /// Changes nothing.
    pub fn keep() -> vk::StencilOpState {
        vk::StencilOpState::default().compare_op(vk::CompareOp::ALWAYS)
    }

    /// Does this to all eight bits wherever a fragment is that passes the depth test.
    pub fn on_pass(op: vk::StencilOp) -> vk::StencilOpState {
        keep().pass_op(op).compare_mask(0xff).write_mask(0xff)
    }
}

//! Compute and graphics pipelines, for dynamic rendering.

use ash::vk;

use super::{Gpu, SetLayout};
use crate::Result;
use crate::shader::{Binding, Shader};

/// A graphics pipeline. Dynamic are viewport and scissor (one each), cull mode, front face, depth bias where
/// `depth_bias` is set, and the stencil reference where `stencil` is given.
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

/// Value of a specialisation constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Constant {
    /// `bool`.
    Bool(bool),
    /// `uint`.
    U32(u32),
    /// `int`.
    I32(i32),
    /// `float`.
    F32(f32),
}

/// One binding of a pipeline, over all its stages.
#[derive(Clone, Debug, PartialEq)]
pub struct PipelineBinding {
    /// Set, number, name, kind; the access is that of all stages together.
    pub binding: Binding,
    /// Stages whose shaders have it.
    pub stages: vk::ShaderStageFlags,
    /// Their files.
    pub files: Vec<&'static str>,
}

/// A pipeline with its layout.
#[derive(Clone)]
pub struct Pipeline {}

impl Pipeline {
    /// The Vulkan handle.
    pub fn raw(&self) -> vk::Pipeline {
        unimplemented!()
    }

    /// Debug name.
    pub fn name(&self) -> &str {
        unimplemented!()
    }

    /// Its layout.
    pub fn layout(&self) -> vk::PipelineLayout {
        unimplemented!()
    }

    /// Graphics or compute.
    pub fn bind_point(&self) -> vk::PipelineBindPoint {
        unimplemented!()
    }

    /// Bindings of all stages, by set and number.
    pub fn bindings(&self) -> &[PipelineBinding] {
        unimplemented!()
    }

    /// Layout of a set, where the pipeline has it.
    pub fn set_layout(&self, _set: u32) -> Option<&SetLayout> {
        unimplemented!()
    }

    /// The push constants: stages and bytes, from offset 0; `None` where no stage has some.
    pub fn push(&self) -> Option<(vk::ShaderStageFlags, u32)> {
        unimplemented!()
    }

    /// Shaders, in the order of the stages.
    pub fn shaders(&self) -> &[&'static Shader] {
        unimplemented!()
    }

    /// Values of specialisation constants it was made with.
    pub fn constants(&self) -> &[(u32, Constant)] {
        unimplemented!()
    }

    /// Workgroup size; `[0; 3]` for graphics.
    pub fn workgroup(&self) -> [u32; 3] {
        unimplemented!()
    }
}

impl Gpu {
    /// Makes a compute pipeline. `constants` are specialisation constants by `constant_id`.
    ///
    /// # Errors
    /// [`crate::Error::Missing`] for capabilities and limits that the device lacks;
    /// [`crate::Error::Invalid`] for a shader of another stage; [`crate::Error::Vulkan`].
    pub fn compute_pipeline(
        &self,
        _name: &str,
        _shader: &'static Shader,
        _constants: &[(u32, Constant)],
    ) -> Result<Pipeline> {
        unimplemented!()
    }

    /// Makes a graphics pipeline.
    ///
    /// # Errors
    /// As [`Gpu::compute_pipeline`]; also [`crate::Error::Invalid`] naming both files where two stages disagree
    /// about a binding or the push constants, where a fragment output has no attachment of its kind, or where a set
    /// layout lacks a binding.
    pub fn graphics_pipeline(&self, _info: &GraphicsPipelineInfo) -> Result<Pipeline> {
        unimplemented!()
    }
}

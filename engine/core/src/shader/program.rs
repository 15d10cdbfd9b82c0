//! What a technique says of a pipeline: shaders and fixed state. Formats come from the pass's attachments, so a
//! program is plain data, and the pipelines behind it are made and kept by the device that runs it.

use std::sync::{Mutex, PoisonError};

use ash::vk;
use rustc_hash::FxHashMap;

use super::{ConstantSlot, Shader};
use crate::gpu::{
    ColorTarget, Constant, DepthState, Gpu, GraphicsPipelineInfo, Pipeline, SetLayout, StencilState, VertexBuffer,
    blend, stencil,
};
use crate::{Error, Result, parallel};

/// Shaders and fixed state of draws.
#[derive(Clone)]
pub struct Program {
    /// Vertex shader.
    pub vertex: &'static Shader,
    /// Geometry shader.
    pub geometry: Option<&'static Shader>,
    /// Fragment shader.
    pub fragment: Option<&'static Shader>,
    /// Vertex buffers, by binding number.
    pub vertex_buffers: &'static [VertexBuffer<'static>],
    /// Points, lines, triangles.
    pub topology: vk::PrimitiveTopology,
    /// Blending of all colour attachments.
    pub blend: vk::PipelineColorBlendAttachmentState,
    /// Depth test, and whether it writes. `None`: neither.
    pub depth: Option<(vk::CompareOp, bool)>,
    /// Stencil test of front and back faces. `None`: no test, nothing written.
    pub stencil: Option<(vk::StencilOpState, vk::StencilOpState)>,
    /// Depth is clamped, not clipped.
    pub depth_clamp: bool,
    /// Logic operation in place of blending.
    pub logic_op: Option<vk::LogicOp>,
    /// Specialisation constants.
    pub constants: Vec<(u32, Constant)>,
    /// Layouts of sets shared with other pipelines: the scene's material set.
    pub set_layouts: Vec<(u32, SetLayout)>,
}

impl Program {
    /// Triangles without vertex buffers, no test, no blending.
    pub fn new(vertex: &'static Shader, fragment: Option<&'static Shader>) -> Self {
        Self {
            vertex,
            geometry: None,
            fragment,
            vertex_buffers: &[],
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            blend: blend::replace(),
            depth: None,
            stencil: None,
            depth_clamp: false,
            logic_op: None,
            constants: Vec::new(),
            set_layouts: Vec::new(),
        }
    }

    /// With these vertex buffers.
    pub fn vertex_buffers(self, vertex_buffers: &'static [VertexBuffer<'static>]) -> Self {
        Self { vertex_buffers, ..self }
    }

    /// With a depth test.
    pub fn depth(self, compare: vk::CompareOp, write: bool) -> Self {
        Self { depth: Some((compare, write)), ..self }
    }

    /// With a stencil test of front and of back faces.
    pub fn stencil(self, front: vk::StencilOpState, back: vk::StencilOpState) -> Self {
        Self { stencil: Some((front, back)), ..self }
    }

    /// With blending.
    pub fn blend(self, blend: vk::PipelineColorBlendAttachmentState) -> Self {
        Self { blend, ..self }
    }

    /// With a set shared with other pipelines.
    pub fn set_layout(mut self, set: u32, layout: &SetLayout) -> Self {
        self.set_layouts.push((set, layout.clone()));
        self
    }

    /// With the value of a specialisation constant.
    pub fn constant<T: Into<Constant>>(mut self, slot: ConstantSlot<T>, value: T) -> Self {
        self.constants.push((slot.id(), value.into()));
        self
    }

    /// All its shaders.
    pub fn shaders(&self) -> impl Iterator<Item = &'static Shader> {
        [Some(self.vertex), self.geometry, self.fragment].into_iter().flatten()
    }
}

/// What a pass adds to a program: its attachments.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Targets {
    /// Formats of colour attachments, by location.
    pub color: Vec<vk::Format>,
    /// Format of the depth attachment.
    pub depth: Option<vk::Format>,
    /// Format of the stencil attachment.
    pub stencil: Option<vk::Format>,
    /// Views drawn at once; 0: no multiview.
    pub view_mask: u32,
    /// Samples a pixel.
    pub samples: u32,
}

/// The pipelines of a device, made at first use.
#[derive(Default)]
pub struct Pipelines {
    made: Mutex<FxHashMap<Key, Pipeline>>,
}

type Key = Vec<u64>;

/// What a pipeline is made from.
#[derive(Clone, Copy)]
pub enum Wanted<'a> {
    /// A compute shader, with its specialisation constants.
    Compute(&'static Shader, &'a [(u32, Constant)]),
    /// A program for a pass's attachments.
    Graphics(&'a Program, &'a Targets),
}

impl Pipelines {
    /// A pipeline for each, in order. Those that are not there yet are made on all cores: a software driver takes
    /// milliseconds for each.
    ///
    /// # Errors
    /// As [`Gpu::compute_pipeline`] and [`Gpu::graphics_pipeline`].
    pub fn all(&self, gpu: &Gpu, wanted: &[Wanted]) -> Result<Vec<Pipeline>> {
        // 1. Find what is there. Passes of one program often come in a row.
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let mut found: Vec<Option<Pipeline>> = Vec::with_capacity(wanted.len());
        let mut missing: FxHashMap<Key, Vec<usize>> = FxHashMap::default();
        let mut key = Key::new();
        for (place, one) in wanted.iter().enumerate() {
            if place > 0 && one.is_as(&wanted[place - 1]) && found[place - 1].is_some() {
                found.push(found[place - 1].clone());
                continue;
            }
            key.clear();
            one.key(&mut key);
            let known = made.get(&key).cloned();
            if known.is_none() {
                missing.entry(key.clone()).or_default().push(place);
            }
            found.push(known);
        }
        // 2. Make the rest, in the order they are wanted in: the first failure is the one to tell.
        let mut missing: Vec<(Key, Vec<usize>)> = missing.into_iter().collect();
        missing.sort_unstable_by_key(|(_, places)| places[0]);
        let first = |index: usize| &wanted[missing[index].1[0]];
        let make = |index: usize| first(index).make(gpu);
        let fault = |index: usize| Error::invalid(first(index).name(), "made the driver's compiler panic");
        let new = parallel::map(missing.len(), make, fault)?;
        for ((key, places), pipeline) in missing.into_iter().zip(new) {
            places.into_iter().for_each(|place| found[place] = Some(pipeline.clone()));
            made.insert(key, pipeline);
        }
        // 3. Hand them out.
        Ok(found.into_iter().flatten().collect())
    }
}

impl Wanted<'_> {
    fn name(&self) -> &'static str {
        match self {
            Self::Compute(shader, _) => shader.file,
            Self::Graphics(program, _) => program.fragment.unwrap_or(program.vertex).file,
        }
    }

    /// Whether it is plain to see that both are one pipeline.
    fn is_as(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Compute(a, constants), Self::Compute(b, others)) => std::ptr::eq(*a, *b) && constants == others,
            _ => false,
        }
    }

    /// Everything that tells two pipelines apart, in words.
    fn key(&self, key: &mut Key) {
        match self {
            Self::Compute(shader, constants) => {
                key.push(address(Some(shader)));
                push_constants(key, constants);
            }
            Self::Graphics(program, targets) => graphics_key(key, program, targets),
        }
    }

    fn make(&self, gpu: &Gpu) -> Result<Pipeline> {
        let (program, targets) = match *self {
            Self::Compute(shader, constants) => return gpu.compute_pipeline(shader.file, shader, constants),
            Self::Graphics(program, targets) => (program, targets),
        };
        let color: Vec<_> = targets.color.iter().map(|&format| ColorTarget { format, blend: program.blend }).collect();
        let depth = targets.depth.map(|format| {
            let (compare, write) = program.depth.unwrap_or((vk::CompareOp::ALWAYS, false));
            DepthState { format, compare, write }
        });
        let stencil = targets.stencil.map(|format| {
            let (front, back) = program.stencil.unwrap_or((stencil::keep(), stencil::keep()));
            StencilState { format, front, back }
        });
        let sets: Vec<_> = program.set_layouts.iter().map(|(set, layout)| (*set, layout)).collect();
        gpu.graphics_pipeline(&GraphicsPipelineInfo {
            geometry: program.geometry,
            fragment: program.fragment,
            vertex_buffers: program.vertex_buffers,
            topology: program.topology,
            color: &color,
            depth,
            stencil,
            view_mask: targets.view_mask,
            samples: targets.samples,
            depth_clamp: program.depth_clamp,
            logic_op: program.logic_op,
            constants: &program.constants,
            set_layouts: &sets,
            ..GraphicsPipelineInfo::new(self.name(), program.vertex)
        })
    }
}

fn graphics_key(key: &mut Key, program: &Program, targets: &Targets) {
    key.extend([
        address(Some(program.vertex)),
        address(program.geometry),
        address(program.fragment),
        program.vertex_buffers.as_ptr().addr() as u64,
        program.vertex_buffers.len() as u64,
        program.topology.as_raw() as u64,
        u64::from(program.depth_clamp),
        program.logic_op.map_or(u64::MAX, |op| op.as_raw() as u64),
        program.depth.map_or(u64::MAX, |(compare, write)| (compare.as_raw() as u64) << 1 | u64::from(write)),
        targets.depth.map_or(u64::MAX, |format| format.as_raw() as u64),
        targets.stencil.map_or(u64::MAX, |format| format.as_raw() as u64),
        u64::from(targets.view_mask) << 32 | u64::from(targets.samples),
        targets.color.len() as u64,
    ]);
    key.extend(targets.color.iter().map(|format| format.as_raw() as u64));
    let b = program.blend;
    key.extend([
        u64::from(b.blend_enable) << 32 | u64::from(b.color_write_mask.as_raw()),
        (b.src_color_blend_factor.as_raw() as u64) << 32 | b.dst_color_blend_factor.as_raw() as u64,
        (b.src_alpha_blend_factor.as_raw() as u64) << 32 | b.dst_alpha_blend_factor.as_raw() as u64,
        (b.color_blend_op.as_raw() as u64) << 32 | b.alpha_blend_op.as_raw() as u64,
    ]);
    if let Some((front, back)) = program.stencil {
        for s in [front, back] {
            key.extend(
                [s.fail_op.as_raw(), s.pass_op.as_raw(), s.depth_fail_op.as_raw(), s.compare_op.as_raw()]
                    .map(|v| v as u64),
            );
            key.extend([s.compare_mask, s.write_mask].map(u64::from));
        }
    }
    push_constants(key, &program.constants);
    key.extend(
        program.set_layouts.iter().flat_map(|(set, layout)| [u64::from(*set), vk::Handle::as_raw(layout.raw())]),
    );
}

fn address(shader: Option<&'static Shader>) -> u64 {
    shader.map_or(0, |shader| std::ptr::from_ref(shader).addr() as u64)
}

fn push_constants(key: &mut Key, constants: &[(u32, Constant)]) {
    key.push(constants.len() as u64);
    for &(id, value) in constants {
        let bits = match value {
            Constant::Bool(value) => u32::from(value),
            Constant::U32(value) => value,
            Constant::I32(value) => value as u32,
            Constant::F32(value) => value.to_bits(),
        };
        key.push(u64::from(id) << 32 | u64::from(bits));
    }
}

//! Draw lists: what to draw, in buckets of equal state.

use std::ops::Range;

use ash::vk;
use glam::Vec3;

use super::{AlphaMode, GpuScene};
use crate::Result;
use crate::geometry::{Aabb, Frustum};
use crate::gpu::{VertexAttribute, VertexBuffer};
use crate::graph::Recorder;

/// What a material's alpha asks of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DrawClass {
    /// No alpha.
    Opaque,
    /// Alpha test.
    Masked,
    /// Composited, back to front.
    Blend,
}

impl DrawClass {
    /// Class of a material.
    pub fn of(mode: AlphaMode) -> Self {
        match mode {
            AlphaMode::Opaque => Self::Opaque,
            AlphaMode::Mask { .. } => Self::Masked,
            AlphaMode::Blend => Self::Blend,
        }
    }
}

/// One indexed, instanced draw.
#[derive(Clone, Debug)]
pub struct Draw {
    /// What its alpha asks.
    pub class: DrawClass,
    /// No back-face culling.
    pub double_sided: bool,
    /// The transform turns the winding around.
    pub mirrored: bool,
    /// Index of the material.
    pub material: usize,
    /// In the scene's index buffer.
    pub indices: Range<u32>,
    /// Added to each index.
    pub vertex_offset: i32,
    /// In the scene's instance buffer.
    pub instances: Range<u32>,
    /// World-space bounds of all its instances.
    pub bounds: Aabb,
}

/// Draws, sorted by state.
#[derive(Clone, Debug, Default)]
pub struct DrawList {
    draws: Vec<Draw>,
}

/// Which faces a pass draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Faces {
    /// As the material says.
    Material,
    /// Both sides of everything (shadow casters).
    Both,
}

impl DrawList {
    /// A list of these draws, which are sorted by state already.
    pub fn new(draws: Vec<Draw>) -> Self {
        Self { draws }
    }

    /// All draws.
    pub fn draws(&self) -> &[Draw] {
        &self.draws
    }

    /// World-space bounds of all draws; `None` of nothing.
    pub fn bounds(&self) -> Option<Aabb> {
        self.draws.iter().map(|draw| draw.bounds).reduce(Aabb::union)
    }

    /// The draws of a class that touch one of the frusta (all where there are none).
    pub fn visible(&self, class: DrawClass, frusta: &[Frustum]) -> Vec<&Draw> {
        let seen = |draw: &&Draw| frusta.is_empty() || frusta.iter().any(|frustum| frustum.touches(&draw.bounds));
        self.draws.iter().filter(|draw| draw.class == class).filter(seen).collect()
    }

    /// The blended draws that touch a frustum, farthest centre first; equally far ones in the scene's order.
    pub fn back_to_front(&self, frustum: &Frustum, eye: Vec3) -> Vec<&Draw> {
        let mut draws = self.visible(DrawClass::Blend, std::slice::from_ref(frustum));
        draws.sort_by(|a, b| {
            let distance = |draw: &Draw| draw.bounds.center().distance_squared(eye);
            distance(b).total_cmp(&distance(a))
        });
        draws
    }
}

/// Vertex buffers of a pass that needs positions alone.
pub const POSITIONS: &[VertexBuffer<'static>] = &[VertexBuffer {
    stride: 12,
    per_instance: false,
    attributes: &[VertexAttribute { location: 0, format: vk::Format::R32G32B32_SFLOAT, offset: 0 }],
}];

const ALPHA: VertexBuffer<'static> = VertexBuffer {
    stride: 32,
    per_instance: false,
    attributes: &[
        VertexAttribute { location: 1, format: vk::Format::R32G32_SFLOAT, offset: 0 },
        VertexAttribute { location: 2, format: vk::Format::R32G32_SFLOAT, offset: 8 },
        VertexAttribute { location: 3, format: vk::Format::R32G32B32A32_SFLOAT, offset: 16 },
    ],
};

/// Vertex buffers of a pass that tests alpha.
pub const ALPHA_TESTED: &[VertexBuffer<'static>] = &[POSITIONS[0], ALPHA];

/// Vertex buffers of a pass that shades.
pub const SHADED: &[VertexBuffer<'static>] = &[
    POSITIONS[0],
    ALPHA,
    VertexBuffer {
        stride: 28,
        per_instance: false,
        attributes: &[
            VertexAttribute { location: 4, format: vk::Format::R32G32B32_SFLOAT, offset: 0 },
            VertexAttribute { location: 5, format: vk::Format::R32G32B32A32_SFLOAT, offset: 12 },
        ],
    },
];

impl GpuScene {
    /// Records draws with the recorder's current program.
    pub fn draw(&self, recorder: &mut Recorder, faces: Faces, draws: &[&Draw]) -> Result<()> {
        recorder.index_buffer(&self.indices);
        recorder.vertex_buffers(&[&self.positions, &self.alpha_attributes, &self.shading_attributes]);
        for draw in draws {
            let cull = if draw.double_sided || faces == Faces::Both {
                vk::CullModeFlags::NONE
            } else {
                vk::CullModeFlags::BACK
            };
            recorder.faces(cull, draw.mirrored);
            recorder.material(&self.material_sets[draw.material]);
            recorder.draw_indexed(draw.indices.clone(), draw.vertex_offset, draw.instances.clone());
        }
        Ok(())
    }
}

//! Draw lists: what to draw, in buckets of equal state.

use std::collections::BTreeSet;
use std::mem::offset_of;
use std::ops::Range;

use ash::vk;
use glam::Vec3;

use super::{AlphaMode, GpuScene, Material};
use crate::geometry::{Aabb, Frustum};
use crate::gpu::{VertexAttribute, VertexBuffer};
use crate::graph::{RasterPass, Recorder};
use crate::shader::generated::blocks::Instance;
use crate::shader::generated::surface::gbuffer::gbuffer_pulled_vert as pulled;

/// What a material asks of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DrawClass {
    /// Hides all behind.
    Opaque,
    /// Alpha test.
    Masked,
    /// Composited, back to front.
    Blend,
}

impl DrawClass {
    /// Class of a material.
    pub fn of(material: &Material) -> Self {
        match material.alpha_mode {
            _ if material.is_blended() => Self::Blend,
            AlphaMode::Mask { .. } => Self::Masked,
            _ => Self::Opaque,
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
    /// Textures that the material has, as bits in the order of set 1.
    pub textures: u32,
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
    /// World-space bounds, by place in the scene's instance buffer.
    instance_bounds: Vec<Aabb>,
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
    /// A list of these draws, which are sorted by state already. `instance_bounds`: world-space bounds of each
    /// instance, by its place in the instance buffer.
    pub fn new(draws: Vec<Draw>, instance_bounds: Vec<Aabb>) -> Self {
        Self { draws, instance_bounds }
    }

    /// All draws.
    pub fn draws(&self) -> &[Draw] {
        &self.draws
    }

    /// World-space bounds of all draws; `None` of nothing.
    pub fn bounds(&self) -> Option<Aabb> {
        self.draws.iter().map(|draw| draw.bounds).reduce(Aabb::union)
    }

    /// Every combination of textures among draws of these classes, each once; the empty one where there is no draw.
    pub fn texture_sets(&self, classes: &[DrawClass]) -> Vec<u32> {
        let of_class = self.draws.iter().filter(|draw| classes.contains(&draw.class));
        let sets: BTreeSet<_> = of_class.map(|draw| draw.textures).collect();
        if sets.is_empty() { vec![0] } else { sets.into_iter().collect() }
    }

    /// What of the draws of a class touches one of the frusta (all where there are none): a draw for each run of
    /// instances that do.
    pub fn visible(&self, class: DrawClass, frusta: &[Frustum]) -> Vec<Draw> {
        let seen = |bounds: &Aabb| frusta.is_empty() || frusta.iter().any(|frustum| frustum.touches(bounds));
        let mut visible: Vec<Draw> = Vec::new();
        for draw in self.draws.iter().filter(|draw| draw.class == class && seen(&draw.bounds)) {
            let first = visible.len();
            for instance in draw.instances.clone() {
                // An instance that nobody knows the bounds of is seen.
                let bounds = self.instance_bounds.get(instance as usize).copied().unwrap_or(draw.bounds);
                if !seen(&bounds) {
                    continue;
                }
                match visible[first..].last_mut() {
                    Some(run) if run.instances.end == instance => {
                        run.instances.end += 1;
                        run.bounds = run.bounds.union(bounds);
                    }
                    _ => visible.push(Draw { instances: instance..instance + 1, bounds, ..draw.clone() }),
                }
            }
        }
        visible
    }

    /// The blended draws that touch a frustum, farthest centre first; equally far ones in the scene's order.
    pub fn back_to_front(&self, frustum: &Frustum, eye: Vec3) -> Vec<Draw> {
        let mut draws = self.visible(DrawClass::Blend, std::slice::from_ref(frustum));
        draws.sort_by(|a, b| {
            let distance = |draw: &Draw| draw.bounds.center().distance_squared(eye);
            distance(b).total_cmp(&distance(a))
        });
        draws
    }
}

const FLOAT3: vk::Format = vk::Format::R32G32B32_SFLOAT;
const FLOAT4: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

const fn attribute(location: u32, format: vk::Format, offset: usize) -> VertexAttribute {
    VertexAttribute { location, format, offset: offset as u32 }
}

const fn per_instance(attributes: &'static [VertexAttribute]) -> VertexBuffer<'static> {
    VertexBuffer { stride: size_of::<Instance>() as u32, per_instance: true, attributes }
}

/// What `common/instance_transform.glsl` reads.
const TRANSFORM: [VertexAttribute; 3] = {
    let rows = offset_of!(Instance, world_from_object);
    [attribute(6, FLOAT4, rows), attribute(7, FLOAT4, rows + 16), attribute(8, FLOAT4, rows + 32)]
};

/// What `common/surface_vertex.glsl` reads of an instance.
const INSTANCE: [VertexAttribute; 8] = {
    let [x, y, z] = TRANSFORM;
    let normals = offset_of!(Instance, normal_from_object);
    let [normal_x, normal_y, normal_z] =
        [attribute(9, FLOAT3, normals), attribute(10, FLOAT3, normals + 12), attribute(11, FLOAT3, normals + 24)];
    let handedness = attribute(12, vk::Format::R32_SFLOAT, offset_of!(Instance, handedness));
    let numbers = attribute(13, vk::Format::R32G32B32A32_UINT, offset_of!(Instance, object));
    assert!(offset_of!(Instance, first_blended) == offset_of!(Instance, object) + 12, "four numbers side by side");
    [x, y, z, normal_x, normal_y, normal_z, handedness, numbers]
};

const POSITION: VertexBuffer<'static> =
    VertexBuffer { stride: 12, per_instance: false, attributes: &[attribute(0, FLOAT3, 0)] };

/// Vertex buffers of a pass that needs positions alone.
pub const POSITIONS: &[VertexBuffer<'static>] = &[per_instance(&TRANSFORM), POSITION];

const ALPHA: VertexBuffer<'static> = VertexBuffer {
    stride: 32,
    per_instance: false,
    attributes: &[
        attribute(1, vk::Format::R32G32_SFLOAT, 0),
        attribute(2, vk::Format::R32G32_SFLOAT, 8),
        attribute(3, FLOAT4, 16),
    ],
};

/// Vertex buffers of a pass that tests alpha.
pub const ALPHA_TESTED: &[VertexBuffer<'static>] = &[per_instance(&TRANSFORM), POSITION, ALPHA];

/// Vertex buffers of a pass that shades.
pub const SHADED: &[VertexBuffer<'static>] = &[
    per_instance(&INSTANCE),
    POSITION,
    ALPHA,
    VertexBuffer { stride: 28, per_instance: false, attributes: &[attribute(4, FLOAT3, 0), attribute(5, FLOAT4, 12)] },
];

impl GpuScene {
    /// Whether some material that is drawn multiplies the light that passes, channel by channel.
    pub fn transmits(&self) -> bool {
        self.draws.draws().iter().any(|draw| self.materials[draw.material].is_transmissive())
    }

    /// Records draws with the recorder's current program.
    pub fn draw(&self, recorder: &mut Recorder, faces: Faces, draws: &[Draw]) {
        recorder.index_buffer(&self.indices);
        recorder.vertex_buffers(&[&self.instances, &self.positions, &self.alpha_attributes, &self.shading_attributes]);
        for draw in draws {
            self.state(recorder, faces, draw);
            recorder.draw_indexed(draw.indices.clone(), draw.vertex_offset, draw.instances.clone());
        }
    }

    /// Records draws as one of a pass's views sees them, with the program made for their textures: program `i` of the pass
    /// samples `texture_sets[i]`. `pull`: its vertex shader pulls its vertices ([`GpuScene::bind_pulled`]).
    pub fn draw_by_textures(
        &self,
        recorder: &mut Recorder,
        texture_sets: &[u32],
        draws: &[Draw],
        pull: bool,
        (view, faces): (u32, Faces),
    ) {
        for run in draws.chunk_by(|a, b| a.textures == b.textures) {
            let program = texture_sets.iter().position(|&set| set == run[0].textures);
            recorder.program(program.unwrap_or(0));
            recorder.push(&view);
            match pull {
                true => self.draw_pulled(recorder, faces, run),
                false => self.draw(recorder, faces, run),
            }
        }
    }

    /// What a vertex shader of `common/surface_vertex.glsl` reads that pulls its vertices.
    pub fn bind_pulled(&self, pass: &mut RasterPass) {
        pass.constant(pulled::INSTANCES, &self.instances)
            .constant(pulled::INDICES, &self.indices)
            .constant(pulled::POSITIONS, &self.positions)
            .constant(pulled::ALPHA_VERTICES, &self.alpha_attributes)
            .constant(pulled::SHADING_VERTICES, &self.shading_attributes);
    }

    /// As [`GpuScene::draw`], for programs whose vertex shader pulls its vertices: `gl_VertexIndex` is the place in the
    /// index buffer.
    pub fn draw_pulled(&self, recorder: &mut Recorder, faces: Faces, draws: &[Draw]) {
        for draw in draws {
            self.state(recorder, faces, draw);
            recorder.draw(draw.indices.clone(), draw.instances.clone());
        }
    }

    fn state(&self, recorder: &mut Recorder, faces: Faces, draw: &Draw) {
        let both = draw.double_sided || faces == Faces::Both;
        recorder.faces(if both { vk::CullModeFlags::NONE } else { vk::CullModeFlags::BACK }, draw.mirrored);
        recorder.material(&self.material_sets[draw.material]);
    }
}

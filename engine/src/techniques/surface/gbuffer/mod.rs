//! G-buffer: geometry and material of the first opaque surface of each pixel (Saito and Takahashi 1990,
//! "Comprehensible rendering of 3-D shapes").

use ash::vk;

use crate::gpu::Feature;
use crate::graph::{Graph, ImageHandle, ImageShape, Load};
use crate::scene::{DrawClass, Faces, GpuScene, SHADED, View, ViewSet};
use crate::shader::Program;
use crate::shader::generated::surface::gbuffer::{
    gbuffer_frag, gbuffer_pulled_frag, gbuffer_pulled_vert, gbuffer_vert,
};

/// G-buffer pass.
#[derive(Clone, Copy, Debug, Default)]
pub struct GBuffer {
    precision: Precision,
    pull_vertices: bool,
}

/// How finely the buffers are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 8 bits for albedo (sRGB-encoded), roughness and metallic; half-floats for normals and emission.
    #[default]
    Compact,
    /// 32-bit floats.
    Float,
}

/// What a camera sees of the first opaque surfaces. Pixels without one hold zeros, depth the farthest value.
pub struct Surfaces {
    /// D32, as [`crate::scene::depth`] says.
    pub depth: ImageHandle,
    /// Linear base colour; ambient occlusion in A.
    pub albedo: ImageHandle,
    /// World-space shading normal, unit length.
    pub normal: ImageHandle,
    /// Perceptual roughness, metallic, unlit.
    pub material: ImageHandle,
    /// Emitted radiance, cd/m².
    pub emissive: ImageHandle,
    /// Object, primitive, material, each from 1; the triangle's own normal, packed as in `common/normals.glsl`.
    pub ids: ImageHandle,
}

impl GBuffer {
    /// With this precision.
    pub fn precision(self, precision: Precision) -> Self {
        Self { precision, ..self }
    }

    /// Fetches vertices by hand even where the device has geometry shaders and need not: slower, the same picture.
    pub fn pull_vertices(self) -> Self {
        Self { pull_vertices: true, ..self }
    }

    /// Draws what is exactly at `depth`, which a depth pre-pass of the same view made.
    pub fn record<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, view: &View, depth: ImageHandle) -> Surfaces {
        let (albedo, normal, material, emissive) = match self.precision {
            Precision::Compact => (
                vk::Format::R8G8B8A8_SRGB,
                vk::Format::R16G16B16A16_SFLOAT,
                vk::Format::R8G8B8A8_UNORM,
                vk::Format::R16G16B16A16_SFLOAT,
            ),
            Precision::Float => {
                let float = vk::Format::R32G32B32A32_SFLOAT;
                (float, float, float, float)
            }
        };
        let mut image =
            |name: &str, format| graph.image(format!("gbuffer.{name}"), ImageShape::new_2d(format, view.size));
        let albedo = image("albedo", albedo);
        let normal = image("normal", normal);
        let material = image("material", material);
        let emissive = image("emissive", emissive);
        let ids = image("ids", vk::Format::R32G32B32A32_UINT);

        let views = ViewSet::from(*view);
        let frusta = views.frusta();
        let pull = self.pull_vertices || !graph.caps().has(Feature::GeometryShader);
        let texture_sets = scene.draws.texture_sets(&[DrawClass::Opaque, DrawClass::Masked]);
        let program = match pull {
            true => Program::new(&gbuffer_pulled_vert::SHADER, Some(&gbuffer_pulled_frag::SHADER)),
            false => Program::new(&gbuffer_vert::SHADER, Some(&gbuffer_frag::SHADER)).vertex_buffers(SHADED),
        };
        let program = program.depth(vk::CompareOp::EQUAL, false).set_layout(1, &scene.material_layout);
        let one_each = texture_sets.iter().map(|&set| program.clone().constant(gbuffer_frag::TEXTURES, set));
        let mut pass = graph.raster("gbuffer", one_each.collect());
        pass.uniform(gbuffer_vert::VIEWS, &views.block()).depth_test(&depth);
        if pull {
            scene.bind_pulled(&mut pass);
        }
        let none = Load::Clear([0.0; 4]);
        let albedo = pass.color(gbuffer_frag::ALBEDO, albedo, none);
        let normal = pass.color(gbuffer_frag::NORMAL, normal, none);
        let material = pass.color(gbuffer_frag::ROUGHNESS_METALLIC, material, none);
        let emissive = pass.color(gbuffer_frag::EMISSIVE, emissive, none);
        let ids = pass.color_uint(gbuffer_frag::IDS, ids, Load::Clear([0; 4]));
        pass.draw(move |recorder| {
            for class in [DrawClass::Opaque, DrawClass::Masked] {
                let draws = scene.draws.visible(class, &frusta);
                scene.draw_by_textures(recorder, &texture_sets, &draws, pull, (0, Faces::Material));
            }
            Ok(())
        });
        Surfaces { depth, albedo, normal, material, emissive, ids }
    }
}

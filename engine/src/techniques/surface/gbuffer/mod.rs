//! G-buffer: geometry and material of the first opaque surface of each pixel (Saito and Takahashi 1990,
//! "Comprehensible rendering of 3-D shapes").

use ash::vk;

use crate::graph::{Graph, ImageHandle, ImageShape, Load};
use crate::scene::{DrawClass, Faces, GpuScene, SHADED, View, ViewSet};
use crate::shader::Program;
use crate::shader::generated::surface::gbuffer::{gbuffer_frag, gbuffer_vert};

/// G-buffer pass.
#[derive(Clone, Copy, Debug, Default)]
pub struct GBuffer {
    precision: Precision,
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
        Self { precision }
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
        let program = Program::new(&gbuffer_vert::SHADER, Some(&gbuffer_frag::SHADER))
            .vertex_buffers(SHADED)
            .depth(vk::CompareOp::EQUAL, false)
            .set_layout(1, &scene.material_layout);
        let mut pass = graph.raster("gbuffer", vec![program]);
        pass.uniform(gbuffer_vert::VIEWS, &views.block())
            .constant(gbuffer_vert::INSTANCES, &scene.instances)
            .depth_test(&depth);
        let none = Load::Clear([0.0; 4]);
        let albedo = pass.color(gbuffer_frag::ALBEDO, albedo, none);
        let normal = pass.color(gbuffer_frag::NORMAL, normal, none);
        let material = pass.color(gbuffer_frag::ROUGHNESS_METALLIC, material, none);
        let emissive = pass.color(gbuffer_frag::EMISSIVE, emissive, none);
        let ids = pass.color_uint(gbuffer_frag::IDS, ids, Load::Clear([0; 4]));
        pass.draw(move |recorder| {
            recorder.push(&0u32);
            for class in [DrawClass::Opaque, DrawClass::Masked] {
                scene.draw(recorder, Faces::Material, &scene.draws.visible(class, &frusta))?;
            }
            Ok(())
        });
        Surfaces { depth, albedo, normal, material, emissive, ids }
    }
}

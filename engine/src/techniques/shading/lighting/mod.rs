//! Deferred shading: glTF's metallic-roughness BRDF under punctual lights and a constant environment.

use ash::vk;
use glam::Vec3;

use crate::gpu::SamplerInfo;
use crate::graph::{Graph, ImageHandle, ImageShape};
use crate::scene::{GpuScene, View, ViewSet};
use crate::shader::generated::{blocks, shading::lighting::lighting_comp as shader};

/// Deferred shading pass.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lighting {
    /// Radiance that comes from everywhere, cd/m².
    pub environment: Vec3,
}

/// What the pass reads of the first opaque surface; see `surface::gbuffer`.
pub struct LightingInput<'h> {
    /// Depth.
    pub depth: &'h ImageHandle,
    /// Linear base colour; ambient occlusion in A.
    pub albedo: &'h ImageHandle,
    /// World-space normal.
    pub normal: &'h ImageHandle,
    /// Roughness, metallic, unlit.
    pub material: &'h ImageHandle,
    /// Emitted radiance.
    pub emissive: &'h ImageHandle,
    /// Lights, from [`crate::scene::light_block`].
    pub lights: &'h blocks::Lights,
    /// Visibility of lights by layer, 1 is lit; `None` where no light has a mask.
    pub masks: Option<&'h ImageHandle>,
    /// What comes through blended surfaces, by layer; `None` where no light has a deep shadow map.
    pub deep_masks: Option<&'h ImageHandle>,
}

/// Radiance towards the camera, cd/m², 32-bit floats (a half-float may saturate in silence), premultiplied; alpha is 0 where there is no surface.
pub struct Lit {
    /// Everything.
    pub color: ImageHandle,
    /// Of the scene's lights alone.
    pub direct: ImageHandle,
}

impl Lighting {
    /// Shades every pixel.
    pub fn record(&self, graph: &mut Graph, scene: &GpuScene, view: &View, input: &LightingInput) -> Lit {
        let shape = ImageShape::new_2d(vk::Format::R32G32B32A32_SFLOAT, view.size);
        let color = graph.image("lighting.color", shape);
        let direct = graph.image("lighting.direct", shape);
        let mut pass = graph.compute("lighting", &shader::SHADER);
        pass.uniform(shader::VIEWS, &ViewSet::from(*view).block())
            .uniform(shader::LIGHTS, input.lights)
            .uniform(shader::ENVIRONMENT, &blocks::Environment { radiance: self.environment })
            .read(shader::DEPTH, input.depth)
            .read(shader::ALBEDO, input.albedo)
            .read(shader::NORMAL, input.normal)
            .read(shader::MATERIAL, input.material)
            .read(shader::EMISSIVE, input.emissive)
            .specialize(shader::DEEP_SHADOWS, input.deep_masks.is_some());
        match input.masks {
            Some(masks) => pass.read(shader::MASKS, masks),
            None => pass.texture(shader::MASKS, &scene.white, SamplerInfo::nearest()),
        };
        match input.deep_masks {
            Some(masks) => pass.read(shader::DEEP_MASKS, masks),
            None => pass.texture(shader::DEEP_MASKS, &scene.white, SamplerInfo::nearest()),
        };
        let color = pass.write(shader::COLOR, color);
        let direct = pass.write(shader::DIRECT, direct);
        pass.dispatch([view.size[0], view.size[1], 1]);
        Lit { color, direct }
    }
}

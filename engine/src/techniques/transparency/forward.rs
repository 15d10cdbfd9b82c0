//! Forward shading of blended materials: what every technique of this family composites (`forward.glsl`).

use glam::Vec3;

use crate::gpu::SamplerInfo;
use crate::graph::{ImageHandle, RasterPass};
use crate::scene::{GpuScene, ViewSet};
use crate::shader::Program;
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::sorted::{sorted_frag as fragment, sorted_vert as vertex};

/// What blended surfaces are shaded with.
pub struct ForwardLights<'h> {
    /// Lights, from [`crate::scene::light_block`].
    pub lights: &'h blocks::Lights,
    /// Of the cascaded shadow technique.
    pub cascades: Option<ForwardShadow<'h, blocks::Cascades>>,
    /// Of the spot shadow technique.
    pub spots: Option<ForwardShadow<'h, blocks::SpotMaps>>,
    /// Of the deep shadow technique.
    pub deep: Option<ForwardDeep<'h>>,
    /// How shadow maps are sampled.
    pub sampler: SamplerInfo,
    /// Radiance that comes from everywhere, cd/m².
    pub environment: Vec3,
}

/// What a shadow technique's `visibility.glsl` reads.
pub struct ForwardShadow<'h, P> {
    /// Its uniform block.
    pub parameters: &'h P,
    /// Its shadow maps, a layer each.
    pub maps: &'h ImageHandle,
    /// Bilinear taps a side of its filter.
    pub taps: u32,
}

/// What `shadow/deep/visibility.glsl` reads.
pub struct ForwardDeep<'h> {
    /// Its uniform block.
    pub parameters: &'h blocks::DeepMaps,
    /// Where each texel's steps are.
    pub spans: &'h ImageHandle,
    /// The steps.
    pub steps: &'h ImageHandle,
}

impl ForwardLights<'_> {
    /// One program for each of these texture sets, with the constants that `forward.glsl` has.
    pub(super) fn programs(&self, program: &Program, scene: &GpuScene, texture_sets: &[u32]) -> Vec<Program> {
        let program = program
            .clone()
            .constant(fragment::CASCADE_TAPS, self.cascades.as_ref().map_or(1, |shadow| shadow.taps))
            .constant(fragment::SPOT_TAPS, self.spots.as_ref().map_or(1, |shadow| shadow.taps))
            .constant(fragment::DEEP_SHADOWS, self.deep.is_some())
            .set_layout(1, &scene.material_layout);
        texture_sets.iter().map(|&set| program.clone().constant(fragment::TEXTURES, set)).collect()
    }

    /// Binds what `forward.glsl` and the vertex shader before it read.
    pub(super) fn bind(&self, pass: &mut RasterPass, scene: &GpuScene, views: &ViewSet) {
        pass.uniform(vertex::VIEWS, &views.block())
            .uniform(fragment::LIGHTS, self.lights)
            .uniform(fragment::ENVIRONMENT, &blocks::Environment { radiance: self.environment });
        // Dummies keep the bindings of a technique that is off filled: no light refers to them.
        match &self.cascades {
            Some(shadow) => pass.uniform(fragment::CASCADES, shadow.parameters).sample(
                fragment::CASCADE_MAP,
                shadow.maps,
                self.sampler,
            ),
            None => pass.uniform(fragment::CASCADES, &bytemuck::Zeroable::zeroed()).texture(
                fragment::CASCADE_MAP,
                &scene.no_depth,
                self.sampler,
            ),
        };
        match &self.spots {
            Some(shadow) => pass.uniform(fragment::SPOT_MAPS, shadow.parameters).sample(
                fragment::SPOT_MAP,
                shadow.maps,
                self.sampler,
            ),
            None => pass.uniform(fragment::SPOT_MAPS, &bytemuck::Zeroable::zeroed()).texture(
                fragment::SPOT_MAP,
                &scene.no_depth,
                self.sampler,
            ),
        };
        let nearest = SamplerInfo::nearest();
        match &self.deep {
            Some(deep) => pass
                .uniform(fragment::DEEP_MAPS, deep.parameters)
                .sample(fragment::DEEP_SPANS, deep.spans, nearest)
                .sample(fragment::DEEP_STEPS, deep.steps, nearest),
            None => pass
                .uniform(fragment::DEEP_MAPS, &bytemuck::Zeroable::zeroed())
                .texture(fragment::DEEP_SPANS, &scene.white, nearest)
                .texture(fragment::DEEP_STEPS, &scene.no_words, nearest),
        };
    }
}

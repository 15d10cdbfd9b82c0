//! Blended materials, shaded forward and composited back to front, sorted by the distance of their objects' centres.
//! Objects that interlock come out wrong: that is what the exact techniques of this family are for.

use glam::Vec3;

use crate::gpu::{SamplerInfo, blend};
use crate::graph::{Graph, ImageHandle, Load};
use crate::scene::{DrawClass, Faces, GpuScene, SHADED, View, ViewSet, depth};
use crate::shader::Program;
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::sorted::{sorted_frag as fragment, sorted_vert as vertex};

/// Sorted transparency pass.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sorted {
    /// Radiance that comes from everywhere, cd/m².
    pub environment: Vec3,
}

/// What blended surfaces are shaded with.
pub struct ForwardLights<'h> {
    /// Lights, from [`crate::scene::light_block`].
    pub lights: &'h blocks::Lights,
    /// Of the cascaded shadow technique.
    pub cascades: Option<ForwardShadow<'h, blocks::Cascades>>,
    /// Of the spot shadow technique.
    pub spots: Option<ForwardShadow<'h, blocks::SpotMaps>>,
    /// How shadow maps are sampled.
    pub sampler: SamplerInfo,
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

impl Sorted {
    /// Composites over `color`, behind what is opaque. Without blended objects, `color` comes back untouched.
    pub fn record<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        view: &View,
        depth: &ImageHandle,
        lights: &ForwardLights,
        color: ImageHandle,
    ) -> ImageHandle {
        let views = ViewSet::from(*view);
        let frustum = views.frusta()[0];
        if scene.draws.visible(DrawClass::Blend, &[frustum]).is_empty() {
            return color;
        }
        let eye = view.eye();
        let cascade_taps = lights.cascades.as_ref().map_or(1, |shadow| shadow.taps);
        let spot_taps = lights.spots.as_ref().map_or(1, |shadow| shadow.taps);
        let program = Program::new(&vertex::SHADER, Some(&fragment::SHADER))
            .constant(fragment::CASCADE_TAPS, cascade_taps)
            .constant(fragment::SPOT_TAPS, spot_taps)
            .vertex_buffers(SHADED)
            .depth(depth::CLOSER, false)
            .blend(blend::over())
            .set_layout(1, &scene.material_layout);
        let texture_sets = scene.draws.texture_sets(&[DrawClass::Blend]);
        let one_each = texture_sets.iter().map(|&set| program.clone().constant(fragment::TEXTURES, set));
        let mut pass = graph.raster("transparency.sorted", one_each.collect());
        pass.uniform(vertex::VIEWS, &views.block())
            .constant(vertex::INSTANCES, &scene.instances)
            .uniform(fragment::LIGHTS, lights.lights)
            .uniform(fragment::ENVIRONMENT, &blocks::Environment { radiance: self.environment })
            .depth_test(depth);
        // Dummies keep the bindings of a technique that is off filled: no light refers to them.
        match &lights.cascades {
            Some(shadow) => pass.uniform(fragment::CASCADES, shadow.parameters).sample(
                fragment::CASCADE_MAP,
                shadow.maps,
                lights.sampler,
            ),
            None => pass.uniform(fragment::CASCADES, &bytemuck::Zeroable::zeroed()).texture(
                fragment::CASCADE_MAP,
                &scene.no_depth,
                lights.sampler,
            ),
        };
        match &lights.spots {
            Some(shadow) => pass.uniform(fragment::SPOT_MAPS, shadow.parameters).sample(
                fragment::SPOT_MAP,
                shadow.maps,
                lights.sampler,
            ),
            None => pass.uniform(fragment::SPOT_MAPS, &bytemuck::Zeroable::zeroed()).texture(
                fragment::SPOT_MAP,
                &scene.no_depth,
                lights.sampler,
            ),
        };
        let color = pass.color(fragment::COLOR, color, Load::Keep);
        pass.draw(move |recorder| {
            let draws = scene.draws.back_to_front(&frustum, eye);
            scene.draw_by_textures(recorder, &texture_sets, &draws, |recorder, draws| {
                recorder.push(&0u32);
                scene.draw(recorder, Faces::Material, draws);
            });
            Ok(())
        });
        color
    }
}

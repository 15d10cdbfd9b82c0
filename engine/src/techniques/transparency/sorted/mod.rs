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
    /// Parameters and map of the cascaded shadow technique.
    pub cascades: Option<(&'h blocks::Cascades, &'h ImageHandle)>,
    /// Parameters and maps of the spot shadow technique.
    pub spots: Option<(&'h blocks::SpotMaps, &'h ImageHandle)>,
    /// How shadow maps are sampled.
    pub sampler: SamplerInfo,
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
        let program = Program::new(&vertex::SHADER, Some(&fragment::SHADER))
            .vertex_buffers(SHADED)
            .depth(depth::CLOSER, false)
            .blend(blend::over())
            .set_layout(1, &scene.material_layout);
        let mut pass = graph.raster("transparency.sorted", vec![program]);
        pass.uniform(vertex::VIEWS, &views.block())
            .constant(vertex::INSTANCES, &scene.instances)
            .uniform(fragment::LIGHTS, lights.lights)
            .uniform(fragment::ENVIRONMENT, &blocks::Environment { radiance: self.environment })
            .depth_test(depth);
        // Dummies keep the bindings of a technique that is off filled: no light refers to them.
        match lights.cascades {
            Some((block, map)) => {
                pass.uniform(fragment::CASCADES, block).sample(fragment::CASCADE_MAP, map, lights.sampler)
            }
            None => pass.uniform(fragment::CASCADES, &bytemuck::Zeroable::zeroed()).texture(
                fragment::CASCADE_MAP,
                &scene.no_depth,
                lights.sampler,
            ),
        };
        match lights.spots {
            Some((block, map)) => {
                pass.uniform(fragment::SPOT_MAPS, block).sample(fragment::SPOT_MAP, map, lights.sampler)
            }
            None => pass.uniform(fragment::SPOT_MAPS, &bytemuck::Zeroable::zeroed()).texture(
                fragment::SPOT_MAP,
                &scene.no_depth,
                lights.sampler,
            ),
        };
        let color = pass.color(fragment::COLOR, color, Load::Keep);
        pass.draw(move |recorder| {
            recorder.push(&0u32);
            scene.draw(recorder, Faces::Material, &scene.draws.back_to_front(&frustum, eye))
        });
        color
    }
}

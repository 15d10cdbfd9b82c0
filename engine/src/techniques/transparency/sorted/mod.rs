//! Blended materials, shaded forward and composited back to front, sorted by the distance of their objects' centres.
//! Objects that interlock come out wrong: that is what the exact techniques of this family are for.

use glam::Vec3;

use crate::gpu::{SamplerInfo, blend};
use crate::graph::{Data, Graph, ImageHandle, Load};
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
    /// Lights, from [`crate::scene::record_lights`].
    pub lights: Data,
    /// Parameters and map of the cascaded shadow technique.
    pub cascades: Option<(Data, &'h ImageHandle)>,
    /// Parameters and maps of the spot shadow technique.
    pub spots: Option<(Data, &'h ImageHandle)>,
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
        let data = views.record(graph);
        // Dummies keep bindings filled where a technique is off: no light refers to them.
        let no_cascades = graph.data(&[bytemuck::Zeroable::zeroed(); 1] as &[blocks::Cascades]);
        let no_spots = graph.data_with_tail(
            &<blocks::SpotMaps as bytemuck::Zeroable>::zeroed(),
            &[<blocks::SpotMap as bytemuck::Zeroable>::zeroed()],
        );
        let program = Program::new(&vertex::SHADER, Some(&fragment::SHADER))
            .vertex_buffers(SHADED)
            .depth(depth::CLOSER, false)
            .blend(blend::over())
            .set_layout(1, &scene.material_layout);
        let mut pass = graph.raster("transparency.sorted", vec![program]);
        pass.constant(vertex::VIEWS, data)
            .constant(vertex::INSTANCES, &scene.instances)
            .constant(fragment::MATERIALS, &scene.materials)
            .constant(fragment::LIGHTS, lights.lights)
            .uniform(fragment::ENVIRONMENT, &blocks::Environment { radiance: self.environment })
            .depth_test(depth);
        match lights.cascades {
            Some((data, map)) => {
                pass.constant(fragment::CASCADES, data).sample(fragment::CASCADE_MAP, map, lights.sampler)
            }
            None => pass
                .constant(fragment::CASCADES, no_cascades)
                .texture(fragment::CASCADE_MAP, &scene.no_depth, lights.sampler),
        };
        match lights.spots {
            Some((data, map)) => pass.constant(fragment::SPOT_MAPS, data).sample(fragment::SPOT_MAP, map, lights.sampler),
            None => {
                pass.constant(fragment::SPOT_MAPS, no_spots).texture(fragment::SPOT_MAP, &scene.no_depth, lights.sampler)
            }
        };
        let color = pass.color(fragment::COLOR, color, Load::Keep);
        pass.draw(move |recorder| {
            recorder.push(&0u32);
            scene.draw(recorder, Faces::Material, &scene.draws.back_to_front(&frustum, eye))
        });
        color
    }
}

//! Blended materials, shaded forward and composited back to front, sorted by the distance of their objects' centres.
//! Objects that interlock come out wrong: that is what the exact techniques of this family are for.

use super::forward::ForwardLights;
use crate::gpu::blend;
use crate::graph::{Graph, ImageHandle, Load};
use crate::scene::{DrawClass, Faces, GpuScene, SHADED, View, ViewSet, depth};
use crate::shader::Program;
use crate::shader::generated::transparency::sorted::{sorted_frag as fragment, sorted_vert as vertex};

/// Sorted transparency pass.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sorted;

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
            .blend(blend::over());
        let texture_sets = scene.draws.texture_sets(&[DrawClass::Blend]);
        let mut pass = graph.raster("transparency.sorted", lights.programs(&program, scene, &texture_sets));
        lights.bind(&mut pass, scene, &views);
        pass.depth_test(depth);
        let color = pass.color(fragment::COLOR, color, Load::Keep);
        pass.draw(move |recorder| {
            let draws = scene.draws.back_to_front(&frustum, eye);
            scene.draw_by_textures(recorder, &texture_sets, &draws, false, (0, Faces::Material));
            Ok(())
        });
        color
    }
}

//! Drawing a scene's depth into the layers of an image, one view a layer: the depth pre-pass and shadow maps.

use super::draw::{ALPHA_TESTED, DrawClass, Faces, POSITIONS};
use super::{GpuScene, ViewSet, depth};
use crate::graph::{Graph, ImageHandle, Load, RasterPass};
use crate::shader::generated::surface::depth as shaders;
use crate::shader::{Program, Shader};

/// How several views become layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Expansion {
    /// One pass draws all views.
    Multiview,
    /// A pass each.
    Separate,
}

impl GpuScene {
    /// Clears `target` to the farthest depth and draws what is opaque or alpha-tested: view `i` of the set into layer
    /// `i` of the target. All views in one pass where the device can.
    pub fn record_depth<'f>(
        &'f self,
        graph: &mut Graph<'f>,
        name: &str,
        views: &ViewSet,
        target: ImageHandle,
        faces: Faces,
    ) -> ImageHandle {
        let count = views.views().len() as u32;
        if count == 1 {
            return self.depth_pass(graph, name.into(), Expansion::Separate, views, 0, target, faces);
        }
        if count <= graph.caps().limits.max_multiview_views {
            return self.depth_pass(graph, name.into(), Expansion::Multiview, views, 0, target, faces);
        }
        let layers = graph.split_layers(target).into_iter().enumerate();
        let drawn: Vec<_> = layers
            .map(|(i, layer)| {
                let name = format!("{name}.{i}");
                self.depth_pass(graph, name, Expansion::Separate, views, i, layer, faces)
            })
            .collect();
        graph.join(drawn).expect("a view set has a view")
    }

    #[allow(clippy::too_many_arguments)]
    fn depth_pass<'f>(
        &'f self,
        graph: &mut Graph<'f>,
        name: String,
        expansion: Expansion,
        views: &ViewSet,
        index: usize,
        target: ImageHandle,
        faces: Faces,
    ) -> ImageHandle {
        let frusta = match expansion {
            Expansion::Multiview => views.frusta(),
            Expansion::Separate => vec![views.frusta()[index]],
        };
        let opaque = self.draws.visible(DrawClass::Opaque, &frusta);
        let masked = self.draws.visible(DrawClass::Masked, &frusta);

        let (opaque_vertex, masked_vertex) = match expansion {
            Expansion::Multiview => (&shaders::opaque_multiview_vert::SHADER, &shaders::masked_multiview_vert::SHADER),
            Expansion::Separate => (&shaders::opaque_vert::SHADER, &shaders::masked_vert::SHADER),
        };
        let mut programs = vec![Program::new(opaque_vertex, None).vertex_buffers(POSITIONS)];
        if !masked.is_empty() {
            let fragment: &'static Shader = &shaders::masked_frag::SHADER;
            let program = Program::new(masked_vertex, Some(fragment)).vertex_buffers(ALPHA_TESTED);
            programs.push(program.set_layout(1, &self.material_layout));
        }
        let programs = programs.into_iter().map(|program| program.depth(depth::CLOSER, true)).collect();

        let mut pass: RasterPass = graph.raster(name, programs);
        pass.uniform(shaders::opaque_vert::VIEWS, &views.block());
        pass.constant(shaders::opaque_vert::INSTANCES, &self.instances);
        if expansion == Expansion::Multiview {
            pass.views(views.views().len() as u32);
        }
        let next = pass.depth(target, Load::Clear(depth::CLEAR));
        pass.draw(move |recorder| {
            for (program, draws) in [opaque, masked].iter().enumerate() {
                if draws.is_empty() {
                    continue;
                }
                recorder.program(program);
                if expansion == Expansion::Separate {
                    recorder.push(&(index as u32));
                }
                self.draw(recorder, faces, draws)?;
            }
            Ok(())
        });
        next
    }
}

//! Drawing a scene's depth into the layers of an image, one view a layer: the depth pre-pass and shadow maps.

use super::draw::{ALPHA_TESTED, Draw, DrawClass, Faces, POSITIONS};
use super::{GpuScene, Region, ViewSet, depth};
use crate::geometry::Frustum;
use crate::gpu::{Caps, Feature};
use crate::graph::{Graph, ImageHandle, Load, RasterPass};
use crate::shader::generated::surface::depth as shaders;
use crate::shader::{Program, Shader};

/// How several views become layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Expansion {
    /// One pass; the vertex shader chooses the layer. Each view draws what it sees.
    Layered,
    /// One pass draws all views at once; each view draws what any of them sees.
    Multiview,
    /// A pass each.
    Separate,
}

impl Expansion {
    fn of(caps: &Caps, views: usize) -> Self {
        match views {
            0 | 1 => Self::Separate,
            _ if caps.has(Feature::LayerFromVertexShader) => Self::Layered,
            _ if views <= caps.limits.max_multiview_views as usize => Self::Multiview,
            _ => Self::Separate,
        }
    }

    /// Vertex shaders of opaque and of masked draws.
    fn shaders(self) -> [&'static Shader; 2] {
        match self {
            Self::Layered => [&shaders::opaque_layered_vert::SHADER, &shaders::masked_layered_vert::SHADER],
            Self::Multiview => [&shaders::opaque_multiview_vert::SHADER, &shaders::masked_multiview_vert::SHADER],
            Self::Separate => [&shaders::opaque_vert::SHADER, &shaders::masked_vert::SHADER],
        }
    }
}

/// What one view (or all at once) draws.
struct Batch {
    /// Number pushed to the vertex shader; `None` where the hardware knows it.
    view: Option<u32>,
    region: Region,
    /// Opaque and masked.
    draws: [Vec<Draw>; 2],
}

impl GpuScene {
    /// Clears `target` to the farthest depth and draws what is opaque or alpha-tested: view `i` of the set into layer
    /// `i` of the target, no more than their regions ([`ViewSet::cropped`]). All views in one pass where the device can.
    pub fn record_depth<'f>(
        &'f self,
        graph: &mut Graph<'f>,
        name: &str,
        views: &ViewSet,
        target: ImageHandle,
        faces: Faces,
    ) -> ImageHandle {
        let expansion = Expansion::of(graph.caps(), views.views().len());
        let (frusta, regions) = (views.frusta(), views.regions());
        let batch = |view, region, frusta: &[Frustum]| Batch {
            view,
            region,
            draws: [DrawClass::Opaque, DrawClass::Masked].map(|class| self.draws.visible(class, frusta)),
        };
        let one_each = frusta.iter().zip(regions).enumerate();
        let one_each =
            one_each.map(|(i, (frustum, &region))| batch(Some(i as u32), region, std::slice::from_ref(frustum)));
        match expansion {
            Expansion::Multiview => {
                let around = regions[1..].iter().copied().fold(regions[0], Region::union);
                let all = vec![batch(None, around, &frusta)];
                self.depth_pass(graph, name.into(), expansion, views, all, target, faces)
            }
            Expansion::Layered => {
                let batches = one_each.collect();
                self.depth_pass(graph, name.into(), expansion, views, batches, target, faces)
            }
            Expansion::Separate if frusta.len() == 1 => {
                let batches = one_each.collect();
                self.depth_pass(graph, name.into(), expansion, views, batches, target, faces)
            }
            Expansion::Separate => {
                let layers = graph.split_layers(target).into_iter().zip(one_each).enumerate();
                let drawn: Vec<_> = layers
                    .map(|(i, (layer, batch))| {
                        self.depth_pass(graph, format!("{name}.{i}"), expansion, views, vec![batch], layer, faces)
                    })
                    .collect();
                graph.join(drawn).expect("a view set has a view")
            }
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn depth_pass<'f>(
        &'f self,
        graph: &mut Graph<'f>,
        name: String,
        expansion: Expansion,
        views: &ViewSet,
        batches: Vec<Batch>,
        target: ImageHandle,
        faces: Faces,
    ) -> ImageHandle {
        let [opaque, masked] = expansion.shaders();
        let mut programs = vec![Program::new(opaque, None).vertex_buffers(POSITIONS)];
        if batches.iter().any(|batch| !batch.draws[1].is_empty()) {
            let program = Program::new(masked, Some(&shaders::masked_frag::SHADER)).vertex_buffers(ALPHA_TESTED);
            programs.push(program.set_layout(1, &self.material_layout));
        }
        let programs = programs.into_iter().map(|program| program.depth(depth::CLOSER, true)).collect();

        let mut pass: RasterPass = graph.raster(name, programs);
        pass.uniform(shaders::opaque_vert::VIEWS, &views.block());
        if expansion == Expansion::Multiview {
            pass.views(views.views().len() as u32);
        }
        let next = pass.depth(target, Load::Clear(depth::CLEAR));
        pass.draw(move |recorder| {
            for batch in &batches {
                recorder.scissor(batch.region.offset, batch.region.size);
                for (program, draws) in batch.draws.iter().enumerate().filter(|(_, draws)| !draws.is_empty()) {
                    recorder.program(program);
                    if let Some(view) = batch.view {
                        recorder.push(&view);
                    }
                    self.draw(recorder, faces, draws);
                }
            }
            Ok(())
        });
        next
    }
}

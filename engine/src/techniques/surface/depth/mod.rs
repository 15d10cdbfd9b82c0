//! Depth pre-pass: the depth of the first opaque or alpha-tested surface, so that what follows shades each pixel once.

use ash::vk;

use crate::graph::{Graph, ImageHandle, ImageShape};
use crate::scene::{Faces, GpuScene, View};

/// Depth pre-pass.
#[derive(Clone, Copy, Debug, Default)]
pub struct DepthPrepass;

impl DepthPrepass {
    /// Draws the scene's depth as a camera sees it: D32, `scene::depth`'s convention.
    pub fn record<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, view: &View) -> ImageHandle {
        draw(graph, scene, view, "depth", 1)
    }

    /// The same of several samples a pixel: 1, 2, 4, … as many as the device has. Materials with an alpha cutoff cover all
    /// samples of a pixel that their triangle covers, or none.
    pub fn record_samples<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        view: &View,
        samples: u32,
    ) -> ImageHandle {
        draw(graph, scene, view, "depth.samples", samples)
    }
}

fn draw<'f>(graph: &mut Graph<'f>, scene: &'f GpuScene, view: &View, name: &str, samples: u32) -> ImageHandle {
    let shape = ImageShape::new_2d(vk::Format::D32_SFLOAT, view.size).samples(samples);
    let target = graph.image(name.to_string(), shape);
    scene.record_depth(graph, name, &(*view).into(), target, Faces::Material)
}

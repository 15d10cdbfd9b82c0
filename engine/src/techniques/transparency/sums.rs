//! Layers summed up with weights, and their average over what is opaque.

use ash::vk;

use super::fragments::{Fragments, Step, fragment_pass};
use crate::gpu::blend;
use crate::graph::{Graph, ImageHandle, ImageShape, Load, RasterPass};
use crate::scene::View;
use crate::shader::Program;
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::average_over_comp;
use crate::shader::generated::transparency::weighted::weigh_frag;

/// Sums of a picture's layers: `sums.glsl`. Floats of 32 bits: weighted luminances are beyond half-floats.
pub(super) struct Sums {
    /// Weighted colours; what all layers let through.
    pub(super) colors: ImageHandle,
    /// Weighted alphas.
    pub(super) weights: ImageHandle,
}

impl Sums {
    /// Draws a step whose shader includes `sums.glsl`; `bind` binds the technique's slots and gives what it makes.
    pub(super) fn record<'f, T>(
        graph: &mut Graph<'f>,
        name: &str,
        depth: &ImageHandle,
        (fragments, step): (&dyn Fragments<'f>, Step),
        specialize: impl Fn(Program) -> Program,
        bind: impl FnOnce(&mut RasterPass) -> T,
    ) -> (Self, T) {
        let mut image =
            |what: &str, format| graph.image(format!("{name}.{what}"), ImageShape::new_2d(format, depth.size()));
        let colors = image("sums", vk::Format::R32G32B32A32_SFLOAT);
        let weights = image("weights", vk::Format::R32_SFLOAT);
        let blended = |program: Program| specialize(program.blend(blend::add_and_hide()));
        let mut pass = fragment_pass(graph, format!("{name}.sums"), depth, (fragments, step), blended);
        let made = bind(&mut pass);
        let colors = pass.color(weigh_frag::SUMS, colors, Load::Clear([0.0, 0.0, 0.0, 1.0]));
        let weights = pass.color(weigh_frag::WEIGHTS, weights, Load::Clear([0.0; 4]));
        pass.draw(fragments.draw(step));
        (Self { colors, weights }, made)
    }

    /// Their average over what is opaque.
    pub(super) fn average_over(&self, graph: &mut Graph, name: &str, color: ImageHandle) -> ImageHandle {
        let size = color.size();
        let mut pass = graph.compute(format!("{name}.resolve"), &average_over_comp::SHADER);
        pass.read(average_over_comp::SUMS, &self.colors).read(average_over_comp::WEIGHTS, &self.weights);
        let color = pass.write(average_over_comp::COLOR, color);
        pass.dispatch([size[0], size[1], 1]);
        color
    }
}

/// Distance from depth: `distance.glsl`.
pub(super) fn layer_distances(view: &View) -> blocks::LayerDistances {
    blocks::LayerDistances { row: view.distance_row() }
}

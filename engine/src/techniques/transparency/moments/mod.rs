//! Moment-based transparency: what a pixel's layers let through, as a function of depth, from four power moments of their
//! absorbance.
//!
//! Sources: Münstermann, Krumpen, Klein and Peters 2018, "Moment-based order-independent transparency"; Peters and Klein
//! 2015, "Moment shadow mapping" (the bounds that four moments give).

use ash::vk;

use super::OrderIndependent;
use super::fragments::{Fragments, Step, fragment_pass};
use super::sums::{Sums, layer_distances};
use crate::gpu::blend;
use crate::graph::{Graph, ImageHandle, ImageShape, Load};
use crate::scene::View;
use crate::shader::Program;
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::moments::{add_colors_frag, add_moments_frag};

const NAME: &str = "moments";

/// Moment-based transparency, by four power moments as 32-bit floats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moments;

impl OrderIndependent for Moments {
    fn composite<'f>(
        &self,
        graph: &mut Graph<'f>,
        view: &View,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        color: ImageHandle,
    ) -> ImageHandle {
        let (size, distances, range) = (depth.size(), layer_distances(view), range(fragments.distances()));
        // 1. Absorbance and its moments over depth.
        let moments = graph.image("moments.moments", ImageShape::new_2d(vk::Format::R32G32B32A32_SFLOAT, size));
        let absorbance = graph.image("moments.absorbance", ImageShape::new_2d(vk::Format::R32_SFLOAT, size));
        let add = |program: Program| program.blend(blend::add());
        let mut pass = fragment_pass(graph, "moments.moments", depth, (fragments, Step::AddMoments), add);
        pass.uniform(add_moments_frag::DISTANCES, &distances).uniform(add_moments_frag::MOMENT_RANGE, &range);
        let moments = pass.color(add_moments_frag::MOMENTS, moments, Load::Clear([0.0; 4]));
        let absorbance = pass.color(add_moments_frag::ABSORBANCE, absorbance, Load::Clear([0.0; 4]));
        pass.draw(fragments.draw(Step::AddMoments));

        // 2. Layers, as far as those before them let them be seen; their average over what is opaque.
        let (sums, ()) = Sums::record(
            graph,
            NAME,
            depth,
            (fragments, Step::AddByMoments),
            |program| program,
            |pass| {
                pass.uniform(add_colors_frag::DISTANCES, &distances)
                    .uniform(add_colors_frag::MOMENT_RANGE, &range)
                    .read(add_colors_frag::MOMENTS, &moments)
                    .read(add_colors_frag::ABSORBANCE, &absorbance);
            },
        );
        sums.average_over(graph, NAME, color)
    }
}

/// `depth.glsl`'s block.
fn range([nearest, farthest]: [f32; 2]) -> blocks::MomentRange {
    let nearest = nearest.max(f32::MIN_POSITIVE);
    let logarithms = (farthest.max(nearest) / nearest).ln();
    blocks::MomentRange { nearest: nearest.ln(), scale: 2.0 / logarithms.max(1e-6) }
}

//! Weighted blended transparency: sums with weights that fall with distance, in one pass over the fragments.
//!
//! Source: McGuire and Bavoil 2013, "Weighted blended order-independent transparency", JCGT 2(2), equations 6 to 10.

use ash::vk;

use super::OrderIndependent;
use super::fragments::{Fragments, Step};
use crate::gpu::blend;
use crate::graph::{Graph, ImageHandle, ImageShape, Load};
use crate::scene::{View, depth};
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::weighted::{resolve_comp, weigh_frag};

/// Weighted blended transparency. Exact for one layer, and where all layers of a pixel have one colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Weighted {
    /// How weights fall.
    pub weight: Weight,
}

/// Weight of a layer of alpha α at the distance z along the view axis, in metres: α times one of these, clamped to
/// 0.01 and 3000.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weight {
    /// Equation 7: 10 / (10⁻⁵ + (z/5)² + (z/200)⁶).
    #[default]
    Equation7,
    /// Equation 8: 10 / (10⁻⁵ + (z/10)³ + (z/200)⁶).
    Equation8,
    /// Equation 9: 0.03 / (10⁻⁵ + (z/200)⁴).
    Equation9,
    /// Equation 10: 3000 d³, of the reversed depth d, which the view's near plane scales.
    Equation10,
}

impl Weight {
    /// Number of the equation.
    fn number(self) -> u32 {
        match self {
            Self::Equation7 => 7,
            Self::Equation8 => 8,
            Self::Equation9 => 9,
            Self::Equation10 => 10,
        }
    }
}

impl OrderIndependent for Weighted {
    fn composite<'f>(
        &self,
        graph: &mut Graph<'f>,
        view: &View,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        color: ImageHandle,
    ) -> ImageHandle {
        let size = depth.size();
        // 1. Sums. Floats of 32 bits: weights up to 3000 times luminances are beyond half-floats.
        let sums = graph.image("weighted.sums", ImageShape::new_2d(vk::Format::R32G32B32A32_SFLOAT, size));
        let weights = graph.image("weighted.weights", ImageShape::new_2d(vk::Format::R32_SFLOAT, size));
        let programs = fragments.programs(Step::Weigh).into_iter();
        let programs = programs.map(|program| {
            let program = program.depth(depth::CLOSER, false).blend(blend::add_and_hide());
            program.constant(weigh_frag::EQUATION, self.weight.number())
        });
        let mut pass = graph.raster("weighted.sums", programs.collect());
        fragments.bind(&mut pass, Step::Weigh);
        pass.uniform(weigh_frag::DISTANCES, &distances(view)).depth_test(depth);
        let sums = pass.color(weigh_frag::SUMS, sums, Load::Clear([0.0, 0.0, 0.0, 1.0]));
        let weights = pass.color(weigh_frag::WEIGHTS, weights, Load::Clear([0.0; 4]));
        pass.draw(fragments.draw(Step::Weigh));

        // 2. Their average over what is opaque.
        let mut pass = graph.compute("weighted.resolve", &resolve_comp::SHADER);
        pass.read(resolve_comp::SUMS, &sums).read(resolve_comp::WEIGHTS, &weights);
        let color = pass.write(resolve_comp::COLOR, color);
        pass.dispatch([size[0], size[1], 1]);
        color
    }
}

/// Distance from depth: `distance.glsl`.
fn distances(view: &View) -> blocks::LayerDistances {
    let inverse = view.clip_from_view.inverse();
    // The view looks along -z.
    blocks::LayerDistances { row: [-inverse.z_axis.z, -inverse.w_axis.z, inverse.z_axis.w, inverse.w_axis.w] }
}

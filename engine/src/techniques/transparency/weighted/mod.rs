//! Weighted blended transparency: sums with weights that fall with distance, in one pass over the fragments.
//!
//! Source: McGuire and Bavoil 2013, "Weighted blended order-independent transparency", JCGT 2(2), equations 6 to 10.

use super::OrderIndependent;
use super::fragments::{Fragments, Step};
use super::sums::{Sums, layer_distances};
use crate::graph::{Graph, ImageHandle};
use crate::scene::View;
use crate::shader::Program;
use crate::shader::generated::transparency::weighted::weigh_frag;

const NAME: &str = "weighted";

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
        let distances = layer_distances(view);
        let specialize = |program: Program| program.constant(weigh_frag::EQUATION, self.weight.number());
        let sums = Sums::record(graph, NAME, depth, (fragments, Step::Weigh), specialize, |pass| {
            pass.uniform(weigh_frag::DISTANCES, &distances);
        });
        sums.average_over(graph, NAME, color)
    }
}

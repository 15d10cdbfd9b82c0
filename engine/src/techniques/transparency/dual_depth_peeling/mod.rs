//! Dual depth peeling: every layer of blended surfaces, two a round, from the front and from the back, until both ends
//! meet.
//!
//! Source: Bavoil and Myers 2008, "Order independent transparency with dual depth peeling". Unlike there, equal depths
//! are told apart by the triangles' numbers, so that no layer is lost (`peeling.glsl`).

use super::OrderIndependent;
use super::fragments::{Fragments, Step};
use super::peeling::Peeling;
use crate::graph::{Graph, ImageHandle};
use crate::scene::View;
use crate::shader::generated::transparency::dual_depth_peeling::{advance_comp, peel_frag};

/// Depth peeling, from both ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DualDepthPeeling {
    /// Most layers of a pixel, up to 4096. A frame with more fails, and says how many there are.
    pub layers: u32,
}

impl Default for DualDepthPeeling {
    fn default() -> Self {
        Self { layers: 128 }
    }
}

impl OrderIndependent for DualDepthPeeling {
    fn composite<'f>(
        &self,
        graph: &mut Graph<'f>,
        _: &View,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        color: ImageHandle,
    ) -> ImageHandle {
        let peeling = Peeling {
            name: "dual_depth_peeling",
            step: Step::PeelBothEnds,
            state: peel_frag::PEELED,
            found: peel_frag::FOUND,
            front: peel_frag::FRONT,
            back: Some(peel_frag::BACK),
            advance: &advance_comp::SHADER,
            advance_state: advance_comp::PEELED,
            advance_found: advance_comp::FOUND,
        };
        peeling.composite(graph, depth, fragments, self.layers, color)
    }
}

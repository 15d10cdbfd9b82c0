//! Depth peeling: every layer of blended surfaces, one a round, from the front.
//!
//! Sources: Everitt 2001, "Interactive order-independent transparency"; Mammen 1989, "Transparency and antialiasing
//! algorithms implemented with the virtual pixel maps technique". Of equal depths the triangle with the larger number is
//! in front, so that no layer is lost (`peeling.glsl`).

use super::OrderIndependent;
use super::fragments::{Fragments, Step};
use super::peeling::Peeling;
use crate::graph::{Graph, ImageHandle};
use crate::scene::View;
use crate::shader::generated::transparency::depth_peeling::{advance_comp, peel_frag};

/// Depth peeling, from the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DepthPeeling {
    /// Most layers of a pixel, up to 4096. A frame with more fails, and says how many there are.
    pub layers: u32,
}

impl Default for DepthPeeling {
    fn default() -> Self {
        Self { layers: 128 }
    }
}

impl OrderIndependent for DepthPeeling {
    fn composite<'f>(
        &self,
        graph: &mut Graph<'f>,
        _: &View,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        color: ImageHandle,
    ) -> ImageHandle {
        let peeling = Peeling {
            name: "depth_peeling",
            step: Step::Peel,
            state: peel_frag::PEELED,
            found: peel_frag::FOUND,
            front: peel_frag::FRONT,
            back: None,
            advance: &advance_comp::SHADER,
            advance_state: advance_comp::PEELED,
            advance_found: advance_comp::FOUND,
        };
        peeling.composite(graph, depth, fragments, self.layers, color)
    }
}

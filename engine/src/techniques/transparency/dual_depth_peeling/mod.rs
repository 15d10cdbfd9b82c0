//! Dual depth peeling: every layer of blended surfaces, two a round, from the front and from the back, until both ends
//! meet.
//!
//! Source: Bavoil and Myers 2008, "Order independent transparency with dual depth peeling". Unlike there, equal depths
//! are told apart by the triangles' numbers, so that no layer is lost (`peeling.glsl`).

use super::OrderIndependent;
use super::fragments::{Fragments, Step, fragment_pass};
use super::peeling::{Peeled, Rounds};
use crate::graph::{Graph, ImageHandle};
use crate::scene::View;
use crate::shader::generated::transparency::dual_depth_peeling::{advance_comp, peel_frag};

const NAME: &str = "dual_depth_peeling";

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
        mut color: ImageHandle,
    ) -> ImageHandle {
        // 1. How many rounds are needed.
        let rounds = Rounds::new(graph, NAME, depth, fragments, self.layers, 2);
        let Peeled { mut state, mut found, mut front } = Peeled::nothing(graph, NAME, depth.size(), 2);
        for round in rounds.all() {
            // 2. The nearest layer is put behind those before it, the farthest over what is opaque; the next are found.
            let name = format!("{NAME}.peel.{round}");
            let mut pass = fragment_pass(graph, name, depth, (fragments, Step::PeelBothEnds), |program| program);
            state = pass.write(peel_frag::PEELED, state);
            found = pass.write(peel_frag::FOUND, found);
            front = pass.write(peel_frag::FRONT, front);
            color = pass.write(peel_frag::BACK, color);
            pass.draw(rounds.draw(round, fragments.draw(Step::PeelBothEnds)));

            // 3. On to those between.
            let mut pass = graph.compute(format!("{NAME}.advance.{round}"), &advance_comp::SHADER);
            state = pass.write(advance_comp::PEELED, state);
            found = pass.write(advance_comp::FOUND, found);
            let (groups, offset) = rounds.groups(round);
            pass.dispatch_indirect(groups, offset);
        }
        // 4. The front over the back.
        rounds.over(graph, &front, color)
    }
}

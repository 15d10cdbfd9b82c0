//! Depth peeling: every layer of blended surfaces, one a round, from the front.
//!
//! Sources: Everitt 2001, "Interactive order-independent transparency"; Mammen 1989, "Transparency and antialiasing
//! algorithms implemented with the virtual pixel maps technique". Of equal depths the triangle with the larger number is
//! in front, so that no layer is lost (`peeling.glsl`).

use super::OrderIndependent;
use super::fragments::{Fragments, Step, fragment_pass};
use super::peeling::{Peeled, Rounds};
use crate::graph::{Graph, ImageHandle};
use crate::scene::View;
use crate::shader::generated::transparency::depth_peeling::{advance_comp, peel_frag};

const NAME: &str = "depth_peeling";

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
        // 1. How many rounds are needed.
        let rounds = Rounds::new(graph, NAME, depth, fragments, self.layers, 1);
        let Peeled { mut state, mut found, mut front } = Peeled::nothing(graph, NAME, depth.size(), 1);
        for round in rounds.all() {
            // 2. Each pixel's layer of this round is put behind those before, and the next is found.
            let name = format!("{NAME}.peel.{round}");
            let mut pass = fragment_pass(graph, name, depth, (fragments, Step::Peel), |program| program);
            state = pass.write(peel_frag::PEELED, state);
            found = pass.write(peel_frag::FOUND, found);
            front = pass.write(peel_frag::FRONT, front);
            pass.draw(rounds.draw(round, fragments.draw(Step::Peel)));

            // 3. On to the next.
            let mut pass = graph.compute(format!("{NAME}.advance.{round}"), &advance_comp::SHADER);
            state = pass.write(advance_comp::PEELED, state);
            found = pass.write(advance_comp::FOUND, found);
            let (groups, offset) = rounds.groups(round);
            pass.dispatch_indirect(groups, offset);
        }
        // 4. All over what is opaque.
        rounds.over(graph, &front, color)
    }
}

//! Adaptive transparency: each pixel's visibility as a step function of few nodes, and every layer as visible as it says.
//!
//! Source: Salvi, Montgomery and Lefohn 2011, "Adaptive transparency". There fragments come in any order and what is kept
//! depends on it; here they come sorted, nearest first, so that every order of draws gives the same picture.

use crate::graph::{Graph, ImageHandle};
use crate::scene::View;
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::adaptive::resolve_comp as shader;

/// Turns of loops that lavapipe 22 gives an invocation.
const TURNS: u32 = 65_000;

/// Adaptive transparency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Adaptive {
    /// Nodes of a pixel's visibility, from 2 to 32.
    pub kept: u32,
}

impl Default for Adaptive {
    fn default() -> Self {
        Self { kept: 8 }
    }
}

impl Adaptive {
    fn nodes(&self) -> u32 {
        self.kept.clamp(2, 32)
    }

    /// Most layers of a pixel.
    pub fn most_layers(&self) -> u32 {
        TURNS / (2 * self.nodes() + 4)
    }

    /// Composites sorted lists over `color`. `nodes` and `spans`: the A-buffer's sorted lists, of nodes that are compact and
    /// tinted. `unit`: what colours are stored as multiples of.
    pub fn record(
        &self,
        graph: &mut Graph,
        view: &View,
        (nodes, spans): (&ImageHandle, &ImageHandle),
        unit: f32,
        color: ImageHandle,
    ) -> ImageHandle {
        let size = color.size();
        let mut pass = graph.compute("adaptive.resolve", &shader::SHADER);
        pass.uniform(shader::DISTANCES, &blocks::LayerDistances { row: view.distance_row() })
            .read(shader::NODES, nodes)
            .read(shader::SPANS, spans)
            .specialize(shader::NODE_UNIT, unit)
            .specialize(shader::NODE_FORMAT, 3)
            .specialize(shader::KEPT, self.nodes());
        let color = pass.write(shader::COLOR, color);
        pass.dispatch([size[0], size[1], 1]);
        color
    }
}

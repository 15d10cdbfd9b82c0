//! Stochastic transparency: layers cover random samples of their pixel, and what the samples see tells how visible each
//! layer is.
//!
//! Source: Enderton, Sintorn, Shirley and Luebke 2010, "Stochastic transparency": the depth-based estimate with alpha
//! correction.

use ash::vk;

use super::OrderIndependent;
use super::fragments::{Fragments, Step, fragment_pass};
use super::sums::Sums;
use crate::graph::{Graph, ImageHandle, ImageShape};
use crate::scene::View;
use crate::shader::Program;
use crate::shader::generated::transparency::stochastic::{add_colors_frag, sample_depths_frag};

const NAME: &str = "stochastic";

/// Stochastic transparency. Its noise stays the same from frame to frame, whatever the order of draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stochastic {
    /// Samples a pixel, from 1 to 64.
    pub samples: u32,
}

impl Default for Stochastic {
    fn default() -> Self {
        Self { samples: 8 }
    }
}

impl OrderIndependent for Stochastic {
    fn composite<'f>(
        &self,
        graph: &mut Graph<'f>,
        _: &View,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        color: ImageHandle,
    ) -> ImageHandle {
        // 1. The nearest layer of each sample.
        let samples = self.samples.clamp(1, 64);
        let shape = ImageShape::new_2d(vk::Format::R32_UINT, depth.size()).layers(samples);
        let depths = graph.image("stochastic.depths", shape);
        let depths = graph.clear("stochastic.depths.begin", depths, vk::ClearColorValue::default());
        let specialize = |program: Program| program.constant(sample_depths_frag::SAMPLES, samples);
        let mut pass = fragment_pass(graph, "stochastic.samples", depth, (fragments, Step::SampleDepths), specialize);
        let depths = pass.write(sample_depths_frag::SAMPLE_DEPTHS, depths);
        pass.draw(fragments.draw(Step::SampleDepths));

        // 2. Layers, as visible as they are to the samples; their average over what is opaque.
        let specialize = |program: Program| program.constant(add_colors_frag::SAMPLES, samples);
        let (sums, ()) = Sums::record(graph, NAME, depth, (fragments, Step::AddBySamples), specialize, |pass| {
            pass.read(add_colors_frag::SAMPLE_DEPTHS, &depths);
        });
        sums.average_over(graph, NAME, color)
    }
}

//! k-buffer: the nearest layers of each pixel are kept and composited exactly, all others are averaged behind them.
//!
//! Sources: Bavoil, Callahan, Lefohn, Comba and Silva 2007, "Multi-fragment effects on the GPU using the k-buffer"; the
//! tail is as in Maule, Comba, Torchelsen and Bastos 2013, "Hybrid transparency", with the average of McGuire and Bavoil
//! 2013, equation 5.

use ash::vk;

use super::OrderIndependent;
use super::fragments::{Fragments, Step, fragment_pass};
use super::sums::Sums;
use crate::graph::{Graph, ImageHandle, ImageShape};
use crate::scene::View;
use crate::shader::Program;
use crate::shader::generated::transparency::kbuffer::{
    keep_colors_frag, keep_depths_frag, keep_tags_frag, resolve_comp,
};

const NAME: &str = "kbuffer";

/// k-buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KBuffer {
    /// Layers of a pixel that are kept, from 1 to 32.
    pub kept: u32,
}

impl Default for KBuffer {
    fn default() -> Self {
        Self { kept: 4 }
    }
}

impl OrderIndependent for KBuffer {
    fn composite<'f>(
        &self,
        graph: &mut Graph<'f>,
        _: &View,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        color: ImageHandle,
    ) -> ImageHandle {
        let (size, kept, tints) = (depth.size(), self.kept.clamp(1, 32), fragments.tints());
        let mut empty = |what: &str, format, layers| {
            let image = graph.image(format!("{NAME}.{what}"), ImageShape::new_2d(format, size).layers(layers));
            graph.clear(format!("{NAME}.{what}.begin"), image, vk::ClearColorValue::default())
        };
        let depths = empty("depths", vk::Format::R32_UINT, kept);
        let tags = empty("tags", vk::Format::R32_UINT, kept);
        let colors = empty("colors", vk::Format::R32G32B32A32_SFLOAT, if tints { 2 * kept } else { kept });
        let specialize = |program: Program| program.constant(keep_depths_frag::KEPT, kept);

        // 1. The nearest depths.
        let mut pass = fragment_pass(graph, "kbuffer.depths", depth, (fragments, Step::KeepDepths), specialize);
        let depths = pass.write(keep_depths_frag::KEPT_DEPTHS, depths);
        pass.draw(fragments.draw(Step::KeepDepths));

        // 2. Whose they are, where several have one depth.
        let mut pass = fragment_pass(graph, "kbuffer.tags", depth, (fragments, Step::KeepTags), specialize);
        pass.read(keep_tags_frag::KEPT_DEPTHS, &depths);
        let tags = pass.write(keep_tags_frag::KEPT_TAGS, tags);
        pass.draw(fragments.draw(Step::KeepTags));

        // 3. Their colours, and sums of all others.
        let specialize =
            |program: Program| program.constant(keep_colors_frag::KEPT, kept).constant(keep_colors_frag::TINTED, tints);
        let (sums, colors) = Sums::record(graph, NAME, depth, (fragments, Step::KeepColors), specialize, |pass| {
            pass.read(keep_colors_frag::KEPT_DEPTHS, &depths).read(keep_colors_frag::KEPT_TAGS, &tags);
            pass.write(keep_colors_frag::KEPT_COLORS, colors)
        });

        // 4. All over what is opaque.
        let mut pass = graph.compute("kbuffer.resolve", &resolve_comp::SHADER);
        pass.read(resolve_comp::SUMS, &sums.colors)
            .read(resolve_comp::WEIGHTS, &sums.weights)
            .read(resolve_comp::KEPT_DEPTHS, &depths)
            .read(resolve_comp::KEPT_COLORS, &colors)
            .specialize(resolve_comp::KEPT, kept)
            .specialize(resolve_comp::TINTED, tints);
        let color = pass.write(resolve_comp::COLOR, color);
        pass.dispatch([size[0], size[1], 1]);
        color
    }
}

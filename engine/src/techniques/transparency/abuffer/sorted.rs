//! Sorted lists as they are, for what is more than one colour a pixel.

use std::mem::offset_of;

use ash::vk;

use super::arrays::Arrays;
use super::resolve::{GROUPS, LONG_GROUPS, SHORT};
use super::told::{Amount, Told};
use super::{ABuffer, Built, NODES, NodeFormat, node};
use crate::Error;
use crate::graph::{Graph, ImageHandle, ImageShape};
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::abuffer::{sort_comp, sort_long_comp, spans_comp};
use crate::techniques::transparency::fragments::{Fragments, count};

/// Most nodes that [`SortedLists`] count exactly: floats hold their places.
pub const MOST_SORTED: u64 = 1 << 24;

/// The fragments of each pixel, nearest first.
pub struct SortedLists {
    /// Nodes, R32G32B32A32 uint texels row by row: depth, key, and the rest as `node.glsl` has it.
    pub nodes: ImageHandle,
    /// By pixel, R32G32B32A32 float: number of its first node, how many it has, depth of the nearest and of the
    /// farthest.
    pub spans: ImageHandle,
}

impl ABuffer {
    /// Sorts all fragments before the opaque `depth`, of one sample a pixel. `name` stands before the names of passes and resources. Nodes are
    /// of [`NodeFormat::CompactTinted`] or [`NodeFormat::Transmittance`], whichever is asked for.
    ///
    /// Running the frame fails with [`crate::Error::Invalid`] where there are more fragments than [`MOST_SORTED`] or than
    /// there is room for, or a pixel has more than `most_layers`.
    pub fn sort<'f>(
        &self,
        graph: &mut Graph<'f>,
        name: &'static str,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        most_layers: u32,
    ) -> SortedLists {
        // A node must have all it holds in one texel.
        let format = match self.format {
            NodeFormat::Transmittance => NodeFormat::Transmittance,
            _ => NodeFormat::CompactTinted,
        };
        let this = Self { format, samples: 1, ..*self };
        // 1. An array for each pixel.
        let count = count(graph, name, depth, fragments);
        let (Arrays { built, sorted: room, .. }, totals) = this.arrays(graph, name, depth, fragments, &count);
        let sorted = Told::Totals(totals).image(
            graph,
            format!("{name}.sorted"),
            NODES,
            move |Amount { nodes, longest, .. }| {
                if nodes > MOST_SORTED {
                    let wrong = format!("{nodes} fragments are more than the {MOST_SORTED} that can be listed");
                    return Err(Error::invalid("A-buffer", wrong));
                }
                if longest > most_layers {
                    let wrong = format!("a pixel has {longest} layers; at most {most_layers} can be taken");
                    return Err(Error::invalid("A-buffer", wrong));
                }
                Ok(node::texels_size(nodes))
            },
        );
        let shape = ImageShape::new_2d(vk::Format::R32G32B32A32_SFLOAT, depth.size());
        let spans = graph.image(format!("{name}.spans"), shape);
        let spans = graph.clear(format!("{name}.spans.begin"), spans, vk::ClearColorValue::default());

        // 2. Sorted, short ones in registers, long ones in memory.
        let sorted = this.sort_short(graph, &built, sorted);
        let nodes = this.sort_long(graph, &built, room, sorted);

        // 3. Where each pixel's begin.
        let mut pass = graph.compute(format!("{name}.spans"), &spans_comp::SHADER);
        pass.read(spans_comp::TOTALS, &built.scanned.totals)
            .read(spans_comp::WORK, &built.work)
            .read(spans_comp::SORTED, &nodes);
        let spans = pass.write(spans_comp::SPANS, spans);
        pass.dispatch_indirect(&built.scanned.totals, offset_of!(blocks::Totals, work_groups) as u64);
        SortedLists { nodes, spans }
    }

    fn sort_short(&self, graph: &mut Graph, built: &Built, mut sorted: ImageHandle) -> ImageHandle {
        let groups = offset_of!(blocks::Totals, class_groups) as u64;
        for (class, slots) in [4, 8, SHORT].into_iter().enumerate() {
            let mut pass = graph.compute(format!("{}.sort.{slots}", built.name), &sort_comp::SHADER);
            built.bind(&mut pass, self);
            pass.specialize(sort_comp::SLOTS, slots);
            sorted = pass.write(sort_comp::SORTED, sorted);
            pass.dispatch_indirect(&built.scanned.totals, groups + GROUPS * class as u64);
        }
        sorted
    }

    fn sort_long(&self, graph: &mut Graph, built: &Built, room: [ImageHandle; 2], sorted: ImageHandle) -> ImageHandle {
        let [even, odd] = self.merged(graph, built, room);
        let mut pass = graph.compute(format!("{}.sort.long", built.name), &sort_long_comp::SHADER);
        pass.read(sort_long_comp::TOTALS, &built.scanned.totals)
            .read(sort_long_comp::WORK, &built.work)
            .read(sort_long_comp::EVEN, &even)
            .read(sort_long_comp::ODD, &odd)
            .specialize(sort_long_comp::LONG_SORT, self.long_sort.number());
        let sorted = pass.write(sort_long_comp::SORTED, sorted);
        pass.dispatch_indirect(&built.scanned.totals, LONG_GROUPS);
        sorted
    }
}

//! Sorting and compositing.

use std::mem::offset_of;

use ash::vk;

use super::nearest::Nearest;
use super::told::{Amount, Told};
use super::{ABuffer, Built, Composited, Known, LongSort, NODES};
use crate::graph::{BufferHandle, Checkpoint, Graph, ImageHandle, ImageShape};
use crate::scene::{View, ViewSet};
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::abuffer::{
    front_comp, long_blocks_comp, long_composite_comp, long_composite_multisampled_comp, long_flatten_comp,
    long_in_place_comp, long_merge_comp, long_runs_comp, resolve_comp, resolve_multisampled_comp,
};
use crate::{Error, Result};

/// Nodes that fit into registers: `scan.glsl`.
pub(super) const SHORT: u32 = 16;
/// Nodes of a run, and how often runs are merged: `totals.glsl`.
const RUN: u32 = 2048;
const MERGES: u32 = 8;

/// Most layers of a pixel that is sorted in place: `totals.glsl`.
pub const IN_PLACE_MOST: u32 = 512;

/// Most layers of a pixel.
pub const MOST_LAYERS: u32 = RUN << MERGES;

/// Bytes of a count of workgroups.
pub(super) const GROUPS: u64 = 12;

/// Where `Totals` has the workgroups of an invocation a long pixel.
pub(super) const LONG_GROUPS: u64 = offset_of!(blocks::Totals, class_groups) as u64 + 3 * GROUPS;

/// What is composited onto.
pub(super) struct Resolved {
    pub(super) color: ImageHandle,
    pub(super) report: BufferHandle,
    pub(super) front: ImageHandle,
    pub(super) nearest: Nearest,
}

impl Resolved {
    /// Onto `color`: nothing went wrong so far, and there is no layer.
    pub(super) fn new(graph: &mut Graph, layers: u32, color: ImageHandle) -> Self {
        let report = graph.buffer("abuffer.report", size_of::<blocks::ABufferReport>() as u64);
        let report = graph.fill("abuffer.report.begin", report, 0);
        let front = graph.image("abuffer.front", ImageShape::new_2d(vk::Format::R32_SFLOAT, color.size()));
        let nothing = vk::ClearColorValue { float32: [f32::INFINITY; 4] };
        let front = graph.clear("abuffer.front.begin", front, nothing);
        let nearest = Nearest::new(graph, layers, color.size());
        Self { color, report, front, nearest }
    }

    /// With what is known besides.
    pub(super) fn composited(
        self,
        count: ImageHandle,
        nodes: Option<ImageHandle>,
        known: Known,
        counter: Option<Checkpoint<u32>>,
    ) -> Composited {
        let Self { color, report, front, nearest } = self;
        Composited { color, count, front, layers: nearest.layers, nodes, report, known, counter }
    }
}

impl ABuffer {
    /// Sorts each pixel's nodes and composites them over what is there. `sorted`: of [`ABuffer::sorted_room`].
    pub(super) fn resolve(
        &self,
        graph: &mut Graph,
        view: &View,
        built: &Built,
        sorted: [ImageHandle; 2],
        onto: Resolved,
    ) -> (Resolved, [ImageHandle; 2]) {
        let onto = self.short(graph, built, onto);
        let (onto, sorted) = self.long(graph, built, sorted, onto);
        let front = self.front(graph, view, built, onto.front);
        let nearest = self.nearest(graph, view, built, onto.nearest);
        let report = self.check_lists(graph, built, onto.report);
        (Resolved { color: onto.color, report, front, nearest }, sorted)
    }

    /// Two images that long lists are sorted in.
    pub(super) fn sorted_room<'f>(&self, graph: &mut Graph<'f>, name: &str, told: &Told<'f>) -> [ImageHandle; 2] {
        let mut sorted = |which: &str| {
            let this = *self;
            told.image(graph, format!("{name}.sorted.{which}"), NODES, move |amount| this.sorted_size(amount))
        };
        let (even, odd) = (sorted("even"), sorted("odd"));
        // Step 2 of sorting reads only what it wrote itself, which nobody can see from outside.
        [even, graph.clear(format!("{name}.sorted.begin"), odd, vk::ClearColorValue::default())]
    }

    /// Pixels of few nodes, class by class.
    fn short(&self, graph: &mut Graph, built: &Built, onto: Resolved) -> Resolved {
        let Resolved { mut color, mut report, front, nearest } = onto;
        let groups = offset_of!(blocks::Totals, class_groups) as u64;
        let shader = match self.samples {
            1 => &resolve_comp::SHADER,
            _ => &resolve_multisampled_comp::SHADER,
        };
        for (class, slots) in [4, 8, SHORT].into_iter().enumerate() {
            let mut pass = graph.compute(format!("{}.resolve.{slots}", built.name), shader);
            built.bind(&mut pass, self);
            pass.read(resolve_comp::ENDS, &built.ends)
                .specialize(resolve_comp::NODE_UNIT, self.unit())
                .specialize(resolve_comp::SLOTS, slots);
            color = pass.write(resolve_comp::COLOR, color);
            report = pass.write(resolve_comp::REPORT, report);
            pass.dispatch_indirect(&built.scanned.totals, groups + GROUPS * class as u64);
        }
        Resolved { color, report, front, nearest }
    }

    /// Pixels of more nodes: sorted in memory. Where there are none, nothing is dispatched. After an even number of merges a
    /// pixel's nodes are in the first of both images.
    pub(super) fn merged(&self, graph: &mut Graph, built: &Built, [even, odd]: [ImageHandle; 2]) -> [ImageHandle; 2] {
        let Built { name, scanned, .. } = built;
        let totals = &scanned.totals;
        // 0. In place, what is short enough where that is asked for.
        let odd = self.in_place(graph, built, odd);

        // 1. The others in blocks of 16, in registers; of lists, once their nodes stand side by side.
        let odd = if built.linked { self.flatten(graph, built, odd) } else { odd };
        let mut pass = graph.compute(format!("{name}.long.blocks"), &long_blocks_comp::SHADER);
        pass.read(long_blocks_comp::NODES, &built.nodes)
            .read(long_blocks_comp::FLAT_NODES, &odd)
            .read(long_blocks_comp::TOTALS, totals)
            .read(long_blocks_comp::WORK, &built.work)
            .specialize(long_blocks_comp::NODE_FORMAT, self.format.number())
            .specialize(long_blocks_comp::LONG_SORT, self.long_sort.number())
            .specialize(long_blocks_comp::LINKED, built.linked);
        let even = pass.write(long_blocks_comp::SORTED, even);
        pass.dispatch_indirect(totals, offset_of!(blocks::Totals, block_groups) as u64);

        // 2. Runs of 2048, an invocation each.
        let mut pass = graph.compute(format!("{name}.long.runs"), &long_runs_comp::SHADER);
        pass.read(long_runs_comp::TOTALS, totals)
            .read(long_runs_comp::WORK, &built.work)
            .specialize(long_runs_comp::LONG_SORT, self.long_sort.number());
        let mut even = pass.write(long_runs_comp::EVEN, even);
        let mut odd = pass.write(long_runs_comp::ODD, odd);
        pass.dispatch_indirect(totals, offset_of!(blocks::Totals, run_groups) as u64);

        // 3. Runs two to one. Those of step 2 took an odd number of merges.
        for merge in 0..MERGES {
            let (from, to) = if merge % 2 == 0 { (odd, even) } else { (even, odd) };
            let mut pass = graph.compute(format!("{name}.long.merge.{}", RUN << merge), &long_merge_comp::SHADER);
            pass.read(long_merge_comp::TOTALS, totals)
                .read(long_merge_comp::WORK, &built.work)
                .read(long_merge_comp::FROM, &from)
                .push(&(RUN << merge));
            let to = pass.write(long_merge_comp::TO, to);
            let groups = offset_of!(blocks::Totals, merge_groups) as u64 + GROUPS * u64::from(merge);
            pass.dispatch_indirect(totals, groups);
            (even, odd) = if merge % 2 == 0 { (to, from) } else { (from, to) };
        }
        [even, odd]
    }

    /// Pixels that are sorted where their nodes lie.
    fn in_place(&self, graph: &mut Graph, built: &Built, sorted: ImageHandle) -> ImageHandle {
        if self.long_sort == LongSort::Blocks {
            return sorted;
        }
        let mut pass = graph.compute(format!("{}.long.in_place", built.name), &long_in_place_comp::SHADER);
        built.bind(&mut pass, self);
        pass.specialize(long_in_place_comp::LONG_SORT, self.long_sort.number());
        let sorted = pass.write(long_in_place_comp::SORTED, sorted);
        pass.dispatch_indirect(&built.scanned.totals, LONG_GROUPS);
        sorted
    }

    /// Composites pixels of more nodes.
    fn long(
        &self,
        graph: &mut Graph,
        built: &Built,
        sorted: [ImageHandle; 2],
        onto: Resolved,
    ) -> (Resolved, [ImageHandle; 2]) {
        let Resolved { color, report, front, nearest } = onto;
        let Built { name, scanned, .. } = built;
        let [even, odd] = self.merged(graph, built, sorted);
        let shader = match self.samples {
            1 => &long_composite_comp::SHADER,
            _ => &long_composite_multisampled_comp::SHADER,
        };
        let mut pass = graph.compute(format!("{name}.long.composite"), shader);
        pass.read(long_composite_comp::NODES, &built.nodes)
            .read(long_composite_comp::BESIDE, &built.beside)
            .read(long_composite_comp::TOTALS, &scanned.totals)
            .read(long_composite_comp::WORK, &built.work)
            .read(long_composite_comp::ENDS, &built.ends)
            .read(long_composite_comp::EVEN, &even)
            .read(long_composite_comp::ODD, &odd)
            .specialize(long_composite_comp::NODE_FORMAT, self.format.number())
            .specialize(long_composite_comp::SAMPLES, self.samples)
            .specialize(long_composite_comp::NODE_UNIT, self.unit())
            .specialize(long_composite_comp::LONG_SORT, self.long_sort.number())
            .specialize(long_composite_comp::LINKED, built.linked);
        let color = pass.write(long_composite_comp::COLOR, color);
        let report = pass.write(long_composite_comp::REPORT, report);
        pass.dispatch_indirect(&scanned.totals, LONG_GROUPS);
        (Resolved { color, report, front, nearest }, [even, odd])
    }

    /// Nodes of long lists, side by side.
    fn flatten(&self, graph: &mut Graph, built: &Built, to: ImageHandle) -> ImageHandle {
        let mut pass = graph.compute(format!("{}.long.flatten", built.name), &long_flatten_comp::SHADER);
        built.bind(&mut pass, self);
        pass.specialize(long_flatten_comp::LONG_SORT, self.long_sort.number());
        let to = pass.write(long_flatten_comp::FLAT_NODES, to);
        pass.dispatch_indirect(&built.scanned.totals, LONG_GROUPS);
        to
    }

    /// How far the nearest layer is.
    fn front(&self, graph: &mut Graph, view: &View, built: &Built, front: ImageHandle) -> ImageHandle {
        let mut pass = graph.compute(format!("{}.front", built.name), &front_comp::SHADER);
        built.bind(&mut pass, self);
        pass.uniform(front_comp::VIEWS, &ViewSet::from(*view).block());
        let front = pass.write(front_comp::FRONT, front);
        pass.dispatch_indirect(&built.scanned.totals, offset_of!(blocks::Totals, work_groups) as u64);
        front
    }
}

impl ABuffer {
    /// Size of each image of sorted nodes: one texel where no pixel has many.
    fn sorted_size(&self, Amount { nodes, longest, .. }: Amount) -> Result<[u32; 2]> {
        if longest > MOST_LAYERS {
            let wrong = format!("a pixel has {longest} layers; at most {MOST_LAYERS} are sorted");
            return Err(Error::invalid("A-buffer", wrong));
        }
        let needed = self.bytes(nodes, longest);
        if longest > SHORT && needed > self.memory {
            let allowed = self.memory;
            let wrong = format!("{nodes} fragments, sorted, need {needed} bytes; there may be {allowed}");
            return Err(Error::invalid("A-buffer", wrong));
        }
        Ok(super::node::texels_size(if longest > SHORT { nodes } else { 0 }))
    }
}

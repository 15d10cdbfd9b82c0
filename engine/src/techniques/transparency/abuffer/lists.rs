//! Linked lists: a head for each pixel, nodes in the order they come, one counter.

use ash::vk;

use super::resolve::Resolved;
use super::scan::{chunks_of, scan};
use super::told::Told;
use super::{ABuffer, BESIDE, Built, Composited, Known, NODES, Sizing};
use crate::graph::{BufferHandle, Checkpoint, Data, Graph, ImageHandle, ImageShape};
use crate::scene::View;
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::abuffer::{
    list_check_comp, list_counts_comp, list_frag, list_offsets_comp, list_subgroup_frag,
};
use crate::techniques::transparency::fragments::{Fragments, Step, fragment_pass};

/// Lists that were built.
struct Lists {
    nodes: ImageHandle,
    beside: ImageHandle,
    heads: ImageHandle,
    counter: BufferHandle,
}

impl ABuffer {
    pub(super) fn by_lists<'f>(
        &self,
        (step, sizing): (Step, Sizing),
        graph: &mut Graph<'f>,
        view: &View,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        color: ImageHandle,
    ) -> Composited {
        let size = depth.size();
        let (this, caps) = (*self, graph.caps());
        let block = move |capacity, used| blocks::ABufferFrame { size, first_row: 0, capacity, used };
        let count = graph.image("abuffer.count", ImageShape::new_2d(vk::Format::R32_SFLOAT, size));
        let count = graph.clear("abuffer.count.begin", count, vk::ClearColorValue::default());
        let onto = Resolved::new(graph, self.layers, color);
        // A query would count each sample: the counter of lists without room counts fragments.
        let sizing = if self.samples > 1 && sizing == Sizing::Counted { Sizing::Guessed(0) } else { sizing };
        let (resolved, count, totals, counter) = match sizing {
            Sizing::Counted => {
                // 1. How many fragments there are, then lists of as many nodes.
                samples(graph, depth, fragments);
                let told = graph.checkpoint_samples("abuffer.samples", "abuffer.samples");
                let nodes =
                    graph.image_after(&told, "abuffer.nodes", NODES, move |n| this.nodes_size(caps, n[0], true));
                let beside =
                    graph.image_after(&told, "abuffer.beside", BESIDE, move |n| Ok(this.beside_size(n[0], true)));
                let frame = graph.data_after(&told, move |samples| block(samples[0] as u32, 1));
                let lists = self.build(graph, "abuffer", depth, (fragments, step), [nodes, beside], frame, || Ok(true));
                let counter = graph.checkpoint("abuffer.counter", &lists.counter);

                // 2. Sort and composite.
                let ((built, sorted), totals, count) = self.listed(graph, "abuffer", lists, count, frame);
                (self.resolve(graph, view, &built, sorted, onto).0, count, totals, counter)
            }
            Sizing::Guessed(capacity) => {
                // 1. Lists of so many nodes; the counter counts all fragments.
                let most = self.most_nodes(caps, true);
                let capacity = u64::from(capacity).min(most) as u32;
                let room = self.image_size(u64::from(capacity));
                let nodes = graph.image("abuffer.nodes", ImageShape::new_2d(NODES, room));
                let room = self.beside_size(u64::from(capacity), true);
                let beside = graph.image("abuffer.beside", ImageShape::new_2d(BESIDE, room));
                let frame = graph.data(&[block(capacity, 1)]);
                let lists = self.build(graph, "abuffer", depth, (fragments, step), [nodes, beside], frame, || Ok(true));
                let counter: Checkpoint<u32> = graph.checkpoint("abuffer.counter", &lists.counter);
                let enough = graph.data_after(&counter, move |n| block(capacity, u32::from(n[0] <= capacity)));

                // 2. Where they are too few, once more with as many as were counted; else nothing is drawn.
                let nodes = graph.image_after(&counter, "abuffer.redone.nodes", NODES, move |n| {
                    this.nodes_size(caps, if n[0] <= capacity { 0 } else { u64::from(n[0]) }, true)
                });
                let beside = graph.image_after(&counter, "abuffer.redone.beside", BESIDE, move |n| {
                    Ok(this.beside_size(if n[0] <= capacity { 0 } else { u64::from(n[0]) }, true))
                });
                let frame = graph.data_after(&counter, move |n| block(n[0], u32::from(n[0] > capacity)));
                let told = counter.clone();
                let again = move || Ok(told.values()?[0] > capacity);
                let redone =
                    self.build(graph, "abuffer.redone", depth, (fragments, step), [nodes, beside], frame, again);

                // 3. Sort and composite those that are whole; the others count as empty.
                let ((built, sorted), _, count) = self.listed(graph, "abuffer", lists, count, enough);
                let (onto, _) = self.resolve(graph, view, &built, sorted, onto);
                let ((built, sorted), totals, count) = self.listed(graph, "abuffer.redone", redone, count, frame);
                (self.resolve(graph, view, &built, sorted, onto).0, count, totals, counter)
            }
        };
        resolved.composited(count, None, Known::Totals(totals), Some(counter))
    }

    /// Builds lists where `wanted` says so when the frame gets there.
    #[allow(clippy::too_many_arguments)]
    fn build<'f>(
        &self,
        graph: &mut Graph<'f>,
        name: &'static str,
        depth: &ImageHandle,
        (fragments, step): (&dyn Fragments<'f>, Step),
        [nodes, beside]: [ImageHandle; 2],
        frame: Data,
        wanted: impl Fn() -> crate::Result<bool> + 'f,
    ) -> Lists {
        let heads = graph.image(format!("{name}.heads"), ImageShape::new_2d(vk::Format::R32_UINT, depth.size()));
        let no_node = vk::ClearColorValue { uint32: [u32::MAX; 4] };
        let heads = graph.clear(format!("{name}.heads.begin"), heads, no_node);
        let counter = graph.buffer(format!("{name}.counter"), 4);
        let counter = graph.fill(format!("{name}.counter.begin"), counter, 0);
        // llvmpipe asks only fragments that are there, and that of Mesa 22.3 has no word for helpers.
        let helpers_vote = graph.caps().driver != "llvmpipe";
        let specialize = |program| match step {
            Step::SubgroupLists => self.specialized(program).constant(list_subgroup_frag::HELPERS_VOTE, helpers_vote),
            _ => self.specialized(program),
        };
        let mut pass = fragment_pass(graph, format!("{name}.link"), depth, (fragments, step), specialize);
        pass.uniform_data(list_frag::ABUFFER, frame);
        let nodes = pass.write(list_frag::NODES, nodes);
        let beside = pass.write(list_frag::BESIDE, beside);
        let heads = pass.write(list_frag::HEADS, heads);
        let counter = pass.write(list_frag::COUNTER, counter);
        let mut draw = fragments.draw(step);
        pass.draw(move |recorder| if wanted()? { draw(recorder) } else { Ok(()) });
        Lists { nodes, beside, heads, counter }
    }

    /// Walks the lists: how long each is, and which pixels have one.
    fn listed<'f>(
        &self,
        graph: &mut Graph<'f>,
        name: &'static str,
        lists: Lists,
        count: ImageHandle,
        frame: Data,
    ) -> ((Built, [ImageHandle; 2]), Checkpoint<blocks::Totals>, ImageHandle) {
        let Lists { nodes, beside, heads, counter } = lists;
        let size = heads.size();
        let mut pass = graph.compute(format!("{name}.lengths"), &list_counts_comp::SHADER);
        pass.uniform_data(list_counts_comp::ABUFFER, frame)
            .read(list_counts_comp::NODES, &nodes)
            .read(list_counts_comp::BESIDE, &beside)
            .read(list_counts_comp::HEADS, &heads)
            .specialize(list_counts_comp::NODE_FORMAT, self.format.number())
            .specialize(list_counts_comp::SAMPLES, self.samples)
            .specialize(list_counts_comp::LINKED, true);
        let count = pass.write(list_counts_comp::COUNTS, count);
        pass.dispatch([size[0], size[1], 1]);

        let scanned = scan(graph, name, &count, frame, self.long_sort);
        let totals = graph.checkpoint(format!("{name}.totals"), &scanned.totals);
        let told = Told::Totals(totals.clone());
        let work = told.pixels(graph, format!("{name}.work"), size[0], size_of::<blocks::Pixel>() as u64);
        let mut pass = graph.compute(format!("{name}.scan.offsets"), &list_offsets_comp::SHADER);
        pass.uniform_data(list_offsets_comp::ABUFFER, frame)
            .read(list_offsets_comp::COUNTS, &count)
            .read(list_offsets_comp::CHUNKS, &scanned.chunks)
            .read(list_offsets_comp::GROUPS, &scanned.groups)
            .read(list_offsets_comp::TOTALS, &scanned.totals)
            .read(list_offsets_comp::HEADS, &heads);
        let work = pass.write(list_offsets_comp::WORK, work);
        pass.dispatch([chunks_of(size) as u32, 1, 1]);
        let sorted = self.sorted_room(graph, name, &told);
        let built = Built {
            name: name.into(),
            nodes,
            linked: true,
            beside,
            scanned,
            ends: heads,
            counter: Some(counter),
            work,
            frame,
        };
        ((built, sorted), totals, count)
    }

    /// Counts nodes that are in no list.
    pub(super) fn check_lists(&self, graph: &mut Graph, built: &Built, report: BufferHandle) -> BufferHandle {
        let Some(counter) = &built.counter else { return report };
        let mut pass = graph.compute(format!("{}.check", built.name), &list_check_comp::SHADER);
        pass.uniform_data(list_check_comp::ABUFFER, built.frame)
            .read(list_check_comp::TOTALS, &built.scanned.totals)
            .read(list_check_comp::COUNTER, counter);
        let report = pass.write(list_check_comp::REPORT, report);
        pass.dispatch([1, 1, 1]);
        report
    }
}

/// Counts all fragments by a precise occlusion query.
fn samples<'f>(graph: &mut Graph<'f>, depth: &ImageHandle, fragments: &dyn Fragments<'f>) {
    let mut pass = fragment_pass(graph, "abuffer.samples", depth, (fragments, Step::Samples), |program| program);
    pass.count_samples();
    pass.draw(fragments.draw(Step::Samples));
}

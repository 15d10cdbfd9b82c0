//! Contiguous arrays: a pass counts, prefix sums say where each pixel's array begins, a pass fills. All at once, or band
//! by band of the picture's rows where that would not fit into memory.

use ash::vk;

use super::resolve::Resolved;
use super::scan::{Scanned, chunks_of, scan};
use super::told::{Amount, Told};
use super::{ABuffer, BESIDE, Built, Composited, Known, NAME, NODES, NodeFormat, samples};
use crate::gpu::Feature;
use crate::graph::{BufferHandle, Checkpoint, Data, Graph, ImageHandle, ImageShape};
use crate::scene::View;
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::abuffer::array_in_order_frag as ordered;
use crate::shader::generated::transparency::abuffer::{array_frag, rows_comp, scan_offsets_comp};
use crate::techniques::transparency::fragments::{Draw, Fragments, Step, count, fragment_pass};

/// Memory that is made once and used by one band after the other, so that no two are there at once.
struct Room {
    nodes: ImageHandle,
    beside: ImageHandle,
    /// By pixel, where its next node goes.
    cursors: ImageHandle,
    work: BufferHandle,
    sorted: [ImageHandle; 2],
}

/// Arrays that were filled.
pub(super) struct Arrays {
    pub(super) built: Built,
    /// What long lists are sorted in.
    pub(super) sorted: [ImageHandle; 2],
}

impl ABuffer {
    pub(super) fn by_arrays<'f>(
        &self,
        graph: &mut Graph<'f>,
        view: &View,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        color: ImageHandle,
    ) -> Composited {
        // 1. How many fragments each pixel has.
        let count = match self.samples {
            1 => count(graph, NAME, depth, fragments),
            _ => samples::count(graph, depth, fragments),
        };
        let mut onto = Resolved::new(graph, self.layers, color);
        if self.bands <= 1 {
            // 2. All at once: arrays, then sort and composite.
            let (arrays, totals) = self.arrays(graph, NAME, depth, fragments, &count);
            let (onto, room) = self.over(graph, view, arrays, onto);
            let nodes = (self.format != NodeFormat::HalfTinted).then_some(room.nodes);
            return onto.composited(count, nodes, Known::Totals(totals), None);
        }

        // 3. Or band by band: the host parts the picture's rows.
        let rows = rows(graph, &count);
        let told = Told::Rows { rows: rows.clone(), abuffer: *self, caps: graph.caps() };
        let mut room = self.room(graph, NAME, &told, depth.size());
        for index in 0..self.bands as usize {
            let name = format!("{NAME}.{index}");
            let frame = told.frame(graph, depth.size(), index);
            let scanned = scan(graph, &name, &count, frame, self.long_sort);
            let (told, width) = (told.clone(), depth.size()[0]);
            let within = move |draw| in_band(told, index, width, draw);
            let arrays = self.fill(graph, name, (scanned, frame, frame), (depth, fragments, within), &count, room);
            (onto, room) = self.over(graph, view, arrays, onto);
        }
        onto.composited(count, None, Known::Rows(rows), None)
    }

    /// An array for each pixel of the whole picture, of exactly the right size. `name` stands before the names of passes
    /// and resources.
    pub(super) fn arrays<'f>(
        &self,
        graph: &mut Graph<'f>,
        name: &str,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        count: &ImageHandle,
    ) -> (Arrays, Checkpoint<blocks::Totals>) {
        let size = depth.size();
        let counted = graph.data(&[blocks::ABufferFrame { size, first_row: 0, capacity: 0, used: 1 }]);
        let scanned = scan(graph, name, count, counted, self.long_sort);
        let totals = graph.checkpoint(format!("{name}.totals"), &scanned.totals);
        let told = Told::Totals(totals.clone());
        let room = self.room(graph, name, &told, size);
        let frame = told.frame(graph, size, 0);
        let frames = (scanned, counted, frame);
        (self.fill(graph, name.to_owned(), frames, (depth, fragments, |draw| draw), count, room), totals)
    }

    /// Memory for what is known.
    fn room<'f>(&self, graph: &mut Graph<'f>, name: &str, told: &Told<'f>, size: [u32; 2]) -> Room {
        let (this, caps) = (*self, graph.caps());
        let nodes = move |amount: Amount| this.nodes_size(caps, amount.nodes, false);
        Room {
            nodes: told.image(graph, format!("{name}.nodes"), NODES, nodes),
            beside: told.image(graph, format!("{name}.beside"), BESIDE, move |amount| {
                Ok(this.beside_size(amount.nodes, false))
            }),
            cursors: graph.image(format!("{name}.cursors"), ImageShape::new_2d(vk::Format::R32_UINT, size)),
            work: told.pixels(graph, format!("{name}.work"), size[0], size_of::<blocks::Pixel>() as u64),
            sorted: self.sorted_room(graph, name, told),
        }
    }

    /// Places each pixel's array by sums over the counts, and fills it with what of the fragments lies `within`.
    fn fill<'f>(
        &self,
        graph: &mut Graph<'f>,
        name: String,
        (scanned, counted, frame): (Scanned, Data, Data),
        (depth, fragments, within): (&ImageHandle, &dyn Fragments<'f>, impl FnOnce(Draw<'f>) -> Draw<'f>),
        count: &ImageHandle,
        room: Room,
    ) -> Arrays {
        let Room { nodes, beside, cursors, work, sorted } = room;
        // 1. Where each pixel's begin.
        let mut pass = graph.compute(format!("{name}.scan.offsets"), &scan_offsets_comp::SHADER);
        pass.uniform_data(scan_offsets_comp::ABUFFER, counted)
            .read(scan_offsets_comp::COUNTS, count)
            .read(scan_offsets_comp::CHUNKS, &scanned.chunks)
            .read(scan_offsets_comp::GROUPS, &scanned.groups)
            .read(scan_offsets_comp::TOTALS, &scanned.totals);
        let work = pass.write(scan_offsets_comp::WORK, work);
        let cursors = pass.write(scan_offsets_comp::CURSORS, cursors);
        pass.dispatch([chunks_of(depth.size()) as u32, 1, 1]);

        // 2. Filled.
        let specialize = |program| self.specialized(program);
        let step = if self.samples > 1 { Step::ArraysMultisampled } else { filling(graph, fragments) };
        let mut pass = fragment_pass(graph, format!("{name}.fill"), depth, (fragments, step), specialize);
        pass.uniform_data(array_frag::ABUFFER, frame);
        let nodes = pass.write(array_frag::NODES, nodes);
        let beside = pass.write(array_frag::BESIDE, beside);
        let cursors = match step {
            Step::ArraysInOrder => pass.color_in_order(ordered::NEXT_CURSOR, ordered::CURSOR, cursors),
            _ => pass.write(array_frag::CURSORS, cursors),
        };
        pass.draw(within(fragments.draw(step)));
        Arrays {
            built: Built { name, nodes, linked: false, beside, scanned, ends: cursors, counter: None, work, frame },
            sorted,
        }
    }

    /// Sorts arrays and composites them. Gives their memory back.
    fn over(&self, graph: &mut Graph, view: &View, arrays: Arrays, onto: Resolved) -> (Resolved, Room) {
        let Arrays { built, sorted } = arrays;
        let (onto, sorted) = self.resolve(graph, view, &built, sorted, onto);
        let Built { nodes, beside, ends, work, .. } = built;
        (onto, Room { nodes, beside, cursors: ends, work, sorted })
    }
}

/// How fragments come to their arrays: in the order of primitives where that is possible, else by atomic additions.
fn filling<'f>(graph: &Graph<'f>, fragments: &dyn Fragments<'f>) -> Step {
    let ordered = graph.caps().has(Feature::OrderedAttachments);
    match ordered && !fragments.programs(Step::ArraysInOrder).is_empty() {
        true => Step::ArraysInOrder,
        false => Step::Arrays,
    }
}

/// Draws over one band alone; nothing where there is none of this number.
fn in_band<'f>(told: Told<'f>, index: usize, width: u32, mut draw: Draw<'f>) -> Draw<'f> {
    Box::new(move |recorder| {
        let Some(band) = told.band(index)? else { return Ok(()) };
        recorder.scissor([0, band.first_row], [width, band.rows]);
        draw(recorder)
    })
}

/// What each row holds; the host reads it.
fn rows(graph: &mut Graph, count: &ImageHandle) -> Checkpoint<blocks::Row> {
    let height = count.size()[1];
    let rows = graph.buffer("abuffer.rows", u64::from(height) * size_of::<blocks::Row>() as u64);
    let mut pass = graph.compute("abuffer.rows", &rows_comp::SHADER);
    pass.read(rows_comp::COUNTS, count);
    let rows = pass.write(rows_comp::ROWS, rows);
    pass.dispatch([height, 1, 1]);
    graph.checkpoint("abuffer.rows", &rows)
}

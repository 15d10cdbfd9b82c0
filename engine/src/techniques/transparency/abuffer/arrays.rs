//! Contiguous arrays: a pass counts, prefix sums say where each pixel's array begins, a pass fills.

use ash::vk;

use super::resolve::Resolved;
use super::scan::{chunks_of, scan, work};
use super::{ABuffer, Built, Composited};
use crate::graph::{BufferHandle, Graph, ImageHandle};
use crate::scene::View;
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::abuffer::{array_frag, check_comp, scan_offsets_comp};
use crate::techniques::transparency::fragments::{Fragments, Step, count, fragment_pass};

const NAME: &str = "abuffer";

/// Arrays that were filled.
pub(super) struct Arrays {
    pub(super) built: Built,
    /// Fragments of each pixel, R32 float.
    pub(super) count: ImageHandle,
    /// By pixel, the end of its array.
    cursors: BufferHandle,
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
        // 1. Arrays of exactly the right size, filled.
        let Arrays { built, count, cursors } = self.arrays(graph, NAME, depth, fragments);

        // 2. Whether nothing was lost.
        let mut resolved = Resolved::new(graph, color);
        let mut pass = graph.compute("abuffer.check", &check_comp::SHADER);
        pass.read(check_comp::WORK, &built.work).read(check_comp::CURSORS, &cursors);
        resolved.report = pass.write(check_comp::REPORT, resolved.report);
        pass.dispatch_indirect(&built.scanned.totals, std::mem::offset_of!(blocks::Totals, work_groups) as u64);

        // 3. Sort and composite.
        let Resolved { color, report, front } = self.resolve(graph, view, &built, resolved);
        Composited { color, count, front, nodes: Some(built.nodes), report, totals: built.scanned.told, counter: None }
    }

    /// Fills an array for each pixel. `name` stands before the names of passes and resources.
    pub(super) fn arrays<'f>(
        &self,
        graph: &mut Graph<'f>,
        name: &'static str,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
    ) -> Arrays {
        let size = depth.size();

        // 1. How many fragments each pixel has, how many there are, and where each pixel's begin.
        let count = count(graph, name, depth, fragments);
        let frame = graph.data(&[blocks::ABufferFrame { size, capacity: 0, used: 1 }]);
        let scanned = scan(graph, name, &count, frame);
        let work = work(graph, name, &scanned.told);
        let cursors = graph.buffer(format!("{name}.cursors"), 4 * u64::from(size[0]) * u64::from(size[1]));
        let mut pass = graph.compute(format!("{name}.scan.offsets"), &scan_offsets_comp::SHADER);
        pass.uniform_data(scan_offsets_comp::ABUFFER, frame)
            .read(scan_offsets_comp::COUNTS, &count)
            .read(scan_offsets_comp::CHUNKS, &scanned.chunks)
            .read(scan_offsets_comp::GROUPS, &scanned.groups)
            .read(scan_offsets_comp::TOTALS, &scanned.totals);
        let work = pass.write(scan_offsets_comp::WORK, work);
        let cursors = pass.write(scan_offsets_comp::CURSORS, cursors);
        pass.dispatch([chunks_of(size) as u32, 1, 1]);

        // 2. Arrays of exactly that size, filled.
        let (this, caps) = (*self, graph.caps());
        let format = vk::Format::R32G32B32A32_UINT;
        let nodes = graph.image_after(&scanned.told, format!("{name}.nodes"), format, move |totals| {
            this.nodes_size(caps, u64::from(totals[0].total.nodes), false)
        });
        let frame = graph.data_after(&scanned.told, move |totals| blocks::ABufferFrame {
            size,
            capacity: totals[0].total.nodes,
            used: 1,
        });
        let specialize = |program| self.specialized(program);
        let mut pass = fragment_pass(graph, format!("{name}.fill"), depth, (fragments, Step::Arrays), specialize);
        pass.uniform_data(array_frag::ABUFFER, frame);
        let nodes = pass.write(array_frag::NODES, nodes);
        let cursors = pass.write(array_frag::CURSORS, cursors);
        pass.draw(fragments.draw(Step::Arrays));
        Arrays { built: Built { name, nodes, linked: false, scanned, work, frame }, count, cursors }
    }
}

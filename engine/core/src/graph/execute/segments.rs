//! Running a frame with checkpoints, a segment at a time.

use super::{Capture, Executed, Executor, Frame, Ran};
use crate::Result;
use crate::graph::checkpoint::{self, Later};
use crate::graph::description::{Description, Range, VersionId};
use crate::graph::history::Declared;
use crate::graph::plan::{Plan, first_segment, segment};

impl Frame<'_> {
    /// The host has read a version at a checkpoint: passes to come need not ask the device what it holds.
    fn know(&mut self, known: VersionId, whole: &Description, read: &Capture) -> Result<()> {
        let Range::Buffer([first, _]) = whole.versions[known.0 as usize].range else { return Ok(()) };
        let work = self.work.as_mut_slice();
        read.bytes(|bytes| work.iter_mut().for_each(|work| work.know(known, first, bytes)))
    }
}

impl Executor<'_> {
    /// `plan`: of the first segment.
    pub(super) fn execute_segments(
        &mut self,
        mut whole: Description,
        plan: &Plan,
        frame: &mut Frame,
        (mut later, mut histories): (Vec<Later>, Vec<Declared>),
        left: &mut dyn FnMut(&[Capture]),
    ) -> Result<Executed> {
        let mut captures: Vec<Option<Capture>> = whole.roots.iter().map(|_| None).collect();
        let mut executed = Executed::default();
        let mut ends = Vec::new();
        let version_of = |root: usize| whole.roots[root].version;
        frame.awaited = whole.checkpoints.iter().filter_map(|at| at.root).map(version_of).collect();
        for index in 0..=whole.checkpoints.len() {
            // 1. Plan it, by what the segments before it left. The first one was planned by the caller.
            let mut planned = match index {
                0 => {
                    let (first, live) = first_segment(&whole, plan.clone(), self.gpu)?;
                    frame.live = live;
                    first
                }
                _ => segment(&whole, index, &ends, self.gpu)?,
            };

            // 2. Run it.
            let description = std::mem::take(&mut planned.description);
            let (ran, description) = self.run_once(description, &planned.plan, frame)?;
            planned.description = description;
            let Ran { captures: read, passes, counts, recording, running } = ran;
            executed.passes.extend(passes);
            executed.counts.extend(counts);
            executed.recording += recording;
            executed.running += running;
            if index < whole.checkpoints.len() {
                let asked_for = |root: &usize| whole.checkpoints.iter().all(|at| at.root != Some(*root));
                let here = planned.roots.iter().zip(&read).filter(|(root, _)| asked_for(root));
                left(&here.filter_map(|(_, capture)| capture.clone()).collect::<Vec<_>>());
            }
            planned.roots.iter().zip(read).for_each(|(&root, capture)| captures[root] = capture);

            // 3. Read what the checkpoint asks for: sizes and bytes follow from it.
            if let Some(root) = whole.checkpoints.get(index).map(|at| at.root) {
                let capture = root.and_then(|root| captures[root].take());
                let arena = frame.arena.as_ref();
                let write = |offset, bytes: &[u8]| arena.map_or(Ok(()), |arena| arena.write(offset, bytes));
                checkpoint::reach(&mut later, index, &executed, capture.as_ref(), &mut whole, write)?;
                if let (Some(root), Some(capture)) = (root, capture) {
                    frame.know(whole.roots[root].version, &whole, &capture)?;
                }
            }

            // 4. Hand on how it left its resources; what the frame leaves is what the last one leaves.
            ends = planned.plan.ends.clone();
            if index == whole.checkpoints.len() {
                self.histories.keep(std::mem::take(&mut histories), &planned.plan, &frame.memory.0);
            }
            if index > 0 {
                executed.later.push(planned);
            }
        }
        executed.captures = captures.into_iter().flatten().collect();
        Ok(executed)
    }
}

//! Running a frame with checkpoints, a segment at a time.

use super::{Capture, Executed, Executor, Frame, Ran};
use crate::Result;
use crate::graph::checkpoint::{self, Later};
use crate::graph::description::Description;
use crate::graph::history::Declared;
use crate::graph::plan::{Plan, first_segment, segment};

impl Executor<'_> {
    /// `plan`: of the first segment.
    pub(super) fn execute_segments(
        &mut self,
        mut whole: Description,
        plan: &Plan,
        frame: &mut Frame,
        mut later: Vec<Later>,
        mut histories: Vec<Declared>,
    ) -> Result<Executed> {
        let mut captures: Vec<Option<Capture>> = whole.roots.iter().map(|_| None).collect();
        let mut executed = Executed::default();
        let mut ends = Vec::new();
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
            planned.roots.iter().zip(read).for_each(|(&root, capture)| captures[root] = capture);

            // 3. Read what the checkpoint asks for: sizes and bytes follow from it.
            if let Some(at) = whole.checkpoints.get(index) {
                let capture = at.root.and_then(|root| captures[root].take());
                let arena = frame.arena.as_ref();
                let write = |offset, bytes: &[u8]| arena.map_or(Ok(()), |arena| arena.write(offset, bytes));
                checkpoint::reach(&mut later, index, &executed, capture.as_ref(), &mut whole, write)?;
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

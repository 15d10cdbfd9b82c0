//! Making a frame ready: everything but recording.

use std::sync::Arc;

use super::histories::Turns;
use super::queries::Queries;
use super::resources::Resources;
use super::sets::Sets;
use super::timer::Timer;
use super::{Executor, Frame, run};
use crate::Result;
use crate::gpu::{Buffer, DescriptorCache};
use crate::graph::description::{Description, PassId};
use crate::graph::pass::{Bound, Work};
use crate::graph::plan::{Plan, Work as Step};
use crate::graph::record::{Batches, Ready};

/// A frame made ready to be run any number of times: see [`Executor::prepare`].
///
/// Frames of one executor share memory: none keeps anything from run to run but what it imports, and histories.
pub struct Prepared<'f> {
    pub(super) description: Description,
    pub(super) steps: Vec<Task>,
    /// By pass.
    pub(super) work: Vec<Work<'f>>,
    /// One, or two that take turns as histories do.
    pub(super) phases: Vec<Phase>,
    /// Of the frame, as it found them.
    pub(super) turns: Turns,
    pub(super) descriptors: DescriptorCache,
    pub(super) timer: Timer,
    pub(super) queries: Queries,
    /// Number of its first pass in the whole frame.
    pub(super) first_pass: u32,
    /// Descriptor sets point into it, and at what is bound.
    _kept: (Option<Buffer>, Arc<Vec<Bound>>),
}

/// What follows from where resources lie.
pub(super) struct Phase {
    /// One before each step, and the last one at the end.
    pub(super) barriers: Batches,
    /// Of all passes.
    pub(super) programs: Vec<Ready>,
    pub(super) memory: Resources,
}

/// One step.
pub(super) enum Task {
    /// `programs`: among those of all passes.
    Pass {
        pass: u32,
        programs: std::ops::Range<usize>,
    },
    ReadBack(usize),
}

impl Executor<'_> {
    /// Everything but recording.
    pub(super) fn ready<'f>(
        &mut self,
        description: Description,
        plan: &Plan,
        frame: &mut Frame<'f>,
        (mut descriptors, turns): (DescriptorCache, Turns),
    ) -> Result<Prepared<'f>> {
        let work: Vec<Work> = match frame.work.len() == description.passes.len() {
            // All of it, where it is.
            true => std::mem::take(&mut frame.work).collect(),
            false => frame.work.by_ref().take(description.passes.len()).collect(),
        };

        // 1. Memory that the plan placed.
        self.transients.make(self.gpu, plan, &description, self.instruments, &mut frame.memory)?;
        let (memory, arena) = (std::mem::take(&mut frame.memory), frame.arena.as_ref());

        // 2. Pipelines, in the order of the plan.
        let planned = plan.steps.iter().filter_map(|step| match step.work {
            Step::Pass(PassId(pass)) => work.get(pass as usize),
            Step::ReadBack(_) => None,
        });
        let mut wanted = Vec::with_capacity(plan.steps.len());
        planned.for_each(|work| work.pipelines(&mut wanted));
        let mut pipelines = self.pipelines.all(self.gpu, &wanted)?;

        // 3. Descriptor sets and barriers, for each turn of histories.
        let mut steps = Vec::with_capacity(plan.steps.len());
        let mut phases = Vec::with_capacity(2);
        let (gpu, bound) = (self.gpu, &frame.bound);
        let mut memories = turns.memories(memory).peekable();
        while let Some(memory) = memories.next() {
            let left = if memories.peek().is_some() { pipelines.clone() } else { std::mem::take(&mut pipelines) };
            let sets = Sets { gpu, memory: &memory, bound, arena };
            let (mut barriers, validated) = (Batches::with_capacity(plan), gpu.is_validated());
            let mut programs = Vec::with_capacity(left.len());
            let mut left = left.into_iter();
            steps.clear();
            for step in &plan.steps {
                let task = match step.work {
                    Step::Pass(PassId(pass)) => {
                        let (name, work) = (&description.passes[pass as usize].name, &work[pass as usize]);
                        let first = programs.len();
                        sets.ready(name, work, &mut left, &mut descriptors, &mut programs)?;
                        Task::Pass { pass, programs: first..programs.len() }
                    }
                    Step::ReadBack(root) => Task::ReadBack(root),
                };
                steps.push(task);
                run::batch(&mut barriers, &step.barriers, &memory, validated);
            }
            run::batch(&mut barriers, &plan.finally, &memory, validated);
            phases.push(Phase { barriers, programs, memory });
        }
        let timer = if self.instruments { Timer::new(self.gpu, steps.len())? } else { Timer::default() };
        let queries = self.queries(plan, &description, frame)?;
        let first_pass = frame.first_pass;
        frame.first_pass += description.passes.len() as u32;
        let _kept = (frame.arena.clone(), frame.bound.clone());
        Ok(Prepared { description, steps, work, phases, turns, descriptors, timer, queries, first_pass, _kept })
    }

    /// Queries of the passes that run.
    fn queries(&self, plan: &Plan, description: &Description, frame: &Frame) -> Result<Queries> {
        if frame.queries.is_empty() {
            return Ok(Queries::default());
        }
        Queries::new(self.gpu, &frame.queries, |PassId(pass)| {
            let here = pass.checked_sub(frame.first_pass)?;
            let runs = plan.steps.iter().any(|step| step.work == Step::Pass(PassId(here)));
            runs.then(|| description.passes[here as usize].name.to_string())
        })
    }
}

//! Plans of the last frames: a frame that is described as one of them was takes its plan.

use std::sync::{Arc, Mutex, PoisonError};

use super::Executor;
use crate::graph::builder::Graph;
use crate::graph::description::Description;
use crate::graph::errors::GraphErrors;
use crate::graph::plan::{Plan, Planned};

/// How many are kept. Histories take turns, and with them the descriptions of frames that are alike.
const KEPT: usize = 4;

/// Plans with what they were made for.
#[derive(Default)]
pub(super) struct Plans {
    /// The one used last comes last.
    known: Vec<(Description, Planned)>,
    /// Given, and not executed yet.
    given: Option<Planned>,
    /// Lists to describe the next frame in.
    spare: Mutex<Description>,
    /// How many passes and resources the last frame had, and how much its passes bound.
    room: [usize; 3],
}

impl Plans {
    /// Gives an empty frame room for as much as the last one had.
    pub(super) fn begin(&self, graph: &mut Graph, name: &str) {
        let spare = std::mem::take(&mut *self.spare.lock().unwrap_or_else(PoisonError::into_inner));
        graph.description = Description { name: name.into(), ..spare };
        let [passes, resources, bound] = self.room;
        graph.work.reserve(passes);
        graph.external.reserve(resources);
        graph.bound.reserve(bound);
    }

    /// A frame was executed by `plan`. `bound`: how much its passes bound.
    pub(super) fn executed(&mut self, plan: &Plan, mut description: Description, bound: usize) {
        self.room = [description.passes.len(), description.resources.len(), bound];
        let is_plan = |given: &mut Planned| std::ptr::eq(Arc::as_ptr(&given.plan), plan);
        if let Some(planned) = self.given.take_if(is_plan) {
            self.known.push((description, planned));
            if self.known.len() <= KEPT {
                return;
            }
            description = self.known.remove(0).0;
        }
        description.clear();
        self.spare = Mutex::new(description);
    }
}

impl Executor<'_> {
    /// Plans a frame as [`Graph::compile`] does. A frame that is described as one of the last ones was gets the same
    /// plan again, which takes a fraction of the time; what its passes do and bind may be different. One that is but for sizes
    /// is planned again as far as these matter.
    ///
    /// # Errors
    /// As [`Graph::compile`].
    pub fn plan(&mut self, graph: &Graph) -> Result<Arc<Plan>, GraphErrors> {
        let Plans { known, given, .. } = &mut self.plans;
        let same = |(described, _): &(Description, _)| *described == graph.description;
        if graph.is_without_mistakes()
            && let Some(found) = known.iter().rposition(same)
        {
            known[found..].rotate_left(1);
            let plan = known[known.len() - 1].1.plan.clone();
            graph.is_as_planned(&plan);
            return Ok(plan);
        }
        let planned = graph.compile_like(known.iter().rev(), self.gpu)?;
        let plan = planned.plan.clone();
        *given = Some(planned);
        Ok(plan)
    }
}

//! Random frames in a row, with resources that one hands on to the next.

use shadowgraph::graph::GraphErrors;
use shadowgraph::graph::description::{Access, Origin, ResourceId, Shape, State};
use shadowgraph::graph::plan::{Plan, plan};

use super::frames::Frame;
use super::generate::{Maker, shape, state};
use super::{MadeUpDevice, Recipe};

/// Two resources of one shape that take turns, with the states they are in.
struct Pair {
    shape: Shape,
    previous: Vec<State>,
    next: Vec<State>,
}

impl Recipe {
    /// Frames that hand histories on, one for each of the choices.
    ///
    /// # Errors
    /// What planning says.
    pub fn frames(
        &self,
        histories: &[[u8; 4]],
        count: usize,
        device: &MadeUpDevice,
    ) -> Result<Vec<Frame>, GraphErrors> {
        let empty = |choices: &[u8; 4]| Pair {
            shape: shape([choices[0], choices[1], choices[2]]),
            previous: Vec::new(),
            next: Vec::new(),
        };
        let mut pairs: Vec<Pair> = histories.iter().map(empty).collect();
        // By pair: the resources of the last frame that hold its previous and its next.
        let mut known: Vec<[ResourceId; 2]> = Vec::new();
        let mut frames: Vec<Frame> = Vec::new();
        for index in 0..count {
            let mut maker = Maker::new();
            let resources: Vec<_> =
                pairs.iter().zip(histories).enumerate().map(|(i, (p, c))| maker.pair(i, p, c[3])).collect();
            self.resources.iter().for_each(|choices| maker.resource(*choices));
            let from = index * 5 % self.passes.len();
            let passes = self.passes[from..].iter().chain(&self.passes[..from]);
            passes.for_each(|(kind, uses)| maker.step(*kind, uses));
            maker.roots(&self.roots);
            let description = maker.draft.description;
            let plan = plan(&description, device)?;
            let olds = known.iter().flatten();
            let carried = resources.iter().flatten().copied().zip(olds.copied()).collect();
            known.clear();
            for (pair, &[previous, next]) in pairs.iter_mut().zip(&resources) {
                let [last, new] = [previous, next].map(|id| ends(&plan, id));
                let written = holds(&pair.shape, &new);
                (pair.previous, pair.next) = if written { (new, last) } else { (last, new) };
                known.push(if written { [next, previous] } else { [previous, next] });
            }
            frames.push(Frame { description, plan, carried });
        }
        Ok(frames)
    }
}

/// Whether all of it holds something.
fn holds(shape: &Shape, states: &[State]) -> bool {
    let held = states.iter().filter(|state| state.holds).map(|state| state.range.amount());
    held.sum::<u64>() == shape.whole().amount()
}

fn ends(plan: &Plan, resource: ResourceId) -> Vec<State> {
    plan.ends.iter().filter(|end| end.resource == resource).map(|end| end.state).collect()
}

impl Maker {
    fn pair(&mut self, index: usize, pair: &Pair, choice: u8) -> [ResourceId; 2] {
        let is_image = matches!(pair.shape, Shape::Image(_));
        let after = Some(state(choice >> 2, is_image)).filter(|_| choice.is_multiple_of(4));
        let after = after.filter(|after| *after != Access::NONE);
        let holds = holds(&pair.shape, &pair.previous);
        let origin = Origin::Kept { before: pair.previous.clone(), after, needed: false };
        let previous = self.add(&format!("last{index}"), pair.shape.clone(), origin, holds);
        let before = pair.next.iter().map(|state| State { holds: false, ..*state }).collect();
        let origin = Origin::Kept { before, after, needed: true };
        [previous, self.add(&format!("next{index}"), pair.shape.clone(), origin, false)]
    }
}

//! Histories: their memory, and what of them goes on to the next frame.

use std::collections::HashMap;
use std::sync::Arc;

use ash::vk;

use super::resources::{Resources, alone};
use crate::gpu::Gpu;
use crate::graph::builder::External;
use crate::graph::description::{Origin, Resource, ResourceId, Shape};
use crate::graph::history::{Declared, KeptHistories};
use crate::graph::plan::{Plan, Usage};
use crate::{Error, Result};

/// What an executor keeps from frame to frame, by key.
#[derive(Default)]
pub(super) struct Histories {
    pub(super) kept: Arc<KeptHistories>,
    /// The previous and the next one.
    memory: HashMap<String, [External; 2]>,
}

/// Histories of a prepared frame.
#[derive(Default)]
pub(super) struct Turns {
    /// Key, the turn that it stands at, and whether its resources take turns.
    histories: Vec<(String, u64, bool)>,
    /// Those that take turns.
    turning: Vec<[ResourceId; 2]>,
    /// How often the frame ran.
    runs: usize,
}

impl Turns {
    /// The memory of each phase, from that of the first.
    pub(super) fn memories(&self, first: Resources) -> impl Iterator<Item = Resources> + use<> {
        let second = (!self.turning.is_empty()).then(|| {
            let mut second = first.clone();
            self.turning.iter().for_each(|[a, b]| second.0.swap(a.0 as usize, b.0 as usize));
            second
        });
        std::iter::once(first).chain(second)
    }
}

impl Histories {
    /// Gives the frame's histories their memory, and forgets them until [`Histories::keep`]: a frame that fails leaves
    /// none behind.
    pub(super) fn take(&mut self, gpu: &Gpu, declared: &[Declared], external: &mut [Option<External>]) -> Result<()> {
        self.check(declared)?;
        for history in declared {
            Arc::make_mut(&mut self.kept).remove(&history.key);
            let known = self.memory.remove(&history.key).filter(|_| history.found.is_some());
            let both = match known {
                Some(both) => both,
                None => [make(gpu, history, "a")?, make(gpu, history, "b")?],
            };
            for (resource, memory) in history.resources.iter().zip(both) {
                external[resource.0 as usize] = Some(memory);
            }
        }
        Ok(())
    }

    /// Whether histories are where the graph found them.
    fn check(&self, declared: &[Declared]) -> Result<()> {
        for history in declared {
            let kept = self.kept.get(&history.key).filter(|kept| kept.shape == history.shape);
            if kept.map(|kept| kept.turn) != history.found {
                let why = "has gone on since the graph was begun: begin each graph by `Executor::graph`, after the last \
                           frame was executed";
                return Err(Error::invalid(format!("history `{}`", history.key), why));
            }
        }
        Ok(())
    }

    /// Gives a frame that is to run again and again its histories' memory, which stays here as well.
    pub(super) fn share(
        &self,
        declared: Vec<Declared>,
        plan: &Plan,
        external: &mut [Option<External>],
    ) -> Result<Turns> {
        self.check(&declared)?;
        let mut turns = Turns::default();
        for history in declared {
            let refuse = |why: &str| Err(Error::invalid(format!("history `{}` of a prepared frame", history.key), why));
            let (Some(kept), Some(memory)) = (self.kept.get(&history.key), self.memory.get(&history.key)) else {
                return refuse("has no last frame: execute a frame like it first");
            };
            let (turned, after) = history.after(plan);
            if history.is_first {
                return refuse("begins anew with this frame: execute it, and prepare one that goes on");
            }
            if after.states != kept.states {
                return refuse("is left in another state than it is found in: execute a frame like it once more");
            }
            for (resource, memory) in history.resources.iter().zip(memory) {
                external[resource.0 as usize] = Some(memory.clone());
            }
            turns.turning.extend(turned.then_some(history.resources));
            turns.histories.push((history.key, kept.turn, turned));
        }
        Ok(turns)
    }

    /// Which phase of a prepared frame is next.
    pub(super) fn phase(&self, turns: &Turns) -> Result<usize> {
        for (key, turn, _) in &turns.histories {
            if self.kept.get(key).map(|kept| kept.turn) != Some(*turn) {
                let why = "was forgotten, or another frame went on with it: prepare the frame anew";
                return Err(Error::invalid(format!("history `{key}` of a prepared frame"), why));
            }
        }
        Ok(if turns.turning.is_empty() { 0 } else { turns.runs % 2 })
    }

    /// A prepared frame has run. Where it failed, its histories begin anew.
    pub(super) fn turn(&mut self, turns: &mut Turns, succeeded: bool) {
        turns.runs += 1;
        for (key, turn, turned) in &mut turns.histories {
            if !succeeded {
                self.forget(key);
                continue;
            }
            *turn += 1;
            if let Some(memory) = self.memory.get_mut(key).filter(|_| *turned) {
                memory.swap(0, 1);
            }
            if let Some(kept) = Arc::make_mut(&mut self.kept).get_mut(key) {
                kept.turn = *turn;
            }
        }
    }

    /// What goes on to the next frame.
    pub(super) fn keep(&mut self, declared: Vec<Declared>, plan: &Plan, external: &[Option<External>]) {
        for history in declared {
            let (turned, kept) = history.after(plan);
            let [previous, next] = history.resources.map(|resource| external[resource.0 as usize].clone());
            if let (Some(previous), Some(next)) = (previous, next) {
                let both = if turned { [next, previous] } else { [previous, next] };
                self.memory.insert(history.key.clone(), both);
                Arc::make_mut(&mut self.kept).insert(history.key, kept);
            }
        }
    }

    /// Whether there was one of this key.
    pub(super) fn forget(&mut self, key: &str) -> bool {
        Arc::make_mut(&mut self.kept).remove(key);
        self.memory.remove(key).is_some()
    }
}

/// One of a history's two resources. Later frames may use it in other ways than this one: it gets every usage that its
/// format has.
fn make(gpu: &Gpu, history: &Declared, which: &str) -> Result<External> {
    let usage = match &history.shape {
        Shape::Image(shape) => {
            let storage = if shape.samples > 1 { vk::ImageUsageFlags::STORAGE } else { vk::ImageUsageFlags::empty() };
            Usage::Image(gpu.image_usages(shape.format) & !storage)
        }
        Shape::Buffer { .. } => {
            use vk::BufferUsageFlags as Of;
            let shaders = Of::STORAGE_BUFFER | Of::UNIFORM_BUFFER;
            let draws = Of::VERTEX_BUFFER | Of::INDEX_BUFFER | Of::INDIRECT_BUFFER;
            Usage::Buffer(shaders | draws | Of::TRANSFER_SRC | Of::TRANSFER_DST)
        }
    };
    let (name, shape) = (format!("{} {which}", history.key).into(), history.shape.clone());
    alone(gpu, &Resource { name, shape, origin: Origin::Transient }, usage)
}

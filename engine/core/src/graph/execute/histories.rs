//! Histories: their memory, and what of them goes on to the next frame.

use std::collections::HashMap;
use std::sync::Arc;

use ash::vk;

use super::resources::alone;
use crate::gpu::Gpu;
use crate::graph::builder::External;
use crate::graph::description::{Origin, Resource, Shape};
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

impl Histories {
    /// Gives the frame's histories their memory, and forgets them until [`Histories::keep`]: a frame that fails leaves
    /// none behind.
    pub(super) fn take(&mut self, gpu: &Gpu, declared: &[Declared], external: &mut [Option<External>]) -> Result<()> {
        for history in declared {
            let kept = self.kept.get(&history.key).filter(|kept| kept.shape == history.shape);
            if kept.map(|kept| kept.turn) != history.found {
                let why = "has gone on since the graph was begun: begin each graph by `Executor::graph`, after the last \
                           frame was executed";
                return Err(Error::invalid(format!("history `{}`", history.key), why));
            }
        }
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

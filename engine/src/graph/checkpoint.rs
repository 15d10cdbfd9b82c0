//! Checkpoints: the host reads something, and sizes what follows by it.
//!
//! The whole frame is described at once. What is recorded after a checkpoint runs after the host has read what the
//! checkpoint asks for; sizes of buffers and bytes of blocks may follow from that.

use std::sync::{Arc, OnceLock};

use super::builder::{Data, Graph};
use super::description::{self, Root, UNKNOWN_SIZE};
use super::execute::Capture;
use super::handle::{BufferHandle, Handle};
use crate::{Error, Result};

/// A place in the frame where the host reads values of type `T`.
#[derive(Clone, Debug)]
pub struct Checkpoint<T> {
    graph: u64,
    index: usize,
    name: String,
    values: Arc<OnceLock<Vec<T>>>,
}

impl<T: Clone> Checkpoint<T> {
    /// What the host read: for the closures of passes that were recorded after the checkpoint.
    ///
    /// # Errors
    /// [`Error::Invalid`] before the frame got there.
    pub fn values(&self) -> Result<&[T]> {
        let values = self.values.get().map(Vec::as_slice);
        values.ok_or_else(|| Error::invalid(format!("checkpoint `{}`", self.name), "was not reached yet"))
    }
}

/// What is done when the host has read what a checkpoint asks for.
pub(super) struct Later<'f> {
    checkpoint: usize,
    what: What<'f>,
}

enum What<'f> {
    /// The values are told.
    Values(Tell),
    /// A buffer gets its size.
    Size(description::ResourceId, Follow<'f, u64>),
    /// A block gets its bytes.
    Bytes(Data, Follow<'f, Vec<u8>>),
}

type Tell = Box<dyn FnOnce(&Capture) -> Result<()>>;
type Follow<'f, T> = Box<dyn FnOnce() -> Result<T> + 'f>;

impl<'f> Graph<'f> {
    /// The host reads these contents as values of type `T` before anything runs that is recorded from here on.
    /// Everything recorded before has run by then, and runs once. Handles stay as they are.
    pub fn checkpoint<T: bytemuck::Pod>(&mut self, name: impl Into<String>, handle: &impl Handle) -> Checkpoint<T> {
        let name = name.into();
        let index = self.description.checkpoints.len();
        let root = self.description.roots.len();
        self.check_owner(&name, handle);
        self.description.roots.push(Root {
            name: format!("checkpoint {name}"),
            version: handle.version(),
            read_back: true,
        });
        self.description.checkpoints.push(description::Checkpoint {
            name: name.clone(),
            root,
            passes: self.description.passes.len(),
            versions: self.description.versions.len(),
            resources: self.description.resources.len(),
        });
        let values = Arc::new(OnceLock::new());
        let told = values.clone();
        let tell = move |capture: &Capture| {
            // Each checkpoint is reached once.
            let _ = told.set(capture.texels::<T>()?);
            Ok(())
        };
        self.later.push(Later { checkpoint: index, what: What::Values(Box::new(tell)) });
        Checkpoint { graph: self.id, index, name, values }
    }

    /// A new buffer of this frame whose size, in bytes, follows from what the checkpoint reads. At least 4 bytes are
    /// made. Until then its handle covers more bytes than any device has.
    pub fn buffer_after<T: bytemuck::Pod>(
        &mut self,
        checkpoint: &Checkpoint<T>,
        name: impl Into<String>,
        size: impl FnOnce(&[T]) -> u64 + 'f,
    ) -> BufferHandle {
        let buffer = self.buffer(name, UNKNOWN_SIZE);
        let told = checkpoint.clone();
        let size = move || told.values().map(size);
        self.after(checkpoint, What::Size(buffer.resource, Box::new(size)));
        buffer
    }

    /// As [`Graph::data`], of one value that follows from what the checkpoint reads. For passes recorded after it.
    pub fn data_after<T: bytemuck::Pod, B: bytemuck::Pod>(
        &mut self,
        checkpoint: &Checkpoint<T>,
        value: impl FnOnce(&[T]) -> B + 'f,
    ) -> Data {
        let data = self.data(&[B::zeroed()]);
        let told = checkpoint.clone();
        let bytes = move || told.values().map(|values| bytemuck::bytes_of(&value(values)).to_vec());
        self.after(checkpoint, What::Bytes(data, Box::new(bytes)));
        data
    }

    fn after<T>(&mut self, checkpoint: &Checkpoint<T>, what: What<'f>) {
        if checkpoint.graph != self.id {
            let allowed = format!("checkpoints of `{}`", self.description.name);
            let wrong = format!("checkpoint `{}` is one of another graph", checkpoint.name);
            return self.mistake(None, None, wrong, allowed);
        }
        self.later.push(Later { checkpoint: checkpoint.index, what });
    }
}

/// What the host does at a checkpoint: gives the description the sizes, and `write` the bytes at their offsets.
pub(super) fn reach(
    later: &mut Vec<Later>,
    checkpoint: usize,
    capture: &Capture,
    description: &mut description::Description,
    mut write: impl FnMut(u64, &[u8]) -> Result<()>,
) -> Result<()> {
    let (now, rest) = std::mem::take(later).into_iter().partition(|later: &Later| later.checkpoint == checkpoint);
    *later = rest;
    let now: Vec<Later> = now;
    for Later { what, .. } in now {
        match what {
            What::Values(tell) => tell(capture)?,
            What::Size(resource, size) => description.set_size(resource, size()?.max(4)),
            What::Bytes(data, bytes) => write(data.offset, &bytes()?)?,
        }
    }
    Ok(())
}

impl description::Description {
    /// Gives a buffer its size where it was not known.
    pub(super) fn set_size(&mut self, resource: description::ResourceId, size: u64) {
        let Some(known) = self.resources.get_mut(resource.0 as usize) else { return };
        known.shape = description::Shape::Buffer { size };
        for version in self.versions.iter_mut().filter(|version| version.resource == resource) {
            if let description::Range::Buffer([0, end]) = &mut version.range {
                *end = size.min(*end);
            }
        }
    }
}

//! Checkpoints: the host reads something, and sizes what follows by it.
//!
//! The whole frame is described at once. What is recorded after a checkpoint runs after the host has read what the
//! checkpoint asks for; sizes of buffers and bytes of blocks may follow from that.

use std::sync::{Arc, OnceLock};

use super::builder::{Data, Graph};
use super::description::{self, ImageShape, Root, UNKNOWN_SIZE};
use super::execute::{Capture, Executed};
use super::handle::{BufferHandle, Handle, ImageHandle};
use crate::gpu::QueryKind;
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
    /// An image gets its width and height.
    Extent(description::ResourceId, Follow<'f, [u32; 2]>),
    /// A block gets its bytes.
    Bytes(Data, Follow<'f, Vec<u8>>),
}

/// From what ran so far, and from the bytes that are asked for.
type Tell = Box<dyn FnOnce(&Executed, Option<&Capture>) -> Result<()>>;
type Follow<'f, T> = Box<dyn FnOnce() -> Result<T> + 'f>;

impl<'f> Graph<'f> {
    /// The host reads these contents as values of type `T` before anything runs that is recorded from here on.
    /// Everything recorded before has run by then, and runs once. Handles stay as they are.
    pub fn checkpoint<T: bytemuck::Pod>(&mut self, name: impl Into<String>, handle: &impl Handle) -> Checkpoint<T> {
        let name = name.into();
        self.check_owner(&name, handle);
        let root = self.description.roots.len();
        self.description.roots.push(Root {
            name: format!("checkpoint {name}"),
            version: handle.version(),
            read_back: true,
        });
        let nothing = Error::invalid(format!("checkpoint `{name}`"), "has nothing to read");
        self.cut_here(name, Some(root), |_, capture| capture.ok_or(nothing)?.texels::<T>())
    }

    /// As [`Graph::checkpoint`]; the host reads how many samples passed all tests in a pass recorded before, which
    /// counts them ([`super::RasterPass::count_samples`]): one value.
    pub fn checkpoint_samples(&mut self, name: impl Into<String>, pass: &str) -> Checkpoint<u64> {
        let counts = self.queries.iter().filter(|asked| asked.kind == QueryKind::Occlusion);
        let mut names = counts.map(|asked| self.description.passes[asked.pass.0 as usize].name.as_str());
        if !names.any(|known| known == pass) {
            let wrong = "counts no samples, or is not recorded yet".into();
            self.mistake(Some(pass), None, wrong, "a pass before, with `count_samples`".into());
        }
        let pass = pass.to_owned();
        self.cut_here(name.into(), None, move |executed, _| Ok(vec![executed.samples(&pass)?]))
    }

    /// A checkpoint behind all that is recorded so far; `read` gives its values.
    fn cut_here<T: 'static>(
        &mut self,
        name: String,
        root: Option<usize>,
        read: impl FnOnce(&Executed, Option<&Capture>) -> Result<Vec<T>> + 'static,
    ) -> Checkpoint<T> {
        let index = self.description.checkpoints.len();
        self.description.checkpoints.push(description::Checkpoint {
            name: name.clone(),
            root,
            passes: self.description.passes.len(),
            versions: self.description.versions.len(),
            resources: self.description.resources.len(),
        });
        let values = Arc::new(OnceLock::new());
        let told = values.clone();
        let tell = move |executed: &Executed, capture: Option<&Capture>| {
            // Each checkpoint is reached once.
            let _ = told.set(read(executed, capture)?);
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
        name: impl Into<super::Name>,
        size: impl FnOnce(&[T]) -> u64 + 'f,
    ) -> BufferHandle {
        let buffer = self.buffer(name, UNKNOWN_SIZE);
        let told = checkpoint.clone();
        let size = move || told.values().map(size);
        self.after(checkpoint, What::Size(buffer.resource, Box::new(size)));
        buffer
    }

    /// As [`Graph::image`], of one level and layer, its width and height following from what the checkpoint reads;
    /// each is at least 1. An error ends the frame. Until then its handle has 1×1 texels: it is no attachment.
    pub fn image_after<T: bytemuck::Pod>(
        &mut self,
        checkpoint: &Checkpoint<T>,
        name: impl Into<super::Name>,
        format: ash::vk::Format,
        size: impl FnOnce(&[T]) -> Result<[u32; 2]> + 'f,
    ) -> ImageHandle {
        let image = self.image(name, ImageShape::new_2d(format, [1, 1]));
        let told = checkpoint.clone();
        let size = move || size(told.values()?);
        self.after(checkpoint, What::Extent(image.resource, Box::new(size)));
        image
    }

    /// As [`Graph::data`], of one value that follows from what the checkpoint reads. For passes recorded after it.
    pub fn data_after<T: bytemuck::Pod, B: bytemuck::Pod>(
        &mut self,
        checkpoint: &Checkpoint<T>,
        value: impl FnOnce(&[T]) -> B + 'f,
    ) -> Data {
        self.data_slice_after(checkpoint, 1, move |values| vec![value(values)])
    }

    /// As [`Graph::data`], of `count` values that follow from what the checkpoint reads: of more, the first; what is missing
    /// is zero. For passes recorded after it.
    pub fn data_slice_after<T: bytemuck::Pod, B: bytemuck::Pod>(
        &mut self,
        checkpoint: &Checkpoint<T>,
        count: usize,
        values: impl FnOnce(&[T]) -> Vec<B> + 'f,
    ) -> Data {
        let data = self.data(&vec![B::zeroed(); count]);
        let told = checkpoint.clone();
        let bytes = move || {
            let mut values = values(told.values()?);
            values.resize(count, B::zeroed());
            Ok(bytemuck::cast_slice(&values).to_vec())
        };
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
    executed: &Executed,
    capture: Option<&Capture>,
    description: &mut description::Description,
    mut write: impl FnMut(u64, &[u8]) -> Result<()>,
) -> Result<()> {
    let (now, rest) = std::mem::take(later).into_iter().partition(|later: &Later| later.checkpoint == checkpoint);
    *later = rest;
    let now: Vec<Later> = now;
    for Later { what, .. } in now {
        match what {
            What::Values(tell) => tell(executed, capture)?,
            What::Size(resource, size) => description.set_size(resource, size()?.max(4)),
            What::Extent(resource, size) => description.set_extent(resource, size()?.map(|side| side.max(1))),
            What::Bytes(data, bytes) => write(data.offset, &bytes()?)?,
        }
    }
    Ok(())
}

impl description::Description {
    /// Gives an image its size where it was not known. Ranges of images do not depend on it.
    pub(super) fn set_extent(&mut self, resource: description::ResourceId, size: [u32; 2]) {
        let Some(known) = self.resources.get_mut(resource.0 as usize) else { return };
        if let description::Shape::Image(shape) = &mut known.shape {
            shape.extent = [size[0], size[1], 1];
        }
    }

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

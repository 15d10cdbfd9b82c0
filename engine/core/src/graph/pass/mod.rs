//! Describing a pass: what its shaders' bindings and its attachments are.

mod bind;
mod collect;
mod compute;
mod raster;

use std::ops::Range;

use ash::vk;
use smallvec::SmallVec;

pub use bind::{Fits, Unchanging};
pub use compute::ComputePass;
pub use raster::RasterPass;

use super::builder::Data;
use super::description::{self, ResourceId, VersionId};
use super::record::Recorder;
use crate::Result;
use crate::gpu::{self, Buffer, Image, SamplerInfo};
use crate::shader::{Program, Shader, Targets, Wanted};

/// What a pass does, besides what the description says. `bound`: among those of all passes.
pub(in crate::graph) enum Work<'f> {
    Compute {
        shader: &'static Shader,
        constants: Vec<(u32, gpu::Constant)>,
        bound: Range<usize>,
        push: Push<'f>,
        groups: Groups,
    },
    Raster(Box<Raster<'f>>),
    Fill {
        resource: ResourceId,
        range: description::Range,
        value: u32,
    },
    Clear {
        resource: ResourceId,
        range: description::Range,
        value: vk::ClearColorValue,
    },
    ClearDepth {
        resource: ResourceId,
        range: description::Range,
        value: f32,
    },
    /// Of a pass that is switched off.
    Zero(Vec<(ResourceId, description::Range)>),
}

/// Draws: of one pass.
pub(in crate::graph) struct Raster<'f> {
    pub(in crate::graph) programs: Vec<Program>,
    pub(in crate::graph) targets: Targets,
    pub(in crate::graph) attachments: Attachments,
    pub(in crate::graph) bound: Range<usize>,
    pub(in crate::graph) draw: DrawFn<'f>,
}

impl Work<'_> {
    /// Adds what its pipelines are made from.
    pub(in crate::graph) fn pipelines<'a>(&'a self, wanted: &mut Vec<Wanted<'a>>) {
        match self {
            Self::Compute { shader, constants, .. } => wanted.push(Wanted::Compute(shader, constants)),
            Self::Raster(raster) => {
                let Raster { programs, targets, .. } = &**raster;
                wanted.extend(programs.iter().map(|program| Wanted::Graphics(program, targets)));
            }
            Self::Fill { .. } | Self::Clear { .. } | Self::ClearDepth { .. } | Self::Zero(_) => {}
        }
    }

    /// Whether one of these versions says how many workgroups are dispatched.
    pub(in crate::graph) fn waits_for(&self, versions: &[VersionId]) -> bool {
        match self {
            Self::Compute { groups: Groups::Indirect { version, .. }, .. } => versions.contains(version),
            _ => false,
        }
    }

    /// The host knows the bytes of a version from an offset of its buffer on: a dispatch of as many workgroups as they say
    /// need not ask the device, and one of none does nothing.
    pub(in crate::graph) fn know(&mut self, known: VersionId, first: u64, bytes: &[u8]) {
        let Self::Compute { groups, .. } = self else { return };
        let Groups::Indirect { version, offset, .. } = *groups else { return };
        let at = offset.checked_sub(first).filter(|_| version == known);
        let said = at.and_then(|at| bytes.get(at as usize..)).and_then(<[u8]>::first_chunk::<12>);
        let Some(said) = said.map(|said| bytemuck::pod_read_unaligned::<[u32; 3]>(said)) else { return };
        if said.contains(&0) {
            *self = Self::Zero(Vec::new());
        } else {
            *groups = Groups::Direct(said);
        }
    }
}

pub(in crate::graph) type DrawFn<'f> = Box<dyn FnMut(&mut Recorder) -> Result<()> + 'f>;

/// Push constants of a dispatch.
pub(in crate::graph) enum Push<'f> {
    Bytes(SmallVec<[u8; 32]>),
    /// So many bytes, written each time the pass is recorded.
    Asked(usize, AskFn<'f>),
}

pub(in crate::graph) type AskFn<'f> = Box<dyn FnMut(&mut [u8]) + 'f>;

impl Push<'_> {
    pub(in crate::graph) fn size(&self) -> usize {
        match self {
            Self::Bytes(bytes) => bytes.len(),
            Self::Asked(size, _) => *size,
        }
    }

    /// `asked`: room for what is asked for.
    pub(in crate::graph) fn bytes<'a>(&'a mut self, asked: &'a mut Vec<u8>) -> &'a [u8] {
        match self {
            Self::Bytes(bytes) => bytes,
            Self::Asked(size, ask) => {
                asked.clear();
                asked.resize(*size, 0);
                ask(asked);
                asked
            }
        }
    }
}

/// Workgroups of a dispatch.
pub(in crate::graph) enum Groups {
    Direct([u32; 3]),
    /// At an offset of a buffer.
    Indirect {
        buffer: ResourceId,
        version: VersionId,
        offset: u64,
    },
}

/// What lies behind a binding of set 0.
pub(in crate::graph) struct Bound {
    /// Its number.
    pub(in crate::graph) binding: u32,
    pub(in crate::graph) what: What,
}

#[derive(Clone)]
pub(in crate::graph) enum What {
    /// Bytes of the frame's arena.
    Data(Data),
    /// A buffer that never changes while frames run.
    Buffer(Buffer),
    /// An image that never changes while frames run.
    Image(Image, Box<SamplerInfo>),
    /// A resource of the graph. `sampler`: the nearest texel where there is none.
    Resource {
        resource: ResourceId,
        range: description::Range,
        layout: vk::ImageLayout,
        sampler: Option<Box<SamplerInfo>>,
    },
}

/// Attachments of a raster pass.
#[derive(Default)]
pub(in crate::graph) struct Attachments {
    /// By location; every place is filled when the description ends.
    pub(in crate::graph) color: Vec<Option<Attachment>>,
    pub(in crate::graph) depth: Option<Attachment>,
    pub(in crate::graph) stencil: Option<Attachment>,
    /// Whether fragments read the colour attachment in primitive order: then it is the only one.
    pub(in crate::graph) ordered: bool,
    pub(in crate::graph) size: [u32; 2],
    pub(in crate::graph) layers: u32,
}

pub(in crate::graph) struct Attachment {
    pub(in crate::graph) resource: ResourceId,
    pub(in crate::graph) range: description::Range,
    pub(in crate::graph) layout: vk::ImageLayout,
    pub(in crate::graph) load: vk::AttachmentLoadOp,
    pub(in crate::graph) store: vk::AttachmentStoreOp,
    pub(in crate::graph) clear: vk::ClearValue,
}

/// What an attachment holds when a pass begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load<T> {
    /// This value everywhere.
    Clear(T),
    /// What it held before.
    Keep,
    /// Anything: the pass writes every pixel it is asked for.
    Discard,
}

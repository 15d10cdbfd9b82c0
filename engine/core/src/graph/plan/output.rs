//! A plan: plain data, no device, no lifetime.

use smallvec::SmallVec;

use super::Usage;
use super::reason::{CullReason, Reason};
use crate::graph::description::{Access, Description, PassId, Queue, Range, ResourceId, State, VersionId};

/// What to record and submit, in which order, with which barriers, over which memory.
///
/// A plan takes for granted that the device is done with the memory of its transients when it starts: the executor
/// waits for the last frame over the same heaps by a fence, or by a semaphore for all commands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// In an order that satisfies every dependency, over all queues.
    pub steps: Vec<Step>,
    /// Submissions: each step lies in exactly one. In submission order; one batch where there is one queue. The last
    /// one is on the graphics queue.
    pub batches: Vec<Batch>,
    /// Recorded at the end of the last batch: final states of imported resources, read-backs made visible to the host.
    pub finally: Barriers,
    /// Passes that do not run, with the reason, in recorded order.
    pub culled: Vec<(PassId, CullReason)>,
    /// Where transients lie, by resource. Resources that no step uses have none.
    pub placements: Vec<Placement>,
    /// Memory to allocate.
    pub heaps: Vec<Heap>,
    /// What each resource is used for, by [`ResourceId`]; `None` where no step uses it.
    pub usages: Vec<Option<Usage>>,
    /// States that imported and kept resources are left in, by resource: what the next plan begins with.
    pub ends: Vec<End>,
    /// Figures.
    pub statistics: Statistics,
    /// Of the description that a graph was compiled from: with another one it is not executed.
    pub fingerprint: u64,
}

/// One thing to record.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What to do.
    pub work: Work,
    /// Queue it runs on.
    pub queue: Queue,
    /// Recorded before it, in one `vkCmdPipelineBarrier2`.
    pub barriers: Barriers,
}

/// What a step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Work {
    /// A pass.
    Pass(PassId),
    /// Copies the root of this index to memory that the host reads, by `vkCmdCopyImageToBuffer` from
    /// `TRANSFER_SRC_OPTIMAL` or by `vkCmdCopyBuffer`.
    ReadBack(usize),
}

impl Work {
    /// Versions that it uses, and whether it only writes over them.
    pub(in crate::graph) fn uses(self, description: &Description) -> impl Iterator<Item = (VersionId, bool)> {
        let (pass, root) = match self {
            Self::Pass(pass) => (description.passes.get(pass.0 as usize), None),
            Self::ReadBack(root) => (None, description.roots.get(root)),
        };
        let uses = pass.map_or(&[][..], |pass| description.uses_of(pass)).iter();
        let uses = uses.map(|used| (used.version, used.makes.is_some() && !used.reads));
        uses.chain(root.map(|root| (root.version, false)))
    }
}

/// Steps that are submitted together.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Queue it is submitted to.
    pub queue: Queue,
    /// Indices of its steps, in order. Empty where it only hands imported resources over.
    pub steps: Vec<usize>,
    /// What it waits for.
    pub waits: Vec<Wait>,
    /// Recorded after its steps: ownership of resources given to other queues' families.
    pub release: Barriers,
    /// Value that its queue's timeline semaphore is set to when it is done: 1 for the queue's first batch, then one
    /// more each.
    pub signal: u64,
}

/// A wait for another queue's timeline semaphore.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wait {
    /// The other queue.
    pub queue: Queue,
    /// Value to wait for.
    pub value: u64,
    /// Stages that wait.
    pub stages: ash::vk::PipelineStageFlags2,
}

/// One batch of barriers: a `VkDependencyInfo`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Barriers {
    /// Layout transitions, and memory dependencies of images.
    pub images: ImageBarriers,
    /// Memory dependencies of buffers.
    pub buffers: Vec<BufferBarrier>,
    /// Dependencies of no single resource: execution only, memory that changes its tenant, the host.
    pub memory: Vec<MemoryBarrier>,
}

/// Barriers of images: most batches have few.
pub type ImageBarriers = SmallVec<[ImageBarrier; 2]>;

/// A `VkImageMemoryBarrier2`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageBarrier {
    /// The image.
    pub resource: ResourceId,
    /// A [`Range::Image`].
    pub range: Range,
    /// First scopes, and the layout it was in. `UNDEFINED`: what was there does not matter.
    pub from: Access,
    /// What a transition comes behind by way of other barriers: no part of what Vulkan asks for, but synchronisation
    /// validation looks for it in the transition's own barrier.
    pub follows: Access,
    /// Second scopes, and the layout it gets.
    pub to: Access,
    /// Queue family ownership transfer.
    pub ownership: Option<Ownership>,
    /// Why it stands.
    pub reason: Reason,
}

/// A `VkBufferMemoryBarrier2`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferBarrier {
    /// The buffer.
    pub resource: ResourceId,
    /// A [`Range::Buffer`].
    pub range: Range,
    /// First scopes.
    pub from: Access,
    /// Second scopes.
    pub to: Access,
    /// Queue family ownership transfer.
    pub ownership: Option<Ownership>,
    /// Why it stands.
    pub reason: Reason,
}

/// A `VkMemoryBarrier2`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryBarrier {
    /// First scopes.
    pub from: Access,
    /// Second scopes.
    pub to: Access,
    /// Why it stands.
    pub reason: Reason,
}

/// Queue families that a resource is handed over from and to. The same barrier is recorded on both queues: as the
/// release at the end of a [`Batch`], as the acquire before a [`Step`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ownership {
    /// Family that gives.
    pub from: u32,
    /// Family that takes.
    pub to: u32,
}

/// Where a transient lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placement {
    /// The transient.
    pub resource: ResourceId,
    /// Index into [`Plan::heaps`].
    pub heap: usize,
    /// Bytes from the heap's start.
    pub offset: u64,
    /// Bytes.
    pub size: u64,
    /// First and last step that use it. A root that is kept lives to the last step.
    pub steps: [usize; 2],
}

/// Memory to allocate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heap {
    /// Bytes.
    pub size: u64,
    /// Alignment of its start, in bytes.
    pub alignment: u64,
    /// Bit `i`: memory type `i` will do.
    pub type_bits: u32,
}

/// When a part of a resource is in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lifetime {
    /// The resource.
    pub resource: ResourceId,
    /// The part.
    pub range: Range,
    /// First and last step that use it.
    pub steps: [usize; 2],
}

/// The state that a part of a resource is left in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct End {
    /// The resource.
    pub resource: ResourceId,
    /// Its part, and the state.
    pub state: State,
}

/// Figures of a plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Statistics {
    /// Bytes of all heaps.
    pub heap_bytes: u64,
    /// Bytes if no two transients shared memory.
    pub unaliased_bytes: u64,
    /// The most bytes of transients that are alive at once, for this order: no placement can do with less.
    pub lower_bound_bytes: u64,
    /// Calls of `vkCmdPipelineBarrier2`.
    pub barrier_calls: usize,
    /// Barriers of images.
    pub image_barriers: usize,
    /// Barriers of buffers.
    pub buffer_barriers: usize,
    /// Barriers of no single resource.
    pub memory_barriers: usize,
}

impl Plan {
    /// Where a transient lies; `None` for imported and for unused resources.
    pub fn placement(&self, resource: ResourceId) -> Option<&Placement> {
        let index = self.placements.binary_search_by_key(&resource, |placement| placement.resource).ok()?;
        self.placements.get(index)
    }

    /// Whether every step runs on one queue, in one batch.
    pub fn is_single_queue(&self) -> bool {
        self.batches.len() == 1
    }
}

impl Barriers {
    /// Whether there is nothing to record.
    pub fn is_empty(&self) -> bool {
        self.images.is_empty() && self.buffers.is_empty() && self.memory.is_empty()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.images.len() + self.buffers.len() + self.memory.len()
    }
}

impl ImageBarrier {
    /// Whether the contents are thrown away.
    pub fn discards(&self) -> bool {
        self.from.layout == ash::vk::ImageLayout::UNDEFINED
    }
}

//! The untyped layer of the render graph: names, versions, accesses. Plain data, no lifetime, no device.
//!
//! A resource's contents are *versions* in single-assignment form. Every write makes a new version from an older
//! one; a read names the version it wants. What a version comes from says all there is to say about order:
//! a reader comes after the pass that made the version and before the pass that replaces it.

use std::borrow::Cow;
use std::hash::{Hash, Hasher};
use std::ops::Range as Span;

use ash::vk;
use rustc_hash::FxHasher;

use super::name::Name;

/// A whole frame, as described by its techniques.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Description {
    /// For messages and reports.
    pub name: String,
    /// Images and buffers.
    pub resources: Vec<Resource>,
    /// States of resources' contents.
    pub versions: Vec<Version>,
    /// In the order they were recorded.
    pub passes: Vec<Pass>,
    /// What passes read and write, one pass behind the other: [`Description::uses_of`] gives those of one.
    pub uses: Vec<Use>,
    /// Versions that must exist at the end of the frame.
    pub roots: Vec<Root>,
    /// Where the host reads something before it goes on, in order: they take the frame apart into segments.
    pub checkpoints: Vec<Checkpoint>,
}

impl Description {
    /// Takes everything out, and keeps the room.
    pub(super) fn clear(&mut self) {
        let Self { name, resources, versions, passes, uses, roots, checkpoints } = self;
        name.clear();
        resources.clear();
        versions.clear();
        passes.clear();
        uses.clear();
        roots.clear();
        checkpoints.clear();
    }

    /// How much of everything there is.
    pub(super) fn counts(&self) -> [usize; 5] {
        let Self { name: _, resources, versions, passes, uses: _, roots, checkpoints } = self;
        [resources.len(), versions.len(), passes.len(), roots.len(), checkpoints.len()]
    }

    /// What a pass reads and writes. Nothing where its span is not one of the description's uses.
    pub fn uses_of(&self, pass: &Pass) -> &[Use] {
        self.uses.get(pass.uses.start as usize..pass.uses.end as usize).unwrap_or_default()
    }

    /// As [`Description::uses_of`], to be changed; nothing of a pass that there is not.
    pub fn uses_of_mut(&mut self, pass: PassId) -> &mut [Use] {
        let span = self.passes.get(pass.0 as usize).map_or(0..0, |pass| pass.uses.clone());
        self.uses.get_mut(span.start as usize..span.end as usize).unwrap_or_default()
    }

    /// Adds a pass with its uses behind the last one.
    pub fn add_pass(&mut self, name: impl Into<Name>, queue: Queue, uses: impl IntoIterator<Item = Use>) -> PassId {
        let first = self.uses.len() as u32;
        self.uses.extend(uses);
        let uses = first..self.uses.len() as u32;
        self.passes.push(Pass { name: name.into(), queue, uses, side_effect: None });
        PassId(self.passes.len() as u32 - 1)
    }

    /// Leaves of a pass's uses those that are wanted.
    pub(super) fn retain_uses(&mut self, pass: PassId, wanted: impl Fn(&Use) -> bool) {
        let Some(span) = self.passes.get(pass.0 as usize).map(|pass| pass.uses.clone()) else { return };
        let (mut place, mut gone) = (0.., 0);
        self.uses.retain(|used| {
            let goes = place.next().is_some_and(|place| span.contains(&place)) && !wanted(used);
            gone += u32::from(goes);
            !goes
        });
        // What stands behind them moves up.
        for uses in self.passes.iter_mut().map(|pass| &mut pass.uses) {
            let moved = |end: u32| if end >= span.end { end - gone } else { end };
            *uses = if uses.start == span.start { uses.start } else { moved(uses.start) }..moved(uses.end);
        }
    }

    /// A number that tells frames apart that no plan serves both of: of everything but names.
    pub(super) fn fingerprint(&self) -> u64 {
        let Self { name: _, resources, versions, passes, uses: _, roots, checkpoints } = self;
        let mut hasher = FxHasher::default();
        [resources.len(), passes.len(), roots.len(), checkpoints.len()].hash(&mut hasher);
        versions.hash(&mut hasher);
        resources.iter().for_each(|Resource { name: _, shape, origin }| (shape, origin).hash(&mut hasher));
        for pass in passes {
            let (Pass { queue, side_effect, .. }, uses) = (pass, self.uses_of(pass));
            (queue, uses.len(), side_effect.is_some()).hash(&mut hasher);
            uses.iter().for_each(|used| (used.version, used.makes, used.reads, used.access).hash(&mut hasher));
        }
        roots.iter().for_each(|root| (root.version, root.read_back).hash(&mut hasher));
        checkpoints.iter().for_each(|checkpoint| (checkpoint.root, checkpoint.passes).hash(&mut hasher));
        hasher.finish()
    }
}

/// Where the host reads a root, or counts of passes, before anything that was recorded later runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checkpoint {
    /// For messages.
    pub name: String,
    /// Index into [`Description::roots`] of what is read, a read-back; `None`: what passes before it have counted.
    pub root: Option<usize>,
    /// Passes recorded before it.
    pub passes: usize,
    /// Versions made before it.
    pub versions: usize,
    /// Resources made before it.
    pub resources: usize,
}

/// Size of a buffer that a checkpoint will tell. Larger than any device has.
pub const UNKNOWN_SIZE: u64 = 1 << 41;

/// Index into [`Description::resources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ResourceId(pub u32);

/// Index into [`Description::versions`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VersionId(pub u32);

/// Index into [`Description::passes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PassId(pub u32);

/// An image or a buffer.
#[derive(Clone, Debug, PartialEq)]
pub struct Resource {
    /// Unique within a frame.
    pub name: Name,
    /// Image or buffer, with its size.
    pub shape: Shape,
    /// Where its memory comes from.
    pub origin: Origin,
}

/// Image or buffer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// An image.
    Image(ImageShape),
    /// A buffer of so many bytes.
    Buffer {
        /// Bytes.
        size: u64,
    },
}

/// Size and format of an image. Two-dimensional where `extent[2]` is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageShape {
    /// Texel format.
    pub format: vk::Format,
    /// Width, height, depth in texels.
    pub extent: [u32; 3],
    /// Mip levels.
    pub mips: u32,
    /// Array layers.
    pub layers: u32,
    /// 1 or 4 on software drivers.
    pub samples: u32,
}

/// Where a resource's memory comes from.
#[derive(Clone, Debug, PartialEq, Hash)]
pub enum Origin {
    /// Lives within the frame; may share memory with others.
    Transient,
    /// Owned by the application or by an earlier frame. `before` is the state it arrives in (no stages: idle, and
    /// visible to everybody), `after` the one it is to be left in (`None`: as its last use leaves it). It comes from
    /// and goes back to the graphics queue's family.
    Imported {
        /// State at the start of the frame.
        before: Access,
        /// State at the end of the frame.
        after: Option<Access>,
    },
    /// Kept by whoever executes plans, from frame to frame or over a checkpoint. It comes from and goes back to the
    /// graphics queue's family.
    Kept {
        /// States that its parts arrive in. A part that none of them names is idle and holds nothing.
        before: Vec<State>,
        /// State at the end, as for imported resources.
        after: Option<Access>,
        /// Whether what it holds at the end is needed: whoever writes that runs.
        needed: bool,
    },
}

/// State of a part of a resource between two plans.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct State {
    /// The part.
    pub range: Range,
    /// Its last use, which the next one has to wait for: a write, or reads that the contents are visible to. No
    /// stages: idle, and visible to everybody.
    pub access: Access,
    /// Whether it holds anything that may be read.
    pub holds: bool,
}

/// Stages, access mask and layout: what a use needs, or what state a resource is in.
/// Buffers leave `layout` at `UNDEFINED`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Access {
    /// Pipeline stages.
    pub stages: vk::PipelineStageFlags2,
    /// Memory accesses.
    pub mask: vk::AccessFlags2,
    /// Image layout.
    pub layout: vk::ImageLayout,
}

/// Part of a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Of an image: aspects, `[first, end)` of mips and of layers.
    Image {
        /// Colour, depth, stencil.
        aspects: vk::ImageAspectFlags,
        /// `[first, end)`.
        mips: [u32; 2],
        /// `[first, end)`.
        layers: [u32; 2],
    },
    /// Of a buffer: `[first, end)` in bytes.
    Buffer([u64; 2]),
}

/// Two numbers as one.
fn pair([first, second]: [u32; 2]) -> u64 {
    u64::from(first) << 32 | u64::from(second)
}

impl Hash for ImageShape {
    /// In few words: frames have thousands of them.
    fn hash<H: Hasher>(&self, state: &mut H) {
        let Self { format, extent: [width, height, depth], mips, layers, samples } = *self;
        [[format.as_raw() as u32, width], [height, depth], [mips, layers], [samples, 0]]
            .into_iter()
            .for_each(|two| state.write_u64(pair(two)));
    }
}

impl Hash for Range {
    /// In few words: frames have thousands of them.
    fn hash<H: Hasher>(&self, state: &mut H) {
        let words = match *self {
            Range::Image { aspects, mips, layers } => [aspects.as_raw().into(), pair(mips), pair(layers)],
            Range::Buffer([first, end]) => [u64::MAX, first, end],
        };
        words.into_iter().for_each(|word| state.write_u64(word));
    }
}

impl Range {
    /// All of an image.
    pub fn whole_image(shape: &ImageShape) -> Self {
        Range::Image { aspects: shape.aspects(), mips: [0, shape.mips], layers: [0, shape.layers] }
    }

    /// The smallest range that holds both; the first where they are of different kinds.
    pub fn hull(self, other: Range) -> Self {
        let hull = |a: [u32; 2], b: [u32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        match (self, other) {
            (Range::Image { aspects: a, mips: m, layers: l }, Range::Image { aspects: a2, mips: m2, layers: l2 }) => {
                Range::Image { aspects: a | a2, mips: hull(m, m2), layers: hull(l, l2) }
            }
            (Range::Buffer(a), Range::Buffer(b)) => Range::Buffer([a[0].min(b[0]), a[1].max(b[1])]),
            _ => self,
        }
    }

    /// How much it holds: subresources (one aspect of one mip of one layer each), or bytes.
    pub fn amount(&self) -> u64 {
        match self {
            Range::Image { aspects, mips, layers } => {
                let count = |part: &[u32; 2]| u64::from(part[1].saturating_sub(part[0]));
                u64::from(aspects.as_raw().count_ones()) * count(mips) * count(layers)
            }
            Range::Buffer([first, end]) => end.saturating_sub(*first),
        }
    }

    /// Whether both hold some of the same.
    pub fn overlaps(&self, other: &Range) -> bool {
        let common = |a: [u32; 2], b: [u32; 2]| a[0] < b[1] && b[0] < a[1];
        match (*self, *other) {
            (Range::Buffer(a), Range::Buffer(b)) => a[0] < b[1] && b[0] < a[1],
            (Range::Image { aspects, mips, layers }, Range::Image { aspects: a, mips: m, layers: l }) => {
                aspects.intersects(a) && common(mips, m) && common(layers, l)
            }
            _ => false,
        }
    }

    /// Whether it holds something, all of it within another range of the same kind.
    pub fn lies_in(&self, whole: &Range) -> bool {
        match (*self, *whole) {
            (Range::Buffer([first, end]), Range::Buffer([start, stop])) => start <= first && first < end && end <= stop,
            (Range::Image { aspects, mips, layers }, Range::Image { aspects: all, mips: m, layers: l }) => {
                let within =
                    |part: [u32; 2], all: [u32; 2]| all[0] <= part[0] && part[0] < part[1] && part[1] <= all[1];
                !aspects.is_empty() && all.contains(aspects) && within(mips, m) && within(layers, l)
            }
            _ => false,
        }
    }
}

impl Shape {
    /// All of it.
    pub fn whole(&self) -> Range {
        match self {
            Shape::Image(shape) => Range::whole_image(shape),
            Shape::Buffer { size } => Range::Buffer([0, *size]),
        }
    }
}

/// The contents of (a part of) a resource at one point of the frame.
#[derive(Clone, Debug, PartialEq, Hash)]
pub struct Version {
    /// Whose contents.
    pub resource: ResourceId,
    /// Which part.
    pub range: Range,
    /// Where the contents come from.
    pub source: Source,
}

/// Where a version's contents come from.
#[derive(Clone, Debug, PartialEq, Hash)]
pub enum Source {
    /// At the start of the frame: undefined for a transient, kept for an imported resource.
    Initial,
    /// A pass wrote them over `from`.
    Pass {
        /// The writer.
        pass: PassId,
        /// The version it replaced, whole.
        from: VersionId,
    },
    /// A part of another version, made so that parts can be written in any order.
    Split {
        /// The whole.
        of: VersionId,
    },
    /// One of several versions that unordered writers make from `of`, each seeing some of the others' writes
    /// (atomic appends); they cover the same range.
    Fork {
        /// What they started from.
        of: VersionId,
    },
    /// Parts or forks put together again.
    Join {
        /// All of them.
        of: Vec<VersionId>,
    },
}

impl Source {
    /// The versions it is made from.
    pub fn versions(&self) -> &[VersionId] {
        match self {
            Source::Initial => &[],
            Source::Pass { from: of, .. } | Source::Split { of } | Source::Fork { of } => std::slice::from_ref(of),
            Source::Join { of } => of,
        }
    }
}

/// A pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// Unique within a frame.
    pub name: Name,
    /// Queue it would like to run on.
    pub queue: Queue,
    /// Its places among [`Description::uses`].
    pub uses: Span<u32>,
    /// A reason why it runs although nobody reads what it writes.
    pub side_effect: Option<String>,
}

/// Kind of queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Queue {
    /// Draws, and everything else.
    #[default]
    Graphics,
    /// Dispatches and copies.
    Compute,
    /// Copies.
    Transfer,
}

/// One use of one version by one pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Use {
    /// What the pass calls it: name of the binding or of the attachment, for messages.
    pub slot: Cow<'static, str>,
    /// The version it reads, or writes over.
    pub version: VersionId,
    /// The version it makes, where it writes.
    pub makes: Option<VersionId>,
    /// Whether the contents of `version` matter. A use that only writes every texel does not read.
    pub reads: bool,
    /// Stages, mask, layout.
    pub access: Access,
}

/// A version that must exist at the end of the frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Root {
    /// Name of the capture, or of the reason.
    pub name: String,
    /// Which version.
    pub version: VersionId,
    /// Whether its bytes are copied to the host at the end of the frame. Where a later pass would overwrite the
    /// version, the copy happens before that pass.
    pub read_back: bool,
}

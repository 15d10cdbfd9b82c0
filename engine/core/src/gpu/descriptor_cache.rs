//! Descriptor sets that are kept from frame to frame: writing one costs some drivers more than all else about a pass.

use ash::vk;
use ash::vk::Handle;
use rustc_hash::FxHashMap;

use super::descriptor::{layout_of, set_of_pipeline};
use super::descriptor_writes::Writes;
use super::{Buffer, Descriptor, DescriptorArena, Gpu, Image, Pipeline, Sampler, ViewInfo};
use crate::Result;

/// Frames after which a set that no frame has used is written anew for another.
const KEPT_FRAMES: u64 = 4;

/// Descriptor sets by what they hold, kept from frame to frame.
///
/// What a set points at is told apart by numbers that no two objects of a device ever share, and not by Vulkan's handles,
/// which come again: a set is never found for another object than it was written for. Nothing is kept alive: a set whose
/// objects are gone is not asked for again, and is written anew once it has not been used for some frames.
pub struct DescriptorCache {
    arena: DescriptorArena,
    made: Vec<Made>,
    /// Places among those made, by what they hold.
    known: FxHashMap<Box<[u64]>, usize>,
    /// Places that were asked for in this frame, in order. A frame mostly asks for what the last one did.
    asked: Vec<usize>,
    asked_before: Vec<usize>,
    /// Sets that can be written anew, by their layout.
    free: FxHashMap<vk::DescriptorSetLayout, Vec<vk::DescriptorSet>>,
    frame: u64,
    /// What is looked for.
    key: Vec<u64>,
}

struct Made {
    key: Box<[u64]>,
    set: vk::DescriptorSet,
    layout: vk::DescriptorSetLayout,
    last_used: u64,
}

impl DescriptorCache {
    /// Whether it is of this device.
    pub(crate) fn is_from(&self, gpu: &Gpu) -> bool {
        std::sync::Arc::ptr_eq(self.arena.device(), &gpu.device)
    }

    /// Begins a frame. The device is done with all sets that were given for earlier ones.
    pub fn begin_frame(&mut self) {
        self.frame += 1;
        std::mem::swap(&mut self.asked, &mut self.asked_before);
        self.asked.clear();
        let is_old = |made: &Made| made.last_used + KEPT_FRAMES <= self.frame;
        if !self.made.iter().any(is_old) {
            return;
        }
        for made in self.made.extract_if(.., |made| is_old(made)) {
            self.free.entry(made.layout).or_default().push(made.set);
        }
        self.asked_before.clear();
        self.known.clear();
        self.known.extend(self.made.iter().enumerate().map(|(place, made)| (made.key.clone(), place)));
    }

    /// The set that holds this, for set number `set` of `pipeline`; as [`Gpu::descriptor_set`], and null where it is to
    /// hold nothing. It can be used in this frame, as long as what it points at lives. `descriptors` are gone through
    /// once more where it has to be written.
    ///
    /// # Errors
    /// As [`Gpu::descriptor_set`]; what `descriptors` give.
    pub fn set<'p>(
        &mut self,
        pipeline: &Pipeline,
        set: u32,
        descriptors: impl Iterator<Item = Result<(u32, Points<'p>)>> + Clone,
    ) -> Result<vk::DescriptorSet> {
        // 1. Look for it. Pipelines may share a layout, but each has checks of its own on what is bound.
        self.key.clear();
        self.key.extend([pipeline.id(), u64::from(set)]);
        let words = self.key.len();
        for descriptor in descriptors.clone() {
            let (binding, points) = descriptor?;
            push(&mut self.key, binding, &points);
        }
        if self.key.len() == words {
            return Ok(vk::DescriptorSet::null());
        }
        let guess = self.asked_before.get(self.asked.len()).filter(|&&place| *self.made[place].key == *self.key);
        if let Some(&place) = guess.or_else(|| self.known.get(&self.key[..])) {
            self.asked.push(place);
            let made = &mut self.made[place];
            made.last_used = self.frame;
            return Ok(made.set);
        }

        // 2. Write it.
        let who = || set_of_pipeline(pipeline, set);
        let layout = layout_of(pipeline, set)?;
        let descriptors = descriptors.map(|one| one.map(|(binding, points)| (binding, points.descriptor())));
        let descriptors = descriptors.collect::<Result<Vec<_>>>()?;
        let writes = Writes::check(self.arena.device(), &who, layout, &descriptors)?;
        let raw = match self.free.get_mut(&layout.raw()).and_then(Vec::pop) {
            Some(free) => free,
            None => self.arena.allocate(&who, layout)?,
        };
        writes.write(self.arena.device(), raw);
        let (key, place) = (Box::<[u64]>::from(&self.key[..]), self.made.len());
        self.known.insert(key.clone(), place);
        self.asked.push(place);
        self.made.push(Made { key, set: raw, layout: layout.raw(), last_used: self.frame });
        Ok(raw)
    }
}

/// What a binding points at, as [`Descriptor`] without a share in it: enough to look for a set.
#[derive(Clone, Copy)]
pub enum Points<'a> {
    /// Bytes `[offset, offset + size)` of a buffer.
    Buffer {
        /// The buffer.
        buffer: &'a Buffer,
        /// First byte.
        offset: u64,
        /// Bytes; `vk::WHOLE_SIZE` for the rest.
        size: u64,
    },
    /// A part of an image, in a layout, with a sampler where the binding has one.
    Image {
        /// The image.
        image: &'a Image,
        /// The part.
        view: ViewInfo,
        /// Layout it will be in.
        layout: vk::ImageLayout,
        /// The sampler.
        sampler: Option<Sampler>,
    },
}

impl<'a> Points<'a> {
    /// A whole buffer.
    pub fn buffer(buffer: &'a Buffer) -> Self {
        Self::Buffer { buffer, offset: 0, size: vk::WHOLE_SIZE }
    }

    fn descriptor(&self) -> Descriptor {
        match *self {
            Self::Buffer { buffer, offset, size } => Descriptor::Buffer { buffer: buffer.clone(), offset, size },
            Self::Image { image, view, layout, sampler: None } => {
                Descriptor::Image { image: image.clone(), view, layout }
            }
            Self::Image { image, view, layout, sampler: Some(sampler) } => {
                Descriptor::Sampled { image: image.clone(), view, layout, sampler }
            }
        }
    }
}

/// What tells apart what a binding points at. Samplers live as long as their device: their handles do not come again.
fn push(key: &mut Vec<u64>, binding: u32, points: &Points) {
    let pair = |[first, second]: [u32; 2]| u64::from(first) << 32 | u64::from(second);
    match points {
        Points::Buffer { buffer, offset, size } => key.extend([pair([binding, 0]), buffer.id(), *offset, *size]),
        Points::Image { image, view, layout, sampler } => {
            let ViewInfo { kind, format, aspects, mips, layers } = *view;
            key.extend([
                pair([binding, 1]),
                image.id(),
                pair([kind.as_raw() as u32, format.as_raw() as u32]),
                pair([aspects.as_raw(), layout.as_raw() as u32]),
                pair(mips),
                pair(layers),
                sampler.map_or(0, |sampler| sampler.raw().as_raw()),
            ]);
        }
    }
}

impl Gpu {
    /// A cache without any sets.
    pub fn descriptor_cache(&self, name: &str) -> DescriptorCache {
        DescriptorCache {
            arena: self.descriptor_arena(name),
            made: Vec::new(),
            known: FxHashMap::default(),
            asked: Vec::new(),
            asked_before: Vec::new(),
            free: FxHashMap::default(),
            frame: 0,
            key: Vec::new(),
        }
    }
}

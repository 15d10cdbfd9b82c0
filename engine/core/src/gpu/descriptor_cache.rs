//! Descriptor sets that are kept from frame to frame: writing one costs some drivers more than all else about a pass.

use ash::vk;
use ash::vk::Handle;
use rustc_hash::FxHashMap;

use super::descriptor::{layout_of, set_of_pipeline};
use super::descriptor_writes::Writes;
use super::{Descriptor, DescriptorArena, Gpu, Pipeline, ViewInfo};
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
    made: FxHashMap<Box<[u64]>, Made>,
    /// Sets that can be written anew, by their layout.
    free: FxHashMap<vk::DescriptorSetLayout, Vec<vk::DescriptorSet>>,
    frame: u64,
    /// What is looked for.
    key: Vec<u64>,
}

struct Made {
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
        let Self { made, free, frame, .. } = self;
        made.retain(|_, made| {
            let stays = made.last_used + KEPT_FRAMES > *frame;
            if !stays {
                free.entry(made.layout).or_default().push(made.set);
            }
            stays
        });
    }

    /// The set that holds this, for set number `set` of `pipeline`; as [`Gpu::descriptor_set`]. It can be used in this
    /// frame, as long as what it points at lives.
    ///
    /// # Errors
    /// As [`Gpu::descriptor_set`].
    pub fn set(
        &mut self,
        pipeline: &Pipeline,
        set: u32,
        descriptors: &[(u32, Descriptor)],
    ) -> Result<vk::DescriptorSet> {
        // 1. Look for it. Pipelines may share a layout, but each has checks of its own on what is bound.
        self.key.clear();
        self.key.extend([pipeline.id(), u64::from(set)]);
        descriptors.iter().for_each(|(binding, descriptor)| push(&mut self.key, *binding, descriptor));
        if let Some(made) = self.made.get_mut(&self.key[..]) {
            made.last_used = self.frame;
            return Ok(made.set);
        }

        // 2. Write it.
        let who = || set_of_pipeline(pipeline, set);
        let layout = layout_of(pipeline, set)?;
        let writes = Writes::check(self.arena.device(), &who, layout, descriptors)?;
        let raw = match self.free.get_mut(&layout.raw()).and_then(Vec::pop) {
            Some(free) => free,
            None => self.arena.allocate(&who, layout)?,
        };
        writes.write(self.arena.device(), raw);
        self.made.insert(self.key[..].into(), Made { set: raw, layout: layout.raw(), last_used: self.frame });
        Ok(raw)
    }
}

/// What tells a descriptor apart.
fn push(key: &mut Vec<u64>, binding: u32, descriptor: &Descriptor) {
    let pair = |[first, second]: [u32; 2]| u64::from(first) << 32 | u64::from(second);
    let kind = match descriptor {
        Descriptor::Buffer { .. } => 0,
        Descriptor::Image { .. } => 1,
        Descriptor::Sampled { .. } => 2,
        Descriptor::Sampler(_) => 3,
    };
    key.push(pair([binding, kind]));
    match descriptor {
        Descriptor::Buffer { buffer, offset, size } => key.extend([buffer.id(), *offset, *size]),
        Descriptor::Image { image, view, layout } | Descriptor::Sampled { image, view, layout, .. } => {
            let ViewInfo { kind, format, aspects, mips, layers } = *view;
            key.extend([
                image.id(),
                pair([kind.as_raw() as u32, format.as_raw() as u32]),
                pair([aspects.as_raw(), layout.as_raw() as u32]),
                pair(mips),
                pair(layers),
            ]);
        }
        Descriptor::Sampler(_) => {}
    }
    // Samplers live as long as their device: their handles do not come again.
    if let Descriptor::Sampled { sampler, .. } | Descriptor::Sampler(sampler) = descriptor {
        key.push(sampler.raw().as_raw());
    }
}

impl Gpu {
    /// A cache without any sets.
    pub fn descriptor_cache(&self, name: &str) -> DescriptorCache {
        DescriptorCache {
            arena: self.descriptor_arena(name),
            made: FxHashMap::default(),
            free: FxHashMap::default(),
            frame: 0,
            key: Vec::new(),
        }
    }
}

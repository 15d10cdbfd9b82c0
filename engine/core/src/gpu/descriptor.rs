//! Descriptor sets.

use std::sync::Arc;

use ash::vk;

use super::descriptor_writes::Writes;
use super::device::{Device, Garbage};
use super::layout::descriptor_type;
use super::{Buffer, Gpu, Image, Pipeline, PipelineBinding, Sampler, ViewInfo};
use crate::{Error, Result};

/// What a binding points at.
#[derive(Clone)]
pub enum Descriptor {
    /// A uniform or storage buffer: bytes `[offset, offset + size)`.
    Buffer {
        /// The buffer.
        buffer: Buffer,
        /// First byte; a multiple of the device's alignment for such buffers.
        offset: u64,
        /// Bytes; `vk::WHOLE_SIZE` for the rest.
        size: u64,
    },
    /// A sampled or storage image.
    Image {
        /// The image.
        image: Image,
        /// The part.
        view: ViewInfo,
        /// Layout it will be in.
        layout: vk::ImageLayout,
    },
    /// A combined image sampler.
    Sampled {
        /// The image.
        image: Image,
        /// The part.
        view: ViewInfo,
        /// Layout it will be in.
        layout: vk::ImageLayout,
        /// The sampler.
        sampler: Sampler,
    },
    /// A sampler.
    Sampler(Sampler),
}

impl Descriptor {
    /// A whole buffer.
    pub fn buffer(buffer: &Buffer) -> Self {
        Self::Buffer { buffer: buffer.clone(), offset: 0, size: vk::WHOLE_SIZE }
    }

    /// A whole image in `SHADER_READ_ONLY_OPTIMAL`, with a sampler.
    pub fn texture(image: &Image, sampler: Sampler) -> Self {
        Self::Sampled {
            image: image.clone(),
            view: image.whole(),
            layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
            sampler,
        }
    }

    /// What it is, for messages.
    pub(super) fn kind(&self) -> String {
        match self {
            Self::Buffer { buffer, .. } => format!("buffer {:?}", buffer.name()),
            Self::Image { image, .. } => format!("image {:?} without a sampler", image.name()),
            Self::Sampled { image, .. } => format!("image {:?} with a sampler", image.name()),
            Self::Sampler(_) => "a sampler".into(),
        }
    }

    /// A whole image (its first mip level) for loads and stores, in `GENERAL`.
    pub fn storage(image: &Image) -> Self {
        Self::Image { image: image.clone(), view: image.whole().mip(0), layout: vk::ImageLayout::GENERAL }
    }
}

/// Layout of one descriptor set. Equal contents are one Vulkan object. It is valid as long as its [`Gpu`].
#[derive(Clone)]
pub struct SetLayout {
    pub(super) raw: vk::DescriptorSetLayout,
    pub(super) set: u32,
    pub(super) bindings: Arc<[PipelineBinding]>,
}

impl SetLayout {
    /// The Vulkan handle.
    pub fn raw(&self) -> vk::DescriptorSetLayout {
        self.raw
    }

    /// Number of the set.
    pub fn set(&self) -> u32 {
        self.set
    }

    /// What it holds, by binding number.
    pub fn bindings(&self) -> &[PipelineBinding] {
        &self.bindings
    }
}

/// A long-lived descriptor set. It keeps alive what it points at.
#[derive(Clone)]
pub struct DescriptorSet(Arc<Inner>);

struct Inner {
    device: Arc<Device>,
    id: u64,
    name: String,
    /// Of its own size, for this set alone.
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    /// What it points at.
    _kept: Vec<Descriptor>,
}

impl DescriptorSet {
    /// The Vulkan handle.
    pub fn raw(&self) -> vk::DescriptorSet {
        self.0.set
    }

    /// Debug name.
    pub fn name(&self) -> &str {
        &self.0.name
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        self.device.forget(self.id);
        self.device.defer(Garbage::DescriptorPools(vec![self.pool]));
    }
}

/// Descriptor sets that live for one frame: allocated one by one, given back together.
pub struct DescriptorArena {
    device: Arc<Device>,
    id: u64,
    name: String,
    pools: Vec<vk::DescriptorPool>,
    /// The pool that is being allocated from.
    current: usize,
    /// What the sets point at.
    kept: Vec<Descriptor>,
}

/// Sets of one of an arena's pools, and descriptors of each kind.
const ARENA_SETS: u32 = 128;
const ARENA_DESCRIPTORS: u32 = 512;

impl DescriptorArena {
    /// A set with every binding of `pipeline`'s set number `set`; as [`Gpu::descriptor_set`]. It is valid until the
    /// next `reset`, and until then what it points at is kept.
    ///
    /// # Errors
    /// As [`Gpu::descriptor_set`].
    pub fn set(
        &mut self,
        pipeline: &Pipeline,
        set: u32,
        descriptors: &[(u32, Descriptor)],
    ) -> Result<vk::DescriptorSet> {
        let who = || set_of_pipeline(pipeline, set);
        let layout = layout_of(pipeline, set)?;
        let writes = Writes::check(&self.device, &who, layout, descriptors)?;
        let raw = self.allocate(&who, layout)?;
        writes.write(&self.device, raw);
        self.kept.extend(descriptors.iter().map(|d| d.1.clone()));
        Ok(raw)
    }

    /// A set that nothing is written to yet.
    pub(super) fn allocate(&mut self, who: &dyn Fn() -> String, layout: &SetLayout) -> Result<vk::DescriptorSet> {
        let layouts = [layout.raw];
        loop {
            // A set that is larger than a whole pool gets one of its own size.
            if self.current == self.pools.len() {
                let sizes: Vec<_> = pool_sizes(layout)
                    .into_iter()
                    .chain(ARENA_KINDS.map(|ty| vk::DescriptorPoolSize { ty, descriptor_count: ARENA_DESCRIPTORS }))
                    .collect();
                let pool = make_pool(&self.device, &self.name, &sizes, ARENA_SETS)?;
                self.pools.push(pool);
            }
            let pool = self.pools[self.current];
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            // SAFETY: a live pool that only this arena uses, and a live layout.
            match unsafe { self.device.raw.allocate_descriptor_sets(&info) } {
                Ok(sets) => return Ok(sets[0]),
                Err(vk::Result::ERROR_OUT_OF_POOL_MEMORY | vk::Result::ERROR_FRAGMENTED_POOL) => self.current += 1,
                Err(e) => return Err(self.device.error("vkAllocateDescriptorSets", &who(), e)),
            }
        }
    }

    pub(super) fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// Gives all sets back. The device must be done with them.
    pub fn reset(&mut self) {
        for &pool in &self.pools[..self.pools.len().min(self.current + 1)] {
            // SAFETY: the caller's promise that the device is done with the sets; it cannot fail.
            let _ = unsafe { self.device.raw.reset_descriptor_pool(pool, vk::DescriptorPoolResetFlags::empty()) };
        }
        self.current = 0;
        self.kept.clear();
    }
}

impl Drop for DescriptorArena {
    fn drop(&mut self) {
        self.device.forget(self.id);
        self.device.defer(Garbage::DescriptorPools(std::mem::take(&mut self.pools)));
    }
}

/// Kinds of descriptors that the engine knows.
const ARENA_KINDS: [vk::DescriptorType; 6] = [
    vk::DescriptorType::UNIFORM_BUFFER,
    vk::DescriptorType::STORAGE_BUFFER,
    vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
    vk::DescriptorType::SAMPLED_IMAGE,
    vk::DescriptorType::SAMPLER,
    vk::DescriptorType::STORAGE_IMAGE,
];

impl Gpu {
    /// A long-lived set for set number `set` of `pipeline` and of every pipeline with the same layout there.
    /// `descriptors` are by binding number; an array takes as many entries as it has elements, in order.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] naming the bindings that were not given (none may stay unwritten: a driver may
    /// crash), are not there, or are of another kind.
    pub fn descriptor_set(
        &self,
        name: &str,
        pipeline: &Pipeline,
        set: u32,
        descriptors: &[(u32, Descriptor)],
    ) -> Result<DescriptorSet> {
        self.descriptor_set_of(name, layout_of(pipeline, set)?, descriptors)
    }

    /// As [`Gpu::descriptor_set`], from a layout.
    ///
    /// # Errors
    /// As [`Gpu::descriptor_set`].
    pub fn descriptor_set_of(
        &self,
        name: &str,
        layout: &SetLayout,
        descriptors: &[(u32, Descriptor)],
    ) -> Result<DescriptorSet> {
        let device = &self.device;
        let writes = Writes::check(device, &|| format!("descriptor set {name:?}"), layout, descriptors)?;
        let pool = make_pool(device, name, &pool_sizes(layout), 1)?;
        let layouts = [layout.raw];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        // SAFETY: a live pool that only we use, and a live layout.
        let set = match unsafe { device.raw.allocate_descriptor_sets(&info) } {
            Ok(sets) => sets[0],
            Err(e) => {
                device.destroy(Garbage::DescriptorPools(vec![pool]));
                return Err(device.error("vkAllocateDescriptorSets", name, e));
            }
        };
        device.name(set, name);
        writes.write(device, set);
        Ok(DescriptorSet(Arc::new(Inner {
            id: device.register("descriptor set", name),
            device: device.clone(),
            name: name.into(),
            pool,
            set,
            _kept: descriptors.iter().map(|d| d.1.clone()).collect(),
        })))
    }

    /// An arena for the sets of one frame.
    pub fn descriptor_arena(&self, name: &str) -> DescriptorArena {
        DescriptorArena {
            id: self.device.register("descriptor arena", name),
            device: self.device.clone(),
            name: name.into(),
            pools: Vec::new(),
            current: 0,
            kept: Vec::new(),
        }
    }
}

/// For messages.
pub(super) fn set_of_pipeline(pipeline: &Pipeline, set: u32) -> String {
    format!("descriptor set {set} of pipeline {:?}", pipeline.name())
}

pub(super) fn layout_of(pipeline: &Pipeline, set: u32) -> Result<&SetLayout> {
    pipeline
        .set_layout(set)
        .ok_or_else(|| Error::invalid(format!("pipeline {:?}", pipeline.name()), format!("it has no set {set}")))
}

fn pool_sizes(layout: &SetLayout) -> Vec<vk::DescriptorPoolSize> {
    let size = |b: &PipelineBinding| vk::DescriptorPoolSize {
        ty: descriptor_type(b.binding.kind),
        descriptor_count: b.binding.count.max(1),
    };
    let mut sizes: Vec<_> = layout.bindings.iter().map(size).collect();
    if sizes.is_empty() {
        // A pool holds something, even one for an empty set.
        sizes.push(vk::DescriptorPoolSize { ty: vk::DescriptorType::UNIFORM_BUFFER, descriptor_count: 1 });
    }
    sizes
}

fn make_pool(device: &Device, name: &str, sizes: &[vk::DescriptorPoolSize], sets: u32) -> Result<vk::DescriptorPool> {
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(sets).pool_sizes(sizes);
    // SAFETY: a valid structure.
    let pool = unsafe { device.raw.create_descriptor_pool(&info, None) };
    let pool = pool.map_err(|e| device.error("vkCreateDescriptorPool", name, e))?;
    device.name(pool, &format!("{name}.pool"));
    Ok(pool)
}

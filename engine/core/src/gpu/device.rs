//! What every object of a [`super::Gpu`] shares: the device, its memory, its names, and what waits to be freed.

use std::any::Any;
use std::collections::{BTreeMap, HashMap};
use std::ffi::CString;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use ash::vk;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc};

use super::layout::LayoutKey;
use super::pipeline_cache::CacheFile;
use super::sampler::SamplerKey;
use super::submit::State;
use super::{Caps, Memory, Messages, lock};
use crate::{Error, Result};

/// Lives as long as anything made from it.
pub(super) struct Device {
    pub raw: ash::Device,
    pub instance: ash::Instance,
    pub physical: vk::PhysicalDevice,
    pub caps: Caps,
    pub queue: vk::Queue,
    /// Signalled by every submission, with values that count up from 1.
    pub timeline: vk::Semaphore,
    pub state: Mutex<State>,
    pub samplers: Mutex<HashMap<SamplerKey, vk::Sampler>>,
    pub set_layouts: Mutex<HashMap<LayoutKey, vk::DescriptorSetLayout>>,
    pub pipeline_cache: CacheFile,
    pub messages: Arc<Messages>,
    /// For names and labels, where the extension is there.
    pub debug: Option<ash::ext::debug_utils::Device>,
    /// Whether a validation layer may be watching.
    pub validated: bool,
    allocator: Mutex<Option<Allocator>>,
    live: Mutex<BTreeMap<u64, String>>,
    next_id: AtomicU64,
    /// Set where device and instance are ours to destroy.
    owned: Option<Owned>,
    _entry: ash::Entry,
}

/// What is destroyed with a device that we opened.
pub(super) struct Owned {
    pub messenger: Option<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
}

/// What a [`Device`] is made of.
pub(super) struct Parts {
    pub entry: ash::Entry,
    pub instance: ash::Instance,
    pub physical: vk::PhysicalDevice,
    pub raw: ash::Device,
    pub queue: vk::Queue,
    pub caps: Caps,
    pub messages: Arc<Messages>,
    pub debug: bool,
    /// Whether a validation layer may be watching.
    pub validated: bool,
    pub pipeline_cache: Option<std::path::PathBuf>,
    pub owned: Option<Owned>,
}

/// An object that the device may still be using.
pub(super) enum Garbage {
    Buffer(RawBuffer),
    Image { image: Option<vk::Image>, views: Vec<vk::ImageView>, allocation: Option<Allocation> },
    Memory(Allocation),
    Pipeline(vk::Pipeline, vk::PipelineLayout),
    DescriptorPools(Vec<vk::DescriptorPool>),
    QueryPool(vk::QueryPool),
    RenderPass(vk::RenderPass, vk::Framebuffer),
    Kept(Vec<Box<dyn Any + Send>>),
}

/// A buffer with the memory that is its own (none where it lies in a heap).
pub(super) struct RawBuffer {
    pub buffer: vk::Buffer,
    pub allocation: Option<Allocation>,
}

impl Device {
    pub(super) fn new(parts: Parts) -> Result<Arc<Device>> {
        let Parts { entry, instance, physical, raw, queue, caps, messages, debug, validated, pipeline_cache, owned } =
            parts;
        let debug = debug.then(|| ash::ext::debug_utils::Device::new(&instance, &raw));
        // From here on the device is destroyed by `Drop`, whatever fails.
        let mut device = Device {
            debug,
            validated,
            queue,
            timeline: vk::Semaphore::null(),
            state: Mutex::default(),
            samplers: Mutex::default(),
            set_layouts: Mutex::default(),
            pipeline_cache: CacheFile::none(),
            messages,
            allocator: Mutex::new(None),
            live: Mutex::default(),
            next_id: AtomicU64::new(0),
            owned,
            caps,
            raw,
            instance,
            physical,
            _entry: entry,
        };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: device.instance.clone(),
            device: device.raw.clone(),
            physical_device: device.physical,
            debug_settings: Default::default(),
            buffer_device_address: true,
            allocation_sizes: Default::default(),
        });
        let allocator = allocator.map_err(|e| Error::OutOfMemory {
            object: "the memory allocator".into(),
            bytes: 0,
            why: e.to_string(),
        })?;
        *lock(&device.allocator) = Some(allocator);
        let mut kind = vk::SemaphoreTypeCreateInfo::default().semaphore_type(vk::SemaphoreType::TIMELINE);
        let info = vk::SemaphoreCreateInfo::default().push_next(&mut kind);
        // SAFETY: a live device with timeline semaphores.
        let timeline = unsafe { device.raw.create_semaphore(&info, None) };
        device.timeline = timeline.map_err(|e| device.error("vkCreateSemaphore", "the timeline", e))?;
        device.name(device.timeline, "the timeline");
        device.pipeline_cache = CacheFile::open(&device, pipeline_cache)?;
        device.name(device.queue, "the queue");
        Ok(Arc::new(device))
    }

    /// Gives an object its debug name.
    pub(super) fn name<T: vk::Handle>(&self, object: T, name: &str) {
        let Some(debug) = &self.debug else { return };
        let name = super::c_string(name);
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
        // SAFETY: a live object of this device.
        if let Err(e) = unsafe { debug.set_debug_utils_object_name(&info) } {
            log::debug!("vkSetDebugUtilsObjectNameEXT: {e}");
        }
    }

    /// Turns Vulkan's answer into an error; a lost device tells of its last pass. Not to be called with `state`
    /// locked.
    pub(super) fn error(&self, call: &'static str, object: &str, result: vk::Result) -> Error {
        match result {
            vk::Result::ERROR_DEVICE_LOST => self.lost(),
            _ => Error::Vulkan { call, object: object.into(), result },
        }
    }

    // --- live objects ---

    /// Notes an object that a user holds; the number is for [`Device::forget`].
    pub(super) fn register(&self, kind: &str, name: &str) -> u64 {
        let id = self.next_id.fetch_add(1, Ordering::Relaxed);
        lock(&self.live).insert(id, format!("{kind} {name:?}"));
        id
    }

    pub(super) fn forget(&self, id: u64) {
        lock(&self.live).remove(&id);
    }

    pub(super) fn live_objects(&self) -> Vec<String> {
        lock(&self.live).values().cloned().collect()
    }

    // --- memory ---

    /// Allocates memory.
    pub(super) fn allocate(
        &self,
        name: &str,
        requirements: vk::MemoryRequirements,
        memory: Memory,
        linear: bool,
    ) -> Result<Allocation> {
        let out_of_memory = |why| Error::OutOfMemory { object: name.into(), bytes: requirements.size, why };
        if requirements.size > self.caps.limits.max_allocation_size {
            let most = self.caps.limits.max_allocation_size;
            return Err(out_of_memory(format!("the device allocates at most {most} bytes at once")));
        }
        let info = AllocationCreateDesc {
            name,
            requirements,
            location: memory.location(),
            linear,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        match lock(&self.allocator).as_mut() {
            Some(allocator) => allocator.allocate(&info).map_err(|e| out_of_memory(e.to_string())),
            None => Err(out_of_memory("there is no allocator".into())),
        }
    }

    pub(super) fn free(&self, allocation: Allocation) {
        if let Some(allocator) = lock(&self.allocator).as_mut()
            && let Err(e) = allocator.free(allocation)
        {
            log::error!("memory cannot be freed: {e}");
        }
    }

    /// Bytes of all allocations, those that wait to be freed included.
    pub(super) fn memory_in_use(&self) -> u64 {
        lock(&self.allocator).as_ref().map_or(0, |a| a.generate_report().total_allocated_bytes)
    }

    /// Makes a buffer with memory of its own.
    pub(super) fn make_buffer(&self, info: &super::BufferInfo) -> Result<RawBuffer> {
        // SAFETY: a valid structure (size and usage are checked by the caller).
        let buffer = unsafe { self.raw.create_buffer(&info.vulkan(), None) };
        let buffer = buffer.map_err(|e| self.error("vkCreateBuffer", info.name, e))?;
        let mut made = RawBuffer { buffer, allocation: None };
        // SAFETY: the buffer was just made.
        let requirements = unsafe { self.raw.get_buffer_memory_requirements(buffer) };
        let bound = self.allocate(info.name, requirements, info.memory, true).and_then(|allocation| {
            // SAFETY: memory that satisfies the buffer's requirements and is its own.
            let bound = unsafe { self.raw.bind_buffer_memory(buffer, allocation.memory(), allocation.offset()) };
            made.allocation = Some(allocation);
            bound.map_err(|e| self.error("vkBindBufferMemory", info.name, e))
        });
        if let Err(e) = bound {
            self.destroy(Garbage::Buffer(made));
            return Err(e);
        }
        self.name(buffer, info.name);
        Ok(made)
    }

    /// Destroys what the device no longer uses. Not to be called with `state` locked.
    pub(super) fn destroy(&self, garbage: Garbage) {
        // SAFETY: each object is of this device, is destroyed once (it was moved here), and the device is done with
        // it: `Device::defer` keeps it until then.
        unsafe {
            match garbage {
                Garbage::Buffer(RawBuffer { buffer, allocation }) => {
                    self.raw.destroy_buffer(buffer, None);
                    allocation.into_iter().for_each(|a| self.free(a));
                }
                Garbage::Image { image, views, allocation } => {
                    views.into_iter().for_each(|v| self.raw.destroy_image_view(v, None));
                    image.into_iter().for_each(|i| self.raw.destroy_image(i, None));
                    allocation.into_iter().for_each(|a| self.free(a));
                }
                Garbage::Memory(allocation) => self.free(allocation),
                Garbage::Pipeline(pipeline, layout) => {
                    self.raw.destroy_pipeline(pipeline, None);
                    self.raw.destroy_pipeline_layout(layout, None);
                }
                Garbage::DescriptorPools(pools) => {
                    pools.into_iter().for_each(|p| self.raw.destroy_descriptor_pool(p, None));
                }
                Garbage::QueryPool(pool) => self.raw.destroy_query_pool(pool, None),
                Garbage::RenderPass(pass, framebuffer) => {
                    self.raw.destroy_framebuffer(framebuffer, None);
                    self.raw.destroy_render_pass(pass, None);
                }
                Garbage::Kept(objects) => drop(objects),
            }
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let state = std::mem::take(self.state.get_mut().unwrap_or_else(std::sync::PoisonError::into_inner));
        // SAFETY: nothing else of the device is in use: whatever was made from it holds an `Arc` of it. Children go
        // before parents.
        unsafe {
            // An error here is the loss of the device, which frees its objects as well.
            let _ =
                if self.owned.is_some() { self.raw.device_wait_idle() } else { self.raw.queue_wait_idle(self.queue) };
            state.destroy(self);
            for sampler in lock(&self.samplers).drain() {
                self.raw.destroy_sampler(sampler.1, None);
            }
            for layout in lock(&self.set_layouts).drain() {
                self.raw.destroy_descriptor_set_layout(layout.1, None);
            }
            self.pipeline_cache.destroy(&self.raw);
            self.raw.destroy_semaphore(self.timeline, None);
            // The allocator frees its blocks, so it goes before the device.
            drop(lock(&self.allocator).take());
            if let Some(owned) = self.owned.take() {
                self.raw.destroy_device(None);
                if let Some((loader, messenger)) = owned.messenger {
                    loader.destroy_debug_utils_messenger(messenger, None);
                }
                self.instance.destroy_instance(None);
            }
        }
    }
}

/// A C string; a NUL inside ends it.
pub(super) fn c_string(text: &str) -> CString {
    CString::new(text.split('\0').next().unwrap_or_default()).unwrap_or_default()
}

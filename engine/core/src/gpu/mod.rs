//! Instance, device, memory, images, buffers, pipelines, commands, queries, validation messages.
//!
//! Everything hangs on a [`Gpu`]. What it makes is reference-counted (`Clone` is cheap and means the same object),
//! named, and destroyed when its last clone is gone *and* the device has finished every submission made until then.
//! Objects keep the device alive, so the order of dropping is free; what still lives when the [`Gpu`] goes is a
//! leak, reported by name ([`Gpu::close`], [`Gpu::live_objects`]).
//!
//! Threads: [`Gpu`] and the objects here are `Send` and `Sync`. [`Commands`] and [`Uploader`] are `Send` only;
//! [`DescriptorArena`] and [`DescriptorCache`] are recorded with through `&mut`. Submission takes a lock.
//!
//! `raw()` gives the Vulkan handle of an object, for recording. A handle is valid while the object lives; a clone
//! given to [`Commands::keep`] lives until the device is done.
#![allow(unsafe_code)]

mod buffer;
mod caps;
mod commands;
mod descriptor;
mod descriptor_cache;
mod descriptor_writes;
mod device;
mod features;
mod format;
mod image;
mod image_info;
mod instance;
mod layout;
mod memory;
mod messages;
mod open;
mod options;
mod pipeline;
mod pipeline_cache;
mod pipeline_checks;
mod pipeline_info;
mod pipeline_state;
mod query;
mod render_pass;
mod sampler;
mod select;
mod submit;
mod upload;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

pub use buffer::{Buffer, BufferInfo};
pub use caps::{Caps, DeviceKind, Feature, Limits, QueueFamily};
pub use commands::{Commands, SemaphoreAt, SubmitToken};
pub use descriptor::{Descriptor, DescriptorArena, DescriptorSet, SetLayout};
pub use descriptor_cache::{DescriptorCache, Points};
pub use format::{FormatInfo, Numeric, linear_from_srgb};
pub use image::Image;
pub use image_info::{ImageInfo, ViewInfo};
pub use memory::{Heap, Memory, Requirements};
pub use messages::{Message, Messages, Severity};
pub use options::{GpuOptions, RawGpu, Validation};
pub use pipeline::{Constant, Pipeline, PipelineBinding};
pub use pipeline_info::{
    ColorTarget, DepthState, GraphicsPipelineInfo, StencilState, VertexAttribute, VertexBuffer, blend, stencil,
};
pub use query::{QueryKind, QueryPool};
pub(crate) use render_pass::Target;
pub use sampler::{Sampler, SamplerInfo};
pub use upload::Uploader;

use crate::{Error, Result};
use device::{Device, c_string};

/// A Vulkan device and all that the engine keeps for it.
pub struct Gpu {
    device: Arc<Device>,
    /// `close` has said and done all that dropping would.
    closed: bool,
}

impl Gpu {
    /// What the device can do.
    pub fn caps(&self) -> &Caps {
        &self.device.caps
    }

    /// Validation messages so far. A clone of the `Arc` can be read after the [`Gpu`] is gone.
    pub fn messages(&self) -> &Arc<Messages> {
        &self.device.messages
    }

    /// Whether a validation layer may be watching.
    pub(crate) fn is_validated(&self) -> bool {
        self.device.validated
    }

    /// The device, for recording and for what is not wrapped.
    pub fn raw(&self) -> &ash::Device {
        &self.device.raw
    }

    /// The instance, for what is not wrapped.
    pub fn raw_instance(&self) -> &ash::Instance {
        &self.device.instance
    }

    /// The physical device.
    pub fn raw_physical_device(&self) -> ash::vk::PhysicalDevice {
        self.device.physical
    }

    /// Names of the objects made by this [`Gpu`] that still live, each with its kind: `image "shadow.map"`.
    pub fn live_objects(&self) -> Vec<String> {
        self.device.collect();
        self.device.live_objects()
    }

    /// Bytes of memory that images, buffers and heaps take, with those dropped ones that the device may still use.
    /// (The device's own blocks, which these lie in, are larger.)
    pub fn memory_in_use(&self) -> u64 {
        self.device.collect();
        self.device.memory_in_use()
    }

    /// Waits until the device has done all that was submitted, and frees what waited for that.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`].
    pub fn wait_idle(&self) -> Result<()> {
        self.device.wait_all()
    }

    /// Writes the pipeline cache to [`GpuOptions::pipeline_cache`], under a temporary name first. Done by `close` and
    /// on dropping too; without a path it does nothing.
    ///
    /// # Errors
    /// [`crate::Error::Io`].
    pub fn save_pipeline_cache(&self) -> Result<()> {
        self.device.pipeline_cache.save(&self.device.raw)
    }

    /// Waits for the device, frees everything, and tells of leaks.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] naming every object that still lives (plain dropping logs the same);
    /// [`crate::Error::DeviceLost`]; [`crate::Error::Io`] where the pipeline cache cannot be written.
    pub fn close(mut self) -> Result<()> {
        let (waited, saved) = (self.wait_idle(), self.save_pipeline_cache());
        let live = self.device.live_objects();
        self.closed = true;
        drop(self);
        waited?;
        leaks(&live)?;
        saved
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        if self.closed {
            return;
        }
        if let Err(e) = self.wait_idle() {
            log::error!("{e}");
        }
        if let Err(e) = self.save_pipeline_cache() {
            log::warn!("{e}");
        }
        if let Err(e) = leaks(&self.device.live_objects()) {
            log::error!("{e}");
        }
    }
}

impl std::fmt::Debug for Gpu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Gpu({})", self.device.caps.title())
    }
}

fn leaks(live: &[String]) -> Result<()> {
    if live.is_empty() {
        return Ok(());
    }
    Err(Error::invalid("the device", format!("{} objects outlive it: {}", live.len(), live.join(", "))))
}

/// Locks; what a panicking thread left behind is used as it is.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

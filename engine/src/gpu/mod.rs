//! Instance, device, memory, images, buffers, pipelines, commands, queries, validation messages.
//!
//! Everything hangs on a [`Gpu`]. What it makes is reference-counted (`Clone` is cheap and means the same object),
//! named, and destroyed when its last clone is gone *and* the device has finished every submission made until then.
//! Objects keep the device alive, so the order of dropping is free; what still lives when the [`Gpu`] goes is a
//! leak, reported by name ([`Gpu::close`], [`Gpu::live_objects`]).
//!
//! Threads: [`Gpu`] and every object here are `Send` and `Sync`, but for [`Commands`], [`Uploader`] and
//! [`DescriptorArena`], which are `Send` and used by one thread at a time. Submission takes a lock.
//!
//! `raw()` gives the Vulkan handle of an object, for recording. A handle is valid while the object lives; a clone
//! given to [`Commands::keep`] lives until the device is done.
#![allow(unsafe_code)]

mod buffer;
mod caps;
mod commands;
mod descriptor;
mod format;
mod image;
mod memory;
mod messages;
mod options;
mod pipeline;
mod query;
mod sampler;
mod upload;

pub use buffer::{Buffer, BufferInfo};
pub use caps::{Caps, DeviceKind, Feature, Limits, QueueFamily};
pub use commands::{Commands, SemaphoreAt, SubmitToken};
pub use descriptor::{Descriptor, DescriptorArena, DescriptorSet, SetLayout};
pub use format::{FormatInfo, Numeric};
pub use image::{Image, ImageInfo, ViewInfo};
pub use memory::{Heap, Memory, Requirements};
pub use messages::{Message, Messages, Severity};
pub use options::{GpuOptions, RawGpu, Validation};
pub use pipeline::{
    ColorTarget, Constant, DepthState, GraphicsPipelineInfo, Pipeline, PipelineBinding, StencilState, VertexAttribute,
    VertexBuffer, blend,
};
pub use query::{QueryKind, QueryPool};
pub use sampler::{Sampler, SamplerInfo};
pub use upload::Uploader;

use crate::Result;

/// A Vulkan device and all that the engine keeps for it.
pub struct Gpu {}

impl Gpu {
    /// Opens a device without a window.
    ///
    /// Takes the best device (discrete, integrated, virtual, then CPU) that has what the engine needs, or the one
    /// that [`GpuOptions::device`] or `SHADOWGRAPH_DEVICE` names.
    ///
    /// # Errors
    /// [`crate::Error::NoDevice`] where there is no loader, no device or none of that name, or the validation layer
    /// is not installed; [`crate::Error::Missing`] with every feature that the device lacks.
    pub fn headless(_options: GpuOptions) -> Result<Gpu> {
        unimplemented!()
    }

    /// Uses an application's own device, which is not destroyed at the end.
    ///
    /// # Safety
    /// The handles are valid and outlive the [`Gpu`] and all it makes; the device was created with the features and
    /// extensions that [`RawGpu`] states; nobody else uses the queue during a call of [`Gpu::submit`] or
    /// [`Gpu::wait_idle`].
    ///
    /// # Errors
    /// [`crate::Error::Missing`] as for [`Gpu::headless`].
    pub unsafe fn from_raw(_raw: RawGpu) -> Result<Gpu> {
        unimplemented!()
    }

    /// What the device can do.
    pub fn caps(&self) -> &Caps {
        unimplemented!()
    }

    /// Validation messages so far.
    pub fn messages(&self) -> &Messages {
        unimplemented!()
    }

    /// The device, for recording and for what is not wrapped.
    pub fn raw(&self) -> &ash::Device {
        unimplemented!()
    }

    /// Names of the objects made by this [`Gpu`] that still live, each with its kind: `image "shadow.map"`.
    pub fn live_objects(&self) -> Vec<String> {
        unimplemented!()
    }

    /// Waits for the device, frees everything, and tells of leaks.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] naming every object that still lives. (Plain dropping logs the same.)
    pub fn close(self) -> Result<()> {
        unimplemented!()
    }

    /// Waits until the device has done all that was submitted, and frees what waited for that.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`].
    pub fn wait_idle(&self) -> Result<()> {
        unimplemented!()
    }

    /// Writes the pipeline cache to [`GpuOptions::pipeline_cache`], under a temporary name first. Done by `close` and
    /// on dropping too; without a path it does nothing.
    ///
    /// # Errors
    /// [`crate::Error::Io`].
    pub fn save_pipeline_cache(&self) -> Result<()> {
        unimplemented!()
    }
}

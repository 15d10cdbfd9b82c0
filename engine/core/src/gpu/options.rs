//! How a device is opened.

use std::collections::BTreeSet;
use std::path::PathBuf;

use ash::vk;

use super::Feature;

/// How [`super::Gpu::headless`] opens a device.
#[derive(Clone, Debug, Default)]
pub struct GpuOptions {
    /// Part of the name of the wanted device, in any case. `None`: what the environment variable
    /// `SHADOWGRAPH_DEVICE` says, else the best one.
    pub device: Option<String>,
    /// Whether the Khronos validation layer watches.
    pub validation: Validation,
    /// File that keeps compiled pipelines from run to run; its folder is made. A file that is damaged or of another
    /// driver is ignored with a warning.
    pub pipeline_cache: Option<PathBuf>,
    /// Further instance extensions (a window system's).
    pub instance_extensions: Vec<String>,
    /// Further device extensions (`VK_KHR_swapchain`).
    pub device_extensions: Vec<String>,
}

/// Whether the Khronos validation layer watches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Validation {
    /// No layer.
    #[default]
    Off,
    /// Core validation and synchronisation validation.
    On,
    /// The same, and shaders instrumented on the device. Slow.
    GpuAssisted,
}

/// An application's own device, for [`super::Gpu::from_raw`].
pub struct RawGpu {
    /// The loaded Vulkan library.
    pub entry: ash::Entry,
    /// The instance, of Vulkan 1.3.
    pub instance: ash::Instance,
    /// The physical device.
    pub physical_device: vk::PhysicalDevice,
    /// The device, of Vulkan 1.3, with all features enabled that the engine requires ([`super::Caps::required`]).
    pub device: ash::Device,
    /// A queue with graphics, compute and transfer.
    pub queue: vk::Queue,
    /// Its family.
    pub queue_family: u32,
    /// Optional features that were enabled when the device was made, with their extensions.
    pub features: BTreeSet<Feature>,
    /// Whether `VK_EXT_debug_utils` was enabled on the instance.
    pub debug_utils: bool,
    /// As in [`GpuOptions::pipeline_cache`].
    pub pipeline_cache: Option<PathBuf>,
}

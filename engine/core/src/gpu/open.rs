//! Opening a device.

use std::ffi::CStr;
use std::sync::Arc;

use ash::vk;

use super::device::{Device, Owned, Parts};
use super::features::Features;
use super::select::Candidate;
use super::{Gpu, GpuOptions, Messages, RawGpu, Validation, instance, select};
use crate::{Error, Result};

impl Gpu {
    /// Opens a device without a window.
    ///
    /// Takes the best device (discrete, integrated, virtual, then CPU) that has what the engine needs, or the one
    /// that [`GpuOptions::device`] or `SHADOWGRAPH_DEVICE` names.
    ///
    /// # Errors
    /// [`Error::NoDevice`] where there is no loader, no device or none of that name, or the validation layer is not
    /// installed; [`Error::Missing`] with every feature that the device lacks.
    pub fn headless(options: GpuOptions) -> Result<Gpu> {
        // 1. The instance, which reports to a sink that outlives it.
        let messages = Arc::new(Messages::default());
        let opened = instance::open(&options, &messages)?;

        // 2. The device.
        let chosen = select::choose(&opened.instance, &options)
            .and_then(|c| create_device(&opened.instance, &c, &options).map(|raw| (c, raw)));
        let (chosen, raw) = match chosen {
            Ok(chosen) => chosen,
            Err(e) => {
                // SAFETY: nothing was made of the instance but the messenger.
                unsafe {
                    if let Some((loader, messenger)) = opened.debug {
                        loader.destroy_debug_utils_messenger(messenger, None);
                    }
                    opened.instance.destroy_instance(None);
                }
                return Err(e);
            }
        };
        log::info!("device: {}", chosen.caps.title());

        // 3. What objects share.
        // SAFETY: the device was made with one queue of this family.
        let queue = unsafe { raw.get_device_queue(chosen.caps.queue_family, 0) };
        let device = Device::new(Parts {
            entry: opened.entry,
            instance: opened.instance,
            physical: chosen.physical,
            raw,
            queue,
            caps: chosen.caps,
            messages,
            debug: opened.debug_utils,
            validated: options.validation != Validation::Off,
            pipeline_cache: options.pipeline_cache,
            owned: Some(Owned { messenger: opened.debug }),
        })?;
        Ok(Gpu { device, closed: false })
    }

    /// Uses an application's own device, which is not destroyed at the end. Validation messages go where the
    /// application's own messenger sends them.
    ///
    /// # Safety
    /// The handles are valid and outlive the [`Gpu`] and all it makes; the device was created with the features and
    /// extensions that [`RawGpu`] states; nobody else uses the queue during a call of [`Gpu::submit`],
    /// or while the last of these objects is dropped.
    ///
    /// # Errors
    /// [`Error::Missing`] as for [`Gpu::headless`]; [`Error::Invalid`] for a queue family that does not draw and
    /// dispatch.
    pub unsafe fn from_raw(raw: RawGpu) -> Result<Gpu> {
        let mut caps = select::inspect_raw(&raw.instance, raw.physical_device)?.caps;
        // Subgroups are there without being asked for.
        caps.features.retain(|f| raw.features.contains(f) || *f == super::Feature::FragmentBallot);
        caps.queue_family = raw.queue_family;
        match caps.queue_families.get(raw.queue_family as usize) {
            Some(family) if family.graphics && family.compute => {
                if family.timestamp_bits > 0 {
                    caps.features.insert(super::Feature::Timestamps);
                }
            }
            _ => {
                let why = format!("{} does not have graphics and compute", raw.queue_family);
                return Err(Error::invalid("queue family", why));
            }
        }
        let device = Device::new(Parts {
            entry: raw.entry,
            instance: raw.instance,
            physical: raw.physical_device,
            raw: raw.device,
            queue: raw.queue,
            caps,
            messages: Arc::default(),
            debug: raw.debug_utils,
            validated: true,
            pipeline_cache: raw.pipeline_cache,
            owned: None,
        })?;
        Ok(Gpu { device, closed: false })
    }
}

/// A device with one queue, everything required, and every optional feature that it has.
fn create_device(instance: &ash::Instance, chosen: &Candidate, options: &GpuOptions) -> Result<ash::Device> {
    let portability = chosen.offer.extensions.iter().any(|e| e.as_c_str() == ash::khr::portability_subset::NAME);
    let (mut features, mut extensions) = Features::enable(&chosen.offer.optional, portability);
    extensions.extend(options.device_extensions.iter().map(|e| super::c_string(e)));
    extensions.sort();
    extensions.dedup();
    let names: Vec<_> = extensions.iter().map(|e| e.as_ptr()).collect();
    let has = |name: &CStr| extensions.iter().any(|e| e.as_c_str() == name);
    let mut chain = features.chain(&has);
    let priorities = [1.0];
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(chosen.caps.queue_family)
        .queue_priorities(&priorities)];
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&names)
        .push_next(&mut chain);
    // SAFETY: the device has the features and extensions, and all that is pointed at lives to the end of this call.
    unsafe { instance.create_device(chosen.physical, &info, None) }.map_err(|result| Error::Vulkan {
        call: "vkCreateDevice",
        object: chosen.caps.title(),
        result,
    })
}

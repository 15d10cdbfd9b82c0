//! Loading Vulkan, and the instance.

use std::ffi::{CStr, CString};

use ash::vk;

use super::{GpuOptions, Messages, Validation};
use crate::{Error, Result};

pub(super) const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";
const INSTALL: &str = "install a Vulkan loader and driver (Debian, Ubuntu: `apt-get install libvulkan1 \
                       mesa-vulkan-drivers`; macOS: the Vulkan SDK with MoltenVK; Windows: the graphics driver)";

/// An instance and what came with it.
pub(super) struct Opened {
    pub entry: ash::Entry,
    pub instance: ash::Instance,
    pub debug: Option<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// Whether `VK_EXT_debug_utils` is on: names and labels.
    pub debug_utils: bool,
}

/// Loads Vulkan and makes an instance that reports to `messages`, which must outlive it.
pub(super) fn open(options: &GpuOptions, messages: &Messages) -> Result<Opened> {
    // 1. The loader.
    // SAFETY: loading the system's Vulkan library runs its initialisers, as every Vulkan program does.
    let entry = unsafe { ash::Entry::load() }.map_err(|e| Error::NoDevice {
        why: format!("the Vulkan loader cannot be loaded ({e})"),
        hint: INSTALL.into(),
    })?;
    let fail = |call, result| Error::Vulkan { call, object: "the instance".into(), result };

    // 2. Layers and extensions.
    // SAFETY: plain queries.
    let (layers, mut offered, version) = unsafe {
        (
            entry.enumerate_instance_layer_properties().map_err(|e| fail("vkEnumerateInstanceLayerProperties", e))?,
            extensions(&entry, None)?,
            entry.try_enumerate_instance_version().map_err(|e| fail("vkEnumerateInstanceVersion", e))?,
        )
    };
    if version.is_none_or(|v| v < vk::API_VERSION_1_3) {
        return Err(Error::NoDevice { why: "the Vulkan loader is older than 1.3".into(), hint: INSTALL.into() });
    }
    let validate = options.validation != Validation::Off;
    let mut layer_names = Vec::new();
    if validate {
        if !layers.iter().any(|l| l.layer_name_as_c_str() == Ok(LAYER)) {
            return Err(Error::NoDevice {
                why: format!("validation was asked for and {} is not installed", LAYER.to_string_lossy()),
                hint: "install the validation layer (Debian, Ubuntu: `apt-get install vulkan-validationlayers`; \
                       elsewhere: the Vulkan SDK), or open the device without validation"
                    .into(),
            });
        }
        layer_names.push(LAYER.as_ptr());
        offered.extend(extensions(&entry, Some(LAYER))?);
    }
    let offers = |name: &CStr| offered.iter().any(|e| e.as_c_str() == name);
    let mut wanted: Vec<CString> = Vec::new();
    let mut flags = vk::InstanceCreateFlags::empty();
    if offers(ash::ext::debug_utils::NAME) {
        wanted.push(ash::ext::debug_utils::NAME.into());
    }
    if offers(ash::khr::portability_enumeration::NAME) {
        wanted.push(ash::khr::portability_enumeration::NAME.into());
        flags |= vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
    }
    let validation_features = validate && offers(ash::ext::validation_features::NAME);
    if validation_features {
        wanted.push(ash::ext::validation_features::NAME.into());
    }
    let mut missing = Vec::new();
    for name in &options.instance_extensions {
        let name = super::c_string(name);
        if !offers(&name) {
            missing.push(format!("instance extension {}", name.to_string_lossy()));
        } else if !wanted.contains(&name) {
            wanted.push(name);
        }
    }
    if !missing.is_empty() {
        return Err(Error::Missing { device: "the Vulkan loader".into(), who: "the application".into(), missing });
    }
    let debug_utils = offers(ash::ext::debug_utils::NAME);

    // 3. The instance. The messenger in its chain covers its own making and end.
    let application = vk::ApplicationInfo::default()
        .application_name(c"shadowgraph")
        .engine_name(c"shadowgraph")
        .api_version(vk::API_VERSION_1_3);
    let mut enables = vec![vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    if options.validation == Validation::GpuAssisted {
        enables.push(vk::ValidationFeatureEnableEXT::GPU_ASSISTED);
        enables.push(vk::ValidationFeatureEnableEXT::GPU_ASSISTED_RESERVE_BINDING_SLOT);
    }
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enables);
    let mut messenger = messages.messenger();
    let names: Vec<_> = wanted.iter().map(|n| n.as_ptr()).collect();
    let mut info = vk::InstanceCreateInfo::default()
        .application_info(&application)
        .enabled_layer_names(&layer_names)
        .enabled_extension_names(&names)
        .flags(flags);
    if validation_features {
        info = info.push_next(&mut features);
    }
    if debug_utils {
        info = info.push_next(&mut messenger);
    }
    // SAFETY: everything in the chain lives to the end of this function, and `messages` longer than the instance.
    let instance = unsafe { entry.create_instance(&info, None) }.map_err(|result| match result {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => {
            Error::NoDevice { why: "no Vulkan driver is installed".into(), hint: INSTALL.into() }
        }
        result => fail("vkCreateInstance", result),
    })?;

    // 4. The messenger for all in between.
    let debug = if debug_utils && validate {
        let loader = ash::ext::debug_utils::Instance::new(&entry, &instance);
        // SAFETY: the extension is on; `messages` outlives the messenger.
        match unsafe { loader.create_debug_utils_messenger(&messages.messenger(), None) } {
            Ok(messenger) => Some((loader, messenger)),
            Err(result) => {
                // SAFETY: nothing was made of it.
                unsafe { instance.destroy_instance(None) };
                return Err(fail("vkCreateDebugUtilsMessengerEXT", result));
            }
        }
    } else {
        None
    };
    Ok(Opened { entry, instance, debug, debug_utils })
}

fn extensions(entry: &ash::Entry, layer: Option<&CStr>) -> Result<Vec<CString>> {
    // SAFETY: a plain query.
    let found = unsafe { entry.enumerate_instance_extension_properties(layer) }.map_err(|result| Error::Vulkan {
        call: "vkEnumerateInstanceExtensionProperties",
        object: "the instance".into(),
        result,
    })?;
    Ok(found.iter().filter_map(|e| e.extension_name_as_c_str().ok().map(CString::from)).collect())
}

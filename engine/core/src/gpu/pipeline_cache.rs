//! The driver's pipeline cache, kept in a file.

use std::path::{Path, PathBuf};

use ash::vk;

use super::device::Device;
use crate::{Error, Result};

/// Starts our file; the checksum of the rest and the driver's data follow.
const MAGIC: &[u8; 8] = b"SGCACHE1";

/// A pipeline cache and its file.
pub(super) struct CacheFile {
    pub cache: vk::PipelineCache,
    path: Option<PathBuf>,
}

impl CacheFile {
    pub(super) fn none() -> Self {
        Self { cache: vk::PipelineCache::null(), path: None }
    }

    /// Makes the cache, from the file's contents where they are of this driver and whole.
    pub(super) fn open(device: &Device, path: Option<PathBuf>) -> Result<Self> {
        let data = path.as_deref().and_then(|path| match load(device, path) {
            Ok(data) => data,
            Err(why) => {
                log::warn!("pipeline cache {} is ignored: {why}", path.display());
                None
            }
        });
        let data = data.unwrap_or_default();
        let info = vk::PipelineCacheCreateInfo::default().initial_data(&data);
        // SAFETY: empty, or data that this driver wrote and that has not changed since.
        let cache = unsafe { device.raw.create_pipeline_cache(&info, None) };
        let cache = cache.map_err(|e| device.error("vkCreatePipelineCache", "the pipeline cache", e))?;
        device.name(cache, "the pipeline cache");
        Ok(Self { cache, path })
    }

    /// Writes the file, under a temporary name first.
    pub(super) fn save(&self, device: &ash::Device) -> Result<()> {
        let Some(path) = &self.path else { return Ok(()) };
        // SAFETY: a live cache.
        let data = unsafe { device.get_pipeline_cache_data(self.cache) }.map_err(|result| Error::Vulkan {
            call: "vkGetPipelineCacheData",
            object: "the pipeline cache".into(),
            result,
        })?;
        let mut bytes = MAGIC.to_vec();
        bytes.extend_from_slice(&checksum(&data).to_le_bytes());
        bytes.extend_from_slice(&data);
        if let Some(folder) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, e))?;
        }
        let mut temporary = path.clone().into_os_string();
        temporary.push(format!(".{}.tmp", std::process::id()));
        let temporary = PathBuf::from(temporary);
        std::fs::write(&temporary, &bytes).and_then(|()| std::fs::rename(&temporary, path)).map_err(|e| {
            // It is not there, or useless.
            let _ = std::fs::remove_file(&temporary);
            Error::io("write", path, e)
        })
    }

    /// SAFETY: nothing uses the cache.
    pub(super) unsafe fn destroy(&self, device: &ash::Device) {
        // SAFETY: the caller's promise; null is allowed.
        unsafe { device.destroy_pipeline_cache(self.cache, None) };
    }
}

/// The driver's data in the file; `None` where there is no file yet.
fn load(device: &Device, path: &Path) -> Result<Option<Vec<u8>>, String> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(e.to_string()),
    };
    // SAFETY: a plain query.
    let properties = unsafe { device.instance.get_physical_device_properties(device.physical) };
    let data = unwrap(&bytes)?;
    check_header(data, &properties)?;
    Ok(Some(data.to_vec()))
}

/// Our own part of the file: tells whether the rest is as it was written.
fn unwrap(bytes: &[u8]) -> Result<&[u8], String> {
    let rest = bytes.strip_prefix(MAGIC).ok_or("it is no cache of this engine")?;
    let (sum, data) = rest.split_first_chunk::<8>().ok_or("it is cut short")?;
    (u64::from_le_bytes(*sum) == checksum(data)).then_some(data).ok_or_else(|| "it is damaged".into())
}

/// Vulkan's part, `VkPipelineCacheHeaderVersionOne`: tells whether the data are of this driver.
fn check_header(data: &[u8], properties: &vk::PhysicalDeviceProperties) -> Result<(), String> {
    let word = |at: usize| data.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let ours = [32, vk::PipelineCacheHeaderVersion::ONE.as_raw() as u32, properties.vendor_id, properties.device_id];
    let same = (0..4).all(|i| word(i * 4) == Some(ours[i]))
        && data.get(16..16 + vk::UUID_SIZE) == Some(&properties.pipeline_cache_uuid[..]);
    if same { Ok(()) } else { Err("it is of another device or driver".into()) }
}

/// FNV-1a, 64 bits: against damage, not against malice.
fn checksum(data: &[u8]) -> u64 {
    data.iter().fold(0xcbf2_9ce4_8422_2325, |sum, &byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn file(data: &[u8]) -> Vec<u8> {
        [MAGIC, &checksum(data).to_le_bytes()[..], data].concat()
    }

    #[test]
    fn damage_is_seen() {
        let good = file(b"0123456789");
        assert_eq!(unwrap(&good).unwrap(), b"0123456789");
        for i in 0..good.len() {
            let mut bad = good.clone();
            bad[i] ^= 4;
            assert!(unwrap(&bad).is_err(), "byte {i}");
            assert!(unwrap(&good[..i]).is_err(), "cut at {i}");
        }
    }

    #[test]
    fn other_drivers_are_seen() {
        let properties = vk::PhysicalDeviceProperties {
            vendor_id: 7,
            device_id: 9,
            pipeline_cache_uuid: [3; vk::UUID_SIZE],
            ..Default::default()
        };
        let header: Vec<u8> = [32u32, 1, 7, 9].iter().flat_map(|w| w.to_le_bytes()).chain([3; 16]).collect();
        assert!(check_header(&header, &properties).is_ok());
        for i in 0..header.len() {
            let mut other = header.clone();
            other[i] ^= 1;
            assert!(check_header(&other, &properties).is_err(), "byte {i}");
            assert!(check_header(&header[..i], &properties).is_err(), "cut at {i}");
        }
    }
}

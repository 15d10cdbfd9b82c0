//! Buffers.

use ash::vk;

use super::{Gpu, Memory};
use crate::Result;

/// What buffer to make.
#[derive(Clone, Copy, Debug, Default)]
pub struct BufferInfo<'a> {
    /// Debug name.
    pub name: &'a str,
    /// Bytes, at least 1.
    pub size: u64,
    /// What it is used for.
    pub usage: vk::BufferUsageFlags,
    /// Where it lies.
    pub memory: Memory,
}

/// A buffer with its memory.
#[derive(Clone)]
pub struct Buffer {}

impl Buffer {
    /// The Vulkan handle.
    pub fn raw(&self) -> vk::Buffer {
        unimplemented!()
    }

    /// Bytes.
    pub fn size(&self) -> u64 {
        unimplemented!()
    }

    /// Debug name.
    pub fn name(&self) -> &str {
        unimplemented!()
    }

    /// What it may be used for.
    pub fn usage(&self) -> vk::BufferUsageFlags {
        unimplemented!()
    }

    /// Its address on the device.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where it was made without `SHADER_DEVICE_ADDRESS`.
    pub fn address(&self) -> Result<vk::DeviceAddress> {
        unimplemented!()
    }

    /// Copies bytes into mapped memory. The device must not be using that part.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where it is not mapped or the bytes do not fit.
    pub fn write(&self, _offset: u64, _bytes: &[u8]) -> Result<()> {
        unimplemented!()
    }

    /// Copies all bytes out of mapped memory. The device must have finished writing them, and the submission must
    /// have made them visible to the host.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where it is not mapped.
    pub fn read(&self) -> Result<Vec<u8>> {
        unimplemented!()
    }

    /// Looks at the mapped bytes in place; otherwise as [`Buffer::read`].
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where it is not mapped.
    pub fn read_with<R>(&self, _look: impl FnOnce(&[u8]) -> R) -> Result<R> {
        unimplemented!()
    }
}

impl Gpu {
    /// Makes a buffer. Its contents are undefined.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] for a size of 0 or beyond the device's limit; [`crate::Error::OutOfMemory`].
    pub fn create_buffer(&self, _info: &BufferInfo) -> Result<Buffer> {
        unimplemented!()
    }
}

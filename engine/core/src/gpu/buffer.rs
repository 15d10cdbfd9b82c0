//! Buffers.

use std::ptr::NonNull;
use std::sync::{Arc, PoisonError, RwLock};

use ash::vk;

use super::device::{Device, Garbage, RawBuffer};
use super::{Gpu, Heap, Memory};
use crate::{Error, Result};

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

impl BufferInfo<'_> {
    pub(super) fn vulkan(&self) -> vk::BufferCreateInfo<'static> {
        vk::BufferCreateInfo::default().size(self.size).usage(self.usage)
    }

    pub(super) fn check(&self, device: &Device) -> Result<()> {
        let most = device.caps.limits.max_buffer_size;
        let why = if self.size == 0 {
            "a buffer has at least one byte".into()
        } else if self.size > most {
            format!("{} bytes are more than the device's {most} for one buffer", self.size)
        } else if self.usage.is_empty() {
            "no usage is given".into()
        } else {
            return Ok(());
        };
        Err(Error::invalid(format!("buffer {:?}", self.name), why))
    }
}

/// A buffer with its memory.
#[derive(Clone)]
pub struct Buffer(Arc<Inner>);

struct Inner {
    device: Arc<Device>,
    id: u64,
    name: String,
    size: u64,
    usage: vk::BufferUsageFlags,
    buffer: vk::Buffer,
    /// Held while the host touches the bytes.
    mapped: RwLock<Option<Mapped>>,
    /// Taken by `Drop`.
    raw: Option<RawBuffer>,
    /// Where the memory is a heap's. Dropped after `raw` was given away.
    _heap: Option<Heap>,
}

/// First byte of mapped memory.
struct Mapped(NonNull<u8>);

// SAFETY: the pointer is to memory that belongs to the buffer and is mapped as long as it; the lock around it orders
// the host's accesses.
unsafe impl Send for Mapped {}
// SAFETY: as above: readers share the lock, who writes has it alone.
unsafe impl Sync for Mapped {}

impl Buffer {
    pub(super) fn new(device: Arc<Device>, info: &BufferInfo, raw: RawBuffer, heap: Option<Heap>) -> Self {
        // Some devices map all their memory; what works on one is to work on all.
        let allocation = raw.allocation.as_ref().filter(|_| info.memory != Memory::Device);
        let mapped = allocation.and_then(|a| a.mapped_ptr()).map(|p| Mapped(p.cast()));
        Self(Arc::new(Inner {
            id: device.register("buffer", info.name),
            name: info.name.into(),
            size: info.size,
            usage: info.usage,
            buffer: raw.buffer,
            mapped: RwLock::new(mapped),
            raw: Some(raw),
            _heap: heap,
            device,
        }))
    }

    /// A number that no other object of its device ever has.
    pub(super) fn id(&self) -> u64 {
        self.0.id
    }

    /// Whether this is its only handle, and what others did by theirs is over.
    pub(crate) fn is_held_once(&mut self) -> bool {
        Arc::get_mut(&mut self.0).is_some()
    }

    /// The Vulkan handle.
    pub fn raw(&self) -> vk::Buffer {
        self.0.buffer
    }

    /// Bytes.
    pub fn size(&self) -> u64 {
        self.0.size
    }

    /// Debug name.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// What it may be used for.
    pub fn usage(&self) -> vk::BufferUsageFlags {
        self.0.usage
    }

    /// Its address on the device.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where it was made without `SHADER_DEVICE_ADDRESS`.
    pub fn address(&self) -> Result<vk::DeviceAddress> {
        if !self.0.usage.contains(vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS) {
            return Err(self.invalid("it was made without the usage SHADER_DEVICE_ADDRESS"));
        }
        let info = vk::BufferDeviceAddressInfo::default().buffer(self.0.buffer);
        // SAFETY: a live buffer with the usage that this asks for.
        Ok(unsafe { self.0.device.raw.get_buffer_device_address(&info) })
    }

    /// Has the system back mapped memory with pages at once rather than one by one as they are first touched. Contents
    /// stay, and the device may use them meanwhile. Only Linux can; a driver's own mappings have their pages already.
    pub(crate) fn populate(&self) {
        #[cfg(target_os = "linux")]
        if let Some(Mapped(first)) = &*self.0.mapped.read().unwrap_or_else(PoisonError::into_inner) {
            let page = rustix::param::page_size();
            let skipped = first.as_ptr().align_offset(page);
            let whole = (self.0.size as usize).saturating_sub(skipped) / page * page;
            // SAFETY: these bytes lie in the buffer's memory, mapped as long as it; the advice changes none of them.
            let advised = unsafe {
                let start = first.as_ptr().wrapping_add(skipped);
                rustix::mm::madvise(start.cast(), whole, rustix::mm::Advice::LinuxPopulateWrite)
            };
            if let Err(error) = advised {
                log::trace!("{} is backed as it is touched: {error}", self.0.name);
            }
        }
    }

    /// Copies bytes into mapped memory. The device must not be using that part.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where it is not mapped or the bytes do not fit.
    pub fn write(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        let length = bytes.len() as u64;
        if offset.checked_add(length).is_none_or(|end| end > self.0.size) {
            let size = self.0.size;
            return Err(self.invalid(format!("{length} bytes at {offset} do not fit into its {size} bytes")));
        }
        let mapped = self.0.mapped.write().unwrap_or_else(PoisonError::into_inner);
        let Some(first) = mapped.as_ref() else { return Err(self.not_mapped()) };
        // SAFETY: the part lies in the mapped memory of this buffer; the lock keeps other host accesses away.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), first.0.as_ptr().add(offset as usize), bytes.len()) };
        Ok(())
    }

    /// Copies all bytes out of mapped memory. The device must have finished writing them, and the submission must
    /// have made them visible to the host ([`Gpu::submit`] does).
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where it is not mapped.
    pub fn read(&self) -> Result<Vec<u8>> {
        self.read_with(<[u8]>::to_vec)
    }

    /// Looks at the mapped bytes in place; otherwise as [`Buffer::read`]. `look` must not touch this buffer.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where it is not mapped.
    pub fn read_with<R>(&self, look: impl FnOnce(&[u8]) -> R) -> Result<R> {
        let mapped = self.0.mapped.read().unwrap_or_else(PoisonError::into_inner);
        let Some(first) = mapped.as_ref() else { return Err(self.not_mapped()) };
        // SAFETY: the buffer's own bytes, mapped; the lock keeps those who write away.
        Ok(look(unsafe { std::slice::from_raw_parts(first.0.as_ptr(), self.0.size as usize) }))
    }

    /// Whether it is of this device.
    pub(crate) fn is_from(&self, gpu: &super::Gpu) -> bool {
        self.is_of(&gpu.device)
    }

    pub(super) fn is_of(&self, device: &Arc<Device>) -> bool {
        Arc::ptr_eq(&self.0.device, device)
    }

    fn not_mapped(&self) -> Error {
        self.invalid("it is in device memory; make it with Memory::Upload or Memory::Readback to reach its bytes")
    }

    pub(super) fn invalid(&self, why: impl Into<String>) -> Error {
        Error::invalid(format!("buffer {:?}", self.0.name), why)
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        self.device.forget(self.id);
        if let Some(raw) = self.raw.take() {
            self.device.defer(Garbage::Buffer(raw));
        }
    }
}

impl std::fmt::Debug for Buffer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Buffer({:?}, {} bytes)", self.0.name, self.0.size)
    }
}

impl Gpu {
    /// Makes a buffer. Its contents are undefined.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] for a size of 0 or beyond the device's limit; [`crate::Error::OutOfMemory`].
    pub fn create_buffer(&self, info: &BufferInfo) -> Result<Buffer> {
        info.check(&self.device)?;
        let raw = self.device.make_buffer(info)?;
        Ok(Buffer::new(self.device.clone(), info, raw, None))
    }
}

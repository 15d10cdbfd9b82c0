//! Getting bytes into device memory.

use super::{Buffer, Gpu, Image, SubmitToken};
use crate::Result;

/// Collects uploads and submits them together. Where much is collected, it submits in between.
///
/// Whatever is submitted to the [`Gpu`] afterwards sees the data; nobody needs to wait. An image belongs to one
/// uploader from its first upload until [`Uploader::submit`]: its earlier contents are lost, and then it is in
/// `SHADER_READ_ONLY_OPTIMAL` as a whole.
pub struct Uploader {}

impl Uploader {
    /// Uploads into a part of a buffer (made with `TRANSFER_DST`).
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the bytes do not fit; [`crate::Error::OutOfMemory`] for staging memory.
    pub fn buffer(&mut self, _buffer: &Buffer, _offset: u64, _bytes: &[u8]) -> Result<()> {
        unimplemented!()
    }

    /// Uploads one mip level of one layer of an image (made with `TRANSFER_DST`), rows packed from the top.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the bytes are not exactly those of the level, or the format is unknown;
    /// [`crate::Error::OutOfMemory`] for staging memory.
    pub fn image(&mut self, _image: &Image, _mip: u32, _layer: u32, _bytes: &[u8]) -> Result<()> {
        unimplemented!()
    }

    /// Fills mip levels 1 and up of every layer from level 0, each from the one before by a linear blit (sRGB is
    /// averaged as light). The image was made with `TRANSFER_SRC` too.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the format cannot be blitted with linear filter on this device.
    pub fn generate_mips(&mut self, _image: &Image) -> Result<()> {
        unimplemented!()
    }

    /// Submits the rest.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`], [`crate::Error::Vulkan`].
    pub fn submit(self) -> Result<SubmitToken> {
        unimplemented!()
    }
}

impl Gpu {
    /// Begins to collect uploads.
    pub fn uploader(&self, _name: &str) -> Uploader {
        unimplemented!()
    }

    /// Uploads to the start of one buffer.
    ///
    /// # Errors
    /// As [`Uploader::buffer`].
    pub fn upload_buffer(&self, buffer: &Buffer, bytes: &[u8]) -> Result<SubmitToken> {
        let mut uploader = self.uploader(buffer.name());
        uploader.buffer(buffer, 0, bytes)?;
        uploader.submit()
    }

    /// Uploads level 0 of one image's layers, one after the other in `bytes`, and makes its other levels from it.
    ///
    /// # Errors
    /// As [`Uploader::image`] and [`Uploader::generate_mips`].
    pub fn upload_image(&self, _image: &Image, _bytes: &[u8]) -> Result<SubmitToken> {
        unimplemented!()
    }
}

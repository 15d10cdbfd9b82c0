//! Multi-part OpenEXR: *OpenEXR File Layout* (Academy Software Foundation), scan-line parts.
//!
//! Attributes and the RLE and PIZ codecs are the `exr` crate's. The layout of the file is ours, because the crate keeps
//! attributes in a hash map, whose order and with it the file's bytes change from run to run, and because its ZIP takes
//! three times as long: it compresses at level 4, here level 1 costs a tenth of the size.

mod blocks;
mod codec;
mod deep;
mod header;

pub use blocks::Packed;
pub use deep::write_deep_exr;

use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
use std::str::FromStr;

use super::{Capture, write_atomically};
use crate::{Error, Result};

/// How [`write_exr`] writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExrOptions {
    /// Of all parts.
    pub compression: Compression,
}

/// Lossless compression of pixels.
///
/// What they cost: a frame of 33 layers at 1280×720 with seven shadow maps, 150 MB, takes 150 MB without compression,
/// 75 as RLE, 39 as ZIP, 45 as PIZ, and about 0.2, 0.5, 0.5 and 2 seconds of processor time, shared by all cores.
/// `shadowgraph bench write` measures it anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Compression {
    /// None: the fastest to write.
    None,
    /// Runs of equal bytes.
    Rle,
    /// Deflate, a scan line at a time.
    Zips,
    /// Deflate, 16 scan lines at a time: the default, as the smallest.
    #[default]
    Zip,
    /// Wavelets, 32 scan lines at a time.
    Piz,
}

impl Compression {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::None, Self::Rle, Self::Zips, Self::Zip, Self::Piz];

    /// Name in lower case, as [`FromStr`] reads it and as OpenEXR's tools have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rle => "rle",
            Self::Zips => "zips",
            Self::Zip => "zip",
            Self::Piz => "piz",
        }
    }
}

impl FromStr for Compression {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|compression| compression.name() == name).ok_or_else(|| {
            let known = Self::ALL.map(Self::name).join(", ");
            Error::invalid(format!("compression {name:?}"), format!("it is one of {known}"))
        })
    }
}

/// Writes a capture: each part with its own size and channels, metadata in the headers. One part makes a plain
/// single-part file, which more programs read. The file appears whole or not at all, and the same capture gives the
/// same bytes.
///
/// # Errors
/// [`Error::Invalid`] where a size is 0, a channel has not one sample a pixel, or a name is empty, too long (255
/// bytes), taken, or reserved by OpenEXR; [`Error::Io`] where the file cannot be written.
pub fn write_exr(path: &Path, capture: &Capture, options: &ExrOptions) -> Result<()> {
    // 1. Refuse what OpenEXR cannot hold, before any file is made.
    header::check(capture)?;
    // 2. Lay the file out: headers, then a table of offsets, then the chunks of pixels.
    let headers = header::encode(capture, options.compression)?;
    let plan = blocks::plan(capture, options.compression)?;
    let chunks: usize = plan.iter().map(|block| block.chunks).sum();
    let pixels_start = (headers.len() + 8 * chunks) as u64;
    // 3. Compress on all cores, write in order, and fill in the table.
    write_atomically(path, |file| {
        file.write_all(&headers)?;
        file.write_all(&vec![0; 8 * chunks])?;
        let mut offsets = Vec::with_capacity(8 * chunks);
        let mut position = pixels_start;
        blocks::encode_all(capture, options.compression, &plan, |encoded| {
            for size in &encoded.chunk_sizes {
                offsets.extend_from_slice(&position.to_le_bytes());
                position += *size as u64;
            }
            file.write_all(&encoded.bytes)
        })?;
        file.seek(SeekFrom::Start(headers.len() as u64))?;
        file.write_all(&offsets)
    })
}

/// An error of the `exr` crate, on its way through code that writes.
fn to_io(error: ::exr::error::Error) -> io::Error {
    match error {
        ::exr::error::Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    }
}

//! Compression of one chunk.

use std::io;

use exr::compression::Compression as InFile;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{IntegerBounds, LineOrder};
use exr::meta::header::Header;
use zlib_rs::{Deflate, DeflateFlush, Status};

use super::{Compression, header, to_io};
use crate::capture::content::Row;
use crate::capture::{Channel, Part};

impl Compression {
    pub(super) fn in_file(self) -> InFile {
        match self {
            Self::None => InFile::Uncompressed,
            Self::Rle => InFile::RLE,
            Self::Zips => InFile::ZIP1,
            Self::Zip => InFile::ZIP16,
            Self::Piz => InFile::PIZ,
        }
    }

    /// Scan lines in a chunk.
    pub(super) fn lines(self) -> usize {
        self.in_file().scan_lines_per_block()
    }
}

/// One thread's compressor, with memory that it uses again.
pub(super) struct Codec<'a> {
    compression: Compression,
    part: PartCodec<'a>,
    deflate: Deflate,
    separated: Vec<u8>,
    deflated: Vec<u8>,
}

/// What the codecs know of a part.
struct PartCodec<'a> {
    width: usize,
    channels: Vec<&'a Channel>,
    bytes_per_pixel: usize,
    /// For the crate's codecs.
    header: Header,
}

impl<'a> PartCodec<'a> {
    fn new(part: &'a Part, compression: Compression) -> Self {
        let size = Vec2(part.size[0] as usize, part.size[1] as usize);
        let channels = header::sorted(part);
        Self {
            width: size.0,
            bytes_per_pixel: channels.iter().map(|channel| channel.content.bytes_per_sample()).sum(),
            channels,
            header: Header::new("".into(), size, header::channel_list(part).list).with_encoding(
                compression.in_file(),
                BlockDescription::ScanLines,
                LineOrder::Increasing,
            ),
        }
    }
}

impl<'a> Codec<'a> {
    pub(super) fn new(part: &'a Part, compression: Compression) -> Self {
        Self {
            compression,
            part: PartCodec::new(part, compression),
            deflate: deflater(),
            separated: Vec::new(),
            deflated: Vec::new(),
        }
    }

    /// Goes on with another part.
    pub(super) fn set_part(&mut self, part: &'a Part) {
        self.part = PartCodec::new(part, self.compression);
    }

    /// Appends the pixels of scan lines `[first, end)`. Where compression does not make them smaller they are stored
    /// as they are, which readers tell by the size.
    pub(super) fn append(&mut self, lines: [usize; 2], out: &mut Vec<u8>) -> io::Result<()> {
        match self.compression {
            Compression::None => self.part.append_raw(lines, out)?,
            Compression::Zip | Compression::Zips => {
                self.part.separate(lines, &mut self.separated)?;
                to_differences(&mut self.separated);
                match self.deflate() {
                    Some(size) => out.extend_from_slice(&self.deflated[..size]),
                    None => self.part.append_raw(lines, out)?,
                }
            }
            Compression::Rle | Compression::Piz => {
                let mut raw = Vec::with_capacity(self.part.bytes(lines));
                self.part.append_raw(lines, &mut raw)?;
                // The crate wants the machine's own byte order.
                if cfg!(target_endian = "big") {
                    self.part.swap_bytes(lines, &mut raw);
                }
                let position = Vec2(0, lines[0] as i32);
                let section = IntegerBounds::new(position, Vec2(self.part.width, lines[1] - lines[0]));
                let codec = self.compression.in_file();
                let bytes = codec.compress_image_section_to_le(&self.part.header, raw, section).map_err(to_io)?;
                out.extend_from_slice(&bytes);
            }
        }
        Ok(())
    }

    /// Deflates `separated` into `deflated` and says to how many bytes, or `None` where it would not shrink.
    fn deflate(&mut self) -> Option<usize> {
        shrink(&mut self.deflate, &self.separated, &mut self.deflated)
    }
}

/// Level 1, with zlib's header, and its largest window: see the module.
pub(super) fn deflater() -> Deflate {
    Deflate::new(1, true, 15)
}

/// Deflates, and says to how many bytes, or `None` where that would not make less of them.
fn shrink(deflate: &mut Deflate, from: &[u8], to: &mut Vec<u8>) -> Option<usize> {
    deflate.reset();
    // One byte less than the input: more is of no use.
    to.resize(from.len().saturating_sub(1), 0);
    let status = deflate.compress(from, to, DeflateFlush::Finish);
    matches!(status, Ok(Status::StreamEnd)).then_some(deflate.total_out() as usize)
}

/// Bytes as ZIPS packs them, or as they are where that would not make less of them.
pub(super) fn compressed(bytes: &[u8], deflate: &mut Deflate) -> Vec<u8> {
    let every_second = |first: usize| bytes.iter().skip(first).step_by(2).copied();
    let mut separated: Vec<u8> = every_second(0).chain(every_second(1)).collect();
    to_differences(&mut separated);
    let mut packed = Vec::new();
    match shrink(deflate, &separated, &mut packed) {
        Some(size) => {
            packed.truncate(size);
            packed
        }
        None => bytes.to_vec(),
    }
}

impl PartCodec<'_> {
    fn bytes(&self, lines: [usize; 2]) -> usize {
        self.width * (lines[1] - lines[0]) * self.bytes_per_pixel
    }

    /// Scan lines as OpenEXR stores them: line by line, channel by channel, little-endian.
    fn append_raw(&self, lines: [usize; 2], out: &mut Vec<u8>) -> io::Result<()> {
        fn put<const N: usize, T: Copy>(values: &[T], out: &mut Vec<u8>, bytes: impl Fn(T) -> [u8; N]) {
            let start = out.len();
            out.resize(start + N * values.len(), 0);
            for (to, &from) in out[start..].as_chunks_mut().0.iter_mut().zip(values) {
                *to = bytes(from);
            }
        }
        out.reserve(self.bytes(lines));
        for line in lines[0]..lines[1] {
            let row = line * self.width..(line + 1) * self.width;
            for channel in &self.channels {
                match channel.content.row(row.clone()).map_err(io::Error::other)? {
                    Row::F16(values) => put(&values, out, |value| value.to_le_bytes()),
                    Row::F32(values) => put(&values, out, |value| value.to_le_bytes()),
                    Row::U32(values) => put(&values, out, |value| value.to_le_bytes()),
                }
            }
        }
        Ok(())
    }

    /// The same bytes with those at even places before those at odd places (OpenEXR's `reorder`), straight from the
    /// channels: every sample has an even number of bytes, so that its low byte always stands at an even place.
    fn separate(&self, lines: [usize; 2], out: &mut Vec<u8>) -> io::Result<()> {
        fn put16(values: impl ExactSizeIterator<Item = [u8; 2]>, even: &mut [u8], odd: &mut [u8]) {
            for ((even, odd), [low, high]) in even.iter_mut().zip(odd).zip(values) {
                (*even, *odd) = (low, high);
            }
        }
        fn put32(values: impl ExactSizeIterator<Item = [u8; 4]>, even: &mut [u8], odd: &mut [u8]) {
            let (even, odd) = (even.as_chunks_mut().0, odd.as_chunks_mut().0);
            for ((even, odd), [a, b, c, d]) in even.iter_mut().zip(odd).zip(values) {
                (*even, *odd) = ([a, c], [b, d]);
            }
        }
        out.resize(self.bytes(lines), 0);
        let (mut even, mut odd) = out.split_at_mut(self.bytes(lines) / 2);
        for line in lines[0]..lines[1] {
            let row = line * self.width..(line + 1) * self.width;
            for channel in &self.channels {
                let bytes = self.width * channel.content.bytes_per_sample() / 2;
                let (e, o);
                (e, even) = std::mem::take(&mut even).split_at_mut(bytes);
                (o, odd) = std::mem::take(&mut odd).split_at_mut(bytes);
                match channel.content.row(row.clone()).map_err(io::Error::other)? {
                    Row::F16(values) => put16(values.iter().map(|value| value.to_le_bytes()), e, o),
                    Row::F32(values) => put32(values.iter().map(|value| value.to_le_bytes()), e, o),
                    Row::U32(values) => put32(values.iter().map(|value| value.to_le_bytes()), e, o),
                }
            }
        }
        Ok(())
    }

    /// Turns the bytes of every sample around.
    fn swap_bytes(&self, lines: [usize; 2], raw: &mut [u8]) {
        let mut rest = raw;
        for _ in lines[0]..lines[1] {
            for channel in &self.channels {
                let size = channel.content.bytes_per_sample();
                let (row, after) = std::mem::take(&mut rest).split_at_mut(self.width * size);
                row.chunks_exact_mut(size).for_each(<[u8]>::reverse);
                rest = after;
            }
        }
    }
}

/// Every byte becomes its difference from the one before, plus 128 (OpenEXR's `predictor`).
fn to_differences(bytes: &mut [u8]) {
    // In blocks through a copy: a loop that reads what it has just written cannot be vectorised.
    const BLOCK: usize = 4096;
    let mut before = [0; BLOCK];
    let Some((&mut first, rest)) = bytes.split_first_mut() else { return };
    let mut last = first;
    for block in rest.chunks_mut(BLOCK) {
        let before = &mut before[..block.len()];
        before[0] = last;
        before[1..].copy_from_slice(&block[..block.len() - 1]);
        last = block[block.len() - 1];
        for (byte, before) in block.iter_mut().zip(before) {
            *byte = byte.wrapping_sub(*before).wrapping_add(128);
        }
    }
}

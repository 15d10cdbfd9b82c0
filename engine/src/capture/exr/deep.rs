//! Deep scan lines: *OpenEXR File Layout*, "Deep Data", and *Interpreting OpenEXR Deep Pixels*.
//!
//! The `exr` crate does not write them. A chunk is a scan line: its number, three sizes, a table of how many samples there
//! are up to each pixel, and the samples, channel by channel.

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use exr::meta::attribute::{BlockType, SampleType};
use zlib_rs::Deflate;

use super::codec::{compressed, deflater};
use super::{Compression, header};
use crate::capture::{DeepPicture, DeepSample, write_atomically};
use crate::{Error, Result, parallel};

/// Channels in the order of the file, 32-bit floats all.
const CHANNELS: [&str; 5] = ["A", "B", "G", "R", "Z"];

/// Values in that order.
fn values(&DeepSample { depth, color: [red, green, blue, alpha] }: &DeepSample) -> [f32; 5] {
    [alpha, blue, green, red, depth]
}

/// Writes a deep picture as one part `deepscanline` with the channels R, G, B, A and Z, compressed line by line without
/// loss (ZIPS). The file appears whole or not at all, and the same picture gives the same bytes.
///
/// # Errors
/// [`Error::Invalid`] where the size is 0, counts and samples do not match it, or a scan line has more than 2 GiB;
/// [`Error::Io`] where the file cannot be written.
pub fn write_deep_exr(path: &Path, picture: &DeepPicture) -> Result<()> {
    // 1. Where each line's samples begin.
    let starts = starts(picture)?;
    let [width, height] = picture.size.map(|n| n as usize);
    // 2. The header.
    let channels = CHANNELS.map(|name| (name, SampleType::F32));
    let most = picture.counts.iter().max().map_or(0, |&most| most as i32);
    let layout = header::Layout {
        name: "deep",
        kind: BlockType::DeepScanLine,
        chunks: picture.size[1],
        channels: header::channels(channels.into_iter()),
        compression: Compression::Zips,
        size: picture.size,
        display: picture.size,
    };
    let header = header::encode_deep(&layout, most, &picture.metadata)?;
    // 3. Lines, compressed on all cores a few hundred at a time; then the table of where they are.
    write_atomically(path, |file| {
        file.write_all(&header)?;
        file.write_all(&vec![0; 8 * height])?;
        let mut position = (header.len() + 8 * height) as u64;
        let mut offsets = Vec::with_capacity(8 * height);
        const BLOCK: usize = 256;
        // Lines that share a compressor: making one costs as much as a line.
        const LINES: usize = 16;
        for first in (0..height).step_by(BLOCK) {
            let groups = BLOCK.min(height - first).div_ceil(LINES);
            let chunks = |group: usize| {
                let begin = first + group * LINES;
                let mut deflate = deflater();
                let chunk = |line: usize| {
                    let counts = &picture.counts[line * width..(line + 1) * width];
                    encode(line, counts, &picture.samples[starts[line]..starts[line + 1]], &mut deflate)
                };
                Ok((begin..height.min(begin + LINES)).map(chunk).collect::<Vec<_>>())
            };
            let wrong = |group: usize| {
                let begin = first + group * LINES;
                Error::invalid(format!("scan lines {begin} to {}", height.min(begin + LINES) - 1), "cannot be encoded")
            };
            for chunk in parallel::map(groups, chunks, wrong).map_err(std::io::Error::other)?.into_iter().flatten() {
                offsets.extend_from_slice(&position.to_le_bytes());
                position += chunk.len() as u64;
                file.write_all(&chunk)?;
            }
        }
        file.seek(SeekFrom::Start(header.len() as u64))?;
        file.write_all(&offsets)
    })
}

/// By line, then the number of all samples.
fn starts(picture: &DeepPicture) -> Result<Vec<usize>> {
    let wrong = |why: String| Err(Error::invalid("deep picture", why));
    let [width, height] = picture.size.map(|n| n as usize);
    if width == 0 || height == 0 || picture.size.iter().any(|&n| n > i32::MAX as u32) {
        return wrong(format!("its size {width}×{height} must lie in 1 to {}", i32::MAX));
    }
    if picture.counts.len() != width * height {
        return wrong(format!("it has {} counts for {width}×{height} pixels", picture.counts.len()));
    }
    let mut starts = vec![0];
    let mut sum = 0;
    for line in picture.counts.chunks(width) {
        let samples: usize = line.iter().map(|&count| count as usize).sum();
        if samples > i32::MAX as usize / (4 * CHANNELS.len()) {
            return wrong(format!("a scan line has {samples} samples, which exceed OpenEXR's 2 GiB"));
        }
        sum += samples;
        starts.push(sum);
    }
    if sum != picture.samples.len() {
        return wrong(format!("it has {} samples where the counts say {sum}", picture.samples.len()));
    }
    Ok(starts)
}

/// A chunk.
fn encode(line: usize, counts: &[u32], samples: &[DeepSample], deflate: &mut Deflate) -> Vec<u8> {
    let sums = counts.iter().scan(0, |sum, &count| {
        *sum += count;
        Some(*sum)
    });
    let table: Vec<u8> = sums.flat_map(u32::to_le_bytes).collect();
    let planes = (0..CHANNELS.len()).flat_map(|channel| samples.iter().map(move |sample| values(sample)[channel]));
    let data: Vec<u8> = planes.flat_map(f32::to_le_bytes).collect();
    let [packed_table, packed_data] = [&table, &data].map(|bytes| compressed(bytes, deflate));
    let sizes = [packed_table.len(), packed_data.len(), data.len()].map(|size| (size as u64).to_le_bytes());
    [&(line as i32).to_le_bytes()[..], sizes.as_flattened(), &packed_table, &packed_data].concat()
}

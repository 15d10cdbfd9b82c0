//! Chunks of all parts, encoded on all cores and handed over in order.

use std::collections::BTreeMap;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;
use std::thread;

use super::Compression;
use super::codec::Codec;
use super::header;
use crate::capture::{Capture, Part};
use crate::{Error, Result};

/// Work of one go: a few neighbouring chunks of one part.
pub(super) struct Block {
    part: usize,
    /// Scan lines `[first, end)`.
    lines: [usize; 2],
    /// How many chunks that makes.
    pub(super) chunks: usize,
}

/// Chunks as they stand in the file.
pub(super) struct Encoded {
    pub(super) bytes: Vec<u8>,
    pub(super) chunk_sizes: Vec<usize>,
}

/// Pixels of a part as they will stand in a file.
#[derive(Clone, Debug)]
pub struct Packed {
    compression: Compression,
    /// Without their headers; the first ones.
    chunks: Vec<Vec<u8>>,
}

impl Part {
    /// Compresses its pixels into [`Part::packed`] on this thread, for as long as `go_on` says: [`super::write_exr`] need not,
    /// with the same compression. For parts that are there before the others.
    ///
    /// # Errors
    /// [`Error::Invalid`] for what `write_exr` refuses of a part; [`Error::Vulkan`] where memory cannot be read.
    pub fn pack(&mut self, compression: Compression, go_on: impl Fn() -> bool) -> Result<()> {
        header::check_part(self)?;
        let mut codec = Codec::new(self, compression);
        let (height, step) = (self.size[1] as usize, compression.lines());
        let pack = |first: usize| {
            let mut chunk = Vec::new();
            codec.append([first, height.min(first + step)], &mut chunk).map(|()| chunk)
        };
        let chunks = (0..height).step_by(step).take_while(|_| go_on()).map(pack).collect::<io::Result<_>>();
        let chunks = chunks.map_err(|error| Error::invalid(format!("part {:?}", self.name), error.to_string()))?;
        self.packed = Some(Packed { compression, chunks });
        Ok(())
    }

    /// A chunk that was packed so.
    fn packed_chunk(&self, compression: Compression, index: usize) -> Option<&[u8]> {
        let packed = self.packed.as_ref().filter(|packed| packed.compression == compression)?;
        packed.chunks.get(index).map(Vec::as_slice)
    }
}

/// All chunks of the file in its order, in blocks of about 16 scan lines.
pub(super) fn plan(capture: &Capture, compression: Compression) -> Result<Vec<Block>> {
    let lines_per_chunk = compression.lines();
    let lines_per_block = lines_per_chunk.max(16);
    let mut blocks = Vec::new();
    for (index, part) in capture.parts.iter().enumerate() {
        let row: usize =
            part.channels.iter().map(|channel| part.size[0] as usize * channel.content.bytes_per_sample()).sum();
        if row.saturating_mul(lines_per_chunk) > i32::MAX as usize {
            let why = format!("{lines_per_chunk} scan lines exceed OpenEXR's 2 GiB; another compression takes fewer");
            return Err(Error::invalid(format!("part {:?}", part.name), why));
        }
        let height = part.size[1] as usize;
        for first in (0..height).step_by(lines_per_block) {
            let end = height.min(first + lines_per_block);
            blocks.push(Block { part: index, lines: [first, end], chunks: (end - first).div_ceil(lines_per_chunk) });
        }
    }
    Ok(blocks)
}

/// Encodes all blocks and gives them to `write` in order.
pub(super) fn encode_all(
    capture: &Capture,
    compression: Compression,
    blocks: &[Block],
    mut write: impl FnMut(Encoded) -> io::Result<()>,
) -> io::Result<()> {
    let next = AtomicUsize::new(0);
    let stop = AtomicBool::new(false);
    let threads = thread::available_parallelism().map_or(1, usize::from).min(blocks.len());
    // Bounded, so that a slow disk does not fill the memory.
    let (sender, receiver) = sync_channel(2 * threads);
    thread::scope(|scope| {
        for _ in 0..threads {
            let sender = sender.clone();
            let (next, stop) = (&next, &stop);
            scope.spawn(move || {
                let mut worker = Worker { capture, compression, codec: None };
                while !stop.load(Ordering::Relaxed) {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(block) = blocks.get(index) else { return };
                    // Where nobody listens any more, writing has failed and says why.
                    if sender.send((index, worker.encode(block))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let mut early = BTreeMap::new();
        let mut due = 0;
        let mut result = Ok(());
        for (index, encoded) in receiver {
            early.insert(index, encoded);
            while let (Ok(()), Some(encoded)) = (&result, early.remove(&due)) {
                result = encoded.and_then(&mut write);
                due += 1;
            }
            if result.is_err() {
                stop.store(true, Ordering::Relaxed);
                break;
            }
        }
        result
    })
}

struct Worker<'a> {
    capture: &'a Capture,
    compression: Compression,
    /// With the part it is set to.
    codec: Option<(usize, Codec<'a>)>,
}

impl Worker<'_> {
    fn encode(&mut self, block: &Block) -> io::Result<Encoded> {
        let part = &self.capture.parts[block.part];
        let (current, codec) = self.codec.get_or_insert_with(|| (block.part, Codec::new(part, self.compression)));
        if *current != block.part {
            codec.set_part(part);
            *current = block.part;
        }
        let mut encoded = Encoded { bytes: Vec::new(), chunk_sizes: Vec::with_capacity(block.chunks) };
        for first in (block.lines[0]..block.lines[1]).step_by(self.compression.lines()) {
            let end = block.lines[1].min(first + self.compression.lines());
            let start = encoded.bytes.len();
            if self.capture.parts.len() > 1 {
                encoded.bytes.extend_from_slice(&(block.part as i32).to_le_bytes());
            }
            encoded.bytes.extend_from_slice(&(first as i32).to_le_bytes());
            let size_at = encoded.bytes.len();
            encoded.bytes.extend_from_slice(&[0; 4]);
            match part.packed_chunk(self.compression, first / self.compression.lines()) {
                Some(packed) => encoded.bytes.extend_from_slice(packed),
                None => codec.append([first, end], &mut encoded.bytes)?,
            }
            let size = (encoded.bytes.len() - size_at - 4) as i32;
            encoded.bytes[size_at..size_at + 4].copy_from_slice(&size.to_le_bytes());
            encoded.chunk_sizes.push(encoded.bytes.len() - start);
        }
        Ok(encoded)
    }
}

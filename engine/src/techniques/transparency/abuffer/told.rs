//! What the host knows when memory is made: the totals of all pixels, or what each row holds.

use ash::vk;

use super::ABuffer;
use super::bands::{Band, longest_of};
use crate::Result;
use crate::gpu::Caps;
use crate::graph::{BufferHandle, Checkpoint, Data, Graph, ImageHandle};
use crate::shader::generated::blocks;

/// What is known of what is built.
#[derive(Clone)]
pub(super) enum Told<'f> {
    /// Of the whole picture.
    Totals(Checkpoint<blocks::Totals>),
    /// Of its rows, which are parted into bands.
    Rows { rows: Checkpoint<blocks::Row>, abuffer: ABuffer, caps: &'f Caps },
}

/// How much there is at once, at most.
#[derive(Clone, Copy)]
pub(super) struct Amount {
    pub(super) nodes: u64,
    /// Most of a pixel.
    pub(super) longest: u32,
    /// Pixels that have nodes.
    pixels: u64,
}

impl<'f> Told<'f> {
    /// A band, where there is one of this number.
    pub(super) fn band(&self, index: usize) -> Result<Option<Band>> {
        match self {
            Self::Totals(_) => Ok(None),
            Self::Rows { rows, abuffer, caps } => Ok(abuffer.parts(caps, rows.values()?)?.get(index).copied()),
        }
    }

    /// Of a picture so wide.
    fn amount(&self, width: u32) -> Result<Amount> {
        match self {
            Self::Totals(totals) => Ok(of_totals(totals.values()?)),
            Self::Rows { rows, abuffer, caps } => {
                let rows = rows.values()?;
                let bands = abuffer.parts(caps, rows)?;
                let pixels = |band: &Band| (u64::from(band.rows) * u64::from(width)).min(band.nodes);
                Ok(Amount {
                    nodes: bands.iter().map(|band| band.nodes).max().unwrap_or(0),
                    longest: longest_of(rows),
                    pixels: bands.iter().map(pixels).max().unwrap_or(0),
                })
            }
        }
    }

    /// An image.
    pub(super) fn image(
        &self,
        graph: &mut Graph<'f>,
        name: String,
        format: vk::Format,
        size: impl FnOnce(Amount) -> Result<[u32; 2]> + 'f,
    ) -> ImageHandle {
        let this = self.clone();
        let size = move || size(this.amount(0)?);
        match self {
            Self::Totals(told) => graph.image_after(told, name, format, move |_| size()),
            Self::Rows { rows, .. } => graph.image_after(rows, name, format, move |_| size()),
        }
    }

    /// A buffer of so many bytes for each pixel that has nodes, of a picture so wide.
    pub(super) fn pixels(&self, graph: &mut Graph<'f>, name: String, width: u32, bytes: u64) -> BufferHandle {
        let this = self.clone();
        // An error ends the frame where the nodes' image is made.
        let size = move || this.amount(width).map_or(0, |amount| amount.pixels * bytes);
        match self {
            Self::Totals(told) => graph.buffer_after(told, name, move |_| size()),
            Self::Rows { rows, .. } => graph.buffer_after(rows, name, move |_| size()),
        }
    }

    /// `frame.glsl`'s block of the whole picture of this size, or of a band of it: without rows where there is none of this
    /// number.
    pub(super) fn frame(&self, graph: &mut Graph<'f>, size: [u32; 2], index: usize) -> Data {
        let this = self.clone();
        match self {
            Self::Totals(told) => graph.data_after(told, move |totals| blocks::ABufferFrame {
                size,
                first_row: 0,
                capacity: of_totals(totals).nodes as u32,
                used: 1,
            }),
            Self::Rows { rows, .. } => graph.data_after(rows, move |_| {
                let Band { first_row, rows, nodes } = this.band(index).ok().flatten().unwrap_or_default();
                blocks::ABufferFrame { size: [size[0], rows], first_row, capacity: nodes as u32, used: 1 }
            }),
        }
    }
}

fn of_totals(totals: &[blocks::Totals]) -> Amount {
    let total = &totals[0].total;
    let pixels = total.pixels.iter().map(|&pixels| u64::from(pixels)).sum();
    Amount { nodes: u64::from(total.nodes), longest: total.longest, pixels }
}

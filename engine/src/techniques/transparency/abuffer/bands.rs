//! Bands of rows, each small enough for a budget of memory: a band is built, sorted and composited as a picture of its own.

use crate::gpu::Caps;
use crate::shader::generated::blocks;

use super::{ABuffer, SHORT, TEXEL};
use crate::{Error, Result};

/// Rows of a picture that are built at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Band {
    pub(super) first_row: u32,
    pub(super) rows: u32,
    pub(super) nodes: u64,
}

impl Band {
    /// With a row more, the next one.
    fn and(self, row: &blocks::Row) -> Self {
        Self { rows: self.rows + 1, nodes: self.nodes + u64::from(row.nodes), ..self }
    }
}

impl ABuffer {
    /// Bytes of nodes, and of the images that long lists are sorted in.
    pub(super) fn bytes(&self, nodes: u64, longest: u32) -> u64 {
        let sorted = if longest > SHORT { 2 * TEXEL } else { 0 };
        nodes.saturating_mul(self.node_bytes(false) + sorted)
    }

    /// The bands of a picture: as few as fit, at most [`ABuffer::bands`] of them.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the budget that would do.
    pub(super) fn parts(&self, caps: &Caps, rows: &[blocks::Row]) -> Result<Vec<Band>> {
        let found = self.parted(caps, rows, self.memory);
        let allowed = self.bands.max(1) as usize;
        if let Some(bands) = found.as_ref().filter(|bands| bands.len() <= allowed) {
            return Ok(bands.clone());
        }
        // The least budget that would do, by bisection.
        let whole = rows.iter().fold(Band::default(), Band::and);
        let enough = |memory| self.parted(caps, rows, memory).is_some_and(|bands| bands.len() <= allowed);
        let (mut low, mut high) = (self.memory, self.bytes(whole.nodes, longest_of(rows)));
        let advice = if enough(high) {
            while low + 1 < high {
                let middle = low + (high - low) / 2;
                (low, high) = if enough(middle) { (low, middle) } else { (middle, high) };
            }
            format!("{high} would do")
        } else {
            "no more is possible on this device".into()
        };
        let nodes = whole.nodes;
        let wrong = match found {
            Some(bands) => format!("{nodes} fragments in bands of {} bytes make {} bands", self.memory, bands.len()),
            None => format!("of {nodes} fragments the fullest row does not fit into {} bytes", self.memory),
        };
        Err(Error::invalid("A-buffer", format!("{wrong}; {allowed} bands are built; {advice}")))
    }

    /// As few bands of at most so many bytes as can be; none where a row does not fit.
    fn parted(&self, caps: &Caps, rows: &[blocks::Row], memory: u64) -> Option<Vec<Band>> {
        let most = Self { memory, ..*self }.most_nodes(caps, false);
        // All bands share their memory: it must do for the longest list of any.
        let longest = longest_of(rows);
        let fits = |band: &Band| band.nodes <= most && self.bytes(band.nodes, longest) <= memory;
        let mut bands: Vec<Band> = Vec::new();
        for (y, row) in (0..).zip(rows) {
            let alone = Band { first_row: y, ..Band::default() }.and(row);
            match bands.last_mut() {
                Some(band) if fits(&band.and(row)) => *band = band.and(row),
                _ if fits(&alone) => bands.push(alone),
                _ => return None,
            }
        }
        Some(bands)
    }
}

/// Most nodes of a pixel.
pub(super) fn longest_of(rows: &[blocks::Row]) -> u32 {
    rows.iter().map(|row| row.longest).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::techniques::transparency::abuffer::NodeFormat;

    fn rows(rows: &[(u32, u32)]) -> Vec<blocks::Row> {
        rows.iter().map(|&(nodes, longest)| blocks::Row { nodes, longest }).collect()
    }

    #[test]
    fn bands_are_as_few_as_fit() {
        let mut caps = Caps::default();
        caps.limits.max_image_dimension_2d = 16384;
        caps.limits.max_allocation_size = 1 << 30;
        let picture = rows(&[(10, 2), (20, 3), (5, 1), (40, 17), (0, 0), (30, 9)]);
        let bands = |memory, bands| {
            let abuffer = ABuffer { memory, bands, format: NodeFormat::Compact, ..ABuffer::default() };
            let parted = abuffer.parts(&caps, &picture);
            parted.map(|bands| bands.iter().map(|band| (band.first_row, band.rows)).collect::<Vec<_>>())
        };
        // With a long list anywhere, all need three times the memory.
        assert_eq!(bands(105 * 48, 1).unwrap(), [(0, 6)]);
        assert_eq!(bands(40 * 48, 4).unwrap(), [(0, 3), (3, 2), (5, 1)]);
        let said = |memory, most| bands(memory, most).unwrap_err().to_string();
        assert!(said(40 * 48, 2).contains("105 fragments in bands of 1920 bytes make 3 bands; 2 bands are built"));
        assert!(said(40 * 48, 2).ends_with(&format!("{} would do", 70 * 48)), "{}", said(40 * 48, 2));
        assert!(said(40 * 48 - 1, 9).contains("the fullest row does not fit"));
        assert!(said(40 * 48 - 1, 9).ends_with(&format!("{} would do", 40 * 48)));
        assert!(bands(70 * 48, 2).is_ok() && bands(70 * 48 - 1, 2).is_err());
        caps.limits.max_allocation_size = 16 * 39;
        let abuffer = ABuffer { memory: 1, bands: 9, ..ABuffer::default() };
        assert!(abuffer.parts(&caps, &picture).unwrap_err().to_string().contains("no more is possible"));
    }
}

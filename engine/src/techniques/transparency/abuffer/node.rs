//! What is kept of a fragment (`node.glsl`).

use half::f16;

use crate::gpu::Caps;
use crate::shader::Program;
use crate::shader::generated::transparency::abuffer::array_frag as shader;

use super::ABuffer;
use crate::{Error, Result};

/// Triangles that the keys of [`NodeFormat::Compact`] tell apart, and of every format where pixels have several samples.
pub const COMPACT_TRIANGLES: u64 = 1 << 24;

/// How colour and alpha are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum NodeFormat {
    /// RGB9E5 and 8 bits: 16 bytes a node.
    #[default]
    Compact,
    /// Half-floats: 16 bytes a node, 20 in lists.
    Half,
    /// 32-bit floats: 32 bytes a node.
    Float,
    /// RGB9E5, and what is let through channel by channel, 10 bits each: 16 bytes a node, 20 in lists.
    CompactTinted,
    /// 32-bit floats, and what is let through channel by channel: 32 bytes a node, 36 in lists.
    FloatTinted,
    /// Half-floats, and what is let through channel by channel, half-floats too: 20 bytes a node, 24 in lists.
    HalfTinted,
    /// What is let through alone, 21 bits a channel, and no colour: 16 bytes a node, 20 in lists.
    Transmittance,
}

/// Bytes of a texel of nodes.
pub(super) const TEXEL: u64 = 16;
/// Bytes of a word beside a node.
const WORD: u64 = 4;
/// Texels of a row of the nodes' image: `node.glsl`.
const ROW: u32 = 4096;

impl NodeFormat {
    /// Texels of a node.
    pub(super) fn texels(self) -> u64 {
        match self {
            Self::Compact | Self::Half | Self::CompactTinted | Self::HalfTinted | Self::Transmittance => 1,
            Self::Float | Self::FloatTinted => 2,
        }
    }

    /// As `node.glsl` has it.
    pub(super) fn number(self) -> u32 {
        match self {
            Self::Compact => 0,
            Self::Half => 1,
            Self::Float => 2,
            Self::CompactTinted => 3,
            Self::FloatTinted => 4,
            Self::Transmittance => 5,
            Self::HalfTinted => 6,
        }
    }

    /// Whether light that passes through a layer is multiplied channel by channel. Other formats keep one alpha, and
    /// materials have no transmission.
    pub fn is_tinted(self) -> bool {
        matches!(self, Self::CompactTinted | Self::HalfTinted | Self::FloatTinted | Self::Transmittance)
    }
}

/// A node of an array, on the host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Of the depth buffer, reversed.
    pub depth: f32,
    /// Of nodes of equal depth, the one of the larger key is in front.
    pub key: u32,
    /// Premultiplied. The alpha of tinted layers is the channels' mean.
    pub color: [f32; 4],
    /// What it lets through, channel by channel.
    pub through: [f32; 3],
    /// Samples that it is seen at, a bit each: of pixels of one sample, 1.
    pub samples: u32,
}

/// Size of an image of so many texels, at least of one row.
pub(super) fn texels_size(texels: u64) -> [u32; 2] {
    [ROW, texels.div_ceil(u64::from(ROW)).max(1) as u32]
}

impl ABuffer {
    /// Words beside a node of an array or a list: the next node, which [`NodeFormat::Compact`] has no room for where there are
    /// samples, and what else does not fit.
    fn words_beside(&self, linked: bool) -> u64 {
        let link = match self.format {
            NodeFormat::Compact => self.samples > 1,
            NodeFormat::Float => false,
            _ => true,
        };
        u64::from(linked && link) + u64::from(self.format == NodeFormat::HalfTinted)
    }

    /// Bytes of a node of an array or a list.
    pub(super) fn node_bytes(&self, linked: bool) -> u64 {
        self.format.texels() * TEXEL + self.words_beside(linked) * WORD
    }

    /// Most nodes that there may be.
    pub(super) fn most_nodes(&self, caps: &Caps, linked: bool) -> u64 {
        let rows = u64::from(caps.limits.max_image_dimension_2d);
        let bytes = caps.limits.max_allocation_size.min(self.memory);
        let texels = self.format.texels().max(self.words_beside(linked));
        let most = (rows * u64::from(ROW) / texels).min(bytes / self.node_bytes(linked));
        most.min(u64::from(u32::MAX - 1))
    }

    /// Size of the image of so many nodes.
    pub(super) fn image_size(&self, nodes: u64) -> [u32; 2] {
        texels_size(nodes * self.format.texels())
    }

    /// The same.
    ///
    /// # Errors
    /// [`Error::Invalid`] with what would be needed, where that is more than the device can have.
    pub(super) fn nodes_size(&self, caps: &Caps, nodes: u64, linked: bool) -> Result<[u32; 2]> {
        let most = self.most_nodes(caps, linked);
        if nodes > most {
            let bytes = |nodes: u64| nodes * self.node_bytes(linked);
            let (needed, allowed) = (bytes(nodes), bytes(most));
            let wrong = format!("{nodes} fragments need {needed} bytes; there may be {allowed}");
            return Err(Error::invalid("A-buffer", wrong));
        }
        Ok(self.image_size(nodes))
    }

    /// Size of the image of what is beside them.
    pub(super) fn beside_size(&self, nodes: u64, linked: bool) -> [u32; 2] {
        texels_size(nodes * self.words_beside(linked))
    }

    /// What colours are stored as multiples of.
    pub fn unit(&self) -> f32 {
        (self.exponent.clamp(-64, 64) as f32).exp2()
    }

    /// Nodes from the texels of [`super::Composited::nodes`], as `node.glsl` packed them.
    ///
    /// # Errors
    /// [`Error::Invalid`] for [`NodeFormat::HalfTinted`], whose nodes are not in these texels alone.
    pub fn unpack(&self, texels: &[[u32; 4]]) -> Result<Vec<Node>> {
        let unit = self.unit();
        let scaled = |[red, green, blue]: [f32; 3], alpha: f32| [red * unit, green * unit, blue * unit, alpha];
        let float = |word: u32| f32::from_bits(word);
        let halves = |word: u32| [word as u16, (word >> 16) as u16].map(|bits| f16::from_bits(bits).to_f32());
        let node = |texels: &[[u32; 4]]| {
            let [depth, word, low, high] = texels[0];
            let (key, samples) = if self.samples > 1 { (word >> 8, word & 255) } else { (word, 1) };
            let plain = |color: [f32; 4]| (color, [1.0 - color[3]; 3]);
            let tinted = |color: [f32; 3], through: [f32; 3]| (scaled(color, 1.0 - mean(through)), through);
            let (color, through) = match self.format {
                NodeFormat::Compact => {
                    let alpha = if self.samples > 1 { high } else { word & 255 };
                    plain(scaled(shared_exponent(low), alpha as f32 / 255.0))
                }
                NodeFormat::Half => {
                    let ([red, green], [blue, alpha]) = (halves(low), halves(high));
                    plain(scaled([red, green, blue], alpha))
                }
                NodeFormat::Float => {
                    let [red, green, blue, alpha] = texels[1].map(float);
                    plain(scaled([red, green, blue], alpha))
                }
                NodeFormat::CompactTinted => {
                    let through = [high, high >> 10, high >> 20].map(|steps| (steps & 1023) as f32 / 1023.0);
                    tinted(shared_exponent(low), through)
                }
                NodeFormat::FloatTinted => {
                    let [red, green, blue, last] = texels[1].map(float);
                    tinted([red, green, blue], [float(low), float(high), last])
                }
                NodeFormat::Transmittance => {
                    const MOST: u64 = (1 << 21) - 1;
                    let words = u64::from(low) | u64::from(high) << 32;
                    tinted([0.0; 3], [0, 21, 42].map(|bit| (words >> bit & MOST) as f32 / MOST as f32))
                }
                NodeFormat::HalfTinted => return None,
            };
            Some(Node { depth: float(depth), key, color, through, samples })
        };
        let nodes: Option<_> = texels.chunks_exact(self.format.texels() as usize).map(node).collect();
        nodes.ok_or_else(|| Error::invalid("nodes of `NodeFormat::HalfTinted`", "have words beside these texels"))
    }

    /// `program` with the constants of `node.glsl`.
    pub(super) fn specialized(&self, program: Program) -> Program {
        program
            .constant(shader::NODE_FORMAT, self.format.number())
            .constant(shader::NODE_UNIT, self.unit())
            .constant(shader::TINTED, self.format.is_tinted())
            .constant(shader::SAMPLES, self.samples)
    }
}

/// The channels' mean, as `layer.glsl` has it.
fn mean([red, green, blue]: [f32; 3]) -> f32 {
    green + ((red - green) + (blue - green)) * (1.0 / 3.0)
}

/// Red, green and blue of RGB9E5 (`EXT_texture_shared_exponent`).
fn shared_exponent(word: u32) -> [f32; 3] {
    let scale = ((word >> 27) as f32 - 15.0 - 9.0).exp2();
    [word, word >> 9, word >> 18].map(|mantissa| (mantissa & 511) as f32 * scale)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_unpacked_as_they_were_packed() {
        let unpacked =
            |format, texels: &[[u32; 4]]| ABuffer { format, exponent: 1, ..ABuffer::default() }.unpack(texels).unwrap();
        let depth = 0.25_f32.to_bits();
        // 2⁻¹ · (256, 128, 1) / 256, as RGB9E5 has it: mantissas of nine bits, scale 2^(exponent - 24).
        let shared = 256 | 128 << 9 | 1 << 18 | 15 << 27;
        let color = [1.0, 0.5, 1.0 / 256.0, 1.0];
        let node = Node { depth: 0.25, key: 7 << 8 | 255, color, through: [0.0; 3], samples: 1 };
        assert_eq!(unpacked(NodeFormat::Compact, &[[depth, 7 << 8 | 255, shared, 0]]), [node]);
        let half = |value: f32| u32::from(f16::from_f32(value).to_bits());
        let texel = [depth, 9, half(0.5) | half(0.25) << 16, half(1.5) | half(0.75) << 16];
        let node = Node { depth: 0.25, key: 9, color: [1.0, 0.5, 3.0, 0.75], through: [0.25; 3], samples: 1 };
        assert_eq!(unpacked(NodeFormat::Half, &[texel]), [node]);
        let second = [0.5_f32, 0.25, 1.5, 0.75].map(f32::to_bits);
        assert_eq!(unpacked(NodeFormat::Float, &[[depth, 9, 0, 0], second]), [node]);
        // Channel by channel.
        let through = [1.0, 0.0, 0.5];
        let tinted = Node { color: [1.0, 0.5, 3.0, 0.5], through, ..node };
        let [first, second] = [[1.0_f32, 0.0], [0.5, 0.5]].map(|pair| pair.map(f32::to_bits));
        let texels =
            [[depth, 9, first[0], first[1]], [0.5_f32.to_bits(), 0.25_f32.to_bits(), 1.5_f32.to_bits(), second[1]]];
        assert_eq!(unpacked(NodeFormat::FloatTinted, &texels), [tinted]);
        let compact = unpacked(NodeFormat::CompactTinted, &[[depth, 9, shared, 1023 | 512 << 20]]);
        assert_eq!(compact[0].through, [1.0, 0.0, 512.0 / 1023.0]);
        // Red all, green nothing but its highest bit, blue all.
        let most = (1_u32 << 21) - 1;
        let words = u64::from(most) | 1 << 41 | u64::from(most) << 42;
        let node = unpacked(NodeFormat::Transmittance, &[[depth, 9, words as u32, (words >> 32) as u32]])[0];
        assert_eq!(node.through, [1.0, (1 << 20) as f32 / most as f32, 1.0]);
        let beside = ABuffer { format: NodeFormat::HalfTinted, ..ABuffer::default() };
        assert!(beside.unpack(&[[depth, 9, 0, 0]]).unwrap_err().to_string().contains("HalfTinted"));
    }
}

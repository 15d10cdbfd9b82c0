//! What is kept of a fragment (`node.glsl`).

use crate::gpu::Caps;
use crate::shader::Program;
use crate::shader::generated::transparency::abuffer::array_frag as shader;

use super::ABuffer;
use crate::{Error, Result};

/// Triangles that the keys of [`NodeFormat::Compact`] tell apart.
pub const COMPACT_TRIANGLES: u64 = 1 << 24;

/// How colour and alpha are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum NodeFormat {
    /// RGB9E5 and 8 bits: 16 bytes a node.
    #[default]
    Compact,
    /// Half-floats: 16 bytes a node, 32 in lists.
    Half,
    /// 32-bit floats: 32 bytes a node.
    Float,
}

/// Bytes of a texel of nodes.
const TEXEL: u64 = 16;
/// Texels of a row of the nodes' image: `node.glsl`.
const ROW: u32 = 4096;

impl NodeFormat {
    /// Texels of a node.
    fn texels(self, linked: bool) -> u64 {
        match self {
            Self::Compact => 1,
            Self::Half => 1 + u64::from(linked),
            Self::Float => 2,
        }
    }

    /// As `node.glsl` has it.
    pub(super) fn number(self) -> u32 {
        match self {
            Self::Compact => 0,
            Self::Half => 1,
            Self::Float => 2,
        }
    }
}

/// Size of an image of so many texels, at least of one row.
pub(super) fn texels_size(texels: u64) -> [u32; 2] {
    [ROW, texels.div_ceil(u64::from(ROW)).max(1) as u32]
}

impl ABuffer {
    /// Most nodes that there may be.
    pub(super) fn most_nodes(&self, caps: &Caps, linked: bool) -> u64 {
        let rows = u64::from(caps.limits.max_image_dimension_2d);
        let bytes = caps.limits.max_allocation_size.min(self.memory);
        let texels = (rows * u64::from(ROW)).min(bytes / TEXEL);
        (texels / self.format.texels(linked)).min(u64::from(u32::MAX - 1))
    }

    /// Size of the image of so many nodes.
    pub(super) fn image_size(&self, nodes: u64, linked: bool) -> [u32; 2] {
        texels_size(nodes * self.format.texels(linked))
    }

    /// The same.
    ///
    /// # Errors
    /// [`Error::Invalid`] with what would be needed, where that is more than the device can have.
    pub(super) fn nodes_size(&self, caps: &Caps, nodes: u64, linked: bool) -> Result<[u32; 2]> {
        let most = self.most_nodes(caps, linked);
        if nodes > most {
            let bytes = |nodes: u64| nodes * self.format.texels(linked) * TEXEL;
            let (needed, allowed) = (bytes(nodes), bytes(most));
            let wrong = format!("{nodes} fragments need {needed} bytes; there may be {allowed}");
            return Err(Error::invalid("A-buffer", wrong));
        }
        Ok(self.image_size(nodes, linked))
    }

    /// What colours are stored as multiples of.
    pub(super) fn unit(&self) -> f32 {
        (self.exponent.clamp(-64, 64) as f32).exp2()
    }

    /// `program` with the constants of `node.glsl`.
    pub(super) fn specialized(&self, program: Program) -> Program {
        program.constant(shader::NODE_FORMAT, self.format.number()).constant(shader::NODE_UNIT, self.unit())
    }
}

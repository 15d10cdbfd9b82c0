//! Drawing a scene's triangles into the columns of a grid: what the techniques share that look along an axis.

use crate::gpu::Caps;
use crate::scene::POSITIONS;
use crate::shader::generated::voxel::bitmask::columns_vert;
use crate::shader::{Program, Shader};

/// What is inside, of the points that a surface encloses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FillRule {
    /// What the surface winds around: before it lie more crossings one way than the other. Solids that overlap are one.
    #[default]
    NonZero,
    /// What lies behind an odd number of crossings, whichever way the surface faces. Solids that overlap cancel out.
    EvenOdd,
}

/// A program whose vertex shader is made of `common/voxel_columns.glsl`.
pub(super) fn program(caps: &Caps, vertex: &'static Shader, fragment: &'static Shader) -> Program {
    let subpixels = 1 << caps.limits.sub_pixel_bits;
    Program::new(vertex, Some(fragment)).vertex_buffers(POSITIONS).constant(columns_vert::SUBPIXELS, subpixels)
}

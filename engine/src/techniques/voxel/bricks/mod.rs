//! Surface voxels in bricks of 8³ where the surface is: grids that would not fit as a whole.
//!
//! Source: Laine and Karras 2011, "Efficient Sparse Voxel Octrees", for the want; a grid of bricks and a rank of bits in
//! place of a tree, as in Crassin, Neyret, Lefebvre and Eisemann 2009, "GigaVoxels", section 3.

use super::ranks::{Count, Ranks};
use super::{Axis, Grid, VoxelBits, cover};
use crate::Result;
use crate::graph::{BufferHandle, Graph};
use crate::scene::GpuScene;
use crate::shader::Program;
use crate::shader::generated::voxel::bricks::{thin_frag, touched_frag};
use crate::shader::generated::voxel::conservative::{cover_frag, cover_vert};

/// Voxels of a brick along an axis.
pub const BRICK: u32 = 8;
/// Words of a brick.
pub(super) const BRICK_WORDS: usize = 16;

/// Surface voxelization into bricks. Surfaces need not be closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bricks {
    /// Which voxels are set.
    pub thickness: Thickness,
}

/// Which voxels make up a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Thickness {
    /// Those of [`super::conservative::Conservative`].
    #[default]
    Conservative,
    /// Those of [`super::six_separating::SixSeparating`].
    SixSeparating,
}

/// Bits of a grid on the device, where some are set.
pub struct BrickBits {
    /// Where the voxels are.
    pub grid: Grid,
    /// The grid of bricks, a bit a brick that is there, with columns along z.
    pub coarse: VoxelBits,
    /// How many bricks come before each word of the coarse bits: a brick stands at that of its word plus the bits below its
    /// own.
    pub firsts: BufferHandle,
    /// 16 words a brick: voxel (x, y, z) of it is bit `8 · (y % 4) + x` of word `2 · z + y / 4`.
    pub bricks: BufferHandle,
    /// How many there are.
    pub(super) count: Count,
}

/// By how much bricks are grown, beside what voxels are, in bricks: a brick too many does no harm, one too few does.
const SPARE: f32 = 0.01;

impl Bricks {
    /// Sets the voxels of surfaces. The number of bricks is read by the host, and sizes the buffer.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the device cannot bind the grid of bricks at once. Where it cannot bind all bricks,
    /// the frame ends with an error that names the buffer.
    pub fn record<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid) -> Result<BrickBits> {
        // 1. Which bricks are there.
        let VoxelBits { bits, grid: coarse, axis } =
            VoxelBits::new(graph, "voxel.bricks.coarse", &grid.bricks(), Axis::Z)?;
        let bits = graph.fill("voxel.bricks.coarse.clear", bits, 0);
        let program = Program::new(&cover_vert::SHADER, Some(&cover_frag::SHADER));
        let mut pass = graph.raster("voxel.bricks.cover", vec![program]);
        cover::bind(&mut pass, scene, &coarse, axis, SPARE)?;
        let bits = pass.write(cover_frag::BITS, bits);
        cover::draw(pass, scene);
        let coarse = VoxelBits { bits, grid: coarse, axis };
        // 2. A place for each.
        let Ranks { firsts, count } = Ranks::of_grid(graph, "voxel.bricks", &coarse.bits, coarse.grid.words(axis));
        let size = 4 * BRICK_WORDS as u64;
        let bricks =
            graph.buffer_after(&count.told, "voxel.bricks", move |total| size * u64::from(total[0].total.max(1)));
        let bricks = graph.fill("voxel.bricks.clear", bricks, 0);
        // 3. Their voxels.
        let fragment = match self.thickness {
            Thickness::Conservative => &touched_frag::SHADER,
            Thickness::SixSeparating => &thin_frag::SHADER,
        };
        let mut pass = graph.raster("voxel.bricks.mark", vec![Program::new(&cover_vert::SHADER, Some(fragment))]);
        cover::bind(&mut pass, scene, grid, Axis::Z, 0.0)?;
        pass.read(touched_frag::BITS, &coarse.bits).read(touched_frag::FIRSTS, &firsts);
        let bricks = pass.write(touched_frag::BRICKS, bricks);
        cover::draw(pass, scene);
        Ok(BrickBits { grid: *grid, coarse, firsts, bricks, count })
    }
}

/// Names of the captures.
pub(super) const NAMES: [&str; 3] = ["voxel.bricks.coarse", "voxel.bricks.firsts", "voxel.bricks.words"];

impl BrickBits {
    /// Captures all of it, for [`super::Voxels::read_bricks`].
    pub fn capture(&self, graph: &mut Graph) {
        for (name, buffer) in NAMES.iter().zip([&self.coarse.bits, &self.firsts, &self.bricks]) {
            graph.capture(*name, buffer);
        }
    }
}

//! Which points see which? Segments are walked from voxel to voxel, and over empty blocks of them at once.
//!
//! Source: Amanatides and Woo 1987, "A Fast Voxel Traversal Algorithm for Ray Tracing", for the walk; Crassin, Neyret,
//! Lefebvre and Eisemann 2009, "GigaVoxels", for the skipping of empty nodes of a hierarchy.

use ash::vk;
use glam::Vec3;

use super::{Occluders, VoxelSet};
use crate::Result;
use crate::gpu::{Buffer, BufferInfo, Gpu, Memory};
use crate::graph::{BufferHandle, Graph};
use crate::shader::generated::blocks;
pub use crate::shader::generated::blocks::Segment;
use crate::shader::generated::voxel::ray_marching::march_comp;

/// Any-hit visibility between pairs of points, through the bits of a grid.
///
/// A segment is blocked where a point of it lies in a set voxel, but for the voxels that hold its two ends: a point on a
/// surface may lie in a voxel of that surface. Voxels are half open, so that a point lies in one of them. Ends are rounded
/// to 1/4096 voxel, towards the grid's lower corner; the part of a segment outside of the grid meets nothing. From end to
/// origin the answer is the same, but for the rounding of segments that reach out of the grid. A segment that is not
/// finite, or reaches 1e30 voxels, meets nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayMarching {
    /// Levels of the pyramid to skip by, at most; 0 for a walk from voxel to voxel. The answers are the same.
    pub levels: u32,
}

impl Default for RayMarching {
    fn default() -> Self {
        Self { levels: u32::MAX }
    }
}

impl Segment {
    /// Between two points in world space.
    pub fn new(origin: Vec3, end: Vec3) -> Self {
        Self { origin: origin.to_array().into(), end: end.to_array().into() }
    }

    /// A buffer of segments from the host, to be imported into frames.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where there are none; [`crate::Error::OutOfMemory`].
    pub fn upload(gpu: &Gpu, segments: &[Self]) -> Result<Buffer> {
        let bytes: &[u8] = bytemuck::cast_slice(segments);
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let info = BufferInfo { name: "segments", size: bytes.len() as u64, usage, memory: Memory::Upload };
        let buffer = gpu.create_buffer(&info)?;
        buffer.write(0, bytes)?;
        Ok(buffer)
    }
}

/// Segments in a row of invocations.
const ROW: u32 = 1 << 20;

impl RayMarching {
    /// A word for each [`Segment`] of a buffer: 1 where it is blocked, 0 where one end sees the other.
    pub fn record(
        &self,
        graph: &mut Graph,
        occluders: &Occluders<impl VoxelSet>,
        segments: &BufferHandle,
    ) -> BufferHandle {
        let count = (segments.size() / size_of::<Segment>() as u64) as u32;
        let blocked = graph.buffer("voxel.blocked", 4 * u64::from(count.max(1)));
        let mut pass = graph.compute("voxel.ray_marching", &march_comp::SHADER);
        occluders.bind(&mut pass, self.levels);
        pass.read(march_comp::SEGMENTS, segments).push(&blocks::MarchPush { count, row: ROW });
        let blocked = pass.write(march_comp::BLOCKED, blocked);
        pass.dispatch([count.min(ROW), count.div_ceil(ROW), 1]);
        blocked
    }
}

//! The grid, and what its bits mean.

use glam::Vec3;

use super::bricks::BRICK;
use crate::geometry::Aabb;
use crate::graph::{BufferHandle, Graph};
use crate::shader::generated::blocks;
use crate::{Error, Result};

/// Most voxels along an axis.
pub const MAX_RESOLUTION: u32 = 2048;

/// A regular grid of cubic voxels.
///
/// Voxel (i, j, k) has its centre at `min + (i + ½, j + ½, k + ½) · edge`. A centre exactly on a surface counts by
/// Vulkan's top-left rule across the columns a technique looks along, and as behind the surface along them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    min: Vec3,
    edge: f32,
    size: [u32; 3],
}

/// An axis of a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axis {
    /// World x.
    X,
    /// World y.
    Y,
    /// World z.
    #[default]
    Z,
}

impl Axis {
    /// World axes in column coordinates: two across, then this one. The order turns no solid inside out.
    pub fn order(self) -> [usize; 3] {
        match self {
            Self::X => [1, 2, 0],
            Self::Y => [2, 0, 1],
            Self::Z => [0, 1, 2],
        }
    }

    /// Name of a pass or a resource: a frame may look along several axes.
    pub(super) fn named(self, what: impl std::fmt::Display) -> String {
        let axis = ["x", "y", "z"][self as usize];
        format!("voxel.{axis}.{what}")
    }
}

impl Grid {
    /// With its lower corner in world space, the edge of a voxel in metres, and voxels along x, y and z.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the edge is not positive, a number is not finite, or the size is 0 or beyond
    /// [`MAX_RESOLUTION`].
    pub fn new(min: Vec3, edge: f32, size: [u32; 3]) -> Result<Self> {
        let invalid = |why: String| Err(Error::invalid("the voxel grid", why));
        if !(min.is_finite() && edge.is_finite() && edge > 0.0) {
            return invalid(format!("its corner {min} must be finite, and the edge of a voxel, {edge} m, positive"));
        }
        if size.iter().any(|&n| n == 0 || n > MAX_RESOLUTION) {
            return invalid(format!("{size:?} voxels: each axis has 1 to {MAX_RESOLUTION}"));
        }
        Ok(Self { min, edge, size })
    }

    /// A cube of `resolution` voxels an axis around bounds, with half a voxel of margin where they are widest.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the bounds are a point or not finite, or as [`Grid::new`].
    pub fn around(bounds: &Aabb, resolution: u32) -> Result<Self> {
        let extent = bounds.max - bounds.min;
        let widest = extent.max_element();
        if !(widest.is_finite() && widest > 0.0) {
            let why = format!("its bounds, {} to {}, have no extent to put voxels in", bounds.min, bounds.max);
            return Err(Error::invalid("the voxel grid", why));
        }
        // A single voxel cannot have a margin.
        let edge = widest / (resolution.max(2) - 1) as f32;
        let center = 0.5 * (bounds.min + bounds.max);
        Self::new(center - 0.5 * edge * resolution as f32, edge, [resolution; 3])
    }

    /// World-space lower corner, metres.
    pub fn min(&self) -> Vec3 {
        self.min
    }

    /// Edge of a voxel, metres.
    pub fn edge(&self) -> f32 {
        self.edge
    }

    /// Voxels along x, y and z.
    pub fn size(&self) -> [u32; 3] {
        self.size
    }

    /// Centre of a voxel, world space.
    pub fn center(&self, voxel: [u32; 3]) -> Vec3 {
        self.min + (Vec3::from(voxel.map(|i| i as f32)) + 0.5) * self.edge
    }

    /// All voxels in the order `[z][y][x]`: x runs fastest.
    pub fn voxels(&self) -> impl Iterator<Item = [u32; 3]> + use<> {
        let [width, height, depth] = self.size;
        let rows = (0..depth).flat_map(move |z| (0..height).map(move |y| [y, z]));
        rows.flat_map(move |[y, z]| (0..width).map(move |x| [x, y, z]))
    }

    /// The grid whose voxels are bricks of 8³ of these.
    pub(super) fn bricks(&self) -> Self {
        Self { min: self.min, edge: BRICK as f32 * self.edge, size: self.size.map(|n| n.div_ceil(BRICK)) }
    }

    /// Columns across, and voxels in one, along an axis.
    pub fn columns(&self, axis: Axis) -> [u32; 3] {
        axis.order().map(|world| self.size[world])
    }

    /// Words of 32 voxels in all columns.
    pub(super) fn words(&self, axis: Axis) -> u64 {
        let [width, height, depth] = self.columns(axis).map(u64::from);
        width * height * depth.div_ceil(32)
    }

    /// The uniform block `VoxelGrid`.
    pub(super) fn block(&self, axis: Axis) -> blocks::VoxelGrid {
        blocks::VoxelGrid {
            voxel_grid_min: self.min.to_array().into(),
            voxel_edge: self.edge,
            columns: self.columns(axis),
            column_axis: axis as u32,
        }
    }
}

/// Bits of a grid on the device, a bit a voxel.
pub struct VoxelBits {
    /// 32-bit words: voxel `k` of column `(i, j)` is bit `k % 32` of word `((k / 32) · height + j) · width + i`, where
    /// width, height and the voxels of a column are [`Grid::columns`].
    pub bits: BufferHandle,
    /// Where the voxels are.
    pub grid: Grid,
    /// The axis that columns run along.
    pub axis: Axis,
}

impl VoxelBits {
    /// A buffer for a grid, with nothing in it yet.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the device cannot bind so many bits at once; it says how many it can.
    pub(super) fn new(graph: &mut Graph, name: &str, grid: &Grid, axis: Axis) -> Result<Self> {
        let bytes = 4 * grid.words(axis);
        let most = u64::from(graph.caps().limits.max_storage_buffer_range);
        if bytes > most {
            let why =
                format!("{:?} voxels take {bytes} bytes; the device binds {most} at once; bricks take less", grid.size);
            return Err(Error::invalid("the voxel grid", why));
        }
        Ok(Self { bits: graph.buffer(name, bytes), grid: *grid, axis })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_around_bounds_has_half_a_voxel_of_margin() {
        let bounds = Aabb { min: Vec3::new(-1.0, 2.0, 0.0), max: Vec3::new(3.0, 3.0, 1.0) };
        let grid = Grid::around(&bounds, 9).unwrap();
        assert_eq!((grid.edge(), grid.min()), (0.5, Vec3::new(-1.25, 0.25, -1.75)));
        assert_eq!(grid.center([0, 0, 0]), Vec3::new(-1.0, 0.5, -1.5));
    }

    #[test]
    fn grids_that_cannot_be_are_refused() {
        let point = Aabb { min: Vec3::ONE, max: Vec3::ONE };
        assert!(Grid::around(&point, 8).unwrap_err().to_string().contains("no extent"));
        assert!(Grid::new(Vec3::ZERO, 1.0, [4, 0, 4]).unwrap_err().to_string().contains("1 to 2048"));
        assert!(Grid::new(Vec3::ZERO, 1.0, [2049; 3]).is_err());
        assert!(Grid::new(Vec3::ZERO, -1.0, [4; 3]).unwrap_err().to_string().contains("positive"));
        assert!(Grid::new(Vec3::NAN, 1.0, [4; 3]).is_err());
    }
}

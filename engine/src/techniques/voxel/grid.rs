//! The grid, and what its bits mean.

use glam::Vec3;

use crate::geometry::Aabb;
use crate::graph::{BufferHandle, Capture, Graph};
use crate::shader::generated::blocks;
use crate::{Error, Result};

/// Most voxels along an axis.
pub const MAX_RESOLUTION: u32 = 1024;

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
        self.rows().flatten()
    }

    /// The same, row by row along x.
    pub fn rows(&self) -> impl Iterator<Item = impl Iterator<Item = [u32; 3]> + use<>> + use<> {
        let [width, height, depth] = self.size;
        let rows = (0..depth).flat_map(move |z| (0..height).map(move |y| [y, z]));
        rows.map(move |[y, z]| (0..width).map(move |x| [x, y, z]))
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
            let why = format!("{:?} voxels take {bytes} bytes; the device binds {most} at once", grid.size);
            return Err(Error::invalid("the voxel grid", why));
        }
        Ok(Self { bits: graph.buffer(name, bytes), grid: *grid, axis })
    }
}

/// Bits of a grid on the host.
#[derive(Clone, Debug, PartialEq)]
pub struct Voxels {
    grid: Grid,
    axis: Axis,
    words: Vec<u32>,
}

impl Voxels {
    /// From a capture of [`VoxelBits::bits`].
    ///
    /// # Errors
    /// [`Error::Invalid`] where the capture has another size; [`Error::Vulkan`] where it cannot be read.
    pub fn read(capture: &Capture, grid: &Grid, axis: Axis) -> Result<Self> {
        let words: Vec<u32> = capture.texels()?;
        if words.len() as u64 != grid.words(axis) {
            let why = format!("its {} words are not those of {:?} voxels along {axis:?}", words.len(), grid.size);
            return Err(Error::invalid(format!("capture `{}`", capture.name), why));
        }
        Ok(Self { grid: *grid, axis, words })
    }

    /// Those that `is_set` says, with columns along z.
    pub fn from_fn(grid: &Grid, is_set: impl Fn([u32; 3]) -> bool) -> Self {
        let [width, height, _] = grid.size;
        let mut words = vec![0; grid.words(Axis::Z) as usize];
        for [i, j, k] in grid.voxels().filter(|&voxel| is_set(voxel)) {
            words[(k as usize / 32 * height as usize + j as usize) * width as usize + i as usize] |= 1 << (k % 32);
        }
        Self { grid: *grid, axis: Axis::Z, words }
    }

    /// Where the voxels are.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The axis that columns run along.
    pub fn axis(&self) -> Axis {
        self.axis
    }

    /// Whether a voxel is set; nothing outside the grid is.
    pub fn get(&self, voxel: [u32; 3]) -> bool {
        self.rank(voxel).is_some()
    }

    /// The word that holds a set voxel, and how many of its lower bits are set.
    pub(super) fn rank(&self, voxel: [u32; 3]) -> Option<(usize, u32)> {
        let [i, j, k] = self.axis.order().map(|world| voxel[world]);
        let [width, height, depth] = self.grid.columns(self.axis);
        if i >= width || j >= height || k >= depth {
            return None;
        }
        let index = (k as usize / 32 * height as usize + j as usize) * width as usize + i as usize;
        let (word, bit) = (self.words[index], 1 << (k % 32));
        (word & bit != 0).then(|| (index, (word & (bit - 1)).count_ones()))
    }

    /// How many words there are.
    pub(super) fn words(&self) -> usize {
        self.words.len()
    }

    /// How many voxels are set.
    pub fn count(&self) -> u64 {
        self.words.iter().map(|word| u64::from(word.count_ones())).sum()
    }

    /// A byte a voxel, 1 where it is set, in the order `[z][y][x]`.
    pub fn bytes(&self) -> Vec<u8> {
        self.grid.voxels().map(|voxel| u8::from(self.get(voxel))).collect()
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
        assert!(Grid::new(Vec3::ZERO, 1.0, [4, 0, 4]).unwrap_err().to_string().contains("1 to 1024"));
        assert!(Grid::new(Vec3::ZERO, 1.0, [1025; 3]).is_err());
        assert!(Grid::new(Vec3::ZERO, -1.0, [4; 3]).unwrap_err().to_string().contains("positive"));
        assert!(Grid::new(Vec3::NAN, 1.0, [4; 3]).is_err());
    }

    #[test]
    fn bits_are_found_along_every_axis() {
        let grid = Grid::new(Vec3::ZERO, 1.0, [3, 5, 40]).unwrap();
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let [width, height, depth] = grid.columns(axis);
            let mut words = vec![0; grid.words(axis) as usize];
            let [i, j, k] = axis.order().map(|world| [2, 3, 37][world]);
            assert!(i < width && j < height && k < depth);
            words[((k / 32 * height + j) * width + i) as usize] = 1 << (k % 32);
            let voxels = Voxels { grid, axis, words };
            assert!(voxels.get([2, 3, 37]) && !voxels.get([2, 3, 36]) && !voxels.get([3, 3, 37]));
            let bytes = voxels.bytes();
            assert_eq!(bytes.iter().position(|&byte| byte == 1), Some((37 * 5 + 3) * 3 + 2));
            assert_eq!((bytes.len(), voxels.count()), (600, 1));
        }
    }
}

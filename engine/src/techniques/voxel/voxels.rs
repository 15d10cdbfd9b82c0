//! Bits of a grid on the host.

use super::bricks::{BRICK, BRICK_WORDS};
use super::{Axis, Grid};
use crate::graph::{Capture, Executed};
use crate::{Error, Result};

/// Bits of a grid on the host.
#[derive(Clone, Debug, PartialEq)]
pub struct Voxels {
    pub(super) grid: Grid,
    pub(super) store: Store,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Store {
    /// All of them, as [`super::VoxelBits`] says.
    Columns { axis: Axis, words: Vec<u32> },
    /// Where some are set, as [`super::bricks::BrickBits`] says.
    Bricks { coarse: Box<Voxels>, firsts: Vec<u32>, bricks: Vec<[u32; BRICK_WORDS]> },
}

impl Voxels {
    /// From a capture of [`super::VoxelBits::bits`].
    ///
    /// # Errors
    /// [`Error::Invalid`] where the capture has another size; [`Error::Vulkan`] where it cannot be read.
    pub fn read(capture: &Capture, grid: &Grid, axis: Axis) -> Result<Self> {
        let words: Vec<u32> = capture.texels()?;
        if words.len() as u64 != grid.words(axis) {
            let why = format!("its {} words are not those of {:?} voxels along {axis:?}", words.len(), grid.size());
            return Err(Error::invalid(format!("capture `{}`", capture.name), why));
        }
        Ok(Self { grid: *grid, store: Store::Columns { axis, words } })
    }

    /// From the captures of [`super::bricks::BrickBits::capture`].
    ///
    /// # Errors
    /// As [`Voxels::read`], and where a capture is not there.
    pub fn read_bricks(executed: &Executed, grid: &Grid) -> Result<Self> {
        let [coarse, firsts, bricks] = super::bricks::NAMES.map(|name| executed.capture(name));
        let coarse = Self::read(coarse?, &grid.bricks(), Axis::Z)?;
        let (firsts, bricks): (Vec<u32>, Vec<[u32; BRICK_WORDS]>) = (firsts?.texels()?, bricks?.texels()?);
        let count = coarse.count();
        if firsts.len() != coarse.words().len() || bricks.len() as u64 != count.max(1) {
            let why = format!("{} bricks, by {} words, are not {count}", bricks.len(), firsts.len());
            return Err(Error::invalid("the captured bricks", why));
        }
        Ok(Self { grid: *grid, store: Store::Bricks { coarse: Box::new(coarse), firsts, bricks } })
    }

    /// Those that `is_set` says, with columns along z.
    pub fn from_fn(grid: &Grid, is_set: impl Fn([u32; 3]) -> bool) -> Self {
        let [width, height, _] = grid.size();
        let mut words = vec![0; grid.words(Axis::Z) as usize];
        for [i, j, k] in grid.voxels().filter(|&voxel| is_set(voxel)) {
            words[(k as usize / 32 * height as usize + j as usize) * width as usize + i as usize] |= 1 << (k % 32);
        }
        Self { grid: *grid, store: Store::Columns { axis: Axis::Z, words } }
    }

    /// Where the voxels are.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The axis that columns run along; of bricks z.
    pub fn axis(&self) -> Axis {
        match &self.store {
            Store::Columns { axis, .. } => *axis,
            Store::Bricks { coarse, .. } => coarse.axis(),
        }
    }

    /// Whether a voxel is set; nothing outside the grid is.
    pub fn get(&self, voxel: [u32; 3]) -> bool {
        self.rank(voxel).is_some()
    }

    /// The word that holds a set voxel, and how many of its lower bits are set.
    pub(super) fn rank(&self, voxel: [u32; 3]) -> Option<(usize, u32)> {
        let (index, bit) = self.place(voxel)?;
        let word = self.words()[index];
        (word & bit != 0).then(|| (index, (word & (bit - 1)).count_ones()))
    }

    /// The word with a voxel's bit, and the bit; nothing where there is none.
    fn place(&self, voxel: [u32; 3]) -> Option<(usize, u32)> {
        match &self.store {
            Store::Columns { axis, .. } => {
                let [i, j, k] = axis.order().map(|world| voxel[world]);
                let [width, height, depth] = self.grid.columns(*axis);
                let index = || (k as usize / 32 * height as usize + j as usize) * width as usize + i as usize;
                (i < width && j < height && k < depth).then(|| (index(), 1 << (k % 32)))
            }
            Store::Bricks { coarse, firsts, .. } => {
                let (word, below) = coarse.rank(voxel.map(|i| i / BRICK))?;
                let [x, y, z] = voxel.map(|i| i % BRICK);
                let first = BRICK_WORDS * (firsts[word] + below) as usize;
                Some((first + (2 * z + y / 4) as usize, 1 << (8 * (y % 4) + x)))
            }
        }
    }

    /// All words that hold bits.
    pub(super) fn words(&self) -> &[u32] {
        match &self.store {
            Store::Columns { words, .. } => words,
            Store::Bricks { bricks, .. } => bricks.as_flattened(),
        }
    }

    /// Bytes that they take.
    pub fn memory(&self) -> u64 {
        match &self.store {
            Store::Columns { words, .. } => size_of_val(&words[..]) as u64,
            Store::Bricks { coarse, firsts, bricks } => {
                coarse.memory() + size_of_val(&firsts[..]) as u64 + size_of_val(&bricks[..]) as u64
            }
        }
    }

    /// How many voxels are set.
    pub fn count(&self) -> u64 {
        self.words().iter().map(|word| u64::from(word.count_ones())).sum()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn bits_are_found_along_every_axis() {
        let grid = Grid::new(Vec3::ZERO, 1.0, [3, 5, 40]).unwrap();
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let [width, height, depth] = grid.columns(axis);
            let mut words = vec![0; grid.words(axis) as usize];
            let [i, j, k] = axis.order().map(|world| [2, 3, 37][world]);
            assert!(i < width && j < height && k < depth);
            words[((k / 32 * height + j) * width + i) as usize] = 1 << (k % 32);
            let voxels = Voxels { grid, store: Store::Columns { axis, words } };
            assert!(voxels.get([2, 3, 37]) && !voxels.get([2, 3, 36]) && !voxels.get([3, 3, 37]));
            let bytes = voxels.bytes();
            assert_eq!(bytes.iter().position(|&byte| byte == 1), Some((37 * 5 + 3) * 3 + 2));
            assert_eq!((bytes.len(), voxels.count()), (600, 1));
            assert_eq!(voxels.set().collect::<Vec<_>>(), [[2, 3, 37]]);
        }
    }
}

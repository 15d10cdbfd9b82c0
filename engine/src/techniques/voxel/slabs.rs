//! Walks over the voxels of a grid on the host, slab by slab, with voxels as the bits of rows: a word at a time, and in whatever
//! order a file wants.

use super::bricks::BRICK;
use super::voxels::{Store, Voxels};

/// Slices of a slab: those of a word of bits, and whole bricks.
const SLICES: u32 = 32;

/// Slices of a grid, one after the other.
pub(crate) struct Slab {
    /// World axes: along rows, from row to row, from slice to slice.
    order: [usize; 3],
    /// Voxels of the grid along these.
    size: [u32; 3],
    /// Its slices, of the grid's.
    first: u32,
    end: u32,
    /// 64 voxels of a row a word, the first one the lowest bit.
    words: Vec<u64>,
}

impl Slab {
    /// Words in a row.
    fn stride(&self) -> usize {
        self.size[0].div_ceil(64) as usize
    }

    /// The rows of each slice, as bits.
    pub(crate) fn slices(&self) -> impl Iterator<Item = &[u64]> {
        self.words.chunks_exact(self.stride() * self.size[1] as usize)
    }

    /// All rows, as bits.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[u64]> {
        self.words.chunks_exact(self.stride())
    }

    /// The word and the bit of a voxel.
    fn place(&self, voxel: [u32; 3]) -> (usize, u32) {
        let [along, row, slice] = self.order.map(|world| voxel[world]);
        let row = (slice - self.first) as usize * self.size[1] as usize + row as usize;
        (row * self.stride() + along as usize / 64, along % 64)
    }

    /// The first voxel of a word.
    fn voxel(&self, word: usize) -> [u32; 3] {
        let (row, along) = (word / self.stride(), 64 * (word % self.stride()) as u32);
        let height = self.size[1] as usize;
        let mut voxel = [0; 3];
        let own = [along, (row % height) as u32, self.first + (row / height) as u32];
        self.order.into_iter().zip(own).for_each(|(world, own)| voxel[world] = own);
        voxel
    }

    /// Sets voxels by the bits of a word that begins at one of them and goes along a world axis. Bits beyond the slab do not
    /// count.
    fn put(&mut self, first: [u32; 3], axis: usize, word: u32) {
        let [along, row, _] = self.order.map(|world| world == axis);
        let ends = [self.size[0], self.size[1], self.end];
        let mut bits = u64::from(word);
        for (world, end) in self.order.into_iter().zip(ends) {
            let room = end.saturating_sub(first[world]);
            bits &= if world == axis && room < 32 { (1 << room) - 1 } else { !0 };
            bits *= u64::from(room > 0);
        }
        if bits == 0 {
            return;
        }
        let (index, bit) = self.place(first);
        if along {
            self.words[index] |= bits << bit;
            return;
        }
        // The next voxel along the axis is so many words away.
        let step = self.stride() * if row { 1 } else { self.size[1] as usize };
        set_bits(bits).for_each(|behind| self.words[index + behind as usize * step] |= 1 << bit);
    }
}

/// The places of a word's set bits.
fn set_bits(word: u64) -> impl Iterator<Item = u32> {
    std::iter::successors(Some(word), |rest| Some(rest & rest.wrapping_sub(1)))
        .take_while(|&rest| rest != 0)
        .map(u64::trailing_zeros)
}

impl Voxels {
    /// The grid in slabs, one behind the other along the last of `order`: world axes along rows, from row to row, and from
    /// slice to slice.
    pub(crate) fn slabs(&self, order: [usize; 3]) -> impl Iterator<Item = Slab> + '_ {
        let size = order.map(|world| self.grid().size()[world]);
        (0..size[2]).step_by(SLICES as usize).map(move |first| {
            let slices = SLICES.min(size[2] - first);
            let words = slices as usize * size[1] as usize * size[0].div_ceil(64) as usize;
            let mut slab = Slab { order, size, first, end: first + slices, words: vec![0; words] };
            self.fill(&mut slab);
            slab
        })
    }

    /// Puts all of a slab's voxels into it.
    fn fill(&self, slab: &mut Slab) {
        // What the slab holds of the grid, by world axes.
        let mut from = [0; 3];
        let mut to = self.grid().size();
        let across = slab.order[2];
        (from[across], to[across]) = (slab.first, slab.end);
        match &self.store {
            Store::Columns { axis, words } => {
                let order = axis.order();
                let [width, height, _] = self.grid().columns(*axis).map(|n| n as usize);
                let [[left, right], [top, bottom], [near, far]] = order.map(|world| [from[world], to[world]]);
                for (k, j) in (near / 32..far.div_ceil(32)).flat_map(|k| (top..bottom).map(move |j| (k, j))) {
                    let row = (k as usize * height + j as usize) * width;
                    let row = &words[row + left as usize..row + right as usize];
                    for (i, &word) in (left..).zip(row).filter(|(_, word)| **word != 0) {
                        let mut first = [0; 3];
                        order.into_iter().zip([i, j, 32 * k]).for_each(|(world, own)| first[world] = own);
                        slab.put(first, order[2], word);
                    }
                }
            }
            Store::Bricks { coarse, firsts, bricks } => {
                let [xs, ys, zs] = [0, 1, 2].map(|world| from[world] / BRICK..to[world].div_ceil(BRICK));
                let places = zs.flat_map(|z| ys.clone().map(move |y| [y, z]));
                let places = places.flat_map(|[y, z]| xs.clone().map(move |x| [x, y, z]));
                for (place, (word, below)) in places.filter_map(|place| Some((place, coarse.rank(place)?))) {
                    let [x, y, z] = place.map(|i| BRICK * i);
                    // Rows of eight, from the lowest byte.
                    let words = bricks[(firsts[word] + below) as usize];
                    for (row, bits) in (0..).zip(words.into_iter().flat_map(u32::to_le_bytes)) {
                        slab.put([x, y + row % BRICK, z + row / BRICK], 0, bits.into());
                    }
                }
            }
        }
    }

    /// Those that are set, in the order `[z][y][x]`.
    pub fn set(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.slabs([0, 1, 2]).flat_map(|slab| {
            let words: Vec<usize> = (0..slab.words.len()).filter(|&word| slab.words[word] != 0).collect();
            words.into_iter().flat_map(move |word| {
                let [x, y, z] = slab.voxel(word);
                set_bits(slab.words[word]).map(move |behind| [x + behind, y, z])
            })
        })
    }

    /// A byte a voxel, 1 where it is set, in the order `[z][y][x]`.
    pub fn bytes(&self) -> Vec<u8> {
        let size = self.grid().size().map(|n| n as usize);
        let mut bytes = Vec::with_capacity(size.iter().product());
        for slab in self.slabs([0, 1, 2]) {
            for row in slab.rows() {
                bytes.extend((0..size[0]).map(|x| (row[x / 64] >> (x % 64)) as u8 & 1));
            }
        }
        bytes
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::techniques::voxel::{Axis, Grid};

    /// Voxels at random, along each axis and in bricks.
    fn all(grid: &Grid) -> Vec<Voxels> {
        let mut random = 0x2545_f491_4f6c_dd1d_u64;
        let mut next = || {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            (random >> 32) as u32 & (random as u32)
        };
        // Bits beyond the grid, too, do no harm.
        let mut stores: Vec<_> = [Axis::X, Axis::Y, Axis::Z]
            .map(|axis| Store::Columns { axis, words: (0..grid.words(axis)).map(|_| next()).collect() })
            .into();
        let coarse = Voxels::from_fn(&grid.bricks(), |[x, y, z]| (x + y + z) % 2 == 0);
        let mut count = 0;
        let first = |word: &u32| {
            count += word.count_ones();
            count - word.count_ones()
        };
        let firsts = coarse.words().iter().map(first).collect();
        let bricks = (0..count).map(|_| std::array::from_fn(|_| next())).collect();
        stores.push(Store::Bricks { coarse: Box::new(coarse), firsts, bricks });
        stores.into_iter().map(|store| Voxels { grid: *grid, store }).collect()
    }

    #[test]
    fn slabs_hold_every_voxel_in_any_order() {
        let grid = Grid::new(Vec3::ZERO, 1.0, [70, 41, 95]).unwrap();
        for voxels in all(&grid) {
            for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
                let [along, rows, slices] = order.map(|world| grid.size()[world]);
                let found: Vec<Vec<u64>> = voxels
                    .slabs(order)
                    .flat_map(|slab| slab.slices().map(<[u64]>::to_vec).collect::<Vec<_>>())
                    .collect();
                assert_eq!(found.len(), slices as usize);
                for [k, j, i] in
                    (0..slices).flat_map(|k| (0..rows).flat_map(move |j| (0..along).map(move |i| [k, j, i])))
                {
                    let word = found[k as usize][(j * along.div_ceil(64) + i / 64) as usize];
                    let mut voxel = [0; 3];
                    order.into_iter().zip([i, j, k]).for_each(|(world, own)| voxel[world] = own);
                    assert_eq!(word >> (i % 64) & 1 == 1, voxels.get(voxel), "{order:?} {voxel:?}");
                }
                let set = found.iter().flatten().map(|word| word.count_ones()).sum::<u32>();
                assert_eq!(set as usize, grid.voxels().filter(|&voxel| voxels.get(voxel)).count(), "{order:?}");
            }
            let expected: Vec<_> = grid.voxels().filter(|&voxel| voxels.get(voxel)).collect();
            assert!(expected.len() > 10_000 && voxels.set().eq(expected));
            assert!(voxels.bytes().into_iter().eq(grid.voxels().map(|voxel| u8::from(voxels.get(voxel)))));
        }
    }
}

//! binvox: a text header, then pairs of bytes, a value and how often it comes. y runs fastest, then z, then x.

use std::io::Write;
use std::path::Path;

use super::super::write_atomically;
use crate::Result;
use crate::techniques::voxel::Voxels;

/// Longest run of a pair.
const LONGEST: u8 = u8::MAX;

pub(super) fn write(path: &Path, voxels: &Voxels) -> Result<()> {
    let grid = voxels.grid();
    let [width, height, depth] = grid.size();
    let [x, y, z] = grid.min().to_array();
    // The side of the cube that the voxels would fill.
    let side = grid.edge() * width.max(height).max(depth) as f32;
    let header = format!("#binvox 1\ndim {width} {depth} {height}\ntranslate {x} {y} {z}\nscale {side}\ndata\n");
    write_atomically(path, |file| {
        file.write_all(header.as_bytes())?;
        let (mut run, mut length) = (false, 0);
        for slab in voxels.slabs([1, 2, 0]) {
            for row in slab.rows() {
                for value in (0..height as usize).map(|y| row[y / 64] >> (y % 64) & 1 == 1) {
                    if value != run || length == LONGEST {
                        if length > 0 {
                            file.write_all(&[run.into(), length])?;
                        }
                        (run, length) = (value, 0);
                    }
                    length += 1;
                }
            }
        }
        file.write_all(&[run.into(), length])
    })
}

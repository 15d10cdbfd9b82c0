//! A picture of slices.

use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use super::super::write_atomically;
use super::too_many;
use crate::Result;
use crate::techniques::voxel::Voxels;

/// Of a picture's side, in pixels.
const MOST: u32 = 4096;

/// Greys of set and other voxels, and of the lines between slices.
const SET: u8 = 235;
const CLEAR: u8 = 20;
const LINE: u8 = 90;

pub(super) fn write(path: &Path, voxels: &Voxels) -> Result<()> {
    let [width, height, depth] = voxels.grid().size();
    let fit = |size: u32| ((MOST - 1) / (size + 1)).max(1);
    let count = depth.min(fit(width) * fit(height));
    let square = (count as f32).sqrt().ceil() as u32;
    let across = count.min(fit(width)).min(square.max(count.div_ceil(fit(height))));
    let down = count.div_ceil(across);
    let size = [across * (width + 1) + 1, down * (height + 1) + 1];
    let mut pixels = vec![LINE; size[0] as usize * size[1] as usize];
    for tile in 0..count {
        // The middles of equal shares of the depth.
        let z = ((2 * tile + 1) * depth / (2 * count)).min(depth - 1);
        let [left, top] = [tile % across * (width + 1) + 1, tile / across * (height + 1) + 1];
        for [x, y] in (0..height).flat_map(|y| (0..width).map(move |x| [x, y])) {
            let value = if voxels.get([x, height - 1 - y, z]) { SET } else { CLEAR };
            pixels[(top + y) as usize * size[0] as usize + (left + x) as usize] = value;
        }
    }
    let mut bytes = Vec::new();
    let encoded = PngEncoder::new(&mut bytes).write_image(&pixels, size[0], size[1], ExtendedColorType::L8);
    encoded.map_err(|error| too_many(path, error.to_string()))?;
    write_atomically(path, |file| std::io::Write::write_all(file, &bytes))
}

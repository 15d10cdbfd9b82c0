//! Mip levels of textures, made on the host: the same texels on every driver, and no shader that a driver compiles
//! for each format and size before the first frame.

use std::sync::LazyLock;

use super::Texture;
use crate::gpu::linear_from_srgb;

/// Levels 1 and up of a texture, each RGBA with 8 bits a channel: level `k + 1` is level `k` sampled linearly at its
/// texel centres, which for even sizes is the average of 2×2 texels. Colours are averaged as light where they are
/// sRGB-encoded.
pub(super) fn levels(texture: &Texture, srgb: bool) -> Vec<Vec<u8>> {
    static SRGB: LazyLock<Coding> = LazyLock::new(Coding::srgb);
    static LINEAR: LazyLock<Coding> = LazyLock::new(Coding::linear);
    let coding: &Coding = if srgb { &SRGB } else { &LINEAR };
    let count = texture.size[0].max(texture.size[1]).max(1).ilog2();
    let mut size = texture.size.map(|size| size as usize);
    let mut levels: Vec<Vec<u8>> = Vec::with_capacity(count as usize);
    for level in 0..count as usize {
        let above = if level == 0 { &texture.pixels[..] } else { &levels[level - 1][..] };
        let next = half(above, size, coding);
        size = size.map(|size| (size / 2).max(1));
        levels.push(next);
    }
    levels
}

/// Bits of linear light that colours are averaged in.
const LIGHT_BITS: u32 = 16;
/// Alpha, and colours that are no light: 8 bits and as many behind the point.
const PLAIN_BITS: u32 = 8;

/// How 8-bit values become fixed-point light and back.
struct Coding {
    /// For colours; alpha is plain.
    decode: [u32; 256],
    /// Of the highest bits of light; `None`: plain as well.
    encode: Option<Vec<u8>>,
}

impl Coding {
    fn linear() -> Self {
        Self { decode: std::array::from_fn(|v| (v as u32) << PLAIN_BITS), encode: None }
    }

    fn srgb() -> Self {
        let top = f64::from((1u32 << LIGHT_BITS) - 1);
        let light = |code: f64| (linear_from_srgb(code / 255.0) * top).round() as u32;
        // A code stands for all light nearer to it than to its neighbours, as seen in the encoding.
        let mut encode = vec![255; 1 << LIGHT_BITS];
        let mut first = 0;
        for code in 0..255u8 {
            let end = light(f64::from(code) + 0.5) as usize;
            encode[first..end].fill(code);
            first = end;
        }
        Self { decode: std::array::from_fn(|code| light(code as f64)), encode: Some(encode) }
    }

    fn color(&self, light: u32) -> u8 {
        match &self.encode {
            Some(codes) => codes.get(light as usize).copied().unwrap_or(255),
            None => plain(light),
        }
    }
}

fn plain(value: u32) -> u8 {
    ((value + (1 << (PLAIN_BITS - 1))) >> PLAIN_BITS).min(255) as u8
}

/// Where a texel of the next level lies between two of this one: their indices, and the second's share in 1/256.
fn taps(size: usize) -> Vec<(usize, usize, u32)> {
    let next = (size / 2).max(1);
    let tap = |k: usize| {
        let place = (k as f64 + 0.5) * size as f64 / next as f64 - 0.5;
        let low = place.floor().max(0.0) as usize;
        (low, (low + 1).min(size - 1), ((place - place.floor()) * 256.0).round() as u32)
    };
    (0..next).map(tap).collect()
}

fn half(above: &[u8], [width, height]: [usize; 2], coding: &Coding) -> Vec<u8> {
    let (columns, rows) = (taps(width), taps(height));
    let texels = above.as_chunks::<4>().0;
    let mut next = vec![0; 4 * columns.len() * rows.len()];
    for (row, &(y0, y1, t)) in next.chunks_exact_mut(4 * columns.len()).zip(&rows) {
        let (upper, lower) = (&texels[y0 * width..][..width], &texels[y1 * width..][..width]);
        for (texel, &(x0, x1, s)) in row.as_chunks_mut::<4>().0.iter_mut().zip(&columns) {
            let corners = [upper[x0], upper[x1], lower[x0], lower[x1]];
            // In 1/65536: with 16 bits of light the sum still fits into 32.
            let weights = [(256 - s) * (256 - t), s * (256 - t), (256 - s) * t, s * t];
            let mut sums = [1_u32 << 15; 4];
            for ([r, g, b, a], weight) in corners.into_iter().zip(weights) {
                sums[0] += coding.decode[usize::from(r)] * weight;
                sums[1] += coding.decode[usize::from(g)] * weight;
                sums[2] += coding.decode[usize::from(b)] * weight;
                sums[3] += (u32::from(a) << PLAIN_BITS) * weight;
            }
            let [r, g, b, a] = sums;
            *texel = [coding.color(r >> 16), coding.color(g >> 16), coding.color(b >> 16), plain(a >> 16)];
        }
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Filter, Wrap};

    fn texture(size: [u32; 2], texel: impl Fn(u32) -> [u8; 4]) -> Texture {
        let pixels: Vec<u8> = (0..size[0] * size[1]).flat_map(texel).collect();
        let (wrap, mip) = ([Wrap::Repeat; 2], Some(Filter::Linear));
        let (magnify, minify) = (Filter::Linear, Filter::Linear);
        Texture { name: "t".into(), size, pixels: pixels.into(), wrap, magnify, minify, mip }
    }

    #[test]
    fn light_is_averaged_and_numbers_are() {
        // Half black, half white is 188 of sRGB, and 128 of plain numbers.
        let board = texture([4, 4], |k| [if (k + k / 4) % 2 == 0 { 0 } else { 255 }; 4]);
        let light = levels(&board, true);
        assert_eq!(
            (light.len(), &light[0][..4], &light[1][..]),
            (2, &[188, 188, 188, 128][..], &[188, 188, 188, 128][..])
        );
        assert_eq!(levels(&board, false)[1], [128; 4]);
    }

    #[test]
    fn one_colour_stays() {
        for value in 0..=255u8 {
            let flat = texture([5, 3], |_| [value, value, value, value]);
            for srgb in [false, true] {
                let made = levels(&flat, srgb);
                assert_eq!(made.len(), 2);
                assert!(made.iter().flatten().all(|&v| v == value), "{value} {srgb} {made:?}");
            }
        }
    }

    #[test]
    fn odd_sizes_keep_their_centres() {
        // 3 texels become 1, sampled at the middle; a single row stays one.
        let ramp = texture([3, 1], |k| [(k * 100) as u8, 0, 0, 255]);
        assert_eq!(levels(&ramp, false), [vec![100, 0, 0, 255]]);
    }
}

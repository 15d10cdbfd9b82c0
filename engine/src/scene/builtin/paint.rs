//! Textures from functions of a point: base colour, normal map and metallic-roughness map of one surface at once.

use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3, vec2};

use super::random::{hash, step};
use crate::scene::{Filter, Texture, TextureSlot, Wrap};

/// A surface at one point.
#[derive(Clone, Copy, Debug)]
pub struct Texel {
    /// sRGB-encoded.
    pub color: Vec3,
    /// Coverage.
    pub alpha: f32,
    /// Metres above the mean surface.
    pub height: f32,
    /// Perceptual.
    pub roughness: f32,
    /// 0 or 1, or between where both meet.
    pub metallic: f32,
}

impl Default for Texel {
    fn default() -> Self {
        Self { color: Vec3::ONE, alpha: 1.0, height: 0.0, roughness: 1.0, metallic: 0.0 }
    }
}

/// Texels of a square, rows from the top.
pub struct Painting {
    size: u32,
    /// Metres that the square covers.
    extent: Vec2,
    /// With coverage.
    colors: Vec<[u8; 4]>,
    heights: Vec<f32>,
    /// Roughness, metallic.
    finish: Vec<[u8; 2]>,
}

impl Painting {
    /// Evaluates `texel` at the middle of every texel, in 0 to 1 with v down.
    pub fn new(size: u32, extent: Vec2, texel: impl Fn(Vec2) -> Texel) -> Self {
        let count = (size * size) as usize;
        let (mut colors, mut heights, mut finish) = (vec![[0; 4]; count], vec![0.0; count], vec![[0; 2]; count]);
        let at = |i: u32| (i as f32 + 0.5) / size as f32;
        for i in 0..count {
            let p = vec2(at(i as u32 % size), at(i as u32 / size));
            let Texel { color, alpha, height, roughness, metallic } = texel(p);
            colors[i] = [byte(color.x), byte(color.y), byte(color.z), byte(alpha)];
            heights[i] = height;
            finish[i] = [byte(roughness), byte(metallic)];
        }
        Self { size, extent, colors, heights, finish }
    }

    /// Base colour with coverage.
    pub fn base_color(&self, name: &str) -> Texture {
        self.texture(name, |i| self.colors[i])
    }

    /// Roughness in G, metallic in B.
    pub fn metallic_roughness(&self, name: &str) -> Texture {
        self.texture(name, |i| [255, self.finish[i][0], self.finish[i][1], 255])
    }

    /// Tangent-space normals of the heights; the surface goes on beyond the edges as the other side begins.
    pub fn normal(&self, name: &str) -> Texture {
        let n = self.size as usize;
        let pitch = self.extent / self.size as f32;
        let heights = &self.heights;
        self.texture(name, |i| {
            let (x, row) = (i % n, i - i % n);
            let next = if x + 1 == n { row } else { i + 1 };
            let last = if x == 0 { row + n - 1 } else { i - 1 };
            let below = if i + n >= n * n { x } else { i + n };
            let above = if row == 0 { n * n - n + x } else { i - n };
            let right = (heights[next] - heights[last]) / (2.0 * pitch.x);
            let down = (heights[below] - heights[above]) / (2.0 * pitch.y);
            let normal = Vec3::new(-right, down, 1.0).normalize() * 0.5 + 0.5;
            [byte(normal.x), byte(normal.y), byte(normal.z), 255]
        })
    }

    fn texture(&self, name: &str, pixel: impl Fn(usize) -> [u8; 4]) -> Texture {
        let mut pixels = vec![0; self.colors.len() * 4];
        for (i, bytes) in pixels.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            *bytes = pixel(i);
        }
        Texture {
            name: name.into(),
            size: [self.size; 2],
            pixels: Arc::from(pixels),
            wrap: [Wrap::Repeat; 2],
            magnify: Filter::Linear,
            minify: Filter::Linear,
            mip: Some(Filter::Linear),
        }
    }
}

/// Use of a texture that covers a square of `extent` metres by coordinates in metres.
pub fn slot(texture: usize, extent: Vec2) -> TextureSlot {
    TextureSlot { texture, uv_set: 0, transform: Mat3::from_scale(1.0 / extent) }
}

#[inline]
fn byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// Where a point lies in a wall of blocks in staggered rows.
pub struct Block {
    /// 0 to 1, for each block its own.
    pub id: f32,
    /// Another one.
    pub other: f32,
    /// Metres to the nearest edge of the block.
    pub edge: f32,
}

/// Rows of blocks over the unit square, which is `extent` metres large. Each row is shifted by `stagger` of a block;
/// the square repeats where `rows * stagger` is whole.
#[inline]
pub fn blocks(p: Vec2, extent: Vec2, columns: u32, rows: u32, stagger: f32, seed: u32) -> Block {
    let y = p.y * rows as f32;
    let row = (y.floor() as i32).rem_euclid(rows as i32) as u32;
    let x = (p.x * columns as f32 + stagger * row as f32).rem_euclid(columns as f32);
    let column = x.floor() as u32 % columns;
    let near = |f: f32| f.min(1.0 - f);
    let edge_x = near(x.fract()) * extent.x / columns as f32;
    let edge_y = near(y.rem_euclid(1.0)) * extent.y / rows as f32;
    Block { id: hash(column, row, seed), other: hash(column, row, seed ^ 0x55), edge: edge_x.min(edge_y) }
}

/// How much a point is inside a leaf: 1 within, 0 outside, soft over one or two texels. The leaf runs from `base`
/// along `axis` with half its `width` to each side. With it, how far from the midrib (0) to the edge (1).
#[inline]
pub fn leaf(p: Vec2, base: Vec2, axis: Vec2, width: f32) -> Option<(f32, f32)> {
    let from_base = p - base;
    let square = axis.length_squared();
    let t = from_base.dot(axis) / square;
    let side = from_base.perp_dot(axis).abs();
    if !(0.0..=1.0).contains(&t) || side * side > 1.4 * width * width * square {
        return None;
    }
    let side = side / square.sqrt();
    let half = width * (t * std::f32::consts::PI).sin().powf(0.8) * (1.15 - 0.4 * t);
    (side < half).then(|| (1.0 - step(half - 0.006, half, side), side / half.max(1e-6)))
}

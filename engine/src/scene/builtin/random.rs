//! Numbers that look random and are the same on every run.

use glam::{Vec2, Vec3, vec3};

/// A permuted congruential generator (O'Neill 2014, PCG-XSH-RR 64/32).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A sequence of its own for each seed.
    pub fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        random.bits();
        random
    }

    /// 32 bits.
    pub fn bits(&mut self) -> u32 {
        let state = self.0;
        self.0 = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = ((state >> 18 ^ state) >> 27) as u32;
        mixed.rotate_right((state >> 59) as u32)
    }

    /// From 0 up to, not including, 1.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / 16_777_216.0
    }

    /// From `low` up to `high`.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vec3 {
        let y = self.between(-1.0, 1.0);
        let (sin, cos) = self.between(0.0, std::f32::consts::TAU).sin_cos();
        let r = (1.0 - y * y).max(0.0).sqrt();
        vec3(r * cos, y, r * sin)
    }
}

/// 0 to 1, from a lattice point.
#[inline]
pub fn hash(x: u32, y: u32, seed: u32) -> f32 {
    let mut h = x.wrapping_mul(0x8da6_b343) ^ y.wrapping_mul(0xd816_3841) ^ seed.wrapping_mul(0xcb1a_b31f);
    h = (h ^ h >> 15).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ h >> 12).wrapping_mul(0x297a_2d39);
    ((h ^ h >> 15) >> 8) as f32 / 16_777_216.0
}

/// Fractal noise over the unit square that repeats without a seam, from a table.
pub struct Noise {
    table: Vec<f32>,
}

impl Noise {
    const SIZE: u32 = 256;

    /// Five octaves of value noise, from 4 to 64 cells.
    pub fn new(seed: u32) -> Self {
        let mut table = vec![0.0; (Self::SIZE * Self::SIZE) as usize];
        for octave in 0..5 {
            let cells = 4u32 << octave;
            let weight = 0.5f32.powi(octave + 1) / (1.0 - 0.5f32.powi(5));
            let width = Self::SIZE / cells;
            let ease: Vec<f32> = (0..width).map(|i| smooth(i as f32 / width as f32)).collect();
            let lattice: Vec<f32> = (0..cells * cells)
                .map(|i| hash(i % cells, i / cells, seed.wrapping_add(octave as u32 * 101)))
                .collect();
            let corner = |x: u32, y: u32| lattice[((y % cells) * cells + x % cells) as usize];
            for (i, value) in table.iter_mut().enumerate() {
                let (x, y) = (i as u32 % Self::SIZE, i as u32 / Self::SIZE);
                let (cx, cy) = (x / width, y / width);
                let (fx, fy) = (ease[(x % width) as usize], ease[(y % width) as usize]);
                let low = corner(cx, cy) + (corner(cx + 1, cy) - corner(cx, cy)) * fx;
                let high = corner(cx, cy + 1) + (corner(cx + 1, cy + 1) - corner(cx, cy + 1)) * fx;
                *value += weight * (low + (high - low) * fy);
            }
        }
        Self { table }
    }

    /// 0 to 1, with period 1 in both directions.
    #[inline]
    pub fn at(&self, p: Vec2) -> f32 {
        let p = p * Self::SIZE as f32;
        let cell = p.floor();
        let f = p - cell;
        let mask = Self::SIZE as i32 - 1;
        let (x, y) = (cell.x as i32, cell.y as i32);
        let value = |x: i32, y: i32| self.table[((y & mask) * Self::SIZE as i32 + (x & mask)) as usize];
        let low = value(x, y) + (value(x + 1, y) - value(x, y)) * f.x;
        let high = value(x, y + 1) + (value(x + 1, y + 1) - value(x, y + 1)) * f.x;
        low + (high - low) * f.y
    }
}

/// 3t² − 2t³, between 0 and 1.
#[inline]
pub fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// 0 below `low`, 1 above `high`, smooth between.
#[inline]
pub fn step(low: f32, high: f32, x: f32) -> f32 {
    smooth((x - low) / (high - low))
}

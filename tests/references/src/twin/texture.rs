//! Textures: level of detail and filtering as the Vulkan specification defines them (chapter "Image Operations"),
//! and a chain of levels made like a chain of linear blits.
//!
//! - Texels are decoded from sRGB before they are filtered.
//! - Level `k + 1` is level `k` sampled linearly at its texel centres (`vkCmdBlitImage`, `VK_FILTER_LINEAR`), stored
//!   in 8 bits, in the texture's encoding. For even sizes this is the average of 2×2 texels.
//! - λ = log2(max(ρx, ρy)), ρx = |(∂u/∂x · width, ∂v/∂x · height)|. λ ≤ 0 magnifies; else the minification filter
//!   applies, in the nearest level or between two levels, as the sampler's mip filter says.
//!
//! Drivers may filter with few bits of weight (8 are common), so a sampled value can differ by about 1/255.

use glam::{DVec2, DVec4};
use shadowgraph::scene::{Filter, Texture, Wrap};

/// A chain of levels, decoded on access.
pub struct Levels {
    levels: Vec<Level>,
    srgb: bool,
    decode: [f64; 256],
}

struct Level {
    size: [i64; 2],
    texels: Vec<[u8; 4]>,
}

impl Levels {
    /// The chain of a texture whose colour channels are sRGB-encoded or linear.
    pub fn new(texture: &Texture, srgb: bool) -> Self {
        let decode = std::array::from_fn(|k| decode_srgb(k as f64 / 255.0));
        let texels = texture.pixels.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
        let size = texture.size.map(i64::from);
        let mut chain = Self { levels: vec![Level { size, texels }], srgb, decode };
        if texture.mip.is_some() {
            while chain.levels[chain.levels.len() - 1].size != [1, 1] {
                let next = chain.half(chain.levels.len() - 1);
                chain.levels.push(next);
            }
        }
        chain
    }

    /// Number of levels.
    pub fn count(&self) -> usize {
        self.levels.len()
    }

    /// Linear RGBA at texture coordinates and a level of detail.
    pub fn sample(&self, texture: &Texture, uv: DVec2, lambda: f64) -> DVec4 {
        let Some(mip) = texture.mip else {
            return self.level(0, texture, uv, if lambda <= 0.0 { texture.magnify } else { texture.minify });
        };
        if lambda <= 0.0 {
            return self.level(0, texture, uv, texture.magnify);
        }
        // NaN (a surface seen edge-on) goes to the last level.
        let top = (self.levels.len() - 1) as f64;
        let lambda = if lambda < top { lambda } else { top };
        match mip {
            // The specification's rounding: ⌈λ + ½⌉ − 1.
            Filter::Nearest => self.level(((lambda + 0.5).ceil() - 1.0) as usize, texture, uv, texture.minify),
            Filter::Linear => {
                let (low, t) = (lambda.floor(), lambda.fract());
                let high = (low + 1.0).min(top);
                self.level(low as usize, texture, uv, texture.minify) * (1.0 - t)
                    + self.level(high as usize, texture, uv, texture.minify) * t
            }
        }
    }

    fn level(&self, index: usize, texture: &Texture, uv: DVec2, filter: Filter) -> DVec4 {
        let level = &self.levels[index];
        let fetch = |x: f64, y: f64| {
            let x = wrap(x, level.size[0], texture.wrap[0]);
            let y = wrap(y, level.size[1], texture.wrap[1]);
            self.texel(level, x, y)
        };
        let p = uv * DVec2::new(level.size[0] as f64, level.size[1] as f64);
        match filter {
            Filter::Nearest => fetch(p.x.floor(), p.y.floor()),
            Filter::Linear => {
                let p = p - 0.5;
                let (i, t) = (p.floor(), p - p.floor());
                let top = fetch(i.x, i.y) * (1.0 - t.x) + fetch(i.x + 1.0, i.y) * t.x;
                let bottom = fetch(i.x, i.y + 1.0) * (1.0 - t.x) + fetch(i.x + 1.0, i.y + 1.0) * t.x;
                top * (1.0 - t.y) + bottom * t.y
            }
        }
    }

    fn texel(&self, level: &Level, x: i64, y: i64) -> DVec4 {
        let [r, g, b, a] = level.texels[(y * level.size[0] + x) as usize];
        let color = |v: u8| if self.srgb { self.decode[v as usize] } else { f64::from(v) / 255.0 };
        DVec4::new(color(r), color(g), color(b), f64::from(a) / 255.0)
    }

    fn half(&self, index: usize) -> Level {
        let from = &self.levels[index];
        let size = from.size.map(|n| (n / 2).max(1));
        let encode = |v: f64| (if self.srgb { encode_srgb(v) } else { v } * 255.0).round() as u8;
        let texel = |x: i64, y: i64| {
            let at = |k: i64, axis: usize| {
                let p = (k as f64 + 0.5) * from.size[axis] as f64 / size[axis] as f64 - 0.5;
                let clamp = |v: f64| (v as i64).clamp(0, from.size[axis] - 1);
                (clamp(p.floor()), clamp(p.floor() + 1.0), p - p.floor())
            };
            let ((x0, x1, s), (y0, y1, t)) = (at(x, 0), at(y, 1));
            let value = (self.texel(from, x0, y0) * (1.0 - s) + self.texel(from, x1, y0) * s) * (1.0 - t)
                + (self.texel(from, x0, y1) * (1.0 - s) + self.texel(from, x1, y1) * s) * t;
            [encode(value.x), encode(value.y), encode(value.z), (value.w * 255.0).round() as u8]
        };
        let texels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
        Level { size, texels }
    }
}

/// λ of a texture of `size` texels, from the change of its coordinates by a pixel in x and in y.
pub fn level_of_detail(size: [u32; 2], dx: DVec2, dy: DVec2) -> f64 {
    let size = DVec2::new(f64::from(size[0]), f64::from(size[1]));
    (dx * size).length().max((dy * size).length()).log2()
}

fn wrap(index: f64, size: i64, mode: Wrap) -> i64 {
    // Beyond what an index holds, any texel is as good as another.
    let i = index as i64;
    match mode {
        Wrap::Repeat => i.rem_euclid(size),
        Wrap::ClampToEdge => i.clamp(0, size - 1),
        Wrap::MirroredRepeat => {
            let k = i.rem_euclid(2 * size);
            if k < size { k } else { 2 * size - 1 - k }
        }
    }
}

/// IEC 61966-2-1: linear from encoded, both 0 to 1.
pub fn decode_srgb(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// IEC 61966-2-1: encoded from linear, both 0 to 1.
pub fn encode_srgb(v: f64) -> f64 {
    if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(size: [u32; 2], pixels: Vec<u8>, wrap: Wrap, filter: Filter) -> Texture {
        let (magnify, minify, mip) = (filter, filter, Some(Filter::Linear));
        Texture { name: "t".into(), size, pixels: pixels.into(), wrap: [wrap; 2], magnify, minify, mip }
    }

    /// Alpha ramp 0, 85, 170, 255 along x.
    fn ramp(wrap: Wrap, filter: Filter) -> Texture {
        texture([4, 1], (0..4).flat_map(|k| [0, 0, 0, k * 85]).collect(), wrap, filter)
    }

    #[test]
    fn wraps_and_filters() {
        let alpha = |wrap, filter, u| {
            let t = ramp(wrap, filter);
            Levels::new(&t, false).sample(&t, DVec2::new(u, 0.5), 0.0).w * 3.0
        };
        use Filter::{Linear, Nearest};
        let cases = [
            (Wrap::Repeat, Nearest, 0.3, 1.0),
            (Wrap::Repeat, Nearest, 1.3, 1.0),
            (Wrap::Repeat, Nearest, -0.1, 3.0),
            (Wrap::ClampToEdge, Nearest, -0.1, 0.0),
            (Wrap::ClampToEdge, Nearest, 1.1, 3.0),
            (Wrap::MirroredRepeat, Nearest, -0.3, 1.0),
            (Wrap::MirroredRepeat, Nearest, 1.3, 2.0),
            (Wrap::Repeat, Linear, 0.25, 0.5),
            (Wrap::Repeat, Linear, 0.0, 1.5),
            (Wrap::ClampToEdge, Linear, 0.0, 0.0),
            (Wrap::ClampToEdge, Linear, 0.375, 1.0),
        ];
        for (wrap, filter, u, expected) in cases {
            let found = alpha(wrap, filter, u);
            assert!((found - expected).abs() < 1e-12, "{wrap:?} {filter:?} {u}: {found}, not {expected}");
        }
    }

    #[test]
    fn levels_average_in_linear_light() {
        // Half black and half white: 0.5 in linear light, 188 in sRGB; 128 where the values are linear already.
        let pixels: Vec<u8> = (0..16).flat_map(|k| [if (k + k / 4) % 2 == 0 { 0 } else { 255 }; 4]).collect();
        let t = texture([4, 4], pixels, Wrap::Repeat, Filter::Linear);
        let color = Levels::new(&t, true);
        assert_eq!(color.count(), 3);
        assert!((color.sample(&t, DVec2::splat(0.3), 2.0).x - 0.5).abs() < 0.005);
        assert_eq!(color.levels[1].texels[0], [188, 188, 188, 128]);
        assert_eq!(Levels::new(&t, false).levels[2].texels, [[128; 4]]);
    }

    #[test]
    fn level_of_detail_counts_texels_a_pixel() {
        let lambda = level_of_detail([256, 64], DVec2::new(4.0 / 256.0, 0.0), DVec2::new(0.0, 1.0 / 64.0));
        assert_eq!(lambda, 2.0);
        let t = ramp(Wrap::Repeat, Filter::Linear);
        let levels = Levels::new(&t, false);
        assert_eq!(levels.count(), 3);
        let at = |lambda| levels.sample(&t, DVec2::new(0.5, 0.5), lambda).w;
        assert!((at(1.25) - (at(1.0) * 0.75 + at(2.0) * 0.25)).abs() < 1e-12);
        assert_eq!(at(f64::NAN), at(2.0));
        assert_eq!(at(f64::NEG_INFINITY), at(0.0));
    }

    #[test]
    fn srgb_curve_is_its_own_inverse() {
        for k in 0..=255 {
            let v = f64::from(k) / 255.0;
            assert!((encode_srgb(decode_srgb(v)) - v).abs() < 1e-6);
        }
    }
}

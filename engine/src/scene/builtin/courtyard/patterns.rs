//! What the courtyard's surfaces look like at each point of their textures.

use std::sync::LazyLock;

use glam::{Vec2, Vec3, vec2, vec3};

use crate::scene::builtin::{
    paint::{Block, Texel, blocks, leaf},
    random::{Noise, hash, step},
};

/// Two noises at whole multiples of the period, so that textures repeat.
fn grain(noise: &Noise, p: Vec2, coarse: f32, fine: f32) -> (f32, f32) {
    (noise.at(p * coarse) - 0.5, noise.at(p * fine + vec2(0.37, 0.71)) - 0.5)
}

/// Rows of limestone blocks 75 cm × 40 cm.
pub fn ashlar(noise: &Noise, p: Vec2) -> Texel {
    let (coarse, fine) = grain(noise, p, 1.0, 5.0);
    let Block { id, other, edge } = blocks(p, vec2(3.0, 2.4), 4, 6, 0.5, 11);
    let inside = step(0.004, 0.022, edge + fine * 0.012);
    let tint = vec3(0.83, 0.765, 0.645) * (0.9 + 0.16 * id) + vec3(0.03, 0.0, -0.03) * (other - 0.5);
    let color = vec3(0.60, 0.55, 0.47).lerp(tint + 0.16 * coarse + 0.1 * fine, 0.35 + 0.65 * inside);
    Texel { color, height: 0.012 * inside + 0.008 * fine + 0.003 * other, ..Texel::default() }
}

/// Worn flagstones 72 cm × 60 cm with moss in the joints.
pub fn paving(noise: &Noise, p: Vec2) -> Texel {
    let (coarse, fine) = grain(noise, p, 2.0, 9.0);
    let Block { id, other, edge } = blocks(p, vec2(3.6, 3.6), 5, 6, 0.5, 23);
    let inside = step(0.003, 0.016, edge + fine * 0.01);
    let grey = vec3(0.66, 0.62, 0.56);
    let warm = vec3(0.72, 0.60, 0.48);
    let tint = grey.lerp(warm, step(0.6, 0.9, other)) * (0.84 + 0.26 * id);
    let moss = vec3(0.36, 0.38, 0.24).lerp(vec3(0.42, 0.38, 0.32), step(-0.1, 0.1, coarse));
    let color = moss.lerp(tint + 0.14 * coarse + 0.08 * fine, inside);
    let polish = step(-0.08, 0.14, coarse);
    Texel {
        color,
        height: 0.010 * inside + 0.004 * fine + 0.003 * id,
        roughness: 0.92 - 0.34 * inside * polish,
        ..Texel::default()
    }
}

/// White stone with bent veins.
pub fn marble(noise: &Noise, p: Vec2) -> Texel {
    let bend = vec2(noise.at(p * 2.0), noise.at(p * 2.0 + vec2(0.5, 0.2))) * 0.25;
    let vein = (noise.at(p + bend) - 0.5).abs();
    let fine = (noise.at((p + bend) * 3.0) - 0.5).abs();
    let dark = (1.0 - step(0.0, 0.05, vein)) * 0.32 + (1.0 - step(0.0, 0.04, fine)) * 0.14;
    let cloud = noise.at(p * 2.0 + vec2(0.1, 0.8)) - 0.5;
    let color = (vec3(0.90, 0.865, 0.80) + 0.07 * cloud).lerp(vec3(0.50, 0.46, 0.42), dark);
    Texel { color, roughness: 0.34 + 0.3 * dark + 0.2 * cloud, ..Texel::default() }
}

/// Bricks in stretcher bond.
pub fn brick(noise: &Noise, p: Vec2) -> Texel {
    let (coarse, fine) = grain(noise, p, 1.0, 6.0);
    let Block { id, other, edge } = blocks(p, vec2(1.25, 1.2), 5, 16, 0.5, 31);
    let inside = step(0.003, 0.009, edge + fine * 0.006);
    let tint = vec3(0.64, 0.43, 0.33).lerp(vec3(0.53, 0.34, 0.27), id) * (0.9 + 0.25 * other);
    let color = vec3(0.74, 0.69, 0.60).lerp(tint + 0.12 * fine, inside) + 0.12 * coarse;
    Texel { color, height: 0.006 * inside + 0.004 * fine, ..Texel::default() }
}

/// Boards 20 cm wide.
pub fn planks(noise: &Noise, p: Vec2) -> Texel {
    let board = blocks(p, vec2(2.4, 2.4), 1, 12, 0.0, 41);
    let row = (p.y * 12.0).floor() / 12.0;
    let fibre = noise.at(vec2(p.x, p.y * 12.0 + row * 5.0)) - 0.5;
    let thin = noise.at(vec2(p.x * 2.0, p.y * 48.0)) - 0.5;
    let gap = step(0.0, 0.007, board.edge.max(0.0));
    let color = vec3(0.50, 0.34, 0.21) * (0.82 + 0.36 * board.id) + 0.16 * fibre + 0.10 * thin;
    Texel { color: color * (0.3 + 0.7 * gap), height: 0.006 * gap + 0.004 * thin, ..Texel::default() }
}

/// Fired clay, some of it under lichen.
pub fn roof_tile(noise: &Noise, p: Vec2) -> Texel {
    let (coarse, fine) = grain(noise, p, 1.0, 6.0);
    let id = hash((p.x * 6.0) as u32, (p.y * 4.0) as u32, 5);
    let lichen = step(0.10, 0.22, coarse + fine * 0.3);
    let tint = vec3(0.76, 0.42, 0.28).lerp(vec3(0.62, 0.33, 0.24), id) + 0.14 * fine;
    Texel { color: tint.lerp(vec3(0.60, 0.58, 0.45), lichen * 0.6), ..Texel::default() }
}

/// Lime plaster with stains that run down.
pub fn plaster(noise: &Noise, p: Vec2) -> Texel {
    let (coarse, fine) = grain(noise, p, 1.0, 8.0);
    let stain = step(0.02, 0.25, noise.at(p * vec2(3.0, 1.0)) - 0.5);
    let color = vec3(0.90, 0.76, 0.56) + 0.14 * coarse + 0.05 * fine;
    Texel {
        color: color.lerp(vec3(0.72, 0.60, 0.46), 0.35 * stain),
        height: 0.006 * fine + 0.01 * coarse,
        ..Texel::default()
    }
}

/// Glazed tiles of 22 cm: a star in a ring, blue and yellow on white, four to a pattern.
pub fn azulejo(noise: &Noise, p: Vec2) -> Texel {
    let q = (p * 2.0).fract();
    let c = (q - 0.5).abs();
    let edge = 0.5 - c.x.max(c.y);
    let inside = step(0.008, 0.03, edge);
    let radius = c.length();
    let angle = c.y.atan2(c.x);
    let star = 0.20 + 0.09 * (angle * 4.0).cos();
    let corner = (vec2(0.5, 0.5) - c).length();
    let mut color = vec3(0.92, 0.92, 0.88);
    if (radius - 0.37).abs() < 0.03 || (corner - 0.12).abs() < 0.025 {
        color = vec3(0.12, 0.25, 0.55);
    } else if radius < star {
        color = if radius < star * 0.55 { vec3(0.88, 0.65, 0.18) } else { vec3(0.10, 0.30, 0.60) };
    } else if corner < 0.08 || (c.x - c.y).abs() < 0.02 && radius > 0.42 {
        color = vec3(0.16, 0.45, 0.50);
    }
    let wear = noise.at(p * 2.0) - 0.5;
    let color = vec3(0.70, 0.68, 0.62).lerp(color * (0.96 + 0.14 * wear), inside);
    Texel { color, height: 0.003 * inside, roughness: 0.85 - 0.7 * inside + 0.1 * wear, ..Texel::default() }
}

/// Bronze with patina: bare metal and verdigris.
pub fn bronze(noise: &Noise, p: Vec2) -> Texel {
    let (coarse, fine) = grain(noise, p, 2.0, 7.0);
    let patina = step(0.02, 0.16, coarse + 0.4 * fine);
    let color = (vec3(0.70, 0.53, 0.32) + 0.1 * fine).lerp(vec3(0.33, 0.50, 0.43) + 0.1 * fine, patina);
    Texel { color, roughness: 0.34 + 0.45 * patina + 0.2 * fine, metallic: 1.0 - patina, ..Texel::default() }
}

/// Unglazed clay with turning rings and bloom.
pub fn terracotta(noise: &Noise, p: Vec2) -> Texel {
    let (coarse, fine) = grain(noise, p, 2.0, 8.0);
    let bloom = step(0.0, 0.3, coarse);
    let color = (vec3(0.70, 0.40, 0.27) + 0.1 * fine).lerp(vec3(0.80, 0.66, 0.54), 0.5 * bloom);
    let rings = 0.0015 * (p.y * 24.0 * std::f32::consts::TAU).sin();
    Texel { color, height: rings + 0.003 * fine, ..Texel::default() }
}

/// Cracked bark.
pub fn bark(noise: &Noise, p: Vec2) -> Texel {
    let ridge = (noise.at(p * vec2(4.0, 1.0)) - 0.5).abs();
    let fine = noise.at(p * vec2(10.0, 4.0)) - 0.5;
    let crack = 1.0 - step(0.0, 0.07, ridge);
    let color = (vec3(0.47, 0.39, 0.31) + 0.2 * fine).lerp(vec3(0.20, 0.16, 0.12), crack);
    Texel { color, height: 0.02 * fine - 0.02 * crack, ..Texel::default() }
}

/// Soil with grass.
pub fn earth(noise: &Noise, p: Vec2) -> Texel {
    let (coarse, fine) = grain(noise, p, 2.0, 9.0);
    let grass = step(-0.02, 0.12, coarse);
    let color = vec3(0.32, 0.24, 0.17).lerp(vec3(0.30, 0.36, 0.16), grass) + 0.25 * fine;
    Texel { color, height: 0.03 * fine + 0.02 * coarse, ..Texel::default() }
}

/// A leaf of a card, in the unit square.
struct Leaf {
    base: Vec2,
    axis: Vec2,
    width: f32,
    color: Vec3,
}

/// Where there is no leaf the colour goes on as `ground`, so that filtering shows no rim.
fn sprig(p: Vec2, leaves: &[Leaf], stem: bool, ground: Vec3) -> Texel {
    let mut texel = Texel { color: ground, alpha: 0.0, ..Texel::default() };
    if stem && (p.x - 0.5).abs() < 0.012 && p.y > 0.12 {
        texel = Texel { color: vec3(0.34, 0.30, 0.16), ..Texel::default() };
    }
    for &Leaf { base, axis, width, color } in leaves {
        if let Some((inside, side)) = leaf(p, base, axis, width) {
            let vein = 0.85 + 0.25 * step(0.0, 0.25, side);
            texel.color = texel.color.lerp(color * vein, inside);
            texel.alpha = texel.alpha.max(inside);
        }
    }
    texel
}

/// A sprig of fifteen leaves, its stem at the lower edge.
pub fn leaves(_: &Noise, p: Vec2) -> Texel {
    static LEAVES: LazyLock<Vec<Leaf>> = LazyLock::new(|| {
        let leaf = |i: u32| {
            let side = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
            let (id, other) = (hash(i, 1, 3), hash(i, 2, 3));
            let axis = if i == 14 { vec2(0.0, -0.19) } else { vec2(side * (0.34 + 0.1 * id), -0.10 - 0.12 * other) };
            let color = vec3(0.25, 0.36, 0.15).lerp(vec3(0.44, 0.50, 0.24), id) * (0.85 + 0.3 * other);
            Leaf { base: vec2(0.5, 0.97 - 0.055 * i as f32), axis, width: 0.068, color }
        };
        (0..15).map(leaf).collect()
    });
    sprig(p, &LEAVES, true, vec3(0.33, 0.42, 0.18))
}

/// Nine leaves of three lobes.
pub fn ivy(_: &Noise, p: Vec2) -> Texel {
    static LOBES: LazyLock<Vec<Leaf>> = LazyLock::new(|| {
        let lobes = |i: u32| {
            let center = vec2(0.2 + 0.3 * (i % 3) as f32, 0.24 + 0.3 * (i / 3) as f32);
            let center = center + 0.12 * vec2(hash(i, 3, 9) - 0.5, hash(i, 4, 9) - 0.5);
            let turn = hash(i, 5, 9) * std::f32::consts::TAU;
            let base = center - 0.06 * Vec2::from_angle(turn);
            let color = vec3(0.14, 0.30, 0.10).lerp(vec3(0.34, 0.46, 0.18), hash(i, 6, 9));
            [-1.0f32, 0.0, 1.0].map(|lobe| {
                let axis = (0.19 - 0.04 * lobe.abs()) * Vec2::from_angle(turn + 0.85 * lobe);
                Leaf { base, axis, width: 0.07, color }
            })
        };
        (0..9).flat_map(lobes).collect()
    });
    sprig(p, &LOBES, false, vec3(0.24, 0.38, 0.14))
}

/// Flowers of three colours on stalks.
pub fn flowers(_: &Noise, p: Vec2) -> Texel {
    static STALKS: LazyLock<Vec<Leaf>> = LazyLock::new(|| {
        let stalk = |i: u32| {
            let axis = vec2(0.2 * (hash(i, 1, 17) - 0.5), -0.45 - 0.25 * hash(i, 2, 17));
            Leaf { base: vec2(0.08 + 0.093 * i as f32, 1.0), axis, width: 0.02, color: vec3(0.26, 0.42, 0.16) }
        };
        (0..10).map(stalk).collect()
    });
    let mut texel = sprig(p, &STALKS, false, vec3(0.40, 0.40, 0.25));
    for i in 0..9u32 {
        let center = vec2(0.12 + 0.095 * i as f32, 0.16 + 0.5 * hash(i, 7, 17));
        let from_center = p - center;
        let radius = from_center.length();
        if radius > 0.07 {
            continue;
        }
        let color = match (hash(i, 8, 17) * 3.0) as u32 {
            0 => vec3(0.80, 0.16, 0.34),
            1 => vec3(0.52, 0.34, 0.74),
            _ => vec3(0.93, 0.88, 0.80),
        };
        let angle = from_center.y.atan2(from_center.x);
        let rim = 0.062 * (0.72 + 0.28 * (angle * 5.0).cos().abs());
        if radius < rim {
            let heart = 1.0 - step(0.012, 0.02, radius);
            texel.color = color.lerp(vec3(0.92, 0.72, 0.20), heart) * (0.8 + 0.3 * radius / rim);
            texel.alpha = 1.0;
        }
    }
    texel
}

/// Threads of 3 mm.
fn weave(p: Vec2, threads: f32) -> f32 {
    let q = p * threads * std::f32::consts::PI;
    0.0012 * (q.x.sin() * q.y.sin())
}

/// A sun over waves, gold on crimson, over a banner's whole length.
pub fn banner(noise: &Noise, p: Vec2) -> Texel {
    let fade = noise.at(p * 2.0) - 0.5;
    let gold = vec3(0.86, 0.66, 0.22);
    let mut color = vec3(0.60, 0.07, 0.09);
    let from_sun = (p - vec2(0.5, 0.34)) * vec2(1.0, 2.4);
    let radius = from_sun.length();
    let border = p.x.min(1.0 - p.x);
    let wave = 0.62 + 0.018 * (p.x * 4.0 * std::f32::consts::TAU).sin();
    let rays = radius < 0.30 && radius > 0.20 && (from_sun.y.atan2(from_sun.x) * 8.0).cos() > 0.25;
    let waves = (0..4).any(|i| (p.y - wave - 0.05 * i as f32).abs() < 0.010);
    if radius < 0.165 || rays || waves || (0.05..0.09).contains(&border) || (0.955..0.985).contains(&p.y) {
        color = gold;
    } else if p.y > 0.83 {
        color = vec3(0.12, 0.14, 0.34);
    }
    Texel { color: color * (1.0 + 0.25 * fade), height: weave(p, 128.0), ..Texel::default() }
}

/// Striped canvas.
pub fn sail(noise: &Noise, p: Vec2) -> Texel {
    let fade = noise.at(p) - 0.5;
    let stripe = step(0.47, 0.5, (p.x * 4.0).fract()) * (1.0 - step(0.97, 1.0, (p.x * 4.0).fract()));
    let color = vec3(0.90, 0.85, 0.74).lerp(vec3(0.13, 0.33, 0.50), stripe);
    Texel { color: color * (1.0 + 0.2 * fade), height: weave(p, 128.0), ..Texel::default() }
}

/// Ripples on deep water.
pub fn water(noise: &Noise, p: Vec2) -> Texel {
    let (coarse, fine) = grain(noise, p, 1.0, 3.0);
    let color = vec3(0.13, 0.30, 0.30) + 0.1 * coarse;
    Texel { color, alpha: 0.72, height: 0.05 * coarse + 0.02 * fine, ..Texel::default() }
}

/// Panes of coloured glass in a diamond lattice of lead.
pub fn stained_glass(noise: &Noise, p: Vec2) -> Texel {
    const COLORS: [Vec3; 6] = [
        Vec3::new(0.85, 0.12, 0.12),
        Vec3::new(0.95, 0.70, 0.15),
        Vec3::new(0.10, 0.35, 0.80),
        Vec3::new(0.12, 0.60, 0.32),
        Vec3::new(0.55, 0.20, 0.68),
        Vec3::new(0.90, 0.88, 0.72),
    ];
    let q = vec2(p.x + p.y, p.x - p.y + 1.0) * 3.0;
    let near = q.fract().min(1.0 - q.fract()).min_element();
    // Lattice points that repeat with the square have one colour.
    let cell = q.floor();
    let (x, y) = (((cell.x + cell.y) as i32).rem_euclid(6) as u32, ((cell.x - cell.y) as i32).rem_euclid(6) as u32);
    let pane = COLORS[(hash(x, y, 77) * COLORS.len() as f32) as usize % COLORS.len()];
    let lead = 1.0 - step(0.05, 0.09, near);
    let wobble = noise.at(p * 3.0) - 0.5;
    Texel {
        color: (pane * (1.0 + 0.3 * wobble)).lerp(vec3(0.16, 0.16, 0.17), lead),
        alpha: 0.6 + 0.4 * lead,
        height: 0.004 * lead + 0.004 * wobble,
        ..Texel::default()
    }
}

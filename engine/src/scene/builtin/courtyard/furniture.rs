//! Fountain, planters, pots, benches, lanterns and the glass screen.

use std::f32::consts::TAU;

use glam::{Mat4, Vec3, vec3};

use super::{Parts, Shape, Surface, ring};

/// A flat disc that faces up, with coordinates along x.
fn disc(radius: f32, y: f32, strips: usize) -> Shape {
    let mut shape = Shape::new();
    let edge = |k: usize| {
        let z = radius * 0.999 * (1.0 - 2.0 * k as f32 / strips as f32);
        (z, (radius * radius - z * z).sqrt())
    };
    for k in 0..strips {
        let ((z0, w0), (z1, w1)) = (edge(k), edge(k + 1));
        let corners = [vec3(-w0, y, z0), vec3(w0, y, z0), vec3(w1, y, z1), vec3(-w1, y, z1)];
        shape.face(corners, Vec3::ZERO, Vec3::X);
    }
    shape
}

/// A step with eight sides.
fn octagon(shape: &mut Shape, radius: f32, low: f32, high: f32) {
    let p = |i: usize, y: f32| {
        let (sin, cos) = ((i as f32 + 0.5) / 8.0 * TAU).sin_cos();
        vec3(radius * cos, y, -radius * sin)
    };
    for i in 0..8 {
        shape.quad([p(i, low), p(i + 1, low), p(i + 1, high), p(i, high)]);
    }
    for i in [0, 2, 4] {
        // Quads of a fan around corner 0.
        let corners = [p(0, high), p(i + 1, high), p(i + 2, high), p(i + 3, high)];
        shape.face(corners, Vec3::ZERO, Vec3::X);
    }
}

/// Two steps, a basin, and two bowls on a stem with a bronze pine cone; water runs over the bowls' rims.
pub fn fountain() -> Parts {
    let mut steps = Shape::new();
    octagon(&mut steps, 3.0, 0.0, 0.14);
    octagon(&mut steps, 2.6, 0.14, 0.28);

    let mut marble = Shape::new();
    let basin = [
        [2.06, 0.28],
        [2.06, 0.36],
        [2.06, 0.36],
        [1.98, 0.42],
        [1.95, 0.50],
        [1.98, 0.66],
        [2.06, 0.74],
        [2.06, 0.74],
        [2.14, 0.77],
        [2.16, 0.81],
        [2.14, 0.85],
        [2.14, 0.85],
        [1.86, 0.85],
        [1.86, 0.85],
        [1.80, 0.50],
        [1.70, 0.40],
        [0.30, 0.36],
    ];
    marble.lathe(&basin, 56);
    let stem = [
        [0.40, 0.36],
        [0.40, 0.52],
        [0.40, 0.52],
        [0.30, 0.60],
        [0.22, 0.74],
        [0.24, 0.90],
        [0.32, 1.02],
        [0.30, 1.12],
        [0.18, 1.22],
        [0.15, 1.34],
        [0.20, 1.42],
        [0.20, 1.42],
        [0.55, 1.50],
        [0.92, 1.64],
        [1.06, 1.76],
        [1.08, 1.80],
        [1.08, 1.80],
        [1.00, 1.80],
        [1.00, 1.80],
        [0.90, 1.70],
        [0.50, 1.60],
        [0.16, 1.58],
        [0.16, 1.58],
        [0.12, 1.80],
        [0.17, 1.92],
        [0.12, 2.04],
        [0.12, 2.10],
        [0.12, 2.10],
        [0.30, 2.16],
        [0.52, 2.28],
        [0.55, 2.34],
        [0.55, 2.34],
        [0.49, 2.34],
        [0.49, 2.34],
        [0.40, 2.26],
        [0.08, 2.22],
    ];
    marble.lathe(&stem, 40);

    let mut bronze = Shape::new();
    bronze.lathe(&[[0.10, 2.22], [0.10, 2.30], [0.05, 2.38], [0.05, 2.44], [0.05, 2.44], [0.10, 2.46]], 24);
    bronze.grid([48, 24], true, |s, t| {
        // Scales in two families of spirals.
        let profile = (t * std::f32::consts::PI).sin().max(0.0).powf(0.7) * (1.0 - 0.35 * t);
        let scales = (s * TAU * 8.0 + t * 18.0).sin() * (s * TAU * 8.0 - t * 18.0).sin();
        let r = 0.15 * profile * (1.0 + 0.10 * scales) + 0.002;
        let (sin, cos) = (s * TAU).sin_cos();
        (vec3(r * cos, 2.45 + 0.42 * t, -r * sin), glam::vec2(s * 0.8, -0.42 * t))
    });

    let mut water = disc(1.85, 0.70, 24);
    water.add(&disc(0.97, 1.75, 12), Mat4::IDENTITY);
    water.add(&disc(0.48, 2.31, 8), Mat4::IDENTITY);
    let mut falling = Shape::new();
    for (rim, from, to, reach) in [(1.09, 1.79, 0.70, 0.18), (0.56, 2.33, 1.75, 0.10)] {
        // Falls faster and further out; the outline runs upwards.
        let fall: Vec<[f32; 2]> = (0..=8)
            .map(|i| {
                let t = 1.0 - i as f32 / 8.0;
                [rim + reach * t.sqrt(), from + (to - from) * t]
            })
            .collect();
        falling.lathe(&fall, 40);
    }
    vec![
        (Surface::Ashlar, steps),
        (Surface::Marble, marble),
        (Surface::Bronze, bronze),
        (Surface::Water, water),
        (Surface::FallingWater, falling),
    ]
}

/// A square bed of earth in a stone kerb.
pub fn planter() -> Parts {
    let mut stone = Shape::new();
    let mut coping = Shape::new();
    let (half, wall) = (1.05, 0.2);
    for turn in 0..4 {
        let turn = Mat4::from_rotation_y(turn as f32 * TAU / 4.0);
        let mut kerb = Shape::new();
        kerb.cuboid(vec3(-half, 0.0, half - wall), vec3(half - wall, 0.46, half));
        stone.add(&kerb, turn);
        let mut slab = Shape::new();
        slab.cuboid(vec3(-half - 0.05, 0.46, half - wall - 0.05), vec3(half - wall - 0.05, 0.54, half + 0.05));
        coping.add(&slab, turn);
    }
    let mut earth = Shape::new();
    earth.grid([8, 8], false, |s, t| {
        let (x, z) = ((2.0 * s - 1.0) * 0.86, (1.0 - 2.0 * t) * 0.86);
        let y = 0.42 + 0.07 * ((1.0 - s) * s * (1.0 - t) * t * 16.0) + 0.012 * (x * 9.0 + z * 7.0).sin();
        (vec3(x, y, z), glam::vec2(x, z))
    });
    vec![(Surface::Ashlar, stone), (Surface::Marble, coping), (Surface::Earth, earth)]
}

/// A pot 55 cm high with earth in it.
pub fn pot(surface: Surface) -> Parts {
    let mut clay = Shape::new();
    let profile = [
        [0.17, 0.0],
        [0.20, 0.02],
        [0.20, 0.02],
        [0.24, 0.12],
        [0.29, 0.28],
        [0.31, 0.40],
        [0.29, 0.46],
        [0.29, 0.46],
        [0.34, 0.48],
        [0.35, 0.51],
        [0.34, 0.55],
        [0.34, 0.55],
        [0.29, 0.55],
        [0.29, 0.55],
        [0.28, 0.42],
    ];
    clay.lathe(&profile, 32);
    vec![(surface, clay), (Surface::Earth, disc(0.285, 0.48, 6))]
}

/// A bench of boards on two stone blocks.
pub fn bench() -> Parts {
    let mut stone = Shape::new();
    let mut wood = Shape::new();
    for x in [-0.75, 0.75] {
        stone.block(vec3(x, 0.0, 0.0), vec3(0.22, 0.42, 0.46));
    }
    for i in 0..4 {
        let z = -0.195 + 0.13 * i as f32;
        wood.cuboid(vec3(-1.0, 0.42, z - 0.055), vec3(1.0, 0.465, z + 0.055));
    }
    vec![(Surface::Ashlar, stone), (Surface::Planks, wood)]
}

/// A six-sided lantern on a chain that hangs from the origin, 1.2 m long in all.
pub fn lantern(glass: Surface) -> Parts {
    let mut bronze = Shape::new();
    let mut panes = Shape::new();
    let mut bulb = Shape::new();
    let (low, high, radius) = (-1.15, -0.78, 0.15);
    bronze.block(vec3(0.0, -0.62, 0.0), vec3(0.012, 0.62, 0.012));
    bronze.lathe(&[[0.0, low - 0.08], [0.06, low - 0.05], [radius + 0.02, low - 0.02], [radius + 0.02, low]], 6);
    bronze.lathe(&[[radius + 0.05, high], [radius + 0.03, high + 0.03], [0.06, high + 0.10], [0.02, high + 0.18]], 6);
    let corner = |i: usize, y: f32| {
        let (sin, cos) = (i as f32 / 6.0 * TAU).sin_cos();
        vec3(radius * cos, y, -radius * sin)
    };
    for i in 0..6 {
        panes.quad([corner(i, low), corner(i + 1, low), corner(i + 1, high), corner(i, high)]);
        bronze.block(corner(i, low), vec3(0.016, high - low, 0.016));
    }
    bulb.lathe(&[[0.0, -1.05], [0.035, -1.03], [0.05, -0.99], [0.035, -0.94], [0.0, -0.91]], 10);
    vec![(Surface::Bronze, bronze), (Surface::Lamp, bulb), (glass, panes)]
}

/// A folding screen of five leaves with panes of five colours, so that several lie behind one another.
pub fn screen() -> Parts {
    const LEAVES: usize = 5;
    let (width, height, bar) = (0.66, 1.95, 0.04);
    let colors =
        [Surface::RedGlass, Surface::AmberGlass, Surface::GreenGlass, Surface::BlueGlass, Surface::VioletGlass];
    let mut bronze = Shape::new();
    let mut glass = vec![Shape::new(); colors.len()];
    let mut hinge = Vec3::new(-1.3, 0.0, 0.0);
    for leaf in 0..LEAVES {
        let turn = if leaf % 2 == 0 { 0.65 } else { -0.65 };
        let frame = Mat4::from_translation(hinge) * Mat4::from_rotation_y(turn);
        let mut bars = Shape::new();
        let columns = 2;
        let rows = 5;
        let (cell_x, cell_y) = (width / columns as f32, (height - 0.15) / rows as f32);
        for i in 0..=columns {
            bars.block(vec3(i as f32 * cell_x, 0.0, 0.0), vec3(bar, height, bar));
        }
        for j in 0..=rows {
            let y = 0.12 + j as f32 * cell_y;
            bars.cuboid(vec3(0.0, y - bar * 0.5, -bar * 0.4), vec3(width, y + bar * 0.5, bar * 0.4));
        }
        bronze.add(&bars, frame);
        for i in 0..columns {
            for j in 0..rows {
                let mut pane = Shape::new();
                let center = vec3((i as f32 + 0.5) * cell_x, 0.12 + (j as f32 + 0.5) * cell_y, 0.0);
                pane.card(center, Vec3::X * cell_x * 0.5, Vec3::Y * cell_y * 0.5);
                glass[(leaf * 2 + i + j * 3) % colors.len()].add(&pane, frame);
            }
        }
        hinge = frame.transform_point3(vec3(width, 0.0, 0.0));
    }
    let mut parts = vec![(Surface::Bronze, bronze)];
    parts.extend(colors.into_iter().zip(glass));
    parts
}

/// A rod between two points.
pub fn rod(shape: &mut Shape, from: Vec3, to: Vec3, radius: f32) {
    let along = (to - from).normalize_or(Vec3::Y);
    let x = along.any_orthonormal_vector();
    let section =
        |at: Vec3| Mat4::from_cols(x.extend(0.0), along.cross(x).extend(0.0), along.extend(0.0), at.extend(1.0));
    shape.loft(&[section(from), section(to)], &ring::<10>(radius), true);
}

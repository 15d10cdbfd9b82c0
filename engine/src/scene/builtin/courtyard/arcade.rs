//! Columns, piers and arches.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Mat4, Vec3, Vec4, vec2, vec3};

use super::{BAY, Parts, SPRING, Shape, Surface, TOP};

/// Thickness of the arcade's wall.
pub const DEPTH: f32 = 0.55;
const OPENING: f32 = 1.15;
const SEGMENTS: usize = 20;
/// Sides of what is turned.
const AROUND: usize = 22;

/// An outline that swells out by half a circle, from height `low` to `high` at `radius`.
fn torus(radius: f32, low: f32, high: f32) -> [[f32; 2]; 6] {
    let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
    std::array::from_fn(|i| {
        let (sin, cos) = (-FRAC_PI_2 + PI * i as f32 / 5.0).sin_cos();
        [radius + half * cos, middle + half * sin]
    })
}

/// A fluted column with an Attic base and a capital of sixteen leaves, [`SPRING`] high.
pub fn column() -> Parts {
    let mut stone = Shape::new();
    stone.block(Vec3::ZERO, vec3(0.80, 0.16, 0.80));
    stone.block(vec3(0.0, SPRING - 0.14, 0.0), vec3(0.84, 0.14, 0.84));

    // Base: torus, hollow, torus.
    stone.lathe(&torus(0.31, 0.16, 0.27), AROUND);
    stone.lathe(&[[0.32, 0.265], [0.295, 0.285], [0.280, 0.310], [0.285, 0.340]], AROUND);
    stone.lathe(&torus(0.275, 0.335, 0.40), AROUND);

    // Shaft: flutes that run out at both ends, and a slight swelling.
    let (low, high) = (0.40, 2.52);
    let rows: [f32; 5] = [0.0, 1.0 / 12.0, 0.5, 11.0 / 12.0, 1.0];
    stone.grid([64, rows.len() - 1], true, |s, row| {
        let t = rows[(row * (rows.len() - 1) as f32).round() as usize];
        let y = low + (high - low) * t;
        let radius = 0.275 - 0.045 * t * t;
        let ends = (t * 12.0).min((1.0 - t) * 12.0).min(1.0);
        let flute = (s * 16.0 * PI).sin().abs();
        let r = radius - 0.020 * ends * flute;
        let (sin, cos) = (s * TAU).sin_cos();
        (vec3(r * cos, y, -r * sin), vec2(s * TAU * radius, -y))
    });
    stone.lathe(&torus(0.225, 2.50, 2.56), AROUND);

    // Capital: a bell, and two rows of leaves that bend over.
    let bell = [[0.225, 2.56], [0.228, 2.70], [0.245, 2.82], [0.29, 2.94], [0.36, 3.02], [0.38, 3.06]];
    stone.lathe(&bell, AROUND);
    for (row, (foot, height, offset)) in [(2.56, 0.26, 0.0), (2.62, 0.40, PI / 8.0)].into_iter().enumerate() {
        let mut leaf = Shape::new();
        leaf.grid([2, 5], false, |s, t| {
            let across = 2.0 * s - 1.0;
            let width = 0.085 * (1.0 - 0.75 * t * t * t);
            // Bends outwards towards its tip, which hangs over.
            let out = 0.235 + 0.015 + 0.13 * t.powi(3) + 0.02 * row as f32 - 0.02 * across * across;
            let rise = height * (t - 0.28 * t.powi(5));
            (vec3(width * across, foot + rise, out), vec2(0.17 * s, -height * t))
        });
        for i in 0..8 {
            stone.add(&leaf, Mat4::from_rotation_y(offset + i as f32 * TAU / 8.0));
        }
    }
    vec![(Surface::Marble, stone)]
}

/// A square pier for a corner.
pub fn pier() -> Parts {
    let mut stone = Shape::new();
    stone.block(Vec3::ZERO, vec3(1.04, 0.3, 1.04));
    stone.block(vec3(0.0, 0.3, 0.0), vec3(0.9, SPRING - 0.5, 0.9));
    stone.block(vec3(0.0, SPRING - 0.2, 0.0), vec3(1.04, 0.2, 1.04));
    vec![(Surface::Ashlar, stone)]
}

/// The wall over one bay with its arch, a moulding on both faces and a keystone.
pub fn bay() -> Parts {
    let mut wall = Shape::new();
    wall.arch(BAY, DEPTH, SPRING, TOP, OPENING, SEGMENTS);
    // The undersides that rest on the capitals.
    for (left, right) in [(-BAY * 0.5, -OPENING), (OPENING, BAY * 0.5)] {
        let p = |x: f32, z: f32| vec3(x, SPRING, z * DEPTH * 0.5);
        wall.face([p(left, -1.0), p(right, -1.0), p(right, 1.0), p(left, 1.0)], Vec3::ZERO, Vec3::X);
    }

    let mut trim = Shape::new();
    let outline = [
        [0.34, 0.0],
        [0.34, 0.03],
        [0.34, 0.03],
        [0.30, 0.055],
        [0.26, 0.075],
        [0.26, 0.075],
        [0.20, 0.045],
        [0.20, 0.045],
        [0.02, 0.045],
        [0.02, 0.045],
        [0.02, 0.0],
    ];
    for face in [0.0, PI] {
        let turn = Mat4::from_rotation_y(face);
        // x of the outline points away from the arch's centre, y out of the wall.
        let sections: Vec<Mat4> = (0..=SEGMENTS)
            .map(|k| {
                let angle = PI * (1.0 - k as f32 / SEGMENTS as f32);
                let radial = vec3(angle.cos(), angle.sin(), 0.0);
                let origin = vec3(0.0, SPRING, DEPTH * 0.5) + radial * OPENING;
                let forward = radial.cross(Vec3::Z);
                turn * Mat4::from_cols(radial.extend(0.0), Vec4::Z, forward.extend(0.0), origin.extend(1.0))
            })
            .collect();
        trim.loft(&sections, &outline, false);
    }
    let crown = SPRING + OPENING;
    trim.block(vec3(0.0, crown - 0.04, 0.0), vec3(0.26, 0.46, DEPTH + 0.24));
    vec![(Surface::Ashlar, wall), (Surface::Marble, trim)]
}

/// The moulding along the top of the arcade, on the side of the court.
pub fn cornice(length: f32) -> Parts {
    let outline = [
        [0.0, 0.0],
        [0.05, 0.0],
        [0.05, 0.0],
        [0.05, 0.05],
        [0.05, 0.05],
        [0.08, 0.07],
        [0.14, 0.12],
        [0.16, 0.17],
        [0.16, 0.17],
        [0.24, 0.17],
        [0.24, 0.17],
        [0.24, 0.26],
        [0.24, 0.26],
        [0.0, 0.27],
    ];
    let mut stone = Shape::new();
    let end = |x: f32| vec3(x, TOP - 0.30, DEPTH * 0.5);
    stone.moulding(end(-length * 0.5), end(length * 0.5), Vec3::Z, &outline);
    // Brackets below it.
    let count = (length / 0.5) as usize;
    for i in 0..=count {
        let x = (i as f32 / count as f32 - 0.5) * (length - 0.6);
        stone.block(vec3(x, TOP - 0.42, DEPTH * 0.5 + 0.06), vec3(0.14, 0.14, 0.16));
    }
    vec![(Surface::Marble, stone)]
}

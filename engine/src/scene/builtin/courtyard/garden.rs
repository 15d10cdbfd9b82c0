//! Trees, shrubs, ivy and flowers: stems, and leaves as MASK cards.

use std::f32::consts::{PI, TAU};

use glam::{Mat4, Vec3, vec3};

use super::{Parts, Random, Shape, Surface, ring};

/// A tree 4 to 5 m high: a trunk, limbs, and a crown of cards around the limbs' ends.
pub fn tree(random: &mut Random) -> Parts {
    let mut bark = Shape::new();
    let mut leaves = Shape::new();
    let fork = vec3(random.between(-0.15, 0.15), 1.55, random.between(-0.15, 0.15));
    limb(&mut bark, Vec3::ZERO, vec3(0.12, 0.8, -0.05), fork, 0.17, 0.11);
    for i in 0..7 {
        let angle = i as f32 / 7.0 * TAU + random.between(-0.3, 0.3);
        let (sin, cos) = angle.sin_cos();
        let out = if i % 3 == 0 { random.between(0.4, 0.7) } else { random.between(0.9, 1.35) };
        let rise = random.between(1.1, 2.3);
        let end = fork + vec3(cos * out, rise, sin * out);
        let middle = fork + vec3(cos * out * 0.65, rise * 0.35, sin * out * 0.65);
        limb(&mut bark, fork - Vec3::Y * 0.1, middle, end, 0.085, 0.025);
        cluster(&mut leaves, random, end, 0.78, 0.24, 105);
        cluster(&mut leaves, random, middle + Vec3::Y * 0.5, 0.55, 0.22, 40);
    }
    vec![(Surface::Bark, bark), (Surface::Leaves, leaves)]
}

/// A round shrub for a pot, its middle 85 cm above the floor.
pub fn shrub(random: &mut Random) -> Parts {
    let mut leaves = Shape::new();
    cluster(&mut leaves, random, vec3(0.0, 0.86, 0.0), 0.36, 0.15, 130);
    let mut bark = Shape::new();
    limb(&mut bark, vec3(0.0, 0.45, 0.0), vec3(0.02, 0.6, 0.0), vec3(0.0, 0.9, 0.0), 0.03, 0.02);
    vec![(Surface::Bark, bark), (Surface::Leaves, leaves)]
}

/// Ivy that climbs 4.5 m up a wall in the xy plane and spreads.
pub fn ivy(random: &mut Random) -> Parts {
    let mut leaves = Shape::new();
    for _ in 0..11 {
        let mut at = vec3(random.between(-0.35, 0.35), 0.05, 0.0);
        let lean = random.between(-0.55, 0.55);
        while at.y < random.between(3.2, 4.7) {
            // Up along the column, then outwards over the wall.
            let spread = if at.y > 2.9 { lean * 1.6 } else { lean * 0.12 };
            at += vec3(spread * 0.16 + random.between(-0.05, 0.05), 0.15, 0.0);
            let tilt = Mat4::from_rotation_x(random.between(-0.6, 0.1))
                * Mat4::from_rotation_y(random.between(-0.5, 0.5))
                * Mat4::from_rotation_z(random.between(0.0, TAU));
            let size = random.between(0.12, 0.2);
            let right = tilt.transform_vector3(Vec3::X * size);
            let up = tilt.transform_vector3(Vec3::Y * size);
            leaves.card(at + Vec3::Z * random.between(0.02, 0.14), right, up);
        }
    }
    vec![(Surface::Ivy, leaves)]
}

/// Flowers along the edge of a planter.
pub fn flowers(random: &mut Random) -> Parts {
    let mut cards = Shape::new();
    for i in 0..56 {
        let along = random.between(-0.78, 0.78);
        let across = random.between(0.62, 0.8);
        let (x, z) = [(along, across), (across, along), (along, -across), (-across, along)][i % 4];
        let (sin, cos) = random.between(0.0, PI).sin_cos();
        let size = random.between(0.15, 0.22);
        cards.card(vec3(x, 0.42 + size, z), vec3(cos, 0.0, sin) * size, Vec3::Y * size);
    }
    vec![(Surface::Flowers, cards)]
}

/// A bent, tapering limb through three points.
fn limb(shape: &mut Shape, from: Vec3, through: Vec3, to: Vec3, thick: f32, thin: f32) {
    const STEPS: usize = 7;
    let sections: Vec<Mat4> = (0..=STEPS)
        .map(|i| {
            let t = i as f32 / STEPS as f32;
            // A quadratic Bézier curve and its tangent.
            let (a, b) = (from.lerp(through, t), through.lerp(to, t));
            let forward = (b - a).normalize_or(Vec3::Y);
            let x = forward.cross(vec3(0.31, 0.12, 0.94)).normalize_or(Vec3::X);
            let radius = thick + (thin - thick) * t;
            Mat4::from_cols(
                (x * radius).extend(0.0),
                (forward.cross(x) * radius).extend(0.0),
                forward.extend(0.0),
                a.lerp(b, t).extend(1.0),
            )
        })
        .collect();
    let mut wood = Shape::new();
    wood.loft(&sections, &ring::<9>(1.0), true);
    shape.add(&wood, Mat4::IDENTITY);
}

/// Cards of leaves in a ball; sprigs point outwards, and faces look away from its middle where they can.
fn cluster(shape: &mut Shape, random: &mut Random, center: Vec3, radius: f32, size: f32, count: usize) {
    for _ in 0..count {
        let outward = random.direction();
        let at = center + outward * radius * random.unit().powf(0.4) * vec3(1.0, 0.8, 1.0);
        let up = (outward + 0.7 * random.direction() + vec3(0.0, 0.25, 0.0)).normalize_or(Vec3::Y);
        let right = up.cross(random.direction()).normalize_or(up.any_orthonormal_vector());
        let right = if right.cross(up).dot(outward) < 0.0 { -right } else { right };
        let size = size * random.between(0.8, 1.25);
        shape.card(at, right * size, up * size);
    }
}

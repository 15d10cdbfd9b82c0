//! Cloth: hanging banners and sails that span the court.

use std::f32::consts::{PI, TAU};

use glam::{Vec3, vec2, vec3};

use super::{Parts, Shape, Surface, furniture::rod};

/// A banner 85 cm wide and 2.3 m long that hangs from the origin in folds, on a bronze pole.
pub fn banner(phase: f32) -> Parts {
    let (width, length) = (0.85, 2.3);
    let mut cloth = Shape::new();
    cloth.grid([14, 14], false, |s, t| {
        let down = 1.0 - t;
        let folds = 0.06 * (s * 1.6 * TAU + down * 1.5 + phase).sin() * down.sqrt();
        let belly = 0.10 * (down * PI * 0.9 + phase * 0.3).sin() * down;
        let narrow = 1.0 - 0.06 * down;
        (vec3((s - 0.5) * width * narrow, -length * down, folds + belly), vec2(s, down))
    });
    let mut bronze = Shape::new();
    rod(&mut bronze, vec3(-0.5, 0.0, 0.0), vec3(0.5, 0.0, 0.0), 0.018);
    for x in [-0.3, 0.3] {
        rod(&mut bronze, vec3(x, 0.0, -0.35), Vec3::new(x, 0.0, 0.0), 0.012);
    }
    vec![(Surface::BannerCloth, cloth), (Surface::Bronze, bronze)]
}

/// A strip of cloth 2.2 m wide across the court, sagging, with its ropes.
pub fn sail(phase: f32) -> Parts {
    let (half, reach, sag) = (1.1, 6.6, 0.95);
    let surface = |s: f32, t: f32| {
        let across = 2.0 * s - 1.0;
        let ripple = 0.05 * (s * 9.0 * PI + phase).sin() * (t * PI).sin();
        let curl = 0.16 * (2.0 * t - 1.0).powi(2);
        vec3(across * reach, -sag * (1.0 - across * across) + ripple + curl, half * (1.0 - 2.0 * t))
    };
    let mut cloth = Shape::new();
    cloth.grid([48, 12], false, |s, t| (surface(s, t), vec2(s * 2.0 * reach, -t * 2.0 * half)));
    let mut rope = Shape::new();
    for (s, wall) in [(0.0, -7.5), (1.0, 7.5)] {
        for t in [0.0, 1.0] {
            let corner = surface(s, t);
            rod(&mut rope, corner, vec3(wall, corner.y + 0.25, corner.z), 0.012);
        }
    }
    vec![(Surface::SailCloth, cloth), (Surface::Planks, rope)]
}

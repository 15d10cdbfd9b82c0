//! Shadows of a box on a plane.

use glam::{DVec3, Mat4, Vec3};
use shadowgraph::scene::{AlphaMode, Light, Scene as Source};

use crate::tiny;
use crate::twin::scene::Scene;
use crate::twin::shadow::{Receiver, cast, spot_texel, toward_light, visibility};

const TEXEL: f64 = 0.02;
const OFFSET: f64 = 1e-6;

/// A box 2 m wide and high on a plane at y = 0.
fn box_on_plane() -> Source {
    let mut source = tiny::empty();
    let plane = tiny::quad(Vec3::new(-10.0, 0.0, 10.0), Vec3::X * 20.0, Vec3::NEG_Z * 20.0, 0);
    tiny::add(&mut source, plane, Mat4::IDENTITY);
    tiny::add(&mut source, tiny::cuboid(Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 2.0, 1.0), 0), Mat4::IDENTITY);
    source
}

fn ground(x: f64, z: f64) -> Receiver {
    Receiver { position: DVec3::new(x, 0.0, z), normal: DVec3::Y, texel: TEXEL }
}

#[test]
fn the_shadow_of_a_box_is_a_rectangle() {
    // Light along (1, −1, 0): the box of height 2 throws its shadow 2 m in +x, over z −1 to 1.
    let source = box_on_plane();
    let scene = Scene::new(&source);
    let sun = tiny::sun(Vec3::new(1.0, -1.0, 0.0));
    let (mut dark, mut edges) = (0, 0);
    for i in 0..120 {
        for k in 0..80 {
            let (x, z) = (1.013 + f64::from(i) * 0.03, -1.5 + f64::from(k) * 0.037);
            let inside = (3.0 - x).min(1.0 - z.abs());
            let found = visibility(&scene, &sun, &ground(x, z), OFFSET);
            assert!(found.reached);
            assert_eq!(found.lit, inside < 0.0, "({x}, {z})");
            // A step across the rays is √2 as long on the ground in x. Outside a corner the border is farther than
            // the value of the smaller side says.
            let away = if inside < 0.0 { (x - 3.0).max(0.0).hypot((z.abs() - 1.0).max(0.0)) } else { inside };
            if away > 2.0 * TEXEL * std::f64::consts::SQRT_2 && x > 1.0 + 3.0 * TEXEL {
                assert!(!found.near_edge, "({x}, {z})");
            }
            // In z the ring's steps are not stretched, and one lies straight across.
            if inside.abs() < 0.9 * TEXEL && (1.0 - z.abs()) < (3.0 - x) && x < 2.9 {
                assert!(found.near_edge, "({x}, {z})");
                edges += 1;
            }
            dark += u32::from(!found.lit);
        }
    }
    assert!(dark > 2000 && edges > 50, "{dark} {edges}");
}

/// Whether a segment meets the box: interval arithmetic on its slabs, no triangles.
fn segment_meets_box(from: DVec3, to: DVec3) -> bool {
    let way = to - from;
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (axis, (low, high)) in [(-1.0, 1.0), (0.0, 2.0), (-1.0, 1.0)].into_iter().enumerate() {
        let (a, b) = ((low - from[axis]) / way[axis], (high - from[axis]) / way[axis]);
        (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    }
    enter < leave
}

#[test]
fn a_spot_sees_what_the_box_does_not_hide() {
    let source = box_on_plane();
    let scene = Scene::new(&source);
    let position = Vec3::new(-3.1, 5.2, 0.7);
    let spot = tiny::spot(position, Vec3::new(0.6, -1.0, 0.05), 0.3, 0.6);
    let receivers: Vec<_> = (0..90)
        .flat_map(|k| (0..90).map(move |i| (f64::from(i), f64::from(k))))
        .map(|(i, k)| ground(-4.03 + i * 0.0931, -4.01 + k * 0.0917))
        .map(|r| (r.position.x.abs().max(r.position.z.abs()) > 1.05).then_some(r))
        .collect();
    let found = cast(&scene, &spot, &receivers, 90, OFFSET);
    let axis = Vec3::new(0.6, -1.0, 0.05).as_dvec3().normalize();
    let mut counts = [0; 3];
    for (receiver, found) in receivers.iter().zip(&found) {
        assert_eq!(receiver.is_some(), found.is_some());
        let (Some(receiver), Some(found)) = (receiver, found) else { continue };
        assert_eq!(found.lit, !segment_meets_box(receiver.position, position.as_dvec3()), "{}", receiver.position);
        let angle = (receiver.position - position.as_dvec3()).angle_between(axis);
        assert_eq!(found.reached, angle < 0.6, "{}", receiver.position);
        counts[0] += u32::from(found.lit);
        counts[1] += u32::from(!found.lit);
        counts[2] += u32::from(found.reached);
    }
    assert!(counts.iter().all(|&c| c > 300), "{counts:?}");
}

#[test]
fn the_sides_of_the_box_face_the_light_or_do_not() {
    let source = box_on_plane();
    let scene = Scene::new(&source);
    let sun = tiny::sun(Vec3::new(1.0, -1.0, 0.0));
    let side =
        |position: DVec3, normal: DVec3| visibility(&scene, &sun, &Receiver { position, normal, texel: TEXEL }, OFFSET);
    let lit = side(DVec3::new(-1.0, 1.0, 0.0), DVec3::NEG_X);
    assert!(lit.lit && lit.reached && !lit.near_edge, "{lit:?}");
    let dark = side(DVec3::new(1.0, 1.0, 0.0), DVec3::X);
    assert!(!dark.lit && !dark.reached && !dark.near_edge, "{dark:?}");
    // Along the rays: it faces no light.
    assert!(!side(DVec3::new(0.0, 1.0, 1.0), DVec3::Z).reached);
}

fn under(light: &Light, change: impl Fn(&mut Source)) -> bool {
    let mut source = box_on_plane();
    change(&mut source);
    visibility(&Scene::new(&source), light, &ground(0.0, 3.0), OFFSET).lit
}

#[test]
fn casters_are_opaque_and_masked_surfaces_between_the_point_and_the_light() {
    let sun = tiny::sun(Vec3::NEG_Y);
    let lid = |source: &mut Source, mode: AlphaMode, height: f32, up: bool| {
        let mut material = source.materials[0].clone();
        material.alpha_mode = mode;
        material.base_color.w = 0.5;
        source.materials.push(material);
        let front = if up { Vec3::NEG_Z } else { Vec3::Z };
        let quad = tiny::quad(Vec3::new(-1.0, height, 3.0) - front, Vec3::X * 2.0, front * 2.0, 1);
        tiny::add(source, quad, Mat4::IDENTITY);
    };
    let mask = |cutoff| AlphaMode::Mask { cutoff };
    assert!(under(&sun, |_| ()));
    for up in [true, false] {
        assert!(!under(&sun, |s| lid(s, AlphaMode::Opaque, 1.0, up)), "both sides cast");
    }
    assert!(!under(&sun, |s| lid(s, mask(0.4), 1.0, true)));
    assert!(under(&sun, |s| lid(s, mask(0.6), 1.0, true)));
    assert!(under(&sun, |s| lid(s, AlphaMode::Blend, 1.0, true)));

    let lamp = tiny::spot(Vec3::new(0.0, 4.0, 3.0), Vec3::NEG_Y, 0.5, 1.0);
    assert!(!under(&lamp, |s| lid(s, AlphaMode::Opaque, 3.9, true)));
    assert!(under(&lamp, |s| lid(s, AlphaMode::Opaque, 4.1, true)), "behind the lamp");
    assert_eq!(toward_light(&lamp, DVec3::new(0.0, 1.0, 3.0)), (DVec3::Y, 3.0));
}

#[test]
fn texels_of_a_spot_span_its_cone() {
    // 90° over 512 texels: 2 m at 1 m.
    assert!((spot_texel(std::f64::consts::FRAC_PI_4, 512, 1.0) - 2.0 / 512.0).abs() < 1e-15);
}

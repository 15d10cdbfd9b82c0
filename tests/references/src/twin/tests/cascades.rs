//! Splits, fits that hold still, and selection.

use glam::{DVec2, DVec3, Vec3};
use proptest::prelude::*;
use shadowgraph::scene::{Camera as Lens, Projection, View};

use crate::twin::camera::Camera;
use crate::twin::cascades::{Sphere, fit, light_space, select, slice_sphere, splits};

#[test]
fn splits_are_uniform_logarithmic_or_between() {
    let near = |found: &[f64], expected: &[f64]| {
        assert_eq!(found.len(), expected.len());
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} not {expected:?}");
    };
    near(&splits(1.0, 1000.0, 3, 1.0), &[1.0, 10.0, 100.0, 1000.0]);
    near(&splits(1.0, 1000.0, 3, 0.0), &[1.0, 334.0, 667.0, 1000.0]);
    near(&splits(1.0, 1000.0, 3, 0.5), &[1.0, 172.0, 383.5, 1000.0]);
    near(&splits(0.1, 50.0, 1, 0.7), &[0.1, 50.0]);
}

#[test]
fn selection_blends_at_the_end_of_a_slice() {
    let s = [1.0, 11.0, 31.0];
    assert_eq!(select(&s, 0.5, 0.1), Some((0, 0.0)), "nearer than the first split is the first cascade");
    assert_eq!(select(&s, 9.9, 0.1), Some((0, 0.0)));
    assert_eq!(select(&s, 10.5, 0.1), Some((0, 0.5)));
    assert_eq!(select(&s, 11.0, 0.1), Some((0, 1.0)));
    assert_eq!(select(&s, 11.1, 0.1), Some((1, 0.0)));
    assert_eq!(select(&s, 30.9, 0.1), Some((1, 0.0)), "there is no next one");
    assert_eq!(select(&s, 31.1, 0.1), None);
    assert_eq!(select(&s, 10.9, 0.0), Some((0, 0.0)));
}

#[test]
fn the_sphere_around_a_slice_is_the_least() {
    // 90° both ways: corners at √2 · z. A long slice is held by its far corners alone.
    let corner = |z: f64| z * 2.0_f64.sqrt();
    assert_eq!(slice_sphere(1.0, 10.0, corner), Sphere { distance: 10.0, radius: 10.0 * 2.0_f64.sqrt() });
    // A narrow one has its centre between: both ends equally far.
    let narrow = |z: f64| z * 0.2;
    let s = slice_sphere(5.0, 10.0, narrow);
    let reach = |z: f64| narrow(z).hypot(z - s.distance);
    assert!((reach(5.0) - s.radius).abs() < 1e-12 && (reach(10.0) - s.radius).abs() < 1e-12);
    // A box: the middle.
    assert_eq!(slice_sphere(2.0, 10.0, |_| 3.0), Sphere { distance: 6.0, radius: 5.0 });
    // No sphere about another point of the axis is smaller.
    for (near, far, slope) in [(0.1, 3.0, 0.9), (3.0, 9.0, 0.5), (1.0, 1.5, 2.0)] {
        let s = slice_sphere(near, far, |z| z * slope);
        for k in 0..1000 {
            let c = far * f64::from(k) / 500.0;
            let radius = (near * slope).hypot(near - c).max((far * slope).hypot(far - c));
            assert!(radius >= s.radius - 1e-9);
        }
    }
}

fn view(eye: Vec3, yaw: f32, pitch: f32, projection: Projection) -> View {
    let forward = Vec3::new(yaw.sin() * pitch.cos(), pitch.sin(), -yaw.cos() * pitch.cos());
    Lens { projection, ..Lens::look_at(eye, eye + forward, Vec3::Y, 1.0, 0.1) }.view([160, 90])
}

fn projection() -> impl Strategy<Value = Projection> {
    prop_oneof![
        (0.3_f32..1.6).prop_map(|fov_y| Projection::Perspective { fov_y, near: 0.1, far: None }),
        (1.0_f32..8.0).prop_map(|half_height| Projection::Orthographic { half_height, near: 0.1, far: 100.0 }),
    ]
}

proptest! {
    #[test]
    fn a_map_covers_its_slice_and_holds_still(
        eye in [-20.0_f32..20.0, -20.0..20.0, -20.0..20.0],
        (yaw, pitch) in (-3.0_f32..3.0, -1.5_f32..1.5),
        sun in [-1.0_f64..1.0, -1.0..1.0, -1.0..1.0],
        (near, depth) in (0.1_f64..5.0, 0.5_f64..40.0),
        projection in projection(),
    ) {
        let direction = DVec3::from(sun);
        prop_assume!(direction.length() > 0.1);
        let far = near + depth;
        let eye = Vec3::from(eye);
        let here = view(eye, yaw, pitch, projection);
        let map = fit(&here, near, far, direction, 512);

        // 1. All corners of the slice lie in the map
        let camera = Camera::new(&here);
        for (x, y) in [(0.0, 0.0), (160.0, 0.0), (0.0, 90.0), (160.0, 90.0)] {
            for z in [near, far] {
                prop_assert!(map.covers(camera.line(x, y).at(z)));
            }
        }

        // 2. Texels keep their size and their places as the camera turns and moves
        let there = fit(&view(eye + Vec3::new(3.3, -1.7, 0.9), yaw + 1.0, pitch * 0.3, projection), near, far, direction, 512);
        prop_assert!((map.texel - there.texel).abs() <= 1e-12 * map.texel, "{} {}", map.texel, there.texel);
        let point = DVec3::new(1.25, -7.5, 3.0);
        let moved = map.texels(point) - there.texels(point);
        prop_assert!((moved - moved.round()).length() < 1e-6, "moved by {moved}");
    }
}

#[test]
fn light_space_is_a_rotation_that_looks_along_the_light() {
    for direction in [DVec3::new(0.3, -1.0, 0.2), DVec3::NEG_Y, DVec3::Y, DVec3::X, DVec3::new(0.01, -1.0, 0.0)] {
        let m = light_space(direction);
        assert!((m.determinant() - 1.0).abs() < 1e-12);
        assert!((m.transpose() * m).abs_diff_eq(glam::DMat3::IDENTITY, 1e-12));
        assert!((m * DVec3::NEG_Z).distance(direction.normalize()) < 1e-12);
    }
}

#[test]
fn the_margin_is_a_texel_and_the_radius_whole_sixteenths() {
    let here = view(Vec3::new(0.3, 0.2, 0.1), 0.4, 0.2, Projection::Perspective { fov_y: 1.0, near: 0.1, far: None });
    let map = fit(&here, 0.1, 10.0, DVec3::new(0.3, -1.0, 0.2), 1024);
    let radius = map.texel * 1022.0 / 2.0;
    assert!((radius * 16.0 - (radius * 16.0).round()).abs() < 1e-9, "{radius}");
    let whole = map.min / map.texel;
    assert!((whole - whole.round()).length() < 1e-9 && whole != DVec2::ZERO);
}

//! Rays, coverage, culling, distances and edges.

use glam::{DVec3, Mat4, Quat, Vec3, Vec4};
use proptest::prelude::*;
use shadowgraph::scene::{Camera as Lens, Projection, Scene as Source, View};

use crate::tiny;
use crate::twin::camera::{Camera, Picture, Tolerance, cast};
use crate::twin::scene::{Ray, Rule, Scene};

/// 8 × 8 pixels of 1 × 1 m at z = 0, seen from z = 4, by exact matrices. Pixel (i, j) has its centre at
/// (i − 3.5, 3.5 − j).
fn views() -> [View; 2] {
    let world_from_view = Mat4::from_translation(Vec3::Z * 4.0);
    let perspective = Mat4::from_cols(Vec4::X, -Vec4::Y, -Vec4::W, Vec4::Z * 0.25);
    let orthographic = Projection::Orthographic { half_height: 4.0, near: 1.0, far: 9.0 }.clip_from_view(1.0);
    [perspective, orthographic].map(|clip_from_view| View {
        size: [8, 8],
        world_from_view,
        view_from_world: world_from_view.inverse(),
        clip_from_view,
    })
}

fn covered(picture: &Picture) -> Vec<[u32; 2]> {
    let all = (0..picture.size[1]).flat_map(|y| (0..picture.size[0]).map(move |x| [x, y]));
    all.filter(|&[x, y]| picture.at(x, y).surface.is_some()).collect()
}

/// A point of the plane z = 0 at the centre of a pixel.
fn center(i: i32, j: i32) -> Vec3 {
    Vec3::new(i as f32 - 3.5, 3.5 - j as f32, 0.0)
}

fn picture_of(source: &Source, view: &View) -> Picture {
    cast(&Scene::new(source), view, Tolerance::default())
}

#[test]
fn vertices_on_pixel_centres_cover_by_the_top_left_rule() {
    //   1 2 3 4 5     The triangle below the diagonal owns its left edge; the diagonal and the bottom are not its own.
    // 1 a . . . d     The triangle above owns the top edge and the diagonal, but not the right edge.
    // 2 x \ . . .     Together they cover every pixel of the square but the last row and column, once.
    // 3 x x \ . .
    // 4 x x x \ .
    // 5 b . . . c
    let [a, b, c, d] = [(1, 1), (1, 5), (5, 5), (5, 1)].map(|(i, j)| center(i, j));
    let below: Vec<_> = (2..5).flat_map(|j| (1..j).map(move |i| [i, j])).collect();
    let above: Vec<_> = (1..5).flat_map(|j| (j..5).map(move |i| [i, j])).collect();
    for view in views() {
        for (corners, expected) in [([a, b, c], &below), ([a, c, d], &above)] {
            let mut source = tiny::empty();
            tiny::add(&mut source, tiny::triangles(&[corners], 0), Mat4::IDENTITY);
            let picture = picture_of(&source, &view);
            assert_eq!(&covered(&picture), expected);
            // Vertex, edge and all: whatever lies on an edge is near one.
            assert!(picture.at(1, 1).near_edge && picture.at(3, 3).near_edge && !picture.at(2, 4).near_edge);
        }
    }
}

#[test]
fn distance_and_position_are_those_of_the_plane() {
    // z = x / 2 + y / 4, as a triangle that fills the picture.
    let at = |x: f32, y: f32| Vec3::new(x, y, x / 2.0 + y / 4.0);
    let mut source = tiny::empty();
    tiny::add(&mut source, tiny::triangles(&[[at(-40.0, -40.0), at(40.0, -40.0), at(0.0, 60.0)]], 0), Mat4::IDENTITY);
    for (view, is_perspective) in views().into_iter().zip([true, false]) {
        let picture = picture_of(&source, &view);
        for j in 0..8 {
            for i in 0..8 {
                let p = center(i, j).as_dvec3();
                // Perspective: eye + t (p − eye) / 4 with 4 − t = x t / 8 + y t / 16. Orthographic: below p.
                let t = if is_perspective { 4.0 / (1.0 + p.x / 8.0 + p.y / 16.0) } else { 4.0 - p.x / 2.0 - p.y / 4.0 };
                let scale = if is_perspective { t / 4.0 } else { 1.0 };
                let pixel = picture.at(i as u32, j as u32);
                let surface = pixel.surface.as_ref().unwrap();
                assert!((pixel.z - t).abs() < 1e-12, "{i} {j}: {} not {t}", pixel.z);
                assert!(surface.position.distance(DVec3::new(p.x * scale, p.y * scale, 4.0 - t)) < 1e-12);
                assert!(surface.normal.distance(DVec3::new(-0.5, -0.25, 1.0).normalize()) < 1e-7);
                assert_eq!((surface.ids, pixel.near_edge), ([1, 1, 1], false));
            }
        }
    }
}

#[test]
fn what_is_nearer_than_the_near_plane_is_not_there() {
    let mut source = tiny::empty();
    let quad = |z: f32| tiny::quad(Vec3::new(-9.0, -9.0, z), Vec3::X * 18.0, Vec3::Y * 18.0, 0);
    tiny::add(&mut source, quad(3.5), Mat4::IDENTITY);
    tiny::add(&mut source, quad(2.0), Mat4::IDENTITY);
    tiny::add(&mut source, quad(-6.0), Mat4::IDENTITY);
    let [perspective, orthographic] = views().map(|view| picture_of(&source, &view).at(1, 3).z);
    assert_eq!((perspective, orthographic), (0.5, 2.0));
    source.objects.drain(..2);
    let [perspective, orthographic] = views().map(|view| picture_of(&source, &view).at(1, 3).z);
    assert_eq!((perspective, orthographic), (10.0, f64::INFINITY), "the far plane is at 9");
}

#[test]
fn backs_are_culled_where_single_sided_and_turned_where_double_sided() {
    let square = tiny::quad(Vec3::new(-2.0, -2.0, 0.0), Vec3::X * 4.0, Vec3::Y * 4.0, 0);
    let mirror = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let turn = Mat4::from_rotation_y(std::f32::consts::PI);
    for (transform, front) in
        [(Mat4::IDENTITY, true), (mirror, true), (turn, false), (turn * mirror, false), (-Mat4::IDENTITY, false)]
    {
        for double_sided in [false, true] {
            let mut source = tiny::empty();
            source.materials[0].double_sided = double_sided;
            let transform = Mat4 { w_axis: Vec4::W, ..transform };
            tiny::add(&mut source, square.clone(), transform);
            let picture = picture_of(&source, &views()[0]);
            let seen = picture.at(3, 4).surface.as_ref();
            assert_eq!(seen.is_some(), front || double_sided, "{transform:?}");
            if let Some(surface) = seen {
                assert_eq!(surface.front, front);
                for normal in [surface.normal, surface.smooth_normal, surface.flat_normal] {
                    assert!(normal.distance(DVec3::Z) < 1e-6, "{transform:?}: {normal}");
                }
            }
        }
    }
}

#[test]
fn normals_of_an_ellipsoid_stay_on_it() {
    // x² + y²/4 + 4z² = 1, its gradient (x, y/4, 4z); mirrored, turned and moved.
    let axes = Vec3::new(1.0, 2.0, 0.5);
    let turn = Mat4::from_rotation_translation(Quat::from_rotation_x(0.7), Vec3::new(0.2, 0.1, 0.0));
    for mirror in [1.0, -1.0] {
        let world = turn * Mat4::from_scale(axes * Vec3::new(mirror, 1.0, 1.0));
        let mut source = tiny::empty();
        tiny::add(&mut source, tiny::sphere(192, 96, 0), world);
        let mut view = views()[0];
        view.size = [64, 64];
        let picture = picture_of(&source, &view);
        let to_unit = world.inverse().as_dmat4();
        let mut compared = 0;
        for surface in picture.pixels.iter().filter_map(|p| p.surface.as_ref()) {
            let unit = to_unit.transform_point3(surface.position);
            assert!((unit.length() - 1.0).abs() < 1e-3, "{unit}");
            let gradient = to_unit.transpose().transform_vector3(unit).normalize();
            assert!(surface.smooth_normal.distance(gradient) < 4e-3, "{} not {gradient}", surface.smooth_normal);
            assert!(surface.flat_normal.dot(gradient) > 0.99 && surface.front);
            compared += 1;
        }
        assert!(compared > 100, "{compared}");
    }
}

#[test]
fn singular_transforms_neither_fail_nor_show() {
    let mut source = tiny::empty();
    tiny::add(&mut source, tiny::sphere(8, 4, 0), Mat4::from_scale(Vec3::ZERO));
    tiny::add(&mut source, tiny::sphere(8, 4, 0), Mat4::from_scale(Vec3::splat(f32::NAN)));
    assert!(covered(&picture_of(&source, &views()[0])).is_empty());
    // Flat: it has area, and is seen, with a normal along the axis that is gone.
    source.materials[0].double_sided = true;
    tiny::add(&mut source, tiny::sphere(8, 4, 0), Mat4::from_scale(Vec3::new(2.0, 2.0, 0.0)));
    let picture = picture_of(&source, &views()[0]);
    assert!(!covered(&picture).is_empty());
    assert!(picture.pixels.iter().filter_map(|p| p.surface.as_ref()).all(|s| s.flat_normal.z.abs() > 0.99));
}

#[test]
fn triangles_are_counted_over_the_primitives_of_a_mesh() {
    let mut source = tiny::empty();
    source.materials.push(source.materials[0].clone());
    let square = |x: f32, material| tiny::quad(Vec3::new(x, -4.0, 0.0), Vec3::X * 4.0, Vec3::Y * 8.0, material);
    tiny::add(&mut source, tiny::triangles(&[], 0), Mat4::IDENTITY);
    let object = tiny::add(&mut source, square(-4.0, 1), Mat4::IDENTITY);
    // A triangle without area counts too.
    source.meshes[object].primitives[0].indices.splice(0..0, [0, 0, 0]);
    source.meshes[object].primitives.push(square(0.0, 0));
    let picture = picture_of(&source, &views()[0]);
    let ids = |x, y| picture.at(x, y).surface.as_ref().unwrap().ids;
    assert_eq!([ids(1, 6), ids(0, 1), ids(6, 7), ids(4, 1)], [[2, 2, 2], [2, 3, 2], [2, 4, 1], [2, 5, 1]]);
}

#[test]
fn pixels_are_near_edges_within_the_tolerance_only() {
    // The right edge of the nearer square passes `gap` pixels from the centres of column 4.
    let pixel = |gap: f32, behind: bool| {
        let mut source = tiny::empty();
        tiny::add(
            &mut source,
            tiny::quad(Vec3::new(-3.0, -9.0, 0.0), Vec3::X * (3.5 + gap), Vec3::Y * 18.0, 0),
            Mat4::IDENTITY,
        );
        if behind {
            tiny::add(
                &mut source,
                tiny::quad(Vec3::new(-19.0, -19.0, -1.0), Vec3::X * 38.0, Vec3::Y * 38.0, 0),
                Mat4::IDENTITY,
            );
        }
        // Row 2 keeps away from the diagonals of both.
        let pixel = picture_of(&source, &views()[0]).at(4, 2).clone();
        (pixel.surface.map(|s| s.ids[0]), pixel.near_edge)
    };
    for behind in [false, true] {
        let missed = behind.then_some(2);
        // The farthest probe lies 0.061 pixels away in x.
        assert_eq!(pixel(0.03, behind), (Some(1), true));
        assert_eq!(pixel(-0.03, behind), (missed, true));
        assert_eq!(pixel(0.1, behind), (Some(1), false));
        assert_eq!(pixel(-0.1, behind), (missed, false));
    }
}

#[test]
fn surfaces_at_equal_distance_are_contested_and_the_first_is_seen() {
    let mut source = tiny::empty();
    for z in [0.0, 0.0, -1.0] {
        tiny::add(&mut source, tiny::quad(Vec3::new(-9.0, -9.5, z), Vec3::X * 19.0, Vec3::Y * 19.0, 0), Mat4::IDENTITY);
    }
    let at = |source: &Source| {
        let pixel = picture_of(source, &views()[0]).at(1, 2).clone();
        (pixel.surface.unwrap().ids[0], pixel.near_edge)
    };
    assert_eq!(at(&source), (1, true));
    source.objects.remove(1);
    assert_eq!(at(&source), (1, false));
}

#[test]
fn nothing_slips_through_a_closed_surface() {
    let mut source = tiny::empty();
    source.materials[0].double_sided = true;
    tiny::add(&mut source, tiny::sphere(60, 30, 0), Mat4::from_rotation_x(0.3));
    let scene = Scene::new(&source);
    let inside = DVec3::new(0.1, 0.2, -0.3);
    // Along edges, the worst that a ray can do.
    let mut rays = 0;
    for triangle in &scene.triangles {
        let [a, b, c] = triangle.positions;
        for target in [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5, a * 0.3 + b * 0.7, b.lerp(c, 0.001)] {
            let ray = Ray::new(inside, target - inside);
            let hit = scene.closest(&ray, Rule::CAMERA).expect("a ray slipped through");
            assert!((hit.t - 1.0).abs() < 1e-6);
            assert!(scene.any(&ray, Rule::SHADOW));
            rays += 1;
        }
    }
    assert!(rays > 15_000);
}

fn vertex() -> impl Strategy<Value = Vec3> {
    // A coarse grid, for shared planes and equal distances; and anything.
    prop_oneof![
        [-3_i32..4, -3..4, -3..4].prop_map(|p| Vec3::from(p.map(|v| v as f32))),
        [-3.0_f32..3.0, -3.0..3.0, -3.0..3.0].prop_map(Vec3::from),
    ]
}

proptest! {
    #[test]
    fn the_hierarchy_finds_what_a_search_of_all_triangles_finds(
        corners in prop::collection::vec([vertex(), vertex(), vertex()], 0..80),
        origin in vertex(),
        target in vertex(),
        far in 0.5_f64..4.0,
    ) {
        prop_assume!(origin != target);
        let mut source = tiny::empty();
        tiny::add(&mut source, tiny::triangles(&corners, 0), Mat4::IDENTITY);
        let scene = Scene::new(&source);
        let ray = Ray { far, ..Ray::new(origin.as_dvec3(), (target - origin).as_dvec3()) };
        for rule in [Rule::CAMERA, Rule::SHADOW] {
            // Möller and Trumbore 1997, in double precision.
            let mut expected: Option<f64> = None;
            for t in &scene.triangles {
                let [a, b, c] = t.positions;
                let (e1, e2, s) = (b - a, c - a, ray.line.origin - a);
                let p = ray.line.direction.cross(e2);
                let determinant = e1.dot(p);
                let (u, q) = (s.dot(p) / determinant, s.cross(e1));
                let v = ray.line.direction.dot(q) / determinant;
                let t = e2.dot(q) / determinant;
                // A hair from the border two formulas may differ.
                let border = u.min(v).min(1.0 - u - v).abs() < 1e-9 || (t - far).abs() < 1e-9 || t.abs() < 1e-9;
                prop_assume!(!border && determinant.abs() > 1e-9);
                let front = determinant > 0.0;
                if u > 0.0 && v > 0.0 && u + v < 1.0 && t > 0.0 && t < far && (front || !rule.culls_backs) {
                    expected = Some(expected.map_or(t, |e| e.min(t)));
                }
            }
            let found = scene.closest(&ray, rule);
            prop_assert_eq!(found.is_some(), expected.is_some());
            prop_assert_eq!(scene.any(&ray, rule), expected.is_some());
            if let (Some(found), Some(expected)) = (found, expected) {
                prop_assert!((found.t - expected).abs() < 1e-9 * expected.max(1.0));
                let w = found.weights;
                let [a, b, c] = scene.triangles[found.triangle as usize].positions;
                let point = a * w.x + b * w.y + c * w.z;
                prop_assert!(point.distance(ray.line.at(found.t)) < 1e-9);
            }
        }
    }
}

#[test]
fn rays_agree_with_the_matrices_of_the_view() {
    let lens = Lens::look_at(Vec3::new(3.0, 2.0, -1.0), Vec3::new(0.0, 1.0, 4.0), Vec3::Y, 0.9, 0.2);
    let orthographic = Projection::Orthographic { half_height: 2.5, near: 0.5, far: 40.0 };
    let finite = Projection::Perspective { fov_y: 0.9, near: 0.2, far: Some(40.0) };
    for projection in [lens.projection, orthographic, finite] {
        let view = Lens { projection, ..lens.clone() }.view([320, 180]);
        let camera = Camera::new(&view);
        assert!((camera.near / if projection == orthographic { 0.5 } else { 0.2 } - 1.0).abs() < 1e-5);
        assert!(projection == lens.projection || (camera.far / 40.0 - 1.0).abs() < 1e-4, "{}", camera.far);
        for (x, y) in [(0.5, 0.5), (319.5, 0.5), (100.25, 170.0)] {
            let p = camera.line(x, y).at(7.0);
            let clip = view.clip_from_view.as_dmat4() * view.view_from_world.as_dmat4() * p.extend(1.0);
            let pixel = (clip.truncate() / clip.w + 1.0) * 0.5 * DVec3::new(320.0, 180.0, 1.0);
            assert!((pixel.truncate() - glam::DVec2::new(x, y)).length() < 1e-3, "{pixel}");
            assert!((view.view_from_world.as_dmat4().transform_point3(p).z + 7.0).abs() < 1e-5);
        }
    }
}

//! Solid voxels from one pass of XOR against parity along rays.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{DVec3, EulerRot, Mat4, Quat, Vec3};
use shadowgraph::geometry::Aabb;
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::{Primitive, Scene};
use shadowgraph::techniques::voxel::bitmask::{Bitmask, Combine};
use shadowgraph::techniques::voxel::{Axis, Grid, Voxels};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Figure, Picture};
use shadowgraph_tests::harness;
use shadowgraph_tests::{tiny, twin};

/// What a rasteriser may do to a surface: it snaps vertices to 1/256 of a pixel.
const NEAR: f64 = 1.0 / 128.0;

fn voxelize(gpu: &Gpu, scene: &Scene, grid: &Grid, technique: Bitmask) -> Voxels {
    let scene = scene.clone().upload(gpu).unwrap();
    let mut graph = Graph::new("voxelize", gpu.caps());
    let voxels = technique.record(&mut graph, &scene, grid).unwrap();
    graph.capture("bits", &voxels.bits);
    let plan = graph.compile(gpu).unwrap();
    let executed = Executor::new(gpu).execute(&plan, graph).unwrap();
    Voxels::read(executed.capture("bits").unwrap(), grid, voxels.axis).unwrap()
}

fn bounds(scene: &Scene) -> Aabb {
    let objects = scene.objects.iter().flat_map(|object| {
        let points = scene.meshes[object.mesh].primitives.iter().flat_map(|p| &p.positions);
        points.map(|&p| object.world_from_object.transform_point3(p))
    });
    Aabb::around(objects).unwrap()
}

/// Voxels that agree, that differ where the surface is at most [`NEAR`], and that differ elsewhere.
fn compare(voxels: &Voxels, truth: &Scene) -> [usize; 3] {
    let grid = voxels.grid();
    let triangles = twin::voxel::in_grid(&twin::scene::Scene::new(truth), grid);
    let inside = twin::voxel::solid(&triangles, grid.size());
    let [nx, ny, _] = grid.size().map(|n| n as usize);
    let mut counts = [0; 3];
    for (index, (&found, &inside)) in voxels.bytes().iter().zip(&inside).enumerate() {
        let center = DVec3::new((index % nx) as f64, (index / nx % ny) as f64, (index / nx / ny) as f64) + 0.5;
        let agrees = (found == 1) == inside;
        counts[if agrees { 0 } else { 1 + usize::from(!twin::voxel::is_near(center, &triangles, NEAR)) }] += 1;
    }
    counts
}

fn one(name: &str, parts: Vec<(Primitive, Mat4)>) -> Scene {
    let mut scene = tiny::empty();
    scene.name = name.into();
    for (primitive, world_from_object) in parts {
        tiny::add(&mut scene, primitive, world_from_object);
    }
    scene
}

/// A torus around the z axis, with radii 1 and 0.4, of `2 · around · across` triangles.
fn torus(around: u32, across: u32) -> Primitive {
    let point = |i: u32, k: u32| {
        let turn = |n: u32, of: u32| std::f32::consts::TAU * (n % of) as f32 / of as f32;
        let (u, v) = (turn(i, around), turn(k, across));
        let ring = 1.0 + 0.4 * v.cos();
        Vec3::new(ring * u.cos(), ring * u.sin(), 0.4 * v.sin())
    };
    let quads = (0..around).flat_map(|i| (0..across).map(move |k| [i, k]));
    let triangles: Vec<_> = quads
        .flat_map(|[i, k]| {
            let [a, b, c, d] = [point(i, k), point(i + 1, k), point(i + 1, k + 1), point(i, k + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    tiny::triangles(&triangles, 0)
}

/// Tetrahedra of all sizes that run through one another.
fn soup(count: usize) -> Primitive {
    let mut random = 0x9e37_79b9_7f4a_7c15_u64;
    let mut unit = || {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random >> 40) as f32 / (1 << 24) as f32
    };
    let mut triangles = Vec::new();
    for _ in 0..count {
        let middle = Vec3::new(unit(), unit(), unit());
        let size = 0.5 * unit() * unit();
        let corners = [(); 4].map(|()| middle + size * (Vec3::new(unit(), unit(), unit()) - 0.5));
        for [a, b, c] in [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]] {
            triangles.push([corners[a], corners[b], corners[c]]);
        }
    }
    tiny::triangles(&triangles, 0)
}

fn awkward() -> Mat4 {
    Mat4::from_quat(Quat::from_euler(EulerRot::YXZ, 0.7313, 0.4127, 1.1931))
}

fn scenes() -> Vec<Scene> {
    let cuboid = |size: Vec3| tiny::cuboid(-0.5 * size, 0.5 * size, 0);
    let mut scenes = vec![
        one("sphere", vec![(tiny::sphere(64, 32, 0), Mat4::IDENTITY)]),
        one("torus, turned", vec![(torus(64, 32), awkward())]),
        one("cube", vec![(cuboid(Vec3::ONE), Mat4::IDENTITY)]),
        one("thin plate, turned", vec![(cuboid(Vec3::new(1.0, 1.0, 0.02)), awkward())]),
        one("needle, turned", vec![(cuboid(Vec3::new(1.0, 0.01, 0.01)), awkward())]),
        one("200 tetrahedra", vec![(soup(200), Mat4::IDENTITY)]),
        one("mirrored torus", vec![(torus(48, 24), Mat4::from_scale(Vec3::new(-1.0, 0.8, 1.1)) * awkward())]),
    ];
    for file in ["AnalyticSolids/AnalyticSolids.glb", "Boot/Boot.glb", "Spot/Spot.gltf"] {
        if let Some(path) = harness::require_scene(file) {
            scenes.push(Scene::load(&path).unwrap());
        }
    }
    scenes
}

#[test]
fn voxel_bitmask_agrees_with_its_reference() {
    let gpu = shared();
    let mut rows = Vec::new();
    for scene in scenes() {
        for (resolution, axis) in [(32, Axis::X), (64, Axis::Y), (128, Axis::Z)] {
            let grid = Grid::around(&bounds(&scene), resolution).unwrap();
            let [bit, masks, targets] = [Combine::Bit, Combine::Masks, Combine::LogicOp]
                .map(|combine| voxelize(gpu, &scene, &grid, Bitmask { axis, combine }));
            assert!(bit == masks && bit == targets, "{}: the ways to flip bits differ", scene.name);
            let [agree, near, far] = compare(&bit, &scene);
            println!("{} at {resolution} along {axis:?}: {agree} agree, {near} differ near, {far} far", scene.name);
            assert!(far == 0, "{} at {resolution}: {far} voxels", scene.name);
            // The cube's faces lie on voxel centres, where either answer is right.
            let most = if scene.name == "cube" { 8 } else { 100 };
            assert!(bit.count() > 0 && near < agree / most, "{} at {resolution}", scene.name);
            rows.push((scene.name.clone(), agree + near, near));
        }
    }
    let mut figures: Vec<Figure> = Vec::new();
    for of_scene in rows.chunk_by(|a, b| a.0 == b.0) {
        let compared: usize = of_scene.iter().map(|row| row.1).sum();
        let near: usize = of_scene.iter().map(|row| row.2).sum();
        let what = format!("{}: voxels at 32, 64, 128", of_scene[0].0);
        let value = format!("0 of {compared} differ, {near} left out");
        figures.push(Figure { what, value, bound: "none differs; left out within 1/128 voxel of a surface".into() });
    }
    figures.extend(volumes(gpu));
    silent(gpu);

    let picture = harness::require_scene("Spot/Spot.gltf").map(|path| {
        let scene = Scene::load(&path).unwrap();
        let grid = Grid::around(&bounds(&scene), 160).unwrap();
        front(&voxelize(gpu, &scene, &grid, Bitmask::default()))
    });
    figures::publish(gpu, "voxel", "bitmask", &figures, picture.as_ref());
}

/// Error of the volume against the mesh's own, and how it falls with the resolution.
fn volumes(gpu: &Gpu) -> Vec<Figure> {
    let of = |name: &str, primitive: Primitive| {
        let scene = one(name, vec![(primitive, awkward())]);
        let errors = [64_u32, 128, 256, 512].map(|resolution| {
            let grid = Grid::around(&bounds(&scene), resolution).unwrap();
            let triangles = twin::voxel::in_grid(&twin::scene::Scene::new(&scene), &grid);
            let volume = twin::voxel::volume(&triangles);
            let error = (voxelize(gpu, &scene, &grid, Bitmask::default()).count() as f64 / volume - 1.0).abs();
            assert!(error <= 1.5 / f64::from(resolution), "{name} at {resolution}: {error}");
            error
        });
        let worst = errors.iter().zip([64.0, 128.0, 256.0, 512.0]).map(|(error, n)| error * n).fold(0.0, f64::max);
        println!("{name}: relative errors of the volume {errors:?}");
        Figure {
            what: format!("{name}: volume at 64, 128, 256, 512"),
            value: format!("relative error at most {worst:.4} / N"),
            bound: "at most 1.5 / N".into(),
        }
    };
    vec![of("sphere of 16128 triangles", tiny::sphere(128, 64, 0)), of("torus of 16384 triangles", torus(128, 64))]
}

/// The voxels from the front, lit from the upper left.
fn front(voxels: &Voxels) -> Picture {
    let [nx, ny, nz] = voxels.grid().size();
    // From the side of the least z, so x runs to the left.
    let depth = |x: u32, y: u32| (0..nz).find(|&z| voxels.get([nx.wrapping_sub(1 + x), y, z])).map(|z| (nz - z) as f32);
    let scale = 3;
    let mut pixels = Vec::new();
    for row in 0..scale * ny {
        for column in 0..scale * nx {
            let (x, y) = (column / scale, ny - 1 - row / scale);
            let lit = depth(x, y).map(|z| {
                let slope = |other: Option<f32>| (z - other.unwrap_or(0.0)).clamp(-3.0, 3.0);
                let (left, up) = (slope(depth(x.wrapping_sub(1), y)), slope(depth(x, y + 1)));
                let normal = Vec3::new(-left, up, 1.6).normalize();
                let grid_line = if column % scale == 0 || row % scale == 0 { 0.8 } else { 1.0 };
                grid_line * (0.15 + 0.85 * normal.dot(Vec3::new(-0.4, 0.6, 0.7).normalize()).max(0.0))
            });
            pixels.push(lit.map_or([0.02, 0.02, 0.03], |lit| [0.75, 0.68, 0.6].map(|c| c * lit)));
        }
    }
    let caption = format!("{nx}³ voxels of a solid, seen along an axis");
    Picture { size: [scale * nx, scale * ny], pixels, exposure: 1.0, caption }
}

#[test]
fn voxel_bitmask_with_a_seeded_mistake_is_caught() {
    let gpu = shared();
    let truth = one("torus", vec![(torus(48, 24), awkward())]);
    let grid = Grid::around(&bounds(&truth), 64).unwrap();
    let far = |scene: &Scene| compare(&voxelize(gpu, scene, &grid, Bitmask::default()), &truth)[2];
    assert_eq!(far(&truth), 0);
    // A twentieth of a voxel aside; a triangle lost.
    let mut aside = truth.clone();
    aside.objects[0].world_from_object = Mat4::from_translation(Vec3::X * 0.05 * grid.edge()) * awkward();
    assert!(far(&aside) > 0);
    let mut holed = truth.clone();
    holed.meshes[0].primitives[0].indices.drain(..3);
    assert!(far(&holed) > 0);
    silent(gpu);
}

#[test]
fn a_cube_that_fills_its_grid_fills_every_voxel() {
    let gpu = shared();
    let cube = one("cube", vec![(tiny::cuboid(Vec3::ZERO, Vec3::splat(8.0), 0), Mat4::IDENTITY)]);
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        for combine in [Combine::Bit, Combine::Masks, Combine::LogicOp] {
            let technique = Bitmask { axis, combine };
            // Exactly the grid, with faces on its bounds; and a grid that the cube reaches out of on all sides.
            for (min, size) in [(Vec3::ZERO, [8, 8, 8]), (Vec3::splat(2.0), [3, 4, 5])] {
                let grid = Grid::new(min, 1.0, size).unwrap();
                let voxels = voxelize(gpu, &cube, &grid, technique);
                assert_eq!(voxels.count(), u64::from(size[0] * size[1] * size[2]), "{technique:?}, {size:?}");
            }
        }
    }
    silent(gpu);
}

#[test]
fn portable_every_way_to_flip_bits_gives_the_same() {
    let gpu = shared();
    let scene = one("tetrahedra", vec![(soup(50), Mat4::IDENTITY)]);
    let grid = Grid::new(Vec3::splat(-0.1), 0.01, [120, 110, 130]).unwrap();
    let voxels = [Combine::Bit, Combine::Masks, Combine::LogicOp]
        .map(|combine| voxelize(gpu, &scene, &grid, Bitmask { axis: Axis::Y, combine }));
    assert!(voxels[0].count() > 1000 && voxels[0] == voxels[1] && voxels[0] == voxels[2]);
    silent(gpu);
}

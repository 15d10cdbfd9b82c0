//! Solid voxels from one pass of XOR against parity along rays.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{Mat4, Vec3};
use shadowgraph::gpu::Gpu;
use shadowgraph::scene::{Primitive, Scene};
use shadowgraph::techniques::voxel::bitmask::{Bitmask, Combine};
use shadowgraph::techniques::voxel::{Axis, Grid, Voxels};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Figure};
use shadowgraph_tests::harness;
use shadowgraph_tests::plot::LogPlot;
use shadowgraph_tests::solids::{self, awkward, bounds, front, one, soup, torus};
use shadowgraph_tests::{tiny, twin};

fn voxelize(gpu: &Gpu, scene: &Scene, grid: &Grid, technique: Bitmask) -> Voxels {
    solids::voxelize(gpu, scene, grid, |graph, scene| technique.record(graph, scene, grid))
}

/// As [`solids::compare`], with what rays say of a scene.
fn compare(voxels: &Voxels, truth: &Scene) -> [usize; 3] {
    let triangles = twin::voxel::in_grid(truth, voxels.grid());
    solids::compare(voxels, &triangles, &twin::voxel::solid(&triangles, voxels.grid().size()))
}

#[test]
fn voxel_bitmask_agrees_with_its_reference() {
    let gpu = shared();
    let mut rows = Vec::new();
    for scene in solids::closed() {
        for (resolution, axis) in [(32, Axis::X), (64, Axis::Y), (128, Axis::Z), (256, Axis::X)] {
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
        let what = format!("{}: voxels at 32, 64, 128, 256", of_scene[0].0);
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

/// Error of the volume against the mesh's own, and how it falls with the resolution: root mean squares over ways to turn
/// the mesh, for one of them alone may be right by chance.
fn volumes(gpu: &Gpu) -> Vec<Figure> {
    const RESOLUTIONS: [u32; 4] = [64, 128, 256, 512];
    const TURNS: u32 = 6;
    let mut lines = vec![("1.5 / N, the bound", RESOLUTIONS.map(|n| [n.into(), 1.5 / f64::from(n)]).to_vec(), true)];
    let mut of = |name: &'static str, primitive: Primitive| {
        let error = |resolution: u32, turn: u32| {
            let turned = Mat4::from_rotation_x(0.47 * turn as f32) * awkward();
            let scene = one(name, vec![(primitive.clone(), turned)]);
            let grid = Grid::around(&bounds(&scene), resolution).unwrap();
            let volume = twin::voxel::volume(&twin::voxel::in_grid(&scene, &grid));
            let error = (voxelize(gpu, &scene, &grid, Bitmask::default()).count() as f64 / volume - 1.0).abs();
            assert!(error <= 1.5 / f64::from(resolution), "{name} at {resolution}: {error}");
            error
        };
        let mean_square = |n: u32| (0..TURNS).map(|turn| error(n, turn).powi(2)).sum::<f64>() / f64::from(TURNS);
        let errors = RESOLUTIONS.map(|resolution| mean_square(resolution).sqrt());
        let slope = slope(RESOLUTIONS.map(f64::from), errors);
        println!("{name}: relative errors of the volume {errors:?}, slope {slope}");
        assert!(slope <= -1.0, "{name}: {errors:?}");
        let points = errors.iter().zip(RESOLUTIONS).map(|(&error, n)| [n.into(), error]).collect();
        lines.push((name.split(' ').next().unwrap(), points, false));
        let worst = errors.iter().zip(RESOLUTIONS).map(|(error, n)| error * f64::from(n)).fold(0.0, f64::max);
        Figure {
            what: format!("{name}, turned {TURNS} ways: volume at 64, 128, 256, 512"),
            value: format!("relative error at most {worst:.4} / N, slope {slope:.2} (logarithms)"),
            bound: "at most 1.5 / N, slope at most -1".into(),
        }
    };
    let figures =
        vec![of("sphere of 16128 triangles", tiny::sphere(128, 64, 0)), of("torus of 16384 triangles", torus(128, 64))];
    let plot = LogPlot { x: "voxels an axis, N", y: "relative error of the volume", lines: &lines };
    figures::publish_plot("techniques/voxel", "bitmask_volume", &plot);
    figures
}

/// Of the line nearest to the points' logarithms.
fn slope(x: [f64; 4], y: [f64; 4]) -> f64 {
    let (x, y) = (x.map(f64::ln), y.map(f64::ln));
    let mean = |values: [f64; 4]| values.iter().sum::<f64>() / 4.0;
    let (middle, height) = (mean(x), mean(y));
    let product: f64 = x.iter().zip(y).map(|(x, y)| (x - middle) * (y - height)).sum();
    product / x.iter().map(|x| (x - middle).powi(2)).sum::<f64>()
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

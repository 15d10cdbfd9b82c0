//! Voxels that triangles touch against separating axes in double precision.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{Mat4, Vec3};
use shadowgraph::gpu::Gpu;
use shadowgraph::scene::Scene;
use shadowgraph::techniques::voxel::conservative::{Conservative, Pipeline};
use shadowgraph::techniques::voxel::{Axis, Grid, Voxels};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Figure};
use shadowgraph_tests::harness;
use shadowgraph_tests::solids::{self, awkward, bounds, soup, surfaces, torus};
use shadowgraph_tests::voxel_pictures::front;
use shadowgraph_tests::{tiny, twin};

/// How far beyond ε a voxel may be from the triangle that set it, in voxels.
const FAR: f64 = 1e-4;

/// By compute shaders; the rasteriser must find the same.
fn voxelize(gpu: &Gpu, scene: &Scene, grid: &Grid, axis: Axis) -> Voxels {
    let [computed, rasterized] = [Pipeline::Compute, Pipeline::Raster].map(|pipeline| {
        let technique = Conservative { axis, pipeline };
        solids::voxelize(gpu, scene, grid, |graph, scene| technique.record(graph, scene, grid))
    });
    assert!(computed == rasterized, "{} in {:?} along {axis:?}: the pipelines differ", scene.name, grid.size());
    computed
}

/// Voxels that are touched and not set; that are set and further than ε and [`FAR`] from every triangle; that are set.
fn compare(voxels: &Voxels, truth: &Scene) -> [usize; 3] {
    let grid = voxels.grid();
    let triangles = twin::voxel::in_grid(truth, grid);
    let margin = f64::from(Conservative::margin(grid, &bounds(truth)));
    let touched = |margin: f64| {
        twin::voxel::surface(&triangles, grid.size(), |triangle, center| {
            twin::voxel::touches(triangle, center, 0.5 + margin)
        })
    };
    let [least, most] = [0.0, margin + FAR].map(touched);
    solids::mistakes(voxels, &least, &most)
}

#[test]
fn voxel_conservative_agrees_with_its_reference() {
    let gpu = shared();
    let mut figures = Vec::new();
    for scene in surfaces() {
        let mut sum = 0;
        // The finest only where the sweep runs whole.
        let sweep = [(32, Axis::X), (64, Axis::Y), (128, Axis::Z), (256, Axis::X)];
        for &(resolution, axis) in &sweep[..if harness::is_whole() { 4 } else { 3 }] {
            let grid = Grid::around(&bounds(&scene), resolution).unwrap();
            let [missed, far, set] = compare(&voxelize(gpu, &scene, &grid, axis), &scene);
            println!("{} at {resolution} along {axis:?}: {set} set, {missed} missed, {far} too many", scene.name);
            assert!(missed == 0 && far == 0 && set > 0, "{} at {resolution}: {missed}, {far}", scene.name);
            sum += set;
        }
        figures.push(Figure {
            what: format!("{}: voxels at 32, 64, 128, 256", scene.name),
            value: format!("{sum} set, 0 missed, 0 too many; raster: equal bits"),
            bound: "none missed; none further than ε and 1e-4 voxel".into(),
        });
    }
    silent(gpu);
    let picture = harness::require_scene("Demosthenes/Demosthenes.gltf").map(|path| {
        let scene = Scene::load(&path).unwrap();
        front("Demosthenes", &voxelize(gpu, &scene, &Grid::around(&bounds(&scene), 160).unwrap(), Axis::Z))
    });
    figures::publish(gpu, "voxel", "conservative", &figures, picture.as_ref());
}

#[test]
fn voxel_conservative_with_a_seeded_mistake_is_caught() {
    let gpu = shared();
    let truth = tiny::one("torus", vec![(torus(32, 16), awkward())]);
    let grid = Grid::around(&bounds(&truth), 64).unwrap();
    let wrong = |scene: &Scene| compare(&voxelize(gpu, scene, &grid, Axis::Z), &truth);
    assert_eq!(wrong(&truth)[..2], [0, 0]);
    // A hundredth of a voxel aside: voxels are missed, and others too many.
    let mut aside = truth.clone();
    aside.objects[0].world_from_object = Mat4::from_translation(Vec3::X * 0.01 * grid.edge()) * awkward();
    let [missed, far, _] = wrong(&aside);
    assert!(missed > 0 && far > 0);
    silent(gpu);
}

#[test]
fn triangles_on_planes_of_the_grid_set_the_voxels_on_both_sides() {
    let gpu = shared();
    // The square 1 to 3 at height 2, on planes between voxels on all its sides.
    let quad = tiny::one(
        "quad",
        vec![(tiny::quad(Vec3::new(1.0, 1.0, 2.0), Vec3::X * 2.0, Vec3::Y * 2.0, 0), Mat4::IDENTITY)],
    );
    let grid = Grid::new(Vec3::ZERO, 1.0, [4; 3]).unwrap();
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        let voxels = voxelize(gpu, &quad, &grid, axis);
        for index in 0..64 {
            let voxel = [index % 4, index / 4 % 4, index / 16];
            assert_eq!(voxels.get(voxel), (1..=2).contains(&voxel[2]), "{voxel:?} along {axis:?}");
        }
    }
    silent(gpu);
}

#[test]
fn triangles_that_leave_the_grid_set_what_is_in_it() {
    let gpu = shared();
    // Tetrahedra, and triangles of a thousand kilometres through them.
    let mut scene = tiny::one("far", vec![(soup(400), Mat4::IDENTITY)]);
    let vast = |turn: f32| {
        let (sin, cos) = turn.sin_cos();
        let [right, up] = [Vec3::new(cos, sin, 0.3), Vec3::new(-0.2 * sin, cos, -0.9)];
        tiny::quad(0.5 - 4e5 * right - 5e5 * up, 1e6 * right, 1e6 * up, 0)
    };
    let near = voxelize(gpu, &scene, &Grid::new(Vec3::splat(0.3), 0.01, [40, 30, 50]).unwrap(), Axis::X);
    assert!(near.count() > 500, "{}", near.count());
    tiny::add(&mut scene, vast(0.4), Mat4::IDENTITY);
    tiny::add(&mut scene, vast(2.0), Mat4::IDENTITY);
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        let far = voxelize(gpu, &scene, &Grid::new(Vec3::splat(0.3), 0.01, [40, 30, 50]).unwrap(), axis);
        assert!(far.count() > near.count() + 1000, "{}", far.count());
    }
    silent(gpu);
}

#[test]
fn portable_surfaces_are_the_same_along_every_axis() {
    let gpu = shared();
    let scene = tiny::one("tetrahedra", vec![(soup(50), Mat4::IDENTITY)]);
    let grid = Grid::new(Vec3::splat(-0.1), 0.01, [120, 110, 130]).unwrap();
    let [missed, far, set] = compare(&voxelize(gpu, &scene, &grid, Axis::Y), &scene);
    assert!(missed == 0 && far == 0 && set > 1000, "{missed} missed, {far} too many, {set} set");
    silent(gpu);
}

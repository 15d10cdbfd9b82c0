//! Voxels that triangles touch against separating axes in double precision.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{Mat4, Vec3};
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::Scene;
use shadowgraph::techniques::voxel::conservative::Conservative;
use shadowgraph::techniques::voxel::{Axis, Grid, Voxels};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Figure};
use shadowgraph_tests::harness;
use shadowgraph_tests::solids::{awkward, bounds, front, one, soup, torus};
use shadowgraph_tests::{tiny, twin};

/// How far beyond ε a voxel may be from the triangle that set it, in voxels.
const FAR: f64 = 1e-4;

fn voxelize(gpu: &Gpu, scene: &Scene, grid: &Grid, axis: Axis) -> Voxels {
    let scene = scene.clone().upload(gpu).unwrap();
    let mut graph = Graph::new("voxelize", gpu.caps());
    let voxels = Conservative { axis }.record(&mut graph, &scene, grid).unwrap();
    graph.capture("bits", &voxels.bits);
    let plan = graph.compile(gpu).unwrap();
    let executed = Executor::new(gpu).execute(&plan, graph).unwrap();
    Voxels::read(executed.capture("bits").unwrap(), grid, axis).unwrap()
}

/// Voxels that are touched and not set; that are set and further than ε and [`FAR`] from every triangle; that are set.
fn compare(voxels: &Voxels, truth: &Scene) -> [usize; 3] {
    let grid = voxels.grid();
    // Triangles without area touch voxels too.
    let triangles = all_triangles(truth, grid);
    let margin = f64::from(Conservative::margin(grid, &bounds(truth)));
    let [least, most] = [0.0, margin + FAR].map(|m| twin::voxel::touched(&triangles, grid.size(), m));
    let bytes = voxels.bytes();
    let count = |wrong: &dyn Fn(usize) -> bool| (0..bytes.len()).filter(|&i| wrong(i)).count();
    [count(&|i| least[i] && bytes[i] == 0), count(&|i| !most[i] && bytes[i] == 1), count(&|i| bytes[i] == 1)]
}

fn all_triangles(scene: &Scene, grid: &Grid) -> Vec<[glam::DVec3; 3]> {
    let (min, edge) = (grid.min().as_dvec3(), f64::from(grid.edge()));
    let mut triangles = Vec::new();
    for object in &scene.objects {
        let world = object.world_from_object.as_dmat4();
        for primitive in &scene.meshes[object.mesh].primitives {
            triangles.extend(primitive.indices.chunks_exact(3).map(|corners| {
                [0, 1, 2]
                    .map(|i| (world.transform_point3(primitive.positions[corners[i] as usize].as_dvec3()) - min) / edge)
            }));
        }
    }
    triangles
}

fn scenes() -> Vec<Scene> {
    let cuboid = |size: Vec3| tiny::cuboid(-0.5 * size, 0.5 * size, 0);
    // A fan of slivers around the origin, and triangles without area.
    let slivers: Vec<_> = (0..60)
        .map(|i| {
            let turn = 0.37 * i as f32;
            let tip = Vec3::new(turn.cos(), turn.sin(), (0.7 * turn).sin());
            [Vec3::ZERO, tip, tip * 0.5 + Vec3::splat(1e-6 * i as f32)]
        })
        .collect();
    let mut scenes = vec![
        one("sphere", vec![(tiny::sphere(48, 24, 0), awkward())]),
        one("torus", vec![(torus(48, 24), awkward())]),
        one("large triangles", vec![(cuboid(Vec3::new(1.0, 0.7, 0.3)), awkward())]),
        one("needle", vec![(cuboid(Vec3::new(1.0, 0.004, 0.004)), awkward())]),
        one("slivers and triangles without area", vec![(tiny::triangles(&slivers, 0), Mat4::IDENTITY)]),
        one("100 tetrahedra", vec![(soup(100), Mat4::IDENTITY)]),
        one("mirrored torus", vec![(torus(32, 16), Mat4::from_scale(Vec3::new(-1.0, 0.8, 1.1)) * awkward())]),
    ];
    if let Some(path) = harness::require_scene("Demosthenes/Demosthenes.gltf") {
        scenes.push(Scene::load(&path).unwrap());
    }
    scenes
}

#[test]
fn voxel_conservative_agrees_with_its_reference() {
    let gpu = shared();
    let mut figures = Vec::new();
    for scene in scenes() {
        let mut sum = 0;
        for (resolution, axis) in [(32, Axis::X), (64, Axis::Y), (128, Axis::Z)] {
            let grid = Grid::around(&bounds(&scene), resolution).unwrap();
            let [missed, far, set] = compare(&voxelize(gpu, &scene, &grid, axis), &scene);
            println!("{} at {resolution} along {axis:?}: {set} set, {missed} missed, {far} too many", scene.name);
            assert!(missed == 0 && far == 0 && set > 0, "{} at {resolution}: {missed}, {far}", scene.name);
            sum += set;
        }
        figures.push(Figure {
            what: format!("{}: voxels at 32, 64, 128", scene.name),
            value: format!("{sum} set, 0 missed, 0 too many"),
            bound: "none missed; none further than ε and 1e-4 voxel".into(),
        });
    }
    silent(gpu);
    let picture = harness::require_scene("Demosthenes/Demosthenes.gltf").map(|path| {
        let scene = Scene::load(&path).unwrap();
        front(&voxelize(gpu, &scene, &Grid::around(&bounds(&scene), 160).unwrap(), Axis::Z))
    });
    figures::publish(gpu, "voxel", "conservative", &figures, picture.as_ref());
}

#[test]
fn voxel_conservative_with_a_seeded_mistake_is_caught() {
    let gpu = shared();
    let truth = one("torus", vec![(torus(32, 16), awkward())]);
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
    let quad =
        one("quad", vec![(tiny::quad(Vec3::new(1.0, 1.0, 2.0), Vec3::X * 2.0, Vec3::Y * 2.0, 0), Mat4::IDENTITY)]);
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
fn portable_surfaces_are_the_same_along_every_axis() {
    let gpu = shared();
    let scene = one("tetrahedra", vec![(soup(50), Mat4::IDENTITY)]);
    let grid = Grid::new(Vec3::splat(-0.1), 0.01, [120, 110, 130]).unwrap();
    let [missed, far, set] = compare(&voxelize(gpu, &scene, &grid, Axis::Y), &scene);
    assert!(missed == 0 && far == 0 && set > 1000, "{missed} missed, {far} too many, {set} set");
    silent(gpu);
}

//! Thin surfaces of voxels against their definition in double precision, and against leaks.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{Mat4, Vec3};
use shadowgraph::gpu::Gpu;
use shadowgraph::scene::Scene;
use shadowgraph::techniques::voxel::conservative::Conservative;
use shadowgraph::techniques::voxel::six_separating::SixSeparating;
use shadowgraph::techniques::voxel::{Axis, Grid, Voxels};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Figure};
use shadowgraph_tests::harness;
use shadowgraph_tests::solids::{self, awkward, bounds, surfaces, torus};
use shadowgraph_tests::voxel_pictures::front;
use shadowgraph_tests::{tiny, twin};

/// How near a condition may be to equality for either answer to be right, in voxels, beside rounding of coordinates.
const TIE: f64 = 1e-4;

fn voxelize(gpu: &Gpu, scene: &Scene, grid: &Grid, axis: Axis, thin: bool) -> Voxels {
    solids::voxelize(gpu, scene, grid, |graph, scene| match thin {
        true => SixSeparating { axis, ..SixSeparating::default() }.record(graph, scene, grid),
        false => Conservative { axis, ..Conservative::default() }.record(graph, scene, grid),
    })
}

/// Voxels that belong without doubt and are not set; that are set and do not belong without doubt; that are set.
fn compare(voxels: &Voxels, truth: &Scene) -> [usize; 3] {
    let grid = voxels.grid();
    let triangles = twin::voxel::in_grid(truth, grid);
    let tie = TIE + f64::from(Conservative::margin(grid, &bounds(truth)));
    let thin = |margin: f64| {
        twin::voxel::surface(&triangles, grid.size(), |triangle, center| twin::voxel::is_thin(triangle, center, margin))
    };
    let [least, most] = [-tie, tie].map(thin);
    solids::mistakes(voxels, &least, &most)
}

#[test]
fn voxel_six_separating_agrees_with_its_reference() {
    let gpu = shared();
    let mut figures = Vec::new();
    for scene in surfaces() {
        let (mut thin, mut thick) = (0, 0);
        // The finest only where the sweep runs whole.
        let sweep = [(32, Axis::X), (64, Axis::Y), (128, Axis::Z), (256, Axis::X)];
        for &(resolution, axis) in &sweep[..if harness::is_whole() { 4 } else { 3 }] {
            let grid = Grid::around(&bounds(&scene), resolution).unwrap();
            let voxels = voxelize(gpu, &scene, &grid, axis, true);
            let [missed, far, set] = compare(&voxels, &scene);
            println!("{} at {resolution} along {axis:?}: {set} set, {missed} missed, {far} too many", scene.name);
            assert!(missed == 0 && far == 0 && set > 0, "{} at {resolution}: {missed}, {far}", scene.name);
            let conservative = voxelize(gpu, &scene, &grid, axis, false);
            let both = voxels.bytes().iter().zip(conservative.bytes()).all(|(&a, b)| a <= b);
            assert!(both, "{} at {resolution}: a voxel is not among the conservative ones", scene.name);
            (thin, thick) = (thin + set, thick + conservative.count() as usize);
        }
        figures.push(Figure {
            what: format!("{}: voxels at 32, 64, 128, 256", scene.name),
            value: format!("{thin} set, {:.2} of the conservative, 0 missed, 0 too many", thin as f64 / thick as f64),
            bound: "equal but for ties of ε and 1e-4 voxel".into(),
        });
    }
    figures.push(leaks(gpu));
    silent(gpu);
    let picture = harness::require_scene("Koala/Koala.glb").map(|path| {
        let scene = Scene::load(&path).unwrap();
        front("Koala", &voxelize(gpu, &scene, &Grid::around(&bounds(&scene), 160).unwrap(), Axis::Z, true))
    });
    figures::publish(gpu, "voxel", "six_separating", &figures, picture.as_ref());
}

/// Voxels inside closed surfaces that a walk from outside reaches.
fn leaks(gpu: &Gpu) -> Figure {
    let (mut inside, mut reached) = (0, 0);
    for turn in 0..9 {
        let turned = Mat4::from_rotation_x(0.41 * turn as f32) * awkward();
        for primitive in [torus(40, 20), tiny::sphere(24, 12, 0), tiny::cuboid(-Vec3::ONE, Vec3::ONE, 0)] {
            let scene = tiny::one("closed", vec![(primitive, turned)]);
            // Two voxels of room on every side, so that the walk can get around.
            let around = Grid::around(&bounds(&scene), 28).unwrap();
            let grid = Grid::new(around.min() - 2.0 * around.edge(), around.edge(), [32; 3]).unwrap();
            let set: Vec<_> = voxelize(gpu, &scene, &grid, Axis::Z, true).bytes().iter().map(|&b| b == 1).collect();
            let walked = twin::voxel::reached(&set, grid.size());
            let solid = twin::voxel::solid(&twin::voxel::in_grid(&scene, &grid), grid.size());
            let within = |i: &usize| solid[*i] && !set[*i];
            inside += (0..set.len()).filter(within).count();
            reached += (0..set.len()).filter(within).filter(|&i| walked[i]).count();
        }
    }
    assert!(inside > 10_000 && reached == 0, "{reached} of {inside}");
    Figure {
        what: "27 closed surfaces: voxels inside that a walk from outside reaches".into(),
        value: format!("{reached} of {inside}"),
        bound: "none".into(),
    }
}

#[test]
fn voxel_six_separating_with_a_seeded_mistake_is_caught() {
    let gpu = shared();
    let truth = tiny::one("torus", vec![(torus(32, 16), awkward())]);
    let grid = Grid::around(&bounds(&truth), 64).unwrap();
    let wrong = |scene: &Scene| compare(&voxelize(gpu, scene, &grid, Axis::Z, true), &truth);
    assert_eq!(wrong(&truth)[..2], [0, 0]);
    // A hundredth of a voxel aside: voxels are missed, and others too many.
    let mut aside = truth.clone();
    aside.objects[0].world_from_object = Mat4::from_translation(Vec3::X * 0.01 * grid.edge()) * awkward();
    let [missed, far, _] = wrong(&aside);
    assert!(missed > 0 && far > 0);
    // The conservative voxels are too many.
    let [missed, far, _] = compare(&voxelize(gpu, &truth, &grid, Axis::Z, false), &truth);
    assert!(missed == 0 && far > 0);
    silent(gpu);
}

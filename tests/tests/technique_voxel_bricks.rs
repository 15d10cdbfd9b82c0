//! Thickness voxels in bricks against those of the whole grid, and where that does not fit against separating axes.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{DVec3, Mat4, Vec3};
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::Scene;
use shadowgraph::techniques::voxel::bricks::{Bricks, Thickness};
use shadowgraph::techniques::voxel::conservative::Conservative;
use shadowgraph::techniques::voxel::six_separating::SixSeparating;
use shadowgraph::techniques::voxel::{Axis, Grid, Voxels};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Figure};
use shadowgraph_tests::solids::{self, awkward, bounds, surfaces, torus};
use shadowgraph_tests::voxel_pictures::front;
use shadowgraph_tests::{harness, tiny, twin};

/// How far beyond ε a voxel may be from the triangle that set it, in voxels.
const FAR: f64 = 1e-4;

fn in_bricks(gpu: &Gpu, scene: &Scene, grid: &Grid, thickness: Thickness) -> Voxels {
    let find = || -> shadowgraph::Result<Voxels> {
        let scene = scene.clone().upload(gpu)?;
        let mut graph = Graph::new("bricks", gpu.caps());
        Bricks { thickness }.record(&mut graph, &scene, grid)?.capture(&mut graph);
        let plan = graph.compile(gpu)?;
        let executed = Executor::new(gpu).execute(&plan, graph)?;
        Voxels::read_bricks(&executed, grid)
    };
    find().unwrap_or_else(|error| panic!("{}: {error}", scene.name))
}

fn whole(gpu: &Gpu, scene: &Scene, grid: &Grid, thickness: Thickness) -> Voxels {
    solids::voxelize(gpu, scene, grid, |graph, scene| match thickness {
        Thickness::Conservative => Conservative::default().record(graph, scene, grid),
        Thickness::SixSeparating => {
            SixSeparating { axis: Axis::Z, ..SixSeparating::default() }.record(graph, scene, grid)
        }
    })
}

/// Voxels of a block that are touched and not set, or set and further than ε and [`FAR`] from every triangle; and those
/// that are set.
fn compare(voxels: &Voxels, truth: &Scene, first: [u32; 3], size: [u32; 3]) -> [usize; 3] {
    let grid = voxels.grid();
    let margin = f64::from(Conservative::margin(grid, &bounds(truth)));
    let lower = DVec3::from(first.map(f64::from));
    let mut triangles = twin::voxel::in_grid(truth, grid);
    triangles.iter_mut().flatten().for_each(|corner| *corner -= lower);
    let touched = |margin: f64| {
        twin::voxel::surface(&triangles, size, |triangle, center| twin::voxel::touches(triangle, center, 0.5 + margin))
    };
    let (least, most) = (touched(0.0), touched(margin + FAR));
    let block = Grid::new(Vec3::ZERO, 1.0, size).unwrap();
    let own = Voxels::from_fn(&block, |[x, y, z]| voxels.get([first[0] + x, first[1] + y, first[2] + z]));
    solids::mistakes(&own, &least, &most)
}

#[test]
fn voxel_bricks_agrees_with_its_reference() {
    let gpu = shared();
    let mut figures = Vec::new();
    // 1. As the whole grid has them.
    for scene in surfaces() {
        let [mut set, mut bytes, mut all] = [0; 3];
        for resolution in [30, 100, 256] {
            for thickness in [Thickness::Conservative, Thickness::SixSeparating] {
                let grid = Grid::around(&bounds(&scene), resolution).unwrap();
                let (own, whole) = (in_bricks(gpu, &scene, &grid, thickness), whole(gpu, &scene, &grid, thickness));
                assert!(own.set().eq(whole.set()), "{} at {resolution}: {thickness:?} voxels differ", scene.name);
                assert!(own.count() == whole.count() && own.count() > 0, "{}", scene.name);
                set += own.count();
                (bytes, all) = (bytes + own.memory(), all + whole.memory());
            }
        }
        figures.push(Figure {
            what: format!("{}: both kinds at 30, 100, 256, against the whole grid", scene.name),
            value: format!("{set} set, equal; {:.2} of its memory", bytes as f64 / all as f64),
            bound: "equal".into(),
        });
    }
    // 2. Where that does not fit: blocks on the surface of 2048³.
    let mut scenes = vec![tiny::one("torus", vec![(torus(48, 24), awkward())])];
    let koala = harness::require_scene("Koala/Koala.glb").map(|path| Scene::load(&path).unwrap());
    scenes.extend(koala.clone());
    for scene in scenes {
        let grid = Grid::around(&bounds(&scene), 2048).unwrap();
        let own = in_bricks(gpu, &scene, &grid, Thickness::Conservative);
        let every = own.count() as usize / 9;
        let [mut missed, mut far, mut set] = [0; 3];
        for at in own.set().step_by(every).skip(1) {
            let found = compare(&own, &scene, at.map(|i| i.saturating_sub(20)), [40; 3]);
            [missed, far, set] = [missed + found[0], far + found[1], set + found[2]];
        }
        assert!(missed == 0 && far == 0 && set > 5000, "{}: {missed} missed, {far} too many, {set}", scene.name);
        figures.push(Figure {
            what: format!("{} at 2048: blocks of 40³", scene.name),
            value: format!(
                "{set} set, 0 missed, 0 too many; {} set in all, {:.0} MiB of 1024",
                own.count(),
                own.memory() as f64 / f64::from(1 << 20)
            ),
            bound: "none missed; none further than ε and 1e-4 voxel".into(),
        });
    }
    silent(gpu);
    let picture = koala.map(|scene| {
        let grid = Grid::around(&bounds(&scene), 480).unwrap();
        front("Koala", &in_bricks(gpu, &scene, &grid, Thickness::Conservative))
    });
    figures::publish(gpu, "voxel", "bricks", &figures, picture.as_ref());
}

#[test]
fn voxel_bricks_with_a_seeded_mistake_is_caught() {
    let gpu = shared();
    let truth = tiny::one("torus", vec![(torus(32, 16), awkward())]);
    let grid = Grid::around(&bounds(&truth), 64).unwrap();
    let wrong = |scene: &Scene, thickness| compare(&in_bricks(gpu, scene, &grid, thickness), &truth, [0; 3], [64; 3]);
    assert_eq!(wrong(&truth, Thickness::Conservative)[..2], [0, 0]);
    // A hundredth of a voxel aside; as thin as need be.
    let mut aside = truth.clone();
    aside.objects[0].world_from_object = Mat4::from_translation(Vec3::X * 0.01 * grid.edge()) * awkward();
    let [missed, far, _] = wrong(&aside, Thickness::Conservative);
    assert!(missed > 0 && far > 0);
    assert!(wrong(&truth, Thickness::SixSeparating)[0] > 0);
    silent(gpu);
}

#[test]
fn portable_what_touches_bricks_from_outside_is_found() {
    let gpu = shared();
    // A square on a plane between bricks, one that nearly touches it, and one beside the grid.
    let square = |corner: Vec3| (tiny::quad(corner, Vec3::X * 20.0, Vec3::Y * 20.0, 0), Mat4::IDENTITY);
    let parts = [[2.0, 2.0, 8.0], [2.0, 2.0, 16.00009], [2.0, 2.0, 40.0]].map(|at| square(Vec3::from(at)));
    let scene = tiny::one("squares", parts.to_vec());
    let grid = Grid::new(Vec3::ZERO, 1.0, [30, 31, 33]).unwrap();
    for thickness in [Thickness::Conservative, Thickness::SixSeparating] {
        let (own, whole) = (in_bricks(gpu, &scene, &grid, thickness), whole(gpu, &scene, &grid, thickness));
        assert!(own.set().eq(whole.set()) && own.count() > 100, "{thickness:?}");
    }
    let nothing = in_bricks(gpu, &tiny::empty(), &grid, Thickness::Conservative);
    assert_eq!((nothing.count(), nothing.set().count()), (0, 0));
    silent(gpu);
}

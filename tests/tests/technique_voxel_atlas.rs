//! Voxels of an atlas's texels against their points in double precision; holes.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{Mat4, Vec2, Vec3};
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::{Primitive, Scene};
use shadowgraph::techniques::voxel::atlas::{Atlas, Charts, Stretch};
use shadowgraph::techniques::voxel::six_separating::SixSeparating;
use shadowgraph::techniques::voxel::{Axis, Grid, Voxels};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Figure};
use shadowgraph_tests::harness;
use shadowgraph_tests::solids::{self, awkward, bounds, surfaces, torus};
use shadowgraph_tests::voxel_pictures::front;
use shadowgraph_tests::{tiny, twin};

fn voxelize(gpu: &Gpu, scene: &Scene, grid: &Grid, atlas: Atlas) -> Voxels {
    solids::voxelize(gpu, scene, grid, |graph, scene| atlas.record(graph, scene, grid))
}

/// Voxels that must be set and are not; that are set and must not be; that are set.
fn compare(voxels: &Voxels, truth: &Scene, charts: Charts) -> [usize; 3] {
    let grid = voxels.grid();
    let (laid, side) = match charts {
        Charts::ByAxis { per_voxel } => {
            let side = (grid.size()[0] as f32 * per_voxel).ceil() as u32;
            (twin::atlas::by_axis(&twin::voxel::in_grid(truth, grid), per_voxel.into()), side)
        }
        Charts::SecondUvs { side } => (twin::atlas::second_uvs(truth, grid, side.into()), side),
    };
    let snap = twin::atlas::snap(shared().caps().limits.sub_pixel_bits);
    let [must, may] = twin::atlas::voxels(&laid, side, grid.size(), snap);
    solids::mistakes(voxels, &must, &may)
}

/// A wavy sheet whose second texture coordinates run along it unevenly, some of them below 0.
fn sheet() -> Primitive {
    let point = |i: u32, k: u32| {
        let [x, y] = [i, k].map(|n| n as f32 / 20.0);
        Vec3::new(x, y, 0.2 * (7.0 * x + 3.0 * y).sin())
    };
    let quads = (0..20).flat_map(|i| (0..20).map(move |k| [i, k]));
    let corners = quads.flat_map(|[i, k]| [[i, k], [i + 1, k], [i + 1, k + 1], [i, k], [i + 1, k + 1], [i, k + 1]]);
    let corners: Vec<_> = corners.collect();
    let points: Vec<_> = corners.iter().map(|&[i, k]| point(i, k)).collect();
    let mut sheet = tiny::triangles(points.as_chunks().0, 0);
    let uv = |&[i, k]: &[u32; 2]| Vec2::new((i as f32 / 20.0).powf(1.5) - 0.3, 2.0 * k as f32 / 20.0);
    sheet.uvs[1] = corners.iter().map(uv).collect();
    sheet
}

/// Laid out by hand: a sheet, the same one twice in one place of the atlas, and a sphere whose poles are pinched.
fn laid_out() -> Vec<Scene> {
    let aside = Mat4::from_translation(Vec3::new(0.3, 0.2, 0.7)) * awkward();
    vec![
        tiny::one("sheet", vec![(sheet(), awkward())]),
        tiny::one("two sheets in one place of the atlas", vec![(sheet(), awkward()), (sheet(), aside)]),
        tiny::one("sphere", vec![(tiny::sphere(32, 16, 0), awkward())]),
    ]
}

fn check(gpu: &Gpu, scene: &Scene, resolution: u32, atlas: Atlas) -> usize {
    let grid = Grid::around(&bounds(scene), resolution).unwrap();
    let [missed, far, set] = compare(&voxelize(gpu, scene, &grid, atlas), scene, atlas.charts);
    println!("{} at {resolution}, {:?}: {set} set, {missed} missed, {far} too many", scene.name, atlas.charts);
    // What has no area has no texels.
    let some = set > 0 || scene.name.contains("without area");
    assert!(missed == 0 && far == 0 && some, "{} at {resolution}, {atlas:?}: {missed}, {far}, {set}", scene.name);
    set
}

#[test]
fn voxel_atlas_agrees_with_its_reference() {
    let gpu = shared();
    let mut figures = Vec::new();
    for scene in surfaces() {
        let mut set = 0;
        for (resolution, axis, per_voxel) in
            [(32, Axis::X, 2.0), (64, Axis::Y, 1.0), (128, Axis::Z, 3.0), (256, Axis::X, 1.5)]
        {
            set += check(gpu, &scene, resolution, Atlas { axis, charts: Charts::ByAxis { per_voxel } });
        }
        figures.push(figure(format!("{}, charts by axis: voxels at 32, 64, 128, 256", scene.name), set));
    }
    for scene in laid_out() {
        let mut set = 0;
        for (resolution, axis, side) in [(32, Axis::Y, 100), (64, Axis::Z, 333), (128, Axis::X, 1024)] {
            set += check(gpu, &scene, resolution, Atlas { axis, charts: Charts::SecondUvs { side } });
        }
        figures.push(figure(format!("{}, second texture coordinates: voxels at 32, 64, 128", scene.name), set));
    }
    figures.extend(holes(gpu));
    silent(gpu);
    let picture = harness::require_scene("Spot/Spot.gltf").map(|path| {
        let scene = Scene::load(&path).unwrap();
        let grid = Grid::around(&bounds(&scene), 160).unwrap();
        front(
            "Spot",
            &voxelize(gpu, &scene, &grid, Atlas { charts: Charts::ByAxis { per_voxel: 1.0 }, ..Atlas::default() }),
        )
    });
    figures::publish(gpu, "voxel", "atlas", &figures, picture.as_ref());
}

fn figure(what: String, set: usize) -> Figure {
    let bound = "equal but for 1/100 texel around edges and what that moves points by".into();
    Figure { what, value: format!("{set} set, 0 missed, 0 too many"), bound }
}

/// Thin voxels that no texel's point sets, and all of them; by the device, and checked on the host.
fn count_holes(gpu: &Gpu, scene: &Scene, grid: &Grid, charts: Charts) -> [u32; 2] {
    let uploaded = scene.clone().upload(gpu).unwrap();
    let mut graph = Graph::new("holes", gpu.caps());
    let thin = SixSeparating::default().record(&mut graph, &uploaded, grid).unwrap();
    let found = Atlas { charts, ..Atlas::default() }.record(&mut graph, &uploaded, grid).unwrap();
    let holes = Atlas::holes(&mut graph, &thin, &found).unwrap();
    graph.capture("thin", &thin.bits);
    graph.capture("found", &found.bits);
    graph.capture("holes", &holes);
    let plan = graph.compile(gpu).unwrap();
    let executed = Executor::new(gpu).execute(&plan, graph).unwrap();
    let words = |name: &str| executed.capture(name).unwrap().texels::<u32>().unwrap();
    let (thin, found, holes) = (words("thin"), words("found"), words("holes")[0]);
    let missing: u32 = thin.iter().zip(&found).map(|(thin, found)| (thin & !found).count_ones()).sum();
    assert_eq!(holes, missing, "{}", scene.name);
    [holes, thin.iter().map(|word| word.count_ones()).sum()]
}

/// Finer atlases have fewer holes; with as many texels as the greatest stretch asks for, hardly any.
fn holes(gpu: &Gpu) -> Vec<Figure> {
    let mut figures = Vec::new();
    let scenes = [tiny::one("torus", vec![(torus(96, 48), awkward())]), tiny::one("sheet", vec![(sheet(), awkward())])];
    for scene in scenes {
        let grid = Grid::around(&bounds(&scene), 128).unwrap();
        let charts = |per_voxel: f32| -> Vec<Charts> {
            let stretch = Stretch::of(&scene, &grid).ok().filter(|_| scene.name == "sheet");
            let by_uvs = stretch.map(|stretch| stretch.charts(per_voxel));
            [Charts::ByAxis { per_voxel }].into_iter().chain(by_uvs).collect()
        };
        for layout in 0..charts(1.0).len() {
            let densities = [0.5, 1.0, 2.0, 4.0, 8.0];
            let found = densities.map(|density| count_holes(gpu, &scene, &grid, charts(density)[layout]));
            let shares = found.map(|[holes, all]| f64::from(holes) / f64::from(all));
            let name = match charts(1.0)[layout] {
                Charts::ByAxis { .. } => "charts by axis",
                Charts::SecondUvs { .. } => "second texture coordinates",
            };
            println!("{}, {name}: {shares:?}", scene.name);
            assert!(shares.is_sorted_by(|a, b| a >= b) && shares[0] > 0.01, "{}: {shares:?}", scene.name);
            assert!(shares[4] < 0.0005, "{}: {shares:?}", scene.name);
            let percent: Vec<_> = shares.iter().map(|share| format!("{:.3} %", 100.0 * share)).collect();
            figures.push(Figure {
                what: format!(
                    "{} at 128³, {name}: thin voxels without a texel, at ½, 1, 2, 4, 8 texels a voxel",
                    scene.name
                ),
                value: percent.join(", "),
                bound: "fewer and fewer, below 0.05 % at last".into(),
            });
        }
    }
    figures
}

#[test]
fn portable_voxel_atlas_of_a_torus() {
    let torus = tiny::one("torus", vec![(torus(48, 24), awkward())]);
    check(shared(), &torus, 64, Atlas::default());
    check(shared(), &laid_out()[0], 64, Atlas { charts: Charts::SecondUvs { side: 200 }, ..Atlas::default() });
    silent(shared());
}

#[test]
fn what_cannot_be_laid_out_is_an_error() {
    let torus = tiny::one("torus", vec![(torus(48, 24), awkward())]);
    let grid = Grid::around(&bounds(&torus), 64).unwrap();
    let fails = |charts: Charts| {
        let scene = torus.clone().upload(shared()).unwrap();
        let mut graph = Graph::new("atlas", shared().caps());
        Atlas { charts, ..Atlas::default() }.record(&mut graph, &scene, &grid).err().unwrap().to_string()
    };
    assert!(fails(Charts::SecondUvs { side: 100 }).contains("no second texture coordinates"));
    assert!(fails(Charts::ByAxis { per_voxel: 1e4 }).contains("draws at most"));
}

#[test]
fn voxel_atlas_with_a_seeded_mistake_is_caught() {
    let gpu = shared();
    let truth = tiny::one("torus", vec![(torus(32, 16), awkward())]);
    let grid = Grid::around(&bounds(&truth), 64).unwrap();
    let charts = Charts::ByAxis { per_voxel: 2.0 };
    let wrong = |scene: &Scene, found: Charts| {
        compare(&voxelize(gpu, scene, &grid, Atlas { charts: found, ..Atlas::default() }), &truth, charts)
    };
    assert_eq!(wrong(&truth, charts)[..2], [0, 0]);
    // Texels a tenth of a voxel aside, and fewer of them.
    let mut aside = truth.clone();
    aside.objects[0].world_from_object = Mat4::from_translation(Vec3::X * 0.1 * grid.edge()) * awkward();
    let [missed, far, _] = wrong(&aside, charts);
    assert!(missed > 0 && far > 0, "{missed}, {far}");
    assert!(wrong(&truth, Charts::ByAxis { per_voxel: 1.5 })[0] > 0);
    silent(gpu);
}

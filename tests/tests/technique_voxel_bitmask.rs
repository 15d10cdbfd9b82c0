//! Voxels from one pass of XOR or OR against crossings along rays.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{Mat4, Vec3};
use shadowgraph::gpu::Gpu;
use shadowgraph::scene::{Camera, Primitive, Projection, Scene};
use shadowgraph::techniques::voxel::bitmask::{Bitmask, Combine, Fill};
use shadowgraph::techniques::voxel::{Axis, FrustumBits, FrustumGrid, Grid, VoxelBits, Voxels};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Figure};
use shadowgraph_tests::harness;
use shadowgraph_tests::plot::LogPlot;
use shadowgraph_tests::solids::{self, awkward, bounds, soup, torus};
use shadowgraph_tests::twin::frustum::Sight;
use shadowgraph_tests::voxel_pictures::front;
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
                .map(|combine| voxelize(gpu, &scene, &grid, Bitmask { axis, combine, ..Bitmask::default() }));
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
        front("Spot", &voxelize(gpu, &scene, &grid, Bitmask::default()))
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
            let scene = tiny::one(name, vec![(primitive.clone(), turned)]);
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
    let truth = tiny::one("torus", vec![(torus(48, 24), awkward())]);
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
    let cube = tiny::one("cube", vec![(tiny::cuboid(Vec3::ZERO, Vec3::splat(8.0), 0), Mat4::IDENTITY)]);
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        for combine in [Combine::Bit, Combine::Masks, Combine::LogicOp] {
            let technique = Bitmask { axis, combine, ..Bitmask::default() };
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
    let scene = tiny::one("tetrahedra", vec![(soup(50), Mat4::IDENTITY)]);
    let grid = Grid::new(Vec3::splat(-0.1), 0.01, [120, 110, 130]).unwrap();
    for fill in [Fill::Solid, Fill::Surface] {
        let voxels = [Combine::Bit, Combine::Masks, Combine::LogicOp]
            .map(|combine| voxelize(gpu, &scene, &grid, Bitmask { axis: Axis::Y, combine, fill }));
        assert!(voxels[0].count() > 1000 && voxels[0] == voxels[1] && voxels[0] == voxels[2], "{fill:?}");
    }
    silent(gpu);
}

#[test]
fn columns_deeper_than_a_pass_are_the_same_by_logic_operation() {
    let gpu = shared();
    let far = tiny::cuboid(Vec3::new(0.44, 0.44, 0.9), Vec3::new(0.46, 0.47, 1.03), 0);
    let scene = tiny::one("tetrahedra", vec![(soup(50), Mat4::IDENTITY), (far, Mat4::IDENTITY)]);
    // Whole passes of 1024 slices, and a last one of a single target.
    for slices in [1024, 1025, 1300, 2048] {
        // A thin grid through the middle.
        let grid = Grid::new(Vec3::new(0.45, 0.45, -0.1), 1.2 / slices as f32, [64, 60, slices]).unwrap();
        for fill in [Fill::Solid, Fill::Surface] {
            let [bit, targets] = [Combine::Bit, Combine::LogicOp]
                .map(|combine| voxelize(gpu, &scene, &grid, Bitmask { axis: Axis::Z, combine, fill }));
            assert!(bit.count() > 1000 && bit == targets, "{slices} slices, {fill:?}: {} set", bit.count());
            let beyond = bit.set().filter(|voxel| voxel[2] >= 1024).count();
            assert!(slices < 1300 || beyond > 100, "{slices} slices, {fill:?}: {beyond} beyond the first pass");
        }
    }
    silent(gpu);
}

/// Before a scene, in its middle, and with parallel lines of sight.
fn frusta(scene: &Scene, size: [u32; 3]) -> [(&'static str, FrustumGrid); 3] {
    let around = bounds(scene);
    let (middle, radius, [width, height, slices]) = (around.center(), around.radius(), size);
    let pixels = [width, height];
    let before = Camera::framing(around, 0.7, width as f32 / height as f32).view(pixels);
    let inside = middle + radius * Vec3::new(0.21, 0.13, 0.34);
    let inside = Camera::look_at(inside, inside + Vec3::new(-0.4, -0.2, -1.0), Vec3::Y, 1.3, 0.1).view(pixels);
    let mut parallel = Camera::look_at(middle, middle - Vec3::new(0.5, 0.7, 0.9), Vec3::Y, 1.0, 0.1);
    parallel.projection = Projection::Orthographic { half_height: 0.8 * radius, near: 0.0, far: 1.0 };
    let reach = [-0.7 * radius, 0.9 * radius];
    [
        ("before the scene", FrustumGrid::around(&before, &around, slices).unwrap()),
        ("within the scene", FrustumGrid::new(&inside, [0.02 * radius, 1.2 * radius], slices).unwrap()),
        ("with parallel lines of sight", FrustumGrid::new(&parallel.view(pixels), reach, slices).unwrap()),
    ]
}

/// Closed solids, all of them where sweeps run whole.
fn some_closed() -> Vec<Scene> {
    solids::closed().into_iter().step_by(if harness::is_whole() { 1 } else { 4 }).collect()
}

fn in_sight(gpu: &Gpu, scene: &Scene, frustum: &FrustumGrid, technique: Bitmask) -> Voxels {
    solids::voxelize(gpu, scene, &frustum.grid(), |graph, scene| {
        let FrustumBits { bits, frustum } = technique.record_frustum(graph, scene, frustum)?;
        Ok(VoxelBits { bits, grid: frustum.grid(), axis: Axis::Z })
    })
}

/// Voxels that agree, that differ beside a triangle, and that differ elsewhere; those that are set. Of solids, then of
/// surfaces.
fn compare_in_sight(truth: &Scene, frustum: &FrustumGrid, [solid, surface]: [&Voxels; 2]) -> [[usize; 4]; 2] {
    let sight = Sight::new(truth, frustum);
    let inside = sight.solid();
    let [must, may] = sight.surface(solids::NEAR);
    let [width, height, _] = frustum.grid().size().map(|n| n as usize);
    let count = |voxels: &Voxels, kind: &dyn Fn([usize; 3], bool, usize) -> usize| {
        let mut counts = [0; 4];
        for (index, byte) in voxels.bytes().into_iter().enumerate() {
            let voxel = [index % width, index / width % height, index / width / height];
            counts[kind(voxel, byte == 1, index)] += 1;
            counts[3] += usize::from(byte);
        }
        counts
    };
    let far = |voxel, whole| 1 + usize::from(!sight.is_beside(voxel, solids::NEAR, whole));
    let solid = count(solid, &|voxel, set, index| if set == inside[index] { 0 } else { far(voxel, false) });
    let surface = count(surface, &|voxel, set, index| match set {
        true if !may[index] => far(voxel, true),
        false if must[index] => 2,
        _ => 0,
    });
    [solid, surface]
}

#[test]
fn a_frustum_agrees_with_its_reference() {
    let gpu = shared();
    let sizes: &[[u32; 3]] = if harness::is_whole() { &[[61, 47, 40], [150, 120, 100]] } else { &[[61, 47, 40]] };
    let mut counts: [[[usize; 4]; 2]; 3] = Default::default();
    let mut names = [""; 3];
    for scene in some_closed() {
        for &size in sizes {
            for (which, (name, frustum)) in frusta(&scene, size).into_iter().enumerate() {
                let of = |fill: Fill| {
                    let [bit, masks, targets] = [Combine::Bit, Combine::Masks, Combine::LogicOp]
                        .map(|combine| in_sight(gpu, &scene, &frustum, Bitmask { axis: Axis::X, combine, fill }));
                    assert!(bit == masks && bit == targets, "{}: the ways to combine bits differ", scene.name);
                    bit
                };
                let [solid, surface] = [of(Fill::Solid), of(Fill::Surface)];
                let found = compare_in_sight(&scene, &frustum, [&solid, &surface]);
                println!("{} {name} at {size:?}: solid and surface {found:?}", scene.name);
                for [agree, near, far, _] in found {
                    assert!(far == 0 && near < agree / 100, "{} {name} at {size:?}: {found:?}", scene.name);
                }
                counts[which].iter_mut().zip(found).for_each(|(sum, own)| (0..4).for_each(|i| sum[i] += own[i]));
                names[which] = name;
            }
        }
    }
    silent(gpu);
    let mut figures = Vec::new();
    for (name, counts) in names.into_iter().zip(counts) {
        for (what, [agree, near, _, set]) in ["solids", "surfaces"].into_iter().zip(counts) {
            assert!(set > 1000, "{what} {name}: {set} set");
            figures.push(Figure {
                what: format!("in the frustum of a camera {name}: {what} of all scenes above"),
                value: format!("0 of {} differ, {near} left out; {set} set", agree + near),
                bound: "none differs; left out within 1/128 pixel and slice of a surface".into(),
            });
        }
    }
    let by = "technique_voxel_bitmask, a_frustum_agrees_with_its_reference";
    figures::publish_page("techniques/voxel/bitmask.md", by, &gpu.caps().title(), &figures);
    if let Some(path) = harness::require_scene("Spot/Spot.gltf") {
        let scene = Scene::load(&path).unwrap();
        let view = Camera::framing(bounds(&scene), 0.9, 1.0).view([160, 160]);
        let frustum = FrustumGrid::around(&view, &bounds(&scene), 160).unwrap();
        let found = in_sight(gpu, &scene, &frustum, Bitmask::default());
        // The picture has its rows from the bottom.
        let upright = Voxels::from_fn(found.grid(), |[x, y, z]| found.get([x, 159 - y, z]));
        figures::publish_picture("techniques/voxel", "bitmask_frustum", &front("Spot in a frustum", &upright));
    }
}

#[test]
fn a_frustum_with_a_seeded_mistake_is_caught() {
    let gpu = shared();
    let truth = tiny::one("torus", vec![(torus(48, 24), awkward())]);
    for (name, frustum) in frusta(&truth, [60, 60, 60]) {
        let far = |scene: &Scene| {
            let [solid, surface] = [Fill::Solid, Fill::Surface]
                .map(|fill| in_sight(gpu, scene, &frustum, Bitmask { fill, ..Bitmask::default() }));
            compare_in_sight(&truth, &frustum, [&solid, &surface]).map(|counts| counts[2])
        };
        assert_eq!(far(&truth), [0, 0], "{name}");
        // A twentieth of a slice aside; a triangle lost.
        let mut aside = truth.clone();
        let toward = frustum.view().world_from_view.z_axis.truncate() * 0.05 * frustum.thickness();
        aside.objects[0].world_from_object = Mat4::from_translation(toward) * awkward();
        assert!(far(&aside).iter().all(|&far| far > 0), "{name}");
        let mut holed = truth.clone();
        holed.meshes[0].primitives[0].indices.truncate(3 * 1000);
        assert!(far(&holed).iter().all(|&far| far > 0), "{name}");
    }
    silent(gpu);
}

#[test]
fn surfaces_along_an_axis_are_those_of_parallel_lines_of_sight() {
    let gpu = shared();
    for scene in some_closed().into_iter().filter(|scene| scene.name != "cube") {
        // The same columns seen by a camera along −z, whose picture has its rows from the top.
        let grid = Grid::around(&bounds(&scene), 64).unwrap();
        let width = 64.0 * grid.edge();
        let eye = grid.min() + width * Vec3::new(0.5, 0.5, 1.0);
        let mut camera = Camera::look_at(eye, eye - Vec3::Z, Vec3::Y, 1.0, 0.1);
        camera.projection = Projection::Orthographic { half_height: 0.5 * width, near: 0.0, far: width };
        let frustum = FrustumGrid::new(&camera.view([64, 64]), [0.0, width], 64).unwrap();
        let upside_down = |fill| {
            let found = voxelize(gpu, &scene, &grid, Bitmask { fill, ..Bitmask::default() });
            Voxels::from_fn(&frustum.grid(), |[x, y, z]| found.get([x, 63 - y, z]))
        };
        let found = [Fill::Solid, Fill::Surface].map(upside_down);
        let [_, [agree, near, far, set]] = compare_in_sight(&scene, &frustum, found.each_ref());
        assert!(far == 0 && near < agree / 100 && set > 100, "{}: {near} near, {far} far of {set}", scene.name);
    }
    silent(gpu);
}

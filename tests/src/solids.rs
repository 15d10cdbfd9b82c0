//! Solids to voxelize, and what is asked of their voxels.

use glam::{DVec3, EulerRot, Mat4, Quat, Vec3};
use shadowgraph::Result;
use shadowgraph::geometry::Aabb;
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::{GpuScene, Primitive, Scene};
use shadowgraph::techniques::voxel::bitmask::Bitmask;
use shadowgraph::techniques::voxel::{Axis, FillRule, Grid, VoxelBits, Voxels};

use crate::figures::Figure;
use crate::{harness, tiny, twin};

/// The voxels that a technique finds.
pub fn voxelize(
    gpu: &Gpu,
    scene: &Scene,
    grid: &Grid,
    record: impl for<'f> FnOnce(&mut Graph<'f>, &'f GpuScene) -> Result<VoxelBits>,
) -> Voxels {
    let find = || -> Result<Voxels> {
        let scene = scene.clone().upload(gpu)?;
        let mut graph = Graph::new("voxelize", gpu.caps());
        let VoxelBits { bits, axis, .. } = record(&mut graph, &scene)?;
        graph.capture("bits", &bits);
        let plan = graph.compile(gpu)?;
        let executed = Executor::new(gpu).execute(&plan, graph)?;
        Voxels::read(executed.capture("bits")?, grid, axis)
    };
    find().unwrap_or_else(|error| panic!("{}: {error}", scene.name))
}

/// Voxels that must be set and are not, that are set and must not be, and that are set; `[z][y][x]`.
pub fn mistakes(voxels: &Voxels, must: &[bool], may: &[bool]) -> [usize; 3] {
    let bytes = voxels.bytes();
    let count = |wrong: &dyn Fn(usize) -> bool| (0..bytes.len()).filter(|&i| wrong(i)).count();
    [count(&|i| must[i] && bytes[i] == 0), count(&|i| !may[i] && bytes[i] == 1), count(&|i| bytes[i] == 1)]
}

/// What a rasteriser may do to a surface, in voxels: it snaps vertices to 1/256 of a pixel.
pub const NEAR: f64 = 1.0 / 128.0;

/// Voxels that agree with what is inside, that differ where a triangle is at most 1/128 voxel away, and that differ
/// elsewhere. `triangles` in grid coordinates, `inside` as `[z][y][x]`.
pub fn compare(voxels: &Voxels, triangles: &[[DVec3; 3]], inside: &[bool]) -> [usize; 3] {
    let [nx, ny, _] = voxels.grid().size().map(|n| n as usize);
    let mut counts = [0; 3];
    for (index, (&found, &inside)) in voxels.bytes().iter().zip(inside).enumerate() {
        let center = DVec3::new((index % nx) as f64, (index / nx % ny) as f64, (index / nx / ny) as f64) + 0.5;
        let agrees = (found == 1) == inside;
        counts[if agrees { 0 } else { 1 + usize::from(!twin::voxel::is_near(center, triangles, NEAR)) }] += 1;
    }
    counts
}

/// Figures of a technique that counts both faces, over [`closed`] at 32, 64, 128 and 256: by the non-zero rule against
/// winding numbers along rays, by the even-odd rule against the bits of [`Bitmask`]. Where sweeps do not run whole, the
/// first `few` resolutions must do.
pub fn by_both_rules(gpu: &Gpu, few: usize, find: impl Fn(&Scene, &Grid, Axis, FillRule) -> Voxels) -> Vec<Figure> {
    let mut figures = Vec::new();
    for scene in closed() {
        let [mut compared, mut left_out] = [0; 2];
        let sweep = [(32, Axis::X), (64, Axis::Y), (128, Axis::Z), (256, Axis::X)];
        for &(resolution, axis) in &sweep[..if harness::is_whole() { 4 } else { few }] {
            let name = format!("{} at {resolution} along {axis:?}", scene.name);
            let grid = Grid::around(&bounds(&scene), resolution).unwrap_or_else(|error| panic!("{error}"));
            let triangles = twin::voxel::in_grid(&scene, &grid);
            let wound: Vec<_> =
                twin::voxel::windings(&triangles, grid.size()).into_iter().map(|winding| winding != 0).collect();
            let voxels = find(&scene, &grid, axis, FillRule::NonZero);
            let [agree, near, far] = compare(&voxels, &triangles, &wound);
            println!("{name}: {} set, {agree} agree, {near} differ near, {far} far", voxels.count());
            // The cube's faces lie on voxel centres, where either answer is right.
            let most = if scene.name == "cube" { 8 } else { 100 };
            assert!(far == 0 && voxels.count() > 0 && near < agree / most, "{name}: {far} voxels");
            let bitmask = voxelize(gpu, &scene, &grid, |graph, scene| {
                Bitmask { axis, ..Bitmask::default() }.record(graph, scene, &grid)
            });
            assert!(find(&scene, &grid, axis, FillRule::EvenOdd) == bitmask, "{name}: not the bits of the bitmask");
            // Where no solid overlaps itself or another, both rules say the same.
            let overlaps = ["200 tetrahedra", "AnalyticSolids", "Boot", "Spot"].contains(&scene.name.as_str());
            assert!(overlaps || voxels == bitmask, "{name}: the rules differ");
            (compared, left_out) = (compared + agree + near, left_out + near);
        }
        figures.push(Figure {
            what: format!("{}: voxels at 32, 64, 128, 256", scene.name),
            value: format!("0 of {compared} differ, {left_out} left out; even-odd: the bitmask's bits"),
            bound: "none differs; left out within 1/128 voxel of a surface; equal bits".into(),
        });
    }
    figures
}

/// Mistakes that a comparison of windings must see.
pub fn mistakes_are_seen(find: impl Fn(&Scene, &Grid) -> Voxels) {
    let truth = tiny::one("torus", vec![(torus(48, 24), awkward())]);
    let grid = Grid::around(&bounds(&truth), 64).unwrap_or_else(|error| panic!("{error}"));
    let triangles = twin::voxel::in_grid(&truth, &grid);
    let wound: Vec<_> = twin::voxel::windings(&triangles, grid.size()).iter().map(|&winding| winding != 0).collect();
    let far = |change: &dyn Fn(&mut Scene)| {
        let mut scene = truth.clone();
        change(&mut scene);
        compare(&find(&scene, &grid), &triangles, &wound)[2]
    };
    assert_eq!(far(&|_| {}), 0);
    // A twentieth of a voxel aside; a triangle lost; a triangle turned around.
    let aside = Mat4::from_translation(Vec3::X * 0.05 * grid.edge()) * awkward();
    assert!(far(&|scene| scene.objects[0].world_from_object = aside) > 0);
    assert!(far(&|scene| drop(scene.meshes[0].primitives[0].indices.drain(..3))) > 0);
    assert!(far(&|scene| scene.meshes[0].primitives[0].indices.swap(0, 1)) > 0);
}

/// Two cubes that overlap are one by the rule that is not 0, and have a hole by the other one, as by XOR.
pub fn overlap_is_one(gpu: &Gpu, find: impl Fn(&Scene, &Grid, Axis, FillRule) -> Voxels) {
    let (scene, grid) = overlapping_cubes();
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        let of = |rule| find(&scene, &grid, axis, rule).count();
        let bitmask = Bitmask { axis, ..Bitmask::default() };
        let xor = voxelize(gpu, &scene, &grid, |graph, scene| bitmask.record(graph, scene, &grid)).count();
        assert_eq!([of(FillRule::NonZero), of(FillRule::EvenOdd), xor], [960, 896, 896], "{axis:?}");
    }
}

/// World-space bounds of all vertices.
pub fn bounds(scene: &Scene) -> Aabb {
    let objects = scene.objects.iter().flat_map(|object| {
        let points = scene.meshes[object.mesh].primitives.iter().flat_map(|p| &p.positions);
        points.map(|&p| object.world_from_object.transform_point3(p))
    });
    Aabb::around(objects).unwrap_or_else(|| panic!("{} has no vertex", scene.name))
}

/// A torus around the z axis, with radii 1 and 0.4, of `2 · around · across` triangles.
pub fn torus(around: u32, across: u32) -> Primitive {
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
pub fn soup(count: usize) -> Primitive {
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

/// A rotation that no axis of the grid survives.
pub fn awkward() -> Mat4 {
    Mat4::from_quat(Quat::from_euler(EulerRot::YXZ, 0.7313, 0.4127, 1.1931))
}

/// Closed solids that hurt.
pub fn closed() -> Vec<Scene> {
    let cuboid = |size: Vec3| tiny::cuboid(-0.5 * size, 0.5 * size, 0);
    let mut scenes = vec![
        tiny::one("sphere", vec![(tiny::sphere(64, 32, 0), Mat4::IDENTITY)]),
        tiny::one("torus, turned", vec![(torus(64, 32), awkward())]),
        tiny::one("cube", vec![(cuboid(Vec3::ONE), Mat4::IDENTITY)]),
        tiny::one("thin plate, turned", vec![(cuboid(Vec3::new(1.0, 1.0, 0.02)), awkward())]),
        tiny::one("needle, turned", vec![(cuboid(Vec3::new(1.0, 0.01, 0.01)), awkward())]),
        tiny::one("200 tetrahedra", vec![(soup(200), Mat4::IDENTITY)]),
        tiny::one("mirrored torus", vec![(torus(48, 24), Mat4::from_scale(Vec3::new(-1.0, 0.8, 1.1)) * awkward())]),
    ];
    for file in ["AnalyticSolids/AnalyticSolids.glb", "Boot/Boot.glb", "Spot/Spot.gltf"] {
        if let Some(path) = harness::require_scene(file) {
            scenes.push(Scene::load(&path).unwrap_or_else(|error| panic!("{error}")));
        }
    }
    scenes
}

/// Two cubes of 8³ voxels in a grid of 16³ that have 4³ of them in common; the second one is mirrored.
pub fn overlapping_cubes() -> (Scene, Grid) {
    let cube = tiny::cuboid(Vec3::ZERO, Vec3::splat(8.0), 0);
    let mirrored = Mat4::from_translation(Vec3::new(14.0, 6.0, 6.0)) * Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let scene =
        tiny::one("two cubes", vec![(cube.clone(), Mat4::from_translation(Vec3::splat(2.0))), (cube, mirrored)]);
    (scene, Grid::new(Vec3::ZERO, 1.0, [16; 3]).unwrap_or_else(|error| panic!("{error}")))
}

/// Surfaces that hurt: closed and open ones, slivers, triangles without area.
pub fn surfaces() -> Vec<Scene> {
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
        tiny::one("sphere", vec![(tiny::sphere(48, 24, 0), awkward())]),
        tiny::one("torus", vec![(torus(48, 24), awkward())]),
        tiny::one("large triangles", vec![(cuboid(Vec3::new(1.0, 0.7, 0.3)), awkward())]),
        tiny::one("needle", vec![(cuboid(Vec3::new(1.0, 0.004, 0.004)), awkward())]),
        tiny::one("slivers and triangles without area", vec![(tiny::triangles(&slivers, 0), Mat4::IDENTITY)]),
        tiny::one("100 tetrahedra", vec![(soup(100), Mat4::IDENTITY)]),
        tiny::one("mirrored torus", vec![(torus(32, 16), Mat4::from_scale(Vec3::new(-1.0, 0.8, 1.1)) * awkward())]),
    ];
    if let Some(path) = harness::require_scene("Demosthenes/Demosthenes.gltf") {
        scenes.push(Scene::load(&path).unwrap_or_else(|error| panic!("{error}")));
    }
    scenes
}

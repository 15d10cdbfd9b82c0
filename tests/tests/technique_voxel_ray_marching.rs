//! Walks through bits against whole numbers on the host, and against rays through the triangles.
#![allow(missing_docs, clippy::unwrap_used)]

use std::collections::HashMap;

use glam::{DVec3, Mat4, Vec3};
use shadowgraph::Result;
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::description::Access;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::{GpuScene, Scene};
use shadowgraph::techniques::voxel::bitmask::Bitmask;
use shadowgraph::techniques::voxel::bricks::{Bricks, Thickness};
use shadowgraph::techniques::voxel::conservative::Conservative;
use shadowgraph::techniques::voxel::ray_marching::{RayMarching, Segment};
use shadowgraph::techniques::voxel::six_separating::SixSeparating;
use shadowgraph::techniques::voxel::{Axis, Grid, Level, Occluders, VoxelBits, Voxels};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Figure, Picture};
use shadowgraph_tests::solids::{self, awkward, bounds, soup, torus};
use shadowgraph_tests::twin::scene::{Ray, Rule};
use shadowgraph_tests::voxel_pictures::lit;
use shadowgraph_tests::{harness, parallel, tiny, twin};

type Ends = [Vec3; 2];

/// What came of a grid of voxels and segments through it.
struct Marched {
    voxels: Voxels,
    /// By depth of levels: whether each segment is blocked.
    blocked: Vec<Vec<u32>>,
    pyramid: Vec<u32>,
    levels: Vec<Level>,
}

/// Depths of levels that segments are walked with; the answers must be the same.
const LEVELS: [u32; 4] = [0, 1, 3, u32::MAX];

fn march(
    gpu: &Gpu,
    scene: &Scene,
    grid: &Grid,
    segments: &[Ends],
    record: impl for<'f> Fn(&mut Graph<'f>, &'f GpuScene) -> Result<VoxelBits>,
) -> Marched {
    let scene = scene.clone().upload(gpu).unwrap();
    let segments: Vec<_> = segments.iter().map(|&[origin, end]| Segment::new(origin, end)).collect();
    let buffer = Segment::upload(gpu, &segments).unwrap();
    let mut blocked = Vec::new();
    let mut last = None;
    for levels in LEVELS {
        let mut graph = Graph::new("march", gpu.caps());
        let segments = graph.import_buffer(&buffer, Access::NONE, None);
        let voxels = record(&mut graph, &scene).unwrap();
        let occluders = Occluders::record(&mut graph, voxels);
        let words = RayMarching { levels }.record(&mut graph, &occluders, &segments);
        let Occluders { voxels, pyramid } = occluders;
        graph.capture("bits", &voxels.bits);
        graph.capture("pyramid", &pyramid.words);
        graph.capture("blocked", &words);
        let plan = graph.compile(gpu).unwrap();
        let executed = Executor::new(gpu).execute(&plan, graph).unwrap();
        let read = Voxels::read(executed.capture("bits").unwrap(), grid, voxels.axis).unwrap();
        blocked.push(executed.capture("blocked").unwrap().texels().unwrap());
        last = Some((read, executed.capture("pyramid").unwrap().texels().unwrap(), pyramid.levels().to_vec()));
    }
    let (voxels, pyramid, levels) = last.unwrap();
    Marched { voxels, blocked, pyramid, levels }
}

/// Numbers between 0 and 1.
fn random(mut seed: u64) -> impl FnMut() -> f32 {
    seed = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 40) as f32 / (1 << 24) as f32
    }
}

/// Segments within a grid, out of it and past it, along its axes, planes and diagonals, and points.
fn segments(grid: &Grid, count: usize) -> Vec<Ends> {
    let mut unit = random(7);
    let extent = Vec3::from(grid.size().map(|n| n as f32)) * grid.edge();
    let mut point = |margin: f32, whole: bool| {
        let p = Vec3::new(unit(), unit(), unit()) * (1.0 + 2.0 * margin) - margin;
        let voxels = p * extent / grid.edge();
        grid.min() + if whole { voxels.round() * grid.edge() } else { voxels * grid.edge() }
    };
    (0..count)
        .map(|i| {
            let (a, b) = match i % 8 {
                0..4 => (point(0.0, false), point(0.0, false)),
                4 => (point(0.5, false), point(0.5, false)),
                5 => (point(0.2, true), point(0.2, true)),
                6 => {
                    let a = point(0.1, i % 16 < 8);
                    (a, a + Vec3::new(1.0, if i % 3 == 0 { -1.0 } else { 0.0 }, 0.0) * 0.7 * extent)
                }
                _ => {
                    let a = point(0.0, false);
                    (a, a + if i % 3 == 0 { Vec3::ZERO } else { Vec3::splat(0.3 * grid.edge()) })
                }
            };
            [a, b]
        })
        .collect()
}

/// Whether each segment is blocked, by the twin.
fn walked(voxels: &Voxels, segments: &[Ends]) -> Vec<u32> {
    const ROW: usize = 1000;
    parallel::rows(segments.len().div_ceil(ROW), |row| {
        let part = &segments[row * ROW..segments.len().min((row + 1) * ROW)];
        let blocked = |&ends| u32::from(twin::walk::is_blocked(voxels.grid(), |voxel| voxels.get(voxel), ends));
        part.iter().map(blocked).collect()
    })
}

fn different(a: &[u32], b: &[u32]) -> usize {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

/// Voxels of pyramid levels that are not what the 2×2×2 below them say, and how many there are.
fn check_pyramid(marched: &Marched) -> [usize; 2] {
    let voxels = &marched.voxels;
    let axis = voxels.axis();
    let [mut wrong, mut compared] = [0; 2];
    let size = marched.levels[0].size;
    let mut finer: Vec<bool> = Vec::new();
    for [i, j, k] in places(size) {
        let mut world = [0; 3];
        axis.order().into_iter().zip([i, j, k]).for_each(|(axis, at)| world[axis] = at);
        finer.push(voxels.get(world));
    }
    for pair in marched.levels.windows(2) {
        let [below, level] = [pair[0], pair[1]];
        assert_eq!(level.size, below.size.map(|n| n.div_ceil(2)));
        let at = |[i, j, k]: [u32; 3]| ((k * below.size[1] + j) * below.size[0] + i) as usize;
        let mut coarser = Vec::new();
        for [i, j, k] in places(level.size) {
            let children = (0..8).map(|c| [2 * i + (c & 1), 2 * j + (c >> 1 & 1), 2 * k + (c >> 2)]);
            let mut inside = children.filter(|child| child.iter().zip(below.size).all(|(&at, n)| at < n));
            let expected = inside.any(|child| finer[at(child)]);
            let word = level.begin + (k / 32 * level.size[1] + j) * level.size[0] + i;
            wrong += usize::from((marched.pyramid[word as usize] >> (k % 32) & 1 == 1) != expected);
            compared += 1;
            coarser.push(expected);
        }
        finer = coarser;
    }
    [wrong, compared]
}

fn places([nx, ny, nz]: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])))
}

#[test]
fn voxel_ray_marching_agrees_with_its_reference() {
    let gpu = shared();
    let mut figures = vec![exactly(gpu)];
    figures.extend(against_triangles(gpu));
    silent(gpu);
    figures::publish(gpu, "voxel", "ray_marching", &figures, picture(gpu).as_ref());
}

/// Against whole numbers, bit for bit.
fn exactly(gpu: &Gpu) -> Figure {
    let scenes = [
        tiny::one("torus", vec![(torus(48, 24), awkward())]),
        tiny::one("100 tetrahedra", vec![(soup(100), Mat4::IDENTITY)]),
        tiny::one("needle", vec![(tiny::cuboid(Vec3::ZERO, Vec3::new(1.0, 0.01, 0.01), 0), awkward())]),
    ];
    let [mut compared, mut levels] = [0; 2];
    for (index, scene) in scenes.iter().enumerate() {
        let around = bounds(scene);
        let edge = (around.max - around.min).max_element() / 100.0;
        let odd = Grid::new(around.min - 3.3 * edge, edge, [101, 77, 83]).unwrap();
        let grids = [Grid::around(&around, 256).unwrap(), odd, Grid::around(&around, 8).unwrap()];
        for (grid, axis) in grids.iter().zip([Axis::Z, Axis::X, Axis::Y]) {
            let segments = segments(grid, 40_000);
            let marched = march(gpu, scene, grid, &segments, |graph, scene| match index {
                0 => Bitmask { axis, ..Bitmask::default() }.record(graph, scene, grid),
                _ => Conservative { axis, ..Conservative::default() }.record(graph, scene, grid),
            });
            let expected = walked(&marched.voxels, &segments);
            let blocked = expected.iter().sum::<u32>() as usize;
            println!("{} in {:?}: {blocked} of {} blocked", scene.name, grid.size(), segments.len());
            assert!(blocked > segments.len() / 200, "{}: nothing is in the way", scene.name);
            for (depth, found) in LEVELS.iter().zip(&marched.blocked) {
                let wrong = different(found, &expected);
                assert!(wrong == 0, "{} in {:?}, {depth} levels: {wrong} differ", scene.name, grid.size());
                compared += found.len();
            }
            let [wrong, voxels] = check_pyramid(&marched);
            assert!(
                wrong == 0 && voxels > 0,
                "{} in {:?}: {wrong} of {voxels} of the pyramid",
                scene.name,
                grid.size()
            );
            levels += voxels;
        }
    }
    Figure {
        what: "segments through torus, tetrahedra and needle, with 0, 1, 3 and all levels: whether blocked".into(),
        value: format!("0 of {compared} differ; 0 of {levels} voxels of pyramids"),
        bound: "equal to a walk in whole numbers".into(),
    }
}

/// Against rays through the triangles, at 256³.
fn against_triangles(gpu: &Gpu) -> Vec<Figure> {
    const COUNT: usize = 20_000;
    let mut scenes = vec![
        tiny::one("sphere", vec![(tiny::sphere(64, 32, 0), awkward())]),
        tiny::one("torus", vec![(torus(64, 32), awkward())]),
    ];
    for file in ["Boot/Boot.glb", "Spot/Spot.gltf"] {
        if let Some(path) = harness::require_scene(file) {
            scenes.push(Scene::load(&path).unwrap());
        }
    }
    let mut figures = Vec::new();
    for scene in &scenes {
        let grid = Grid::around(&bounds(scene), 256).unwrap();
        let solid =
            march(gpu, scene, &grid, &[[Vec3::ZERO; 2]], |graph, scene| Bitmask::default().record(graph, scene, &grid));
        let surface = march(gpu, scene, &grid, &[[Vec3::ZERO; 2]], |graph, scene| {
            Conservative::default().record(graph, scene, &grid)
        });
        let free = |p: Vec3| {
            let voxel = ((p - grid.min()) / grid.edge()).floor().clamp(Vec3::ZERO, Vec3::splat(255.0));
            let voxel = voxel.to_array().map(|i| i as u32);
            !solid.voxels.get(voxel) && !surface.voxels.get(voxel)
        };
        // 1. As many segments that triangles block as others, with ends in the open.
        let cast = twin::scene::Scene::new(scene);
        let is_blocked = |[a, b]: [DVec3; 2], beyond: f64| {
            let way = b - a;
            let mut ray = Ray::new(a, way);
            (ray.near, ray.far) = (-beyond / way.length(), 1.0 + beyond / way.length());
            cast.any(&ray, Rule::SHADOW)
        };
        let mut unit = random(3);
        let mut segments: Vec<Ends> = Vec::new();
        let mut blocked = 0;
        while segments.len() < COUNT {
            let mut point = || grid.min() + Vec3::new(unit(), unit(), unit()) * 256.0 * grid.edge();
            let ends = [point(), point()];
            if !free(ends[0]) || !free(ends[1]) {
                continue;
            }
            let is = is_blocked(ends.map(Vec3::as_dvec3), 0.0);
            let taken = if is { blocked } else { segments.len() - blocked };
            if taken < COUNT / 2 {
                segments.push(ends);
                blocked += usize::from(is);
            }
        }
        // 2. Those apart from silhouettes: moved by a voxel's diagonal to any side, or made longer or shorter by it, they
        // are as they were.
        let diagonal = f64::from(grid.edge()) * 3.0_f64.sqrt();
        let apart = parallel::rows(segments.len(), |index| {
            let [a, b] = segments[index].map(Vec3::as_dvec3);
            let (side, up) = (b - a).normalize().any_orthonormal_pair();
            let is = is_blocked([a, b], 0.0);
            let moved = (0..8).all(|i| {
                let turn = f64::from(i) * std::f64::consts::FRAC_PI_4;
                let by = diagonal * (side * turn.cos() + up * turn.sin());
                is_blocked([a + by, b + by], 0.0) == is
            });
            let stretched = [diagonal, -diagonal].iter().all(|&beyond| is_blocked([a, b], beyond) == is);
            vec![(is, moved && stretched)]
        });
        // 3. What the voxels say.
        let mut of = |name: &str, record: &dyn for<'f> Fn(&mut Graph<'f>, &'f GpuScene) -> Result<VoxelBits>| {
            let found = march(gpu, scene, &grid, &segments, record).blocked.pop().unwrap();
            let mut counts = [[0_usize; 2]; 2];
            for (&found, &(is, apart)) in found.iter().zip(&apart) {
                counts[usize::from(apart)][usize::from((found == 1) == is)] += 1;
            }
            let [[near_wrong, near_right], [wrong, right]] = counts;
            let agree = right as f64 / (right + wrong) as f64;
            println!("{}, {name}: {counts:?}", scene.name);
            assert!(right + wrong > COUNT / 2 && agree >= 0.99, "{}, {name}: {wrong} of {}", scene.name, right + wrong);
            let share = |count: usize, of: usize| 100.0 * count as f64 / of as f64;
            figures.push(Figure {
                what: format!("{}, {name} at 256³: whether triangles block segments", scene.name),
                value: format!(
                    "{:.3} % of {} agree, {:.1} % near silhouettes left out ({:.1} % of these agree); {:.0} % blocked",
                    share(right, right + wrong),
                    right + wrong,
                    share(near_right + near_wrong, COUNT),
                    share(near_right, near_right + near_wrong),
                    share(blocked, COUNT),
                ),
                bound: "at least 99 % further than a voxel's diagonal from silhouettes; 40 to 60 % blocked".into(),
            });
        };
        of("solid", &|graph, scene| Bitmask::default().record(graph, scene, &grid));
        of("surface", &|graph, scene| Conservative::default().record(graph, scene, &grid));
    }
    figures
}

/// A scene's voxels from the front, with what of a sun and of the sky is seen from before each.
fn picture(gpu: &Gpu) -> Option<Picture> {
    const SKY: usize = 24;
    let scene = Scene::load(&harness::require_scene("Koala/Koala.glb")?).unwrap();
    let grid = Grid::around(&bounds(&scene), 160).unwrap();
    let solid = solids::voxelize(gpu, &scene, &grid, |graph, scene| Bitmask::default().record(graph, scene, &grid));
    let [nx, ny, nz] = grid.size();
    let front = |[x, y]: [u32; 2]| (0..nz).rev().map(|z| [x, y, z]).find(|&voxel| solid.get(voxel));
    let seen: Vec<_> = (0..nx).flat_map(|x| (0..ny).map(move |y| [x, y])).filter_map(front).collect();
    // A sun, and directions all over the front half of a sphere.
    let sun = Vec3::new(-0.8, 1.0, 0.6).normalize() * 400.0;
    let sky = (0..SKY).map(|i| {
        let (z, turn) = ((i as f32 + 0.5) / SKY as f32, 2.399_963 * i as f32);
        let (sin, cos) = turn.sin_cos();
        let across = (1.0 - z * z).sqrt();
        Vec3::new(across * cos, across * sin, z) * 24.0
    });
    let ways: Vec<Vec3> = std::iter::once(sun).chain(sky).map(|way| way * grid.edge()).collect();
    let before = |[x, y, z]: [u32; 3]| grid.center([x, y, z]) + Vec3::Z * grid.edge();
    let segments: Vec<Ends> =
        seen.iter().flat_map(|&voxel| ways.iter().map(move |&way| [before(voxel), before(voxel) + way])).collect();
    let marched = march(gpu, &scene, &grid, &segments, |graph, scene| Bitmask::default().record(graph, scene, &grid));
    let blocked = marched.blocked.last()?;
    let light: HashMap<[u32; 3], f32> = seen
        .iter()
        .zip(blocked.chunks(ways.len()))
        .map(|(&voxel, blocked)| {
            let open = blocked[1..].iter().filter(|&&word| word == 0).count() as f32 / SKY as f32;
            (voxel, 0.45 * open + if blocked[0] == 0 { 0.9 } else { 0.0 })
        })
        .collect();
    let lit = lit("", &solid, |voxel| [0.75, 0.68, 0.6].map(|c| c * light.get(&voxel).copied().unwrap_or(0.0)));
    let caption = "Koala, 160³ voxels: what a sun and the sky see of each, by segments through their bits".into();
    Some(Picture { caption, ..lit })
}

#[test]
fn voxel_ray_marching_with_a_seeded_mistake_is_caught() {
    let gpu = shared();
    let truth = tiny::one("torus", vec![(torus(48, 24), awkward())]);
    let grid = Grid::around(&bounds(&truth), 64).unwrap();
    let segments = segments(&grid, 20_000);
    let of = |scene: &Scene| {
        march(gpu, scene, &grid, &segments, |graph, scene| Bitmask::default().record(graph, scene, &grid))
    };
    let right = of(&truth);
    let expected = walked(&right.voxels, &segments);
    assert_eq!(different(&right.blocked[0], &expected), 0);
    // Voxels of a torus that lies half a voxel aside; segments that end a hundredth of a voxel aside.
    let mut aside = truth.clone();
    aside.objects[0].world_from_object = Mat4::from_translation(Vec3::X * 0.5 * grid.edge()) * awkward();
    assert!(different(&of(&aside).blocked[0], &expected) > 0);
    let moved: Vec<Ends> = segments.iter().map(|&[a, b]| [a, b + 0.01 * grid.edge()]).collect();
    assert!(different(&walked(&right.voxels, &moved), &expected) > 0);
    silent(gpu);
}

#[test]
fn portable_segments_are_blocked_alike_from_both_ends() {
    let gpu = shared();
    let scene = tiny::one("100 tetrahedra", vec![(soup(100), Mat4::IDENTITY)]);
    let grid = Grid::around(&bounds(&scene), 64).unwrap();
    // Within the grid, on planes and edges as well.
    let inside = |p: Vec3| (p - grid.min()).min_element() > 0.0 && (p - grid.min()).max_element() < 64.0 * grid.edge();
    let there: Vec<Ends> = segments(&grid, 40_000).into_iter().filter(|&[a, b]| inside(a) && inside(b)).collect();
    let back: Vec<Ends> = there.iter().map(|&[a, b]| [b, a]).collect();
    let of = |segments: &[Ends]| {
        let mut marched =
            march(gpu, &scene, &grid, segments, |graph, scene| Conservative::default().record(graph, scene, &grid));
        marched.blocked.pop().unwrap()
    };
    let (there, back) = (of(&there), of(&back));
    assert!(there.len() > 10_000 && there.contains(&0) && there.contains(&1) && there == back);
    silent(gpu);
}

#[test]
fn voxels_of_the_ends_do_not_block() {
    let gpu = shared();
    // All voxels of a row from the second to the seventh.
    let scene =
        tiny::one("bar", vec![(tiny::cuboid(Vec3::new(1.1, 0.1, 0.1), Vec3::new(6.9, 0.9, 0.9), 0), Mat4::IDENTITY)]);
    let grid = Grid::new(Vec3::ZERO, 1.0, [8, 1, 1]).unwrap();
    let at = |x: f32| Vec3::new(x, 0.5, 0.5);
    let far = Vec3::splat(1e31);
    let cases = [
        // Within one voxel; to the next one; over one.
        ([at(2.1), at(2.9)], 0),
        ([at(2.1), at(3.9)], 0),
        ([at(2.1), at(4.1)], 1),
        // A free voxel to the first set one; through it.
        ([at(0.5), at(1.5)], 0),
        ([at(0.5), at(2.0)], 1),
        // Ends on planes belong to the voxels above them.
        ([at(0.0), at(1.0)], 0),
        ([at(2.0), at(0.5)], 1),
        // From outside, and past the grid.
        ([at(-3.0), at(1.5)], 0),
        ([at(-3.0), at(9.0)], 1),
        ([Vec3::new(2.5, -1.0, 0.5), Vec3::new(2.5, 2.0, 0.5)], 1),
        ([Vec3::new(2.5, -1.0, 1.5), Vec3::new(2.5, 2.0, 1.5)], 0),
        ([Vec3::new(2.5, 0.5, 1.0), Vec3::new(4.5, 0.5, 1.0)], 0),
        // Nothing, and nowhere.
        ([at(3.0), at(3.0)], 0),
        ([at(f32::NAN), at(5.0)], 0),
        ([at(0.5), at(f32::INFINITY)], 0),
        ([at(0.5), far], 0),
    ];
    let segments: Vec<Ends> = cases.iter().map(|case| case.0).collect();
    let expected: Vec<u32> = cases.iter().map(|case| case.1).collect();
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        let marched = march(gpu, &scene, &grid, &segments, |graph, scene| {
            Conservative { axis, ..Conservative::default() }.record(graph, scene, &grid)
        });
        assert_eq!(marched.voxels.count(), 6);
        assert!(marched.blocked.iter().all(|found| found == &expected), "{axis:?}: {:?}", marched.blocked);
    }
    silent(gpu);
}

#[test]
fn segments_through_bricks_meet_what_those_through_the_whole_grid_do() {
    let gpu = shared();
    let scenes = [
        tiny::one("torus", vec![(torus(48, 24), awkward())]),
        tiny::one("100 tetrahedra", vec![(soup(100), Mat4::IDENTITY)]),
        tiny::one("needle", vec![(tiny::cuboid(Vec3::ZERO, Vec3::new(1.0, 0.01, 0.01), 0), awkward())]),
    ];
    for scene in &scenes {
        let around = bounds(scene);
        let edge = (around.max - around.min).max_element() / 100.0;
        let odd = Grid::new(around.min - 3.3 * edge, edge, [101, 77, 83]).unwrap();
        for grid in [Grid::around(&around, 256).unwrap(), odd, Grid::around(&around, 5).unwrap()] {
            let segments = segments(&grid, 20_000);
            let whole = march(gpu, scene, &grid, &segments, |graph, scene| {
                SixSeparating::default().record(graph, scene, &grid)
            });
            let expected = &whole.blocked[0];
            assert!(expected.iter().sum::<u32>() > 50, "{}: nothing is in the way", scene.name);
            let uploaded = scene.clone().upload(gpu).unwrap();
            let ends: Vec<_> = segments.iter().map(|&[origin, end]| Segment::new(origin, end)).collect();
            let buffer = Segment::upload(gpu, &ends).unwrap();
            // Within bricks, at them, above them.
            for levels in [0, 1, 2, 3, 4, u32::MAX] {
                let mut graph = Graph::new("march", gpu.caps());
                let segments = graph.import_buffer(&buffer, Access::NONE, None);
                let bricks =
                    Bricks { thickness: Thickness::SixSeparating }.record(&mut graph, &uploaded, &grid).unwrap();
                let occluders = Occluders::record(&mut graph, bricks);
                let words = RayMarching { levels }.record(&mut graph, &occluders, &segments);
                graph.capture("blocked", &words);
                let plan = graph.compile(gpu).unwrap();
                let executed = Executor::new(gpu).execute(&plan, graph).unwrap();
                let found: Vec<u32> = executed.capture("blocked").unwrap().texels().unwrap();
                let wrong = different(&found, expected);
                assert!(wrong == 0, "{} in {:?}, {levels} levels: {wrong} differ", scene.name, grid.size());
            }
        }
    }
    silent(gpu);
}

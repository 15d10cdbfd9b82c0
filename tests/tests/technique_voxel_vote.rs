//! Solids with holes in their surfaces, by a vote of columns along three axes.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{DVec3, Mat4, Vec3};
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::Scene;
use shadowgraph::techniques::voxel::bitmask::Bitmask;
use shadowgraph::techniques::voxel::vote::Vote;
use shadowgraph::techniques::voxel::winding::Winding;
use shadowgraph::techniques::voxel::{Axis, FillRule, Grid, Voxels};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Figure};
use shadowgraph_tests::solids::{NEAR, awkward, bounds, soup, torus};
use shadowgraph_tests::tiny;
use shadowgraph_tests::twin::vote::vote;
use shadowgraph_tests::twin::voxel::{in_grid, is_near, solid};
use shadowgraph_tests::voxel_pictures::{beside, front};

const AXES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// What the device finds.
struct Found {
    voted: Voxels,
    /// Along each axis alone.
    along: [Voxels; 3],
    leaks: [u32; 3],
}

fn voxelize(gpu: &Gpu, scene: &Scene, grid: &Grid, rule: FillRule) -> Found {
    let find = || -> shadowgraph::Result<Found> {
        let scene = scene.clone().upload(gpu)?;
        let mut graph = Graph::new("vote", gpu.caps());
        let along = AXES.map(|axis| match rule {
            FillRule::NonZero => Winding { axis, rule }.record(&mut graph, &scene, grid),
            FillRule::EvenOdd => Bitmask { axis, ..Bitmask::default() }.record(&mut graph, &scene, grid),
        });
        let [x, y, z] = along;
        let along = [x?, y?, z?];
        let technique = Vote { rule };
        let leaks = technique.leaks(&mut graph, &scene, grid);
        let voted = technique.record(&mut graph, along.each_ref(), &leaks)?;
        graph.capture("voted", &voted.bits);
        graph.capture("leaks", &leaks.counts);
        for voxels in &along {
            graph.capture(format!("{:?}", voxels.axis), &voxels.bits);
        }
        let plan = graph.compile(gpu)?;
        let executed = Executor::new(gpu).execute(&plan, graph)?;
        let read = |name: String, axis| Voxels::read(executed.capture(&name).unwrap(), grid, axis).unwrap();
        let counts: Vec<u32> = executed.capture("leaks")?.texels()?;
        Ok(Found {
            voted: read("voted".into(), Axis::Z),
            along: AXES.map(|axis| read(format!("{axis:?}"), axis)),
            leaks: counts.try_into().unwrap(),
        })
    };
    find().unwrap_or_else(|error| panic!("{}: {error}", scene.name))
}

/// Voxels that agree, that differ where rounding may decide, and that differ elsewhere. Where the leaks differ by more than
/// rounding may decide, that is a mistake too.
fn compare(found: &Found, truth: &Scene, rule: FillRule) -> [usize; 3] {
    let grid = found.voted.grid();
    let triangles = in_grid(truth, grid);
    let truth = vote(&triangles, grid.size(), rule == FillRule::EvenOdd, NEAR);
    let mut counts = [0; 3];
    for (index, voxel) in grid.voxels().enumerate() {
        let agrees = found.voted.get(voxel) == truth.inside[index];
        let center = DVec3::from(voxel.map(f64::from)) + 0.5;
        let near = || truth.doubtful[index] || is_near(center, &triangles, NEAR);
        counts[if agrees { 0 } else { 1 + usize::from(!near()) }] += 1;
    }
    for axis in 0..3 {
        let off = (found.leaks[axis] as usize).abs_diff(truth.leaks[axis]);
        counts[2] += off.saturating_sub(truth.uncertain[axis]);
    }
    counts
}

/// Solids that lack something: the closed one, and the same with holes.
fn broken() -> Vec<[Scene; 2]> {
    let lack = |name: &str, closed: Scene, lost: &dyn Fn(usize) -> bool| {
        let mut open = closed.clone();
        open.name = name.into();
        let primitive = &mut open.meshes[0].primitives[0];
        let triangles = primitive.indices.as_chunks::<3>().0.iter().enumerate();
        primitive.indices = triangles.filter(|&(i, _)| !lost(i)).flat_map(|(_, corners)| *corners).collect();
        [closed, open]
    };
    let cube = || tiny::one("cube", vec![(tiny::cuboid(-Vec3::ONE, Vec3::ONE, 0), awkward())]);
    let ring = || tiny::one("torus", vec![(torus(48, 24), awkward())]);
    vec![
        lack("turned cube without a face", cube(), &|i| i < 2),
        lack("turned cube without two faces", cube(), &|i| [1, 3].contains(&(i / 2))),
        lack("torus with a patch lost", ring(), &|i| i % 48 < 12 && i < 400),
        lack("torus with every 40th triangle lost", ring(), &|i| i % 40 == 7),
    ]
}

#[test]
fn voxel_vote_agrees_with_its_reference() {
    let gpu = shared();
    let mut figures = Vec::new();
    for [closed, open] in broken() {
        assert!(!open.open_meshes().is_empty() && closed.open_meshes().is_empty(), "{}", open.name);
        let [mut compared, mut left_out, mut wrong, mut alone, mut of] = [0; 5];
        for (resolution, rule) in [(32, FillRule::NonZero), (64, FillRule::EvenOdd), (96, FillRule::NonZero)] {
            let grid = Grid::around(&bounds(&open), resolution).unwrap();
            let found = voxelize(gpu, &open, &grid, rule);
            let [agree, near, far] = compare(&found, &open, rule);
            println!("{} at {resolution}: {agree} agree, {near} near, {far} far; {:?} leak", open.name, found.leaks);
            assert!(far == 0 && near * 50 < agree && found.leaks.iter().any(|&leaks| leaks > 0), "{}", open.name);
            (compared, left_out) = (compared + agree + near, left_out + near);
            // Against the solid that it was.
            let whole = solid(&in_grid(&closed, &grid), grid.size());
            let off = |voxels: &Voxels| voxels.bytes().iter().zip(&whole).filter(|&(&a, &b)| (a == 1) != b).count();
            wrong += off(&found.voted);
            alone += found.along.iter().map(off).sum::<usize>() / 3;
            of += whole.iter().filter(|&&inside| inside).count();
        }
        let part = |n: usize| 100.0 * n as f64 / of as f64;
        figures.push(Figure {
            what: format!("{}: voxels at 32, 64, 96", open.name),
            value: format!(
                "0 of {compared} differ, {left_out} left out; of the whole solid {:.1} % are wrong, by one axis {:.1} %",
                part(wrong),
                part(alone)
            ),
            bound: "none differs; left out where 1/128 voxel decides".into(),
        });
        assert!(wrong * 2 < alone, "{}: {wrong} wrong by the vote, {alone} by an axis", open.name);
    }
    silent(gpu);
    let [_, holed] = broken().swap_remove(3);
    let found = voxelize(gpu, &holed, &Grid::around(&bounds(&holed), 160).unwrap(), FillRule::NonZero);
    let [_, along_y, _] = &found.along;
    let caption = "A torus with every 40th triangle lost, 160³ voxels: by its columns along y, and by the vote";
    let picture = beside([front("", along_y), front("", &found.voted)], caption.into());
    figures::publish(gpu, "voxel", "vote", &figures, Some(&picture));
}

#[test]
fn voxel_vote_with_a_seeded_mistake_is_caught() {
    let gpu = shared();
    let [_, open] = broken().swap_remove(2);
    let grid = Grid::around(&bounds(&open), 48).unwrap();
    let far = |scene: &Scene, rule| compare(&voxelize(gpu, scene, &grid, rule), &open, FillRule::NonZero)[2];
    assert_eq!(far(&open, FillRule::NonZero), 0);
    // A twentieth of a voxel aside; another triangle lost; a triangle turned around.
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut scene = open.clone();
        change(&mut scene);
        far(&scene, FillRule::NonZero)
    };
    let aside = Mat4::from_translation(Vec3::X * 0.05 * grid.edge()) * awkward();
    assert!(changed(&|scene| scene.objects[0].world_from_object = aside) > 0);
    assert!(changed(&|scene| drop(scene.meshes[0].primitives[0].indices.drain(900..903))) > 0);
    assert!(changed(&|scene| scene.meshes[0].primitives[0].indices.swap(900, 901)) > 0);
    silent(gpu);
}

#[test]
fn closed_surfaces_leak_nowhere_and_are_voted_as_they_are() {
    let gpu = shared();
    for scene in [
        tiny::one("torus", vec![(torus(48, 24), awkward())]),
        tiny::one("tetrahedra", vec![(soup(100), Mat4::IDENTITY)]),
    ] {
        // Half of it lies outside of the grid.
        let around = Grid::around(&bounds(&scene), 60).unwrap();
        let grid = Grid::new(around.min() + 0.3, around.edge(), [50, 44, 61]).unwrap();
        for rule in [FillRule::NonZero, FillRule::EvenOdd] {
            let found = voxelize(gpu, &scene, &grid, rule);
            assert_eq!(found.leaks, [0; 3], "{}", scene.name);
            let far = compare(&found, &scene, rule)[2];
            assert!(far == 0 && found.voted.count() > 100, "{}: {far}", scene.name);
        }
    }
    silent(gpu);
}

#[test]
fn sound_columns_at_odds_are_outvoted() {
    // Two boxes without the sides that face each other: lines along x enter the one and leave the other, which is sound,
    // and say that all between them is inside.
    let side = |x: f32| Vec3::new(x, 0.0, 0.0);
    let mut scene = tiny::one(
        "two boxes",
        vec![
            (tiny::cuboid(side(-3.0) - Vec3::ONE, side(-3.0) + Vec3::ONE, 0), Mat4::IDENTITY),
            (tiny::cuboid(side(3.0) - Vec3::ONE, side(3.0) + Vec3::ONE, 0), Mat4::IDENTITY),
        ],
    );
    for (mesh, lost) in scene.meshes.iter_mut().zip([-2.0, 2.0]) {
        let primitive = &mut mesh.primitives[0];
        let positions = &primitive.positions;
        let kept = |corners: &&[u32; 3]| corners.iter().any(|&corner| positions[corner as usize].x != lost);
        primitive.indices = primitive.indices.as_chunks::<3>().0.iter().filter(kept).flatten().copied().collect();
    }
    let grid = Grid::around(&bounds(&scene), 40).unwrap();
    let found = voxelize(shared(), &scene, &grid, FillRule::NonZero);
    let middle = grid.size().map(|n| n / 2);
    assert_eq!(found.leaks, [0; 3]);
    assert!(found.along[0].get(middle) && !found.along[1].get(middle) && !found.along[2].get(middle));
    assert!(!found.voted.get(middle));
    assert_eq!(compare(&found, &scene, FillRule::NonZero)[2], 0);
    silent(shared());
}

#[test]
fn votes_on_other_grids_are_refused() {
    let gpu = shared();
    let scene = tiny::empty().upload(gpu).unwrap();
    let grid = Grid::new(Vec3::ZERO, 1.0, [4; 3]).unwrap();
    let mut graph = Graph::new("vote", gpu.caps());
    let leaks = Vote::default().leaks(&mut graph, &scene, &grid);
    let mut along = |axis| Bitmask { axis, ..Bitmask::default() }.record(&mut graph, &scene, &grid).unwrap();
    let [x, z] = [along(Axis::X), along(Axis::Z)];
    let said = Vote::default().record(&mut graph, [&x, &x, &z], &leaks).err().unwrap().to_string();
    assert!(said.contains("along x, y and z"), "{said}");
}

//! Solid voxels by signed counting against winding numbers along rays, and against the bits of the stencil.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{Mat4, Vec3};
use shadowgraph::gpu::Gpu;
use shadowgraph::scene::Scene;
use shadowgraph::techniques::voxel::bitmask::Bitmask;
use shadowgraph::techniques::voxel::stencil::Stencil;
use shadowgraph::techniques::voxel::winding::Winding;
use shadowgraph::techniques::voxel::{Axis, FillRule, Grid, Voxels};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Figure};
use shadowgraph_tests::solids::{self, awkward, bounds, torus};
use shadowgraph_tests::tiny;
use shadowgraph_tests::voxel_pictures::{beside, cut};

fn voxelize(gpu: &Gpu, scene: &Scene, grid: &Grid, technique: Winding) -> Voxels {
    solids::voxelize(gpu, scene, grid, |graph, scene| technique.record(graph, scene, grid))
}

#[test]
fn voxel_winding_agrees_with_its_reference() {
    let gpu = shared();
    let mut figures =
        solids::by_both_rules(gpu, 3, |scene, grid, axis, rule| voxelize(gpu, scene, grid, Winding { axis, rule }));
    // The stencil counts the same, one slice after the other; open meshes included.
    let mut equal = 0;
    for scene in solids::closed().into_iter().chain(solids::surfaces()) {
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let grid = Grid::around(&bounds(&scene), 64).unwrap();
            for rule in [FillRule::NonZero, FillRule::EvenOdd] {
                let stencil = Stencil { axis, rule, ..Stencil::default() };
                let slices = solids::voxelize(gpu, &scene, &grid, |graph, scene| stencil.record(graph, scene, &grid));
                let counted = voxelize(gpu, &scene, &grid, Winding { axis, rule });
                assert!(counted == slices, "{} along {axis:?}: not the bits of the stencil", scene.name);
                equal += 64 * 64 * 64;
            }
        }
    }
    figures.push(Figure {
        what: "all solids and surfaces at 64 along three axes, by both rules: voxels of the stencil".into(),
        value: format!("0 of {equal} differ"),
        bound: "equal bits".into(),
    });
    silent(gpu);
    let turns =
        [0.0, 0.9, 1.8].map(|turn| (torus(96, 48), Mat4::from_rotation_x(turn) * Mat4::from_rotation_y(0.7 * turn)));
    let rings = tiny::one("three tori", turns.to_vec());
    let grid = Grid::around(&bounds(&rings), 160).unwrap();
    let [odd, all] = [FillRule::EvenOdd, FillRule::NonZero]
        .map(|rule| cut(&voxelize(gpu, &rings, &grid, Winding { rule, ..Winding::default() }), 84));
    let caption = "A slice of three tori that run through one another, 160³ voxels: by the even-odd rule, and by the \
        non-zero rule";
    figures::publish(gpu, "voxel", "winding", &figures, Some(&beside([odd, all], caption.into())));
}

#[test]
fn voxel_winding_with_a_seeded_mistake_is_caught() {
    solids::mistakes_are_seen(|scene, grid| voxelize(shared(), scene, grid, Winding::default()));
    silent(shared());
}

#[test]
fn solids_that_overlap_are_one_where_xor_has_a_hole() {
    let gpu = shared();
    solids::overlap_is_one(gpu, |scene, grid, axis, rule| voxelize(gpu, scene, grid, Winding { axis, rule }));
    silent(gpu);
}

#[test]
fn portable_a_grid_of_many_bands_is_found_band_by_band() {
    let gpu = shared();
    // 1024 columns of 700 voxels a row: 46 rows of counts take 126 MiB. The last band has 14 rows.
    let scene = tiny::one("torus", vec![(torus(24, 12), awkward())]);
    let grid = Grid::new(Vec3::new(-1.5, -0.1, -1.0), 3.0 / 1024.0, [1024, 60, 700]).unwrap();
    let bitmask = solids::voxelize(gpu, &scene, &grid, |graph, scene| Bitmask::default().record(graph, scene, &grid));
    let voxels = voxelize(gpu, &scene, &grid, Winding::default());
    assert!(voxels.count() > 1000 && voxels == bitmask);
    silent(gpu);
}

//! Solid voxels counted slice by slice against winding numbers along rays, and against the bits of XOR.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{DVec3, Mat4, Vec3};
use shadowgraph::gpu::Gpu;
use shadowgraph::scene::Scene;
use shadowgraph::techniques::voxel::bitmask::Bitmask;
use shadowgraph::techniques::voxel::stencil::{Slices, Stencil};
use shadowgraph::techniques::voxel::{Axis, FillRule, Grid, Voxels};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures;
use shadowgraph_tests::harness;
use shadowgraph_tests::solids::{self, awkward, bounds, soup, torus};
use shadowgraph_tests::tiny;
use shadowgraph_tests::twin::voxel::{in_grid, is_near};
use shadowgraph_tests::voxel_pictures::front;

fn voxelize(gpu: &Gpu, scene: &Scene, grid: &Grid, technique: Stencil) -> Voxels {
    solids::voxelize(gpu, scene, grid, |graph, scene| technique.record(graph, scene, grid))
}

#[test]
fn voxel_stencil_agrees_with_its_reference() {
    let gpu = shared();
    // Slice by slice, which takes its time: winding numbers are its bits, and go further.
    let figures = solids::by_both_rules(gpu, 2, |scene, grid, axis, rule| {
        voxelize(gpu, scene, grid, Stencil { axis, rule, ..Stencil::default() })
    });
    silent(gpu);
    let picture = harness::require_scene("Boot/Boot.glb").map(|path| {
        let scene = Scene::load(&path).unwrap();
        front("Boot", &voxelize(gpu, &scene, &Grid::around(&bounds(&scene), 160).unwrap(), Stencil::default()))
    });
    figures::publish(gpu, "voxel", "stencil", &figures, picture.as_ref());
}

#[test]
fn voxel_stencil_with_a_seeded_mistake_is_caught() {
    solids::mistakes_are_seen(|scene, grid| voxelize(shared(), scene, grid, Stencil::default()));
    silent(shared());
}

#[test]
fn solids_that_overlap_are_one_where_xor_has_a_hole() {
    let gpu = shared();
    solids::overlap_is_one(gpu, |scene, grid, axis, rule| {
        voxelize(gpu, scene, grid, Stencil { axis, rule, ..Stencil::default() })
    });
    silent(gpu);
}

#[test]
fn portable_slices_are_the_same_in_layers_in_tiles_and_alone() {
    let gpu = shared();
    // Nothing of the scene is cut off by the sides of the grid that it reaches out of.
    let parts = vec![(soup(50), Mat4::IDENTITY), (tiny::cuboid(Vec3::splat(-1.0), Vec3::splat(0.3), 0), awkward())];
    let scene = tiny::one("tetrahedra", parts);
    let grid = Grid::new(Vec3::splat(-0.1), 0.01, [120, 110, 67]).unwrap();
    for rule in [FillRule::NonZero, FillRule::EvenOdd] {
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let [layered, tiled, separate] = [Slices::Layered, Slices::Tiled, Slices::Separate]
                .map(|slices| voxelize(gpu, &scene, &grid, Stencil { axis, rule, slices }));
            assert!(layered.count() > 1000 && layered == separate && layered == tiled, "{rule:?} along {axis:?}");
        }
    }
    silent(gpu);
}

#[test]
fn a_grid_of_many_slabs_is_found_slab_by_slab() {
    let gpu = shared();
    // 1024 × 1024 pixels take 32 slices at a time; the last slab has 6.
    let scene = tiny::one("torus", vec![(torus(24, 12), awkward())]);
    let grid = Grid::new(Vec3::new(-1.5, -1.5, -0.1), 3.0 / 1024.0, [1024, 1024, 70]).unwrap();
    let bitmask = solids::voxelize(gpu, &scene, &grid, |graph, scene| Bitmask::default().record(graph, scene, &grid));
    for slices in [Slices::Layered, Slices::Tiled, Slices::Separate] {
        let voxels = voxelize(gpu, &scene, &grid, Stencil { slices, ..Stencil::default() });
        assert!(voxels.count() > 1000 && (slices == Slices::Tiled || voxels == bitmask), "{slices:?}");
        // Of tiles, rounding may decide next to a surface.
        let triangles = in_grid(&scene, &grid);
        let (own, other) = (voxels.bytes(), bitmask.bytes());
        let different: Vec<_> = grid.voxels().zip(own.iter().zip(&other)).filter(|(_, (a, b))| a != b).collect();
        let near = |voxel: [u32; 3]| is_near(DVec3::from(voxel.map(f64::from)) + 0.5, &triangles, solids::NEAR);
        let far = different.iter().filter(|(voxel, _)| !near(*voxel)).count();
        println!("{slices:?}: {} of {} differ, {far} of them far", different.len(), own.len());
        assert!(far == 0 && different.len() < own.len() / 100_000, "{slices:?}: {} differ", different.len());
    }
    silent(gpu);
}

//! Voxels as images that shaders sample: texel for texel those of the bits, by every method.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::Vec3;
use shadowgraph::Result;
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executed, Executor, Graph};
use shadowgraph::scene::GpuScene;
use shadowgraph::techniques::voxel::atlas::Atlas;
use shadowgraph::techniques::voxel::bitmask::{Bitmask, Combine};
use shadowgraph::techniques::voxel::bricks::Bricks;
use shadowgraph::techniques::voxel::conservative::{Conservative, Pipeline};
use shadowgraph::techniques::voxel::six_separating::SixSeparating;
use shadowgraph::techniques::voxel::stencil::Stencil;
use shadowgraph::techniques::voxel::winding::Winding;
use shadowgraph::techniques::voxel::{Axis, Grid, VoxelBits, VoxelSet, Voxels, tiled_image, volume_image};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::solids::{awkward, torus};
use shadowgraph_tests::tiny;

/// No two axes alike, and none of whole words.
const SIZE: [u32; 3] = [75, 61, 46];

fn scene(gpu: &Gpu) -> GpuScene {
    tiny::one("torus", vec![(torus(24, 12), awkward())]).upload(gpu).unwrap()
}

fn grid(size: [u32; 3]) -> Grid {
    Grid::new(Vec3::splat(-1.4), 2.8 / size.into_iter().max().unwrap() as f32, size).unwrap()
}

/// Captures both images of what a method finds, whose bits `voxels` takes back; tells how many differ, of so many set.
fn compare<'f, V: VoxelSet>(
    gpu: &'f Gpu,
    find: impl FnOnce(&mut Graph<'f>) -> Result<V>,
    voxels: impl FnOnce(&Executed) -> Voxels,
    capture: impl FnOnce(&mut Graph, &V),
) -> [usize; 2] {
    let mut graph = Graph::new("images", gpu.caps());
    let found = find(&mut graph).unwrap();
    let [width, height, depth] = found.grid().size();
    let volume = volume_image(&mut graph, "volume", &found).unwrap();
    let tiles = tiled_image(&mut graph, "tiles", &found).unwrap();
    capture(&mut graph, &found);
    graph.capture("volume", &volume);
    graph.capture("tiles", &tiles.image);
    let plan = graph.compile(gpu).unwrap();
    let executed = Executor::new(gpu).execute(&plan, graph).unwrap();
    let texels = |name| executed.capture(name).unwrap().texels::<u8>().unwrap();
    let (volume, tiled, voxels) = (texels("volume"), texels("tiles"), voxels(&executed));
    let bytes = voxels.bytes();
    let row = tiles.across * width;
    assert_eq!([volume.len(), tiled.len()], [bytes.len(), (row * height * depth.div_ceil(tiles.across)) as usize]);
    let wrong = voxels.grid().voxels().zip(&bytes).zip(&volume).filter(|&(([x, y, z], &byte), &texel)| {
        let [left, top] = [z % tiles.across * width, z / tiles.across * height];
        let tile = tiled[((top + y) * row + left + x) as usize];
        [texel, tile] != [255 * byte; 2]
    });
    let set = bytes.iter().filter(|&&byte| byte == 1).count();
    let whole: usize = tiled.iter().filter(|&&texel| texel == 255).count();
    [wrong.count() + set.abs_diff(whole), set]
}

type Find = for<'f> fn(&mut Graph<'f>, &'f GpuScene, &Grid, Axis) -> Result<VoxelBits>;

const METHODS: [(&str, Find); 8] = [
    ("bitmask", |graph, scene, grid, axis| Bitmask { axis, ..Bitmask::default() }.record(graph, scene, grid)),
    ("bitmask by logic operation", |graph, scene, grid, axis| {
        Bitmask { axis, combine: Combine::LogicOp, ..Bitmask::default() }.record(graph, scene, grid)
    }),
    ("stencil", |graph, scene, grid, axis| Stencil { axis, ..Stencil::default() }.record(graph, scene, grid)),
    ("winding", |graph, scene, grid, axis| Winding { axis, ..Winding::default() }.record(graph, scene, grid)),
    ("conservative", |graph, scene, grid, axis| {
        Conservative { axis, ..Conservative::default() }.record(graph, scene, grid)
    }),
    ("conservative by the rasteriser", |graph, scene, grid, axis| {
        Conservative { axis, pipeline: Pipeline::Raster }.record(graph, scene, grid)
    }),
    ("six-separating", |graph, scene, grid, axis| {
        SixSeparating { axis, ..SixSeparating::default() }.record(graph, scene, grid)
    }),
    ("atlas", |graph, scene, grid, axis| Atlas { axis, ..Atlas::default() }.record(graph, scene, grid)),
];

#[test]
fn portable_images_hold_the_bits_of_every_method() {
    let gpu = shared();
    let (scene, grid) = (scene(gpu), grid(SIZE));
    for (name, find) in METHODS {
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let read = |executed: &Executed| Voxels::read(executed.capture("bits").unwrap(), &grid, axis).unwrap();
            let capture = |graph: &mut Graph, found: &VoxelBits| graph.capture("bits", &found.bits);
            let [wrong, set] = compare(gpu, |graph| find(graph, &scene, &grid, axis), read, capture);
            assert!(wrong == 0 && set > 1000, "{name} along {axis:?}: {wrong} texels differ, {set} are set");
        }
    }
    let read = |executed: &Executed| Voxels::read_bricks(executed, &grid).unwrap();
    let [wrong, set] =
        compare(gpu, |graph| Bricks::default().record(graph, &scene, &grid), read, |graph, found| found.capture(graph));
    assert!(wrong == 0 && set > 1000, "bricks: {wrong} texels differ, {set} are set");
    silent(gpu);
}

#[test]
fn images_that_cannot_be_are_refused() {
    let gpu = shared();
    let (scene, most) = (scene(gpu), gpu.caps().limits.max_image_dimension_2d);
    let mut graph = Graph::new("images", gpu.caps());
    let slice = Bitmask::default().record(&mut graph, &scene, &grid([40, 40, 1])).unwrap();
    let error = volume_image(&mut graph, "volume", &slice).unwrap_err().to_string();
    assert!(error.contains("`volume`") && error.contains("[40, 40, 1]"), "{error}");
    assert_eq!(tiled_image(&mut graph, "tiles", &slice).unwrap().across, 1);
    // 256 slices of 2048 × 2048 voxels are 16 × 16 tiles.
    if most < 16 * 2048 {
        let mut graph = Graph::new("images", gpu.caps());
        let grid = grid([2048, 2048, 256]);
        let large = Bitmask::default().record(&mut graph, &scene, &grid).unwrap();
        let error = tiled_image(&mut graph, "tiles", &large).err().unwrap().to_string();
        assert!(error.contains("256 slices of 2048 × 2048"), "{error}");
    }
}

//! Segments between random points on the sides of a grid of solid voxels, on the device: its pyramid, and the walks.

use glam::Vec3;
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::description::Access;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::Scene;
use shadowgraph::techniques::voxel::bitmask::Bitmask;
use shadowgraph::techniques::voxel::ray_marching::{RayMarching, Segment};
use shadowgraph::techniques::voxel::{Grid, Occluders};

use super::{Measurement, median};
use crate::cli::BenchArguments;
use crate::failure::Result;

/// Voxels along an axis, and levels of the pyramid that are skipped by.
const CASES: [(u32, u32); 5] = [(64, u32::MAX), (256, u32::MAX), (256, 0), (1024, u32::MAX), (1024, 0)];

const SEGMENTS: usize = 1 << 20;

/// Every case.
pub fn run(
    gpu: &Gpu,
    scene: &Scene,
    arguments: &BenchArguments,
    tell: &mut impl FnMut(Measurement) -> Result<()>,
) -> Result<()> {
    let (scene, runs) = (scene.clone().upload(gpu)?, arguments.runs);
    for (resolution, levels) in CASES {
        let case = format!("rays, {resolution}{}", if levels == 0 { ", no pyramid" } else { "" });
        if !arguments.wants(&case) {
            continue;
        }
        let grid = Grid::around(&scene.bounds, resolution)?;
        let segments = Segment::upload(gpu, &across(&grid))?;
        let mut executor = Executor::new(gpu);
        let (mut pyramids, mut walks, mut blocked) = (Vec::new(), Vec::new(), 0.0);
        // The first run compiles shaders.
        for run in 0..=runs {
            let mut graph = Graph::new("rays", gpu.caps());
            let segments = graph.import_buffer(&segments, Access::NONE, None);
            let voxels = Bitmask::default().record(&mut graph, &scene, &grid)?;
            let occluders = Occluders::record(&mut graph, voxels);
            let words = RayMarching { levels }.record(&mut graph, &occluders, &segments);
            graph.capture("blocked", &words);
            let plan = graph.compile(gpu).map_err(shadowgraph::Error::from)?;
            let executed = executor.execute(&plan, graph)?;
            let seconds = |name: &str| -> f64 {
                executed.passes.iter().filter(|pass| pass.name.starts_with(name)).map(|pass| pass.seconds).sum()
            };
            if run > 0 {
                pyramids.push(1e3 * seconds("voxel.pyramid"));
                walks.push(seconds("voxel.ray_marching"));
            }
            blocked = executed.capture("blocked")?.texels::<u32>()?.iter().sum::<u32>().into();
        }
        let told = |metric: &str, value, unit| Measurement {
            bench: "voxelize",
            case: case.clone(),
            metric: metric.into(),
            value,
            unit,
        };
        let walk = median(walks);
        if levels > 0 {
            tell(told("pyramid", median(pyramids), "ms"))?;
        }
        tell(told("walked", if walk > 0.0 { 1e-6 * SEGMENTS as f64 / walk } else { 0.0 }, "million rays/s"))?;
        tell(told("blocked", 100.0 * blocked / SEGMENTS as f64, "%"))?;
    }
    Ok(())
}

/// Between random points half a voxel from the sides.
fn across(grid: &Grid) -> Vec<Segment> {
    let mut random = 0x9e37_79b9_7f4a_7c15_u64;
    let mut unit = || {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random >> 40) as f32 / (1 << 24) as f32
    };
    let size = Vec3::from(grid.size().map(|n| n as f32));
    let mut point = || {
        let mut p = Vec3::new(unit(), unit(), unit()) * size;
        let side = (6.0 * unit()) as usize % 6;
        p[side / 2] = if side.is_multiple_of(2) { 0.5 } else { size[side / 2] - 0.5 };
        grid.min() + p * grid.edge()
    };
    (0..SEGMENTS).map(|_| Segment::new(point(), point())).collect()
}

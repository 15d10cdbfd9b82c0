//! Finding the voxels on the device.

use std::time::Instant;

use shadowgraph::gpu::Gpu;
use shadowgraph::graph::plan::Plan;
use shadowgraph::graph::{Executed, Executor, Graph};
use shadowgraph::scene::{Camera, GpuScene};
use shadowgraph::techniques::voxel::atlas::Atlas;
use shadowgraph::techniques::voxel::attributes::{Attributes, VoxelAttributes};
use shadowgraph::techniques::voxel::bitmask::{Bitmask, Fill};
use shadowgraph::techniques::voxel::bricks::{Bricks, Thickness};
use shadowgraph::techniques::voxel::conservative::Conservative;
use shadowgraph::techniques::voxel::six_separating::SixSeparating;
use shadowgraph::techniques::voxel::stencil::Stencil;
use shadowgraph::techniques::voxel::vote::Vote;
use shadowgraph::techniques::voxel::winding::Winding;
use shadowgraph::techniques::voxel::{Axis, FillRule, FrustumGrid, Grid, VoxelBits, Voxels};

use super::atlas::{AtlasReport, atlas};
use super::check;
use crate::cli::{RuleName, VoxelMethod, VoxelizeArguments};
use crate::failure::{Failure, Result};

/// What was found.
pub(super) struct Found {
    pub(super) voxels: Voxels,
    /// Where they are, if not in a grid of cubes.
    pub(super) frustum: Option<FrustumGrid>,
    pub(super) attributes: Option<VoxelAttributes>,
    /// Columns that leak along x, y and z, of solids.
    pub(super) leaks: Option<[u32; 3]>,
    pub(super) atlas: Option<AtlasReport>,
    pub(super) seconds: f64,
    /// Of transient memory.
    pub(super) bytes: u64,
}

/// The voxels that were asked for.
pub(super) fn find(
    arguments: &VoxelizeArguments,
    gpu: &Gpu,
    scene: &GpuScene,
    camera: Option<&Camera>,
) -> Result<Found> {
    let began = Instant::now();
    let found = match camera {
        Some(camera) => in_frustum(arguments, gpu, scene, camera)?,
        None if check::is_in_bricks(arguments) => in_bricks(arguments, gpu, scene, &grid(arguments, scene)?)?,
        None => in_grid(arguments, gpu, scene, &grid(arguments, scene)?)?,
    };
    Ok(Found { seconds: began.elapsed().as_secs_f64(), ..found })
}

/// The grid that was asked for.
fn grid(arguments: &VoxelizeArguments, scene: &GpuScene) -> Result<Grid> {
    let size = arguments.resolution.0;
    let most = size.into_iter().max().unwrap_or(1);
    let made = match (arguments.min, arguments.edge) {
        (Some(min), Some(edge)) => Grid::new(min, edge / most as f32, size),
        _ => Grid::around(&scene.bounds, most),
    };
    made.map_err(Failure::input)
}

fn run(gpu: &Gpu, graph: Graph) -> Result<(Plan, Executed)> {
    let plan = graph.compile(gpu).map_err(shadowgraph::Error::from)?;
    let executed = Executor::new(gpu).execute(&plan, graph)?;
    Ok((plan, executed))
}

/// In what a camera sees.
fn in_frustum(arguments: &VoxelizeArguments, gpu: &Gpu, scene: &GpuScene, camera: &Camera) -> Result<Found> {
    let [width, height, slices] = arguments.resolution.0;
    let view = camera.view([width, height]);
    let frustum = FrustumGrid::around(&view, &scene.bounds, slices).map_err(Failure::input)?;
    let mut graph = Graph::new("voxelize", gpu.caps());
    let bitmask = Bitmask { fill: fill(arguments), ..Bitmask::default() };
    let found = bitmask.record_frustum(&mut graph, scene, &frustum)?;
    graph.capture("voxels", &found.bits);
    let (plan, executed) = run(gpu, graph)?;
    let voxels = Voxels::read(executed.capture("voxels")?, &frustum.grid(), Axis::Z)?;
    let bytes = plan.statistics.heap_bytes;
    Ok(Found { voxels, frustum: Some(frustum), attributes: None, leaks: None, atlas: None, seconds: 0.0, bytes })
}

/// Surfaces where the whole grid, or what is in it, would not fit.
fn in_bricks(arguments: &VoxelizeArguments, gpu: &Gpu, scene: &GpuScene, grid: &Grid) -> Result<Found> {
    let thin = arguments.method == VoxelMethod::SixSeparating;
    let thickness = if thin { Thickness::SixSeparating } else { Thickness::Conservative };
    let mut graph = Graph::new("voxelize", gpu.caps());
    let bricks = Bricks { thickness }.record(&mut graph, scene, grid)?;
    bricks.capture(&mut graph);
    if arguments.attributes {
        Attributes::default().record(&mut graph, scene, &bricks)?.capture(&mut graph);
    }
    let (_, executed) = run(gpu, graph)?;
    let voxels = Voxels::read_bricks(&executed, grid)?;
    let attributes = attributes(arguments, &executed, &voxels)?;
    let bytes = voxels.memory();
    Ok(Found { voxels, frustum: None, attributes, leaks: None, atlas: None, seconds: 0.0, bytes })
}

/// In a whole grid.
fn in_grid(arguments: &VoxelizeArguments, gpu: &Gpu, scene: &GpuScene, grid: &Grid) -> Result<Found> {
    let method = arguments.method;
    // XOR is the even-odd rule.
    let is_xor = method == VoxelMethod::Bitmask || arguments.rule == Some(RuleName::EvenOdd);
    let rule = if is_xor { FillRule::EvenOdd } else { FillRule::NonZero };
    let is_atlas = method == VoxelMethod::Atlas;
    let (atlas, report) = is_atlas.then(|| atlas(arguments, gpu, scene, grid)).transpose()?.unzip();
    let how = How { arguments, rule, atlas: atlas.unwrap_or_default() };
    let mut graph = Graph::new("voxelize", gpu.caps());
    // 1. The voxels, along one axis or by the vote of three; columns that leak.
    let vote = Vote { rule };
    let leaks = arguments.is_solid().then(|| vote.leaks(&mut graph, scene, grid));
    let voxels = match leaks.as_ref().filter(|_| arguments.vote) {
        Some(leaks) => {
            let [x, y, z] = [Axis::X, Axis::Y, Axis::Z].map(|axis| how.record(&mut graph, scene, grid, axis));
            vote.record(&mut graph, [&x?, &y?, &z?], leaks)?
        }
        None => how.record(&mut graph, scene, grid, arguments.axis.into())?,
    };
    graph.capture("voxels", &voxels.bits);
    if let Some(leaks) = &leaks {
        graph.capture("leaks", &leaks.counts);
    }
    // 2. What surfaces are like in them.
    if arguments.attributes {
        Attributes::default().record(&mut graph, scene, &voxels)?.capture(&mut graph);
    }
    let axis = voxels.axis;
    let (plan, executed) = run(gpu, graph)?;
    // 3. All of it on the host.
    let voxels = Voxels::read(executed.capture("voxels")?, grid, axis)?;
    let attributes = attributes(arguments, &executed, &voxels)?;
    let leaks = leaks.map(|_| executed.capture("leaks")?.texels::<[u32; 3]>()).transpose()?;
    let leaks = leaks.and_then(|counts| counts.first().copied());
    let bytes = plan.statistics.heap_bytes;
    Ok(Found { voxels, frustum: None, attributes, leaks, atlas: report, seconds: 0.0, bytes })
}

/// How voxels are found.
struct How<'a> {
    arguments: &'a VoxelizeArguments,
    rule: FillRule,
    atlas: Atlas,
}

impl How<'_> {
    /// With columns along an axis.
    fn record<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        grid: &Grid,
        axis: Axis,
    ) -> shadowgraph::Result<VoxelBits> {
        let rule = self.rule;
        match self.arguments.method {
            VoxelMethod::Bitmask => {
                let fill = fill(self.arguments);
                Bitmask { axis, fill, ..Bitmask::default() }.record(graph, scene, grid)
            }
            VoxelMethod::Stencil => Stencil { axis, rule, ..Stencil::default() }.record(graph, scene, grid),
            VoxelMethod::Winding => Winding { axis, rule }.record(graph, scene, grid),
            VoxelMethod::Conservative => Conservative { axis, ..Conservative::default() }.record(graph, scene, grid),
            VoxelMethod::SixSeparating => SixSeparating { axis, ..SixSeparating::default() }.record(graph, scene, grid),
            VoxelMethod::Atlas => self.atlas.record(graph, scene, grid),
        }
    }
}

fn fill(arguments: &VoxelizeArguments) -> Fill {
    if arguments.is_solid() { Fill::Solid } else { Fill::Surface }
}

fn attributes(
    arguments: &VoxelizeArguments,
    executed: &Executed,
    voxels: &Voxels,
) -> shadowgraph::Result<Option<VoxelAttributes>> {
    arguments.attributes.then(|| VoxelAttributes::read(executed, voxels.clone())).transpose()
}

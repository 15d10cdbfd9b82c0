//! `voxelize`: turns a scene's solids or surfaces into a grid of voxels.

use std::io::Write as _;
use std::time::Instant;

use clap::ValueEnum;
use serde::Serialize;
use shadowgraph::capture::{VoxelFormat, write_atomically, write_voxels};
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::{GpuScene, Scene};
use shadowgraph::techniques::voxel::bitmask::Bitmask;
use shadowgraph::techniques::voxel::conservative::Conservative;
use shadowgraph::techniques::voxel::six_separating::SixSeparating;
use shadowgraph::techniques::voxel::stencil::Stencil;
use shadowgraph::techniques::voxel::winding::Winding;
use shadowgraph::techniques::voxel::{Grid, VoxelBits, Voxels};

use crate::cli::{RuleName, VoxelMethod, VoxelizeArguments};
use crate::failure::{Failure, Result};
use crate::output::{check_name, print};
use crate::session;

/// Where the voxels of a file are, and how they were made.
#[derive(Serialize)]
struct Description {
    scene: String,
    method: String,
    /// What is inside, where the method has a rule.
    #[serde(skip_serializing_if = "Option::is_none")]
    rule: Option<String>,
    axis: String,
    /// Voxels along x, y and z.
    resolution: [u32; 3],
    /// World-space lower corner, metres.
    min: [f32; 3],
    /// Metres.
    voxel_edge: f32,
    /// Indices of an array.
    #[serde(skip_serializing_if = "Option::is_none")]
    order: Option<&'static str>,
    set: u64,
    /// Meshes whose surface is not closed, with the number of their open edges.
    open_meshes: Vec<(String, usize)>,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Told<'a> {
    file: String,
    #[serde(flatten)]
    description: &'a Description,
    device: String,
    /// Recording, running and reading back, the driver's compilation included.
    seconds: f64,
    /// Of transient memory on the device.
    bytes: u64,
}

/// Finds the voxels and writes them.
pub fn run(arguments: &VoxelizeArguments) -> Result<()> {
    let ends = VoxelFormat::ALL.map(VoxelFormat::end);
    check_name("--output", &arguments.output, &ends)?;
    let format = VoxelFormat::of(&arguments.output).unwrap_or(VoxelFormat::Npy);
    let [x, y, z] = arguments.resolution.0;
    if arguments.min.is_none() && (x != y || y != z) {
        return Err(Failure::input("a --resolution of three numbers needs --min and --edge"));
    }
    let has_rule = matches!(arguments.method, VoxelMethod::Stencil | VoxelMethod::Winding);
    if arguments.rule.is_some() && !has_rule {
        return Err(Failure::input("--rule is for --method stencil and --method winding"));
    }
    // 1. A scene of closed surfaces, or a warning where solids are wanted.
    let scene = session::scene(&arguments.scene)?;
    let open_meshes = open_meshes(&scene);
    for (name, edges) in open_meshes.iter().filter(|_| arguments.method.is_solid()) {
        log::warn!("mesh `{name}` is not closed ({edges} open edges): columns behind its holes are wrong");
    }
    // 2. Its voxels. All that holds on to the device goes before the device.
    let gpu = session::open(&arguments.device)?;
    let device = gpu.caps().title();
    let found = scene.upload(&gpu).map_err(Failure::from).and_then(|scene| voxelize(arguments, &gpu, &scene));
    let closed = session::close(gpu);
    let (voxels, seconds, bytes) = found?;
    closed?;
    // 3. The file, and beside it what it means.
    let grid = voxels.grid();
    let (path, beside) = (&arguments.output, arguments.output.with_extension("json"));
    let description = Description {
        scene: arguments.scene.to_string(),
        method: name(&arguments.method),
        rule: has_rule.then(|| name(&arguments.rule.unwrap_or(RuleName::NonZero))),
        axis: name(&arguments.axis),
        resolution: grid.size(),
        min: grid.min().to_array(),
        voxel_edge: grid.edge(),
        order: match format {
            VoxelFormat::Npy => Some("[z][y][x]"),
            VoxelFormat::PackedNpy => Some("[z][y][x / 8], lowest bit first"),
            _ => None,
        },
        set: voxels.count(),
        open_meshes,
    };
    write_voxels(path, &voxels, format)?;
    let text = serde_json::to_string_pretty(&description).map_err(Failure::failed)?;
    write_atomically(&beside, |file| writeln!(file, "{text}"))?;
    if arguments.json {
        let file = path.display().to_string();
        let told = Told { file, description: &description, device, seconds, bytes };
        return print(serde_json::to_string(&told).map_err(Failure::failed)?);
    }
    let set = description.set;
    print(format!("wrote {} and {}: {set} of {x}×{y}×{z} voxels are set", path.display(), beside.display()))
}

fn open_meshes(scene: &Scene) -> Vec<(String, usize)> {
    let open = scene.meshes.iter().map(|mesh| (mesh.name.clone(), mesh.open_edges()));
    open.filter(|&(_, edges)| edges > 0).collect()
}

/// As the command line has it.
fn name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map(|value| value.get_name().to_string()).unwrap_or_default()
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

/// The voxels, the seconds they took, and the bytes of memory.
fn voxelize(arguments: &VoxelizeArguments, gpu: &Gpu, scene: &GpuScene) -> Result<(Voxels, f64, u64)> {
    let grid = grid(arguments, scene)?;
    let began = Instant::now();
    let axis = arguments.axis.into();
    let rule = arguments.rule.unwrap_or(RuleName::NonZero).into();
    let mut executor = Executor::new(gpu);
    let (voxels, bytes) = find(&mut executor, gpu, &grid, |graph| match arguments.method {
        VoxelMethod::Bitmask => Bitmask { axis, ..Bitmask::default() }.record(graph, scene, &grid),
        VoxelMethod::Stencil => Stencil { axis, rule, ..Stencil::default() }.record(graph, scene, &grid),
        VoxelMethod::Winding => Winding { axis, rule }.record(graph, scene, &grid),
        VoxelMethod::Conservative => Conservative { axis, ..Conservative::default() }.record(graph, scene, &grid),
        VoxelMethod::SixSeparating => SixSeparating { axis, ..SixSeparating::default() }.record(graph, scene, &grid),
    })?;
    Ok((voxels, began.elapsed().as_secs_f64(), bytes))
}

/// The voxels that a technique records, and the bytes of transient memory it takes.
pub fn find<'f>(
    executor: &mut Executor,
    gpu: &'f Gpu,
    grid: &Grid,
    record: impl FnOnce(&mut Graph<'f>) -> shadowgraph::Result<VoxelBits>,
) -> Result<(Voxels, u64)> {
    let mut graph = Graph::new("voxelize", gpu.caps());
    let VoxelBits { bits, axis, .. } = record(&mut graph)?;
    graph.capture("voxels", &bits);
    let plan = graph.compile(gpu).map_err(shadowgraph::Error::from)?;
    let executed = executor.execute(&plan, graph)?;
    Ok((Voxels::read(executed.capture("voxels")?, grid, axis)?, plan.statistics.heap_bytes))
}

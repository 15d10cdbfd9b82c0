//! `voxelize`: turns a scene's solids or surfaces into a grid of voxels.

use std::io::Write as _;
use std::time::Instant;

use clap::ValueEnum;
use serde::Serialize;
use shadowgraph::capture::{VoxelFormat, write_atomically, write_voxel_attributes, write_voxels};
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::GpuScene;
use shadowgraph::techniques::voxel::atlas::{Atlas, Charts, Stretch};
use shadowgraph::techniques::voxel::attributes::{Attributes, VoxelAttributes};
use shadowgraph::techniques::voxel::bitmask::Bitmask;
use shadowgraph::techniques::voxel::conservative::Conservative;
use shadowgraph::techniques::voxel::six_separating::SixSeparating;
use shadowgraph::techniques::voxel::stencil::Stencil;
use shadowgraph::techniques::voxel::vote::Vote;
use shadowgraph::techniques::voxel::winding::Winding;
use shadowgraph::techniques::voxel::{Axis, FillRule, Grid, VoxelBits, Voxels};

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
    /// Columns along x, y and z in which inside and outside are wrong somewhere, of solids.
    #[serde(skip_serializing_if = "Option::is_none")]
    leaks: Option<[u32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    atlas: Option<AtlasReport>,
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
    let of_atlas = arguments.texels.is_some() || arguments.second_uvs || arguments.close;
    if of_atlas && arguments.method != VoxelMethod::Atlas {
        return Err(Failure::input("--texels, --second-uvs and --close are for --method atlas"));
    }
    if arguments.vote && !arguments.method.is_solid() {
        return Err(Failure::input("--vote is for solids: --method bitmask, stencil and winding"));
    }
    if arguments.attributes && !format.holds_attributes() {
        return Err(Failure::input("--attributes is for files that hold them: .vox and .exr"));
    }
    // 1. A scene of closed surfaces, or a warning where solids are wanted.
    let scene = session::scene(&arguments.scene)?;
    let open_meshes: Vec<_> = scene.open_meshes().iter().map(|&(name, edges)| (name.to_string(), edges)).collect();
    let outcome = if arguments.vote {
        "what is inside of it is a vote of three axes"
    } else {
        "columns behind its holes are wrong; --vote asks three axes"
    };
    for (name, edges) in open_meshes.iter().filter(|_| arguments.method.is_solid()) {
        log::warn!("mesh `{name}` is not closed ({edges} open edges): {outcome}");
    }
    // 2. Its voxels. All that holds on to the device goes before the device.
    let gpu = session::open(&arguments.device)?;
    let device = gpu.caps().title();
    let found = scene.upload(&gpu).map_err(Failure::from).and_then(|scene| voxelize(arguments, &gpu, &scene));
    let closed = session::close(gpu);
    let Found { voxels, attributes, leaks, atlas, seconds, bytes } = found?;
    closed?;
    if let Some(AtlasReport { texels, holes, thin }) = atlas.filter(|atlas| atlas.holes > 0) {
        let remedy =
            if arguments.close { "a finer one is more than the device draws" } else { "--close makes it finer" };
        log::warn!("{holes} of {thin} voxels of the thin surface hold no texel of {texels} a voxel: {remedy}");
    }
    // 3. The file, and beside it what it means.
    let grid = voxels.grid();
    let (path, beside) = (&arguments.output, arguments.output.with_extension("json"));
    let description = Description {
        scene: arguments.scene.to_string(),
        method: name(&arguments.method),
        rule: has_rule.then(|| name(&arguments.rule.unwrap_or(RuleName::NonZero))),
        axis: if arguments.vote { "vote".into() } else { name(&arguments.axis) },
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
        leaks,
        atlas,
    };
    match &attributes {
        Some(attributes) => write_voxel_attributes(path, attributes, format)?,
        None => write_voxels(path, &voxels, format)?,
    }
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

/// What was found.
struct Found {
    voxels: Voxels,
    attributes: Option<VoxelAttributes>,
    /// Columns that leak along x, y and z, of solids.
    leaks: Option<[u32; 3]>,
    atlas: Option<AtlasReport>,
    seconds: f64,
    /// Of transient memory.
    bytes: u64,
}

/// How fine an atlas is, and what it leaves out.
#[derive(Clone, Copy, Serialize)]
struct AtlasReport {
    /// Texels along a voxel's edge.
    texels: f32,
    /// Voxels of the thin surface that hold no texel.
    holes: u32,
    /// Voxels of the thin surface.
    thin: u32,
}

/// An atlas as fine as asked for, or so fine that it leaves no hole, and what it leaves out.
fn atlas(arguments: &VoxelizeArguments, gpu: &Gpu, scene: &GpuScene, grid: &Grid) -> Result<(Atlas, AtlasReport)> {
    let axis = arguments.axis.into();
    let stretch = arguments.second_uvs.then(|| Stretch::of(scene, grid)).transpose()?;
    let charts = |texels| stretch.map_or(Charts::ByAxis { per_voxel: texels }, |stretch| stretch.charts(texels));
    let mut executor = Executor::new(gpu);
    let mut look = |texels: f32| -> shadowgraph::Result<(Atlas, AtlasReport)> {
        let atlas = Atlas { axis, charts: charts(texels) };
        let mut graph = Graph::new("holes", gpu.caps());
        let thin = SixSeparating { axis, ..SixSeparating::default() }.record(&mut graph, scene, grid)?;
        let found = atlas.record(&mut graph, scene, grid)?;
        let holes = Atlas::holes(&mut graph, &thin, &found)?;
        graph.capture("holes", &holes);
        graph.capture("thin", &thin.bits);
        let plan = graph.compile(gpu).map_err(shadowgraph::Error::from)?;
        let executed = executor.execute(&plan, graph)?;
        let words = |name| executed.capture(name)?.texels::<u32>();
        let (holes, thin) = (words("holes")?.iter().sum(), words("thin")?.iter().map(|word| word.count_ones()).sum());
        Ok((atlas, AtlasReport { texels, holes, thin }))
    };
    let mut best = look(arguments.texels.unwrap_or(2.0))?;
    while arguments.close && best.1.holes > 0 {
        // What the device cannot draw ends the search.
        match look(2.0 * best.1.texels) {
            Ok(finer) => best = finer,
            Err(shadowgraph::Error::Invalid { .. }) => break,
            Err(error) => return Err(error.into()),
        }
    }
    Ok(best)
}

/// The voxels by a method, with columns along an axis.
fn record<'f>(
    method: VoxelMethod,
    graph: &mut Graph<'f>,
    scene: &'f GpuScene,
    grid: &Grid,
    axis: Axis,
    rule: FillRule,
) -> shadowgraph::Result<VoxelBits> {
    match method {
        VoxelMethod::Bitmask => Bitmask { axis, ..Bitmask::default() }.record(graph, scene, grid),
        VoxelMethod::Stencil => Stencil { axis, rule, ..Stencil::default() }.record(graph, scene, grid),
        VoxelMethod::Winding => Winding { axis, rule }.record(graph, scene, grid),
        VoxelMethod::Conservative => Conservative { axis, ..Conservative::default() }.record(graph, scene, grid),
        VoxelMethod::SixSeparating => SixSeparating { axis, ..SixSeparating::default() }.record(graph, scene, grid),
        VoxelMethod::Atlas => Atlas { axis, ..Atlas::default() }.record(graph, scene, grid),
    }
}

fn voxelize(arguments: &VoxelizeArguments, gpu: &Gpu, scene: &GpuScene) -> Result<Found> {
    let grid = grid(arguments, scene)?;
    let began = Instant::now();
    let method = arguments.method;
    // XOR is the even-odd rule.
    let is_xor = method == VoxelMethod::Bitmask || arguments.rule == Some(RuleName::EvenOdd);
    let rule = if is_xor { FillRule::EvenOdd } else { FillRule::NonZero };
    let is_atlas = method == VoxelMethod::Atlas;
    let atlas = is_atlas.then(|| atlas(arguments, gpu, scene, &grid)).transpose()?;
    let mut graph = Graph::new("voxelize", gpu.caps());
    // 1. The voxels, along one axis or by the vote of three; columns that leak.
    let vote = Vote { rule };
    let leaks = method.is_solid().then(|| vote.leaks(&mut graph, scene, &grid));
    let voxels = match leaks.as_ref().filter(|_| arguments.vote) {
        Some(leaks) => {
            let [x, y, z] =
                [Axis::X, Axis::Y, Axis::Z].map(|axis| record(method, &mut graph, scene, &grid, axis, rule));
            vote.record(&mut graph, [&x?, &y?, &z?], leaks)?
        }
        None => match &atlas {
            Some((atlas, _)) => atlas.record(&mut graph, scene, &grid)?,
            None => record(method, &mut graph, scene, &grid, arguments.axis.into(), rule)?,
        },
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
    let plan = graph.compile(gpu).map_err(shadowgraph::Error::from)?;
    let executed = Executor::new(gpu).execute(&plan, graph)?;
    // 3. All of it on the host.
    let voxels = Voxels::read(executed.capture("voxels")?, &grid, axis)?;
    let read = |_| VoxelAttributes::read(&executed, voxels.clone());
    let attributes = arguments.attributes.then_some(()).map(read).transpose()?;
    let leaks = leaks.map(|_| executed.capture("leaks")?.texels::<[u32; 3]>()).transpose()?;
    let leaks = leaks.and_then(|counts| counts.first().copied());
    let seconds = began.elapsed().as_secs_f64();
    Ok(Found {
        voxels,
        attributes,
        leaks,
        atlas: atlas.map(|(_, report)| report),
        seconds,
        bytes: plan.statistics.heap_bytes,
    })
}

//! `voxelize`: turns a scene's solids or surfaces into a grid of voxels.

mod atlas;
mod check;
mod find;

use std::io::Write as _;

use clap::ValueEnum;
use serde::Serialize;
use shadowgraph::capture::{VoxelFormat, write_atomically, write_voxel_attributes, write_voxels};
use shadowgraph::scene::Camera;
use shadowgraph::techniques::voxel::FrustumGrid;

use self::atlas::AtlasReport;
use self::find::Found;
use crate::cli::{RuleName, VoxelizeArguments};
use crate::failure::{Failure, Result};
use crate::output::print;
use crate::session;
use crate::view;

/// Where the voxels of a file are, and how they were made.
#[derive(Serialize)]
struct Description {
    scene: String,
    method: String,
    /// `solid` or `surface`.
    fill: &'static str,
    /// What is inside, where the method has a rule.
    #[serde(skip_serializing_if = "Option::is_none")]
    rule: Option<String>,
    axis: String,
    /// Voxels along x, y and z.
    resolution: [u32; 3],
    #[serde(flatten)]
    place: Place,
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

/// Where voxels lie.
#[derive(Serialize)]
#[serde(untagged)]
enum Place {
    Grid {
        /// World-space lower corner, metres.
        min: [f32; 3],
        /// Metres.
        voxel_edge: f32,
    },
    /// Pixels, rows from the top, and slices from the far end, evenly in distance along the view axis.
    Frustum {
        camera: String,
        /// Distances along the view axis, metres.
        near: f32,
        far: f32,
        /// By columns.
        world_from_view: [f32; 16],
        clip_from_view: [f32; 16],
    },
}

impl Place {
    fn of_frustum(camera: &Camera, frustum: &FrustumGrid) -> Self {
        let [near, far] = frustum.distances();
        let view = frustum.view();
        Self::Frustum {
            camera: camera.name.clone(),
            near,
            far,
            world_from_view: view.world_from_view.to_cols_array(),
            clip_from_view: view.clip_from_view.to_cols_array(),
        }
    }
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
    let format = check::format(arguments)?;
    check::arguments(arguments, format)?;
    // 1. A scene of closed surfaces, or a warning where solids are wanted.
    let scene = session::scene(&arguments.scene)?;
    let camera = arguments.camera.as_deref().map(|wanted| view::named(wanted, &scene.cameras)).transpose()?;
    let open_meshes: Vec<_> = scene.open_meshes().iter().map(|&(name, edges)| (name.to_string(), edges)).collect();
    let outcome = if arguments.vote {
        "what is inside of it is a vote of three axes"
    } else {
        "columns behind its holes are wrong; --vote asks three axes"
    };
    for (name, edges) in open_meshes.iter().filter(|_| arguments.is_solid()) {
        log::warn!("mesh `{name}` is not closed ({edges} open edges): {outcome}");
    }
    // 2. Its voxels. All that holds on to the device goes before the device.
    let gpu = session::open(&arguments.device)?;
    let device = gpu.caps().title();
    let uploaded = scene.upload(&gpu).map_err(Failure::from);
    let found = uploaded.and_then(|scene| find::find(arguments, &gpu, &scene, camera.as_ref()));
    let closed = session::close(gpu);
    let Found { voxels, frustum, attributes, leaks, atlas, seconds, bytes } = found?;
    closed?;
    if let Some(AtlasReport { texels, holes, thin }) = atlas.filter(|atlas| atlas.holes > 0) {
        let remedy =
            if arguments.close { "a finer one is more than the device draws" } else { "--close makes it finer" };
        log::warn!("{holes} of {thin} voxels of the thin surface hold no texel of {texels} a voxel: {remedy}");
    }
    // 3. The file, and beside it what it means.
    let grid = voxels.grid();
    let (path, beside) = (&arguments.output, arguments.output.with_extension("json"));
    let place = match camera.zip(frustum) {
        Some((camera, frustum)) => Place::of_frustum(&camera, &frustum),
        None => Place::Grid { min: grid.min().to_array(), voxel_edge: grid.edge() },
    };
    let rule = || name(&arguments.rule.unwrap_or(RuleName::NonZero));
    let axis = match (&place, arguments.vote) {
        (Place::Frustum { .. }, _) => "sight".into(),
        (_, true) => "vote".into(),
        _ => name(&arguments.axis),
    };
    let description = Description {
        scene: arguments.scene.to_string(),
        method: name(&arguments.method),
        fill: if arguments.is_solid() { "solid" } else { "surface" },
        rule: arguments.method.has_rule().then(rule),
        axis,
        resolution: grid.size(),
        place,
        order: match format {
            VoxelFormat::Npy => Some("[z][y][x]"),
            VoxelFormat::PackedNpy => Some("[z][y][x / 8], lowest bit first"),
            VoxelFormat::SparseNpy => Some("records of set voxels, sorted by z, y, x"),
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
    let (set, [x, y, z]) = (description.set, description.resolution);
    print(format!("wrote {} and {}: {set} of {x}×{y}×{z} voxels are set", path.display(), beside.display()))
}

/// As the command line has it.
fn name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map(|value| value.get_name().to_string()).unwrap_or_default()
}

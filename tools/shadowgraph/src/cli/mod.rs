//! The command line.

mod transparency;
mod voxelize;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use glam::Vec3;
use shadowgraph::capture::Compression;
use shadowgraph::frame::Selection;

pub use self::transparency::TransparencyKind;
pub use self::voxelize::{RuleName, VoxelMethod, VoxelizeArguments};
use crate::arguments::{self, SceneSource, Size, Sun};

/// Renders a glTF scene with Vulkan and writes every buffer of the frame into one OpenEXR file: colour, depth, normals,
/// positions, materials, ids, shadows. It needs no window and no graphics card.
#[derive(Debug, Parser)]
#[command(name = "shadowgraph", version, max_term_width = 100, after_help = EXIT_CODES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Say more on standard error; twice or three times for more still
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done, 1 failed, 2 bad usage or bad input.

Environment:
  SHADOWGRAPH_DEVICE  part of the name of the device to use, as --device
  SHADOWGRAPH_CACHE   folder for compiled shaders (otherwise the user's cache folder)

Examples:
  shadowgraph capture builtin:cornell -o cornell.exr --png cornell.png
  shadowgraph info";

/// A command.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a frame and write its layers as OpenEXR
    Capture(CaptureArguments),
    /// Show the render graph of a frame: passes, resources, barriers
    Graph(GraphArguments),
    /// Turn a scene's solids or surfaces into a grid of voxels and write it
    Voxelize(VoxelizeArguments),
    /// Show the device, its driver, and what they can do
    Info(InfoArguments),
    /// Measure how long things take
    Bench(BenchArguments),
}

/// Which device, and whether it is watched.
#[derive(Args, Clone, Debug, Default)]
pub struct DeviceArguments {
    /// Part of the name of the device to use, in any case: `llvmpipe`, `radeon`. Otherwise the best one
    #[arg(long, value_name = "NAME", help_heading = "Device")]
    pub device: Option<String>,
    /// Turn on Vulkan's validation layer with synchronisation validation. Any message is a failure (exit code 1)
    #[arg(long, help_heading = "Device")]
    pub validation: bool,
}

/// What is rendered.
#[derive(Args, Clone, Debug)]
pub struct FrameArguments {
    /// A .gltf or .glb file, or a built-in scene: builtin:NAME
    #[arg(value_parser = arguments::scene)]
    pub scene: SceneSource,
    /// Width and height of the picture in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1280x720")]
    pub size: Size,
    /// A camera of the scene, by name or by index from 0. Without this and without --eye: the scene's first camera, and
    /// where it has none, a view of the whole scene
    #[arg(long, value_name = "NAME|INDEX", conflicts_with_all = ["eye", "target", "up", "fov"], help_heading = "Camera")]
    pub camera: Option<String>,
    /// Where a camera of your own stands, in metres
    #[arg(long, value_name = "X,Y,Z", value_parser = arguments::point, allow_hyphen_values = true, help_heading = "Camera")]
    pub eye: Option<Vec3>,
    /// What it looks at; otherwise the middle of the scene
    #[arg(long, value_name = "X,Y,Z", value_parser = arguments::point, allow_hyphen_values = true, requires = "eye",
        help_heading = "Camera")]
    pub target: Option<Vec3>,
    /// Which way is up; otherwise 0,1,0
    #[arg(long, value_name = "X,Y,Z", value_parser = arguments::direction, allow_hyphen_values = true, requires = "eye",
        help_heading = "Camera")]
    pub up: Option<Vec3>,
    /// Its vertical field of view in degrees; otherwise 60
    #[arg(long, value_name = "DEGREES", value_parser = arguments::field_of_view, allow_hyphen_values = true,
        requires = "eye", help_heading = "Camera")]
    pub fov: Option<f32>,
    /// A sun in place of the scene's directional lights: the way its light travels, and its illuminance in lux
    /// (otherwise 100000). A scene without any light gets a sun anyway
    #[arg(long, value_name = "DX,DY,DZ[,LUX]", allow_hyphen_values = true, help_heading = "Light")]
    pub sun: Option<Sun>,
    /// Light that comes evenly from everywhere, in cd/m²; otherwise a sky that goes with the sun, and 0 without one
    #[arg(long, value_name = "LUMINANCE", value_parser = arguments::not_negative, allow_hyphen_values = true,
        help_heading = "Light")]
    pub environment: Option<f32>,
    /// Visibility through so many voxels along each side of the scene: point lights cast shadows, and there is a layer
    /// ambient_occlusion. What is thinner than a voxel is as thick as one
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(8..=1024), help_heading = "Light")]
    pub voxels: Option<u32>,
    /// How blended surfaces are composited. Sorted by object is right where objects do not interlock; abuffer, depth-peeling
    /// and dual-depth-peeling are exact in every pixel; the others are approximations whatever the order
    #[arg(long, value_enum, value_name = "KIND", default_value_t = TransparencyKind::Sorted)]
    pub transparency: TransparencyKind,
    /// Layers of a pixel that `--transparency kbuffer` keeps (otherwise 4), or nodes of its visibility with `adaptive`
    /// (otherwise 8)
    #[arg(long, value_name = "LAYERS", value_parser = clap::value_parser!(u32).range(1..=32))]
    pub kept: Option<u32>,
    /// Samples a pixel of `--transparency stochastic`; otherwise 8
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub samples: Option<u32>,
    /// How the weights of `--transparency weighted` fall with distance: the number of McGuire and Bavoil's equation;
    /// otherwise 7
    #[arg(long, value_name = "EQUATION", value_parser = clap::value_parser!(u32).range(7..=10))]
    pub weight: Option<u32>,
    /// Samples a pixel of `--transparency abuffer`: 2, 4 or 8, whichever the device has, anti-alias the edges of blended surfaces;
    /// otherwise 1
    #[arg(long, value_name = "COUNT", value_parser = arguments::samples)]
    pub abuffer_samples: Option<u32>,
    /// Most memory for the layers of `--transparency abuffer`, of `--deep` and of `--deep-shadows`, in MiB; otherwise as much as the device gives. Where it is
    /// not enough, the picture is made in up to 64 bands, and where that is not enough either, the command fails and says
    /// how much would be
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..=1 << 30))]
    pub layer_memory: Option<u64>,
    /// Let blended surfaces and glass throw coloured shadows, by deep shadow maps of so many texels a side, from 1 to 2048
    #[arg(long, value_name = "TEXELS", value_parser = clap::value_parser!(u32).range(1..=2048), help_heading = "Light")]
    pub deep_shadows: Option<u32>,
    /// Layers to keep, by name or by first part of the name, between commas: color,Z,N,id. What no layer needs is not
    /// rendered. An unknown name makes the command list the known ones
    #[arg(long, value_name = "LIST|all", value_parser = arguments::layers, default_value = "all")]
    pub layers: Selection,
    /// Store colours and materials as 32-bit floats. Otherwise they are 16-bit floats, and what those cannot hold is
    /// clamped, counted and reported
    #[arg(long)]
    pub float: bool,
    /// The device
    #[command(flatten)]
    pub device: DeviceArguments,
}

/// Ways to look into a frame.
#[derive(Args, Clone, Debug, Default)]
pub struct DebugArguments {
    /// Put a full barrier before every pass: where that changes the picture, a barrier is missing
    #[arg(long, help_heading = "Debugging")]
    pub serialize: bool,
    /// Leave a pass out: what it would have written is zero. `shadowgraph graph` lists the passes; may be repeated
    #[arg(long, value_name = "PASS", help_heading = "Debugging")]
    pub without: Vec<String>,
    /// Write what a resource holds right after a pass to a NumPy array beside the output; may be repeated
    #[arg(long, value_name = "PASS:RESOURCE", help_heading = "Debugging")]
    pub dump: Vec<String>,
}

/// Arguments of `capture`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Layers: color (R,G,B,A), Z (distance along the view axis, m), N (normal) and P (position) in world space, \
albedo, roughness, metallic, occlusion, emissive, direct (light that came straight from lamps), id.object, \
id.primitive, id.material (from 1; names in the header), shadow.LIGHT, transmittance.LIGHT (what comes through glass; \
with --deep-shadows), cascade.index, abuffer.count and abuffer.front.Z (layers, and how far the nearest is; with \
--transparency abuffer), abuffer.0, abuffer.1, ... by name alone (the nearest layer, the next: R,G,B,A,Z), \
ambient_occlusion (the open share of the space around; with --voxels), and shadow maps as parts map.LIGHT.

Examples:
  shadowgraph capture scene.glb -o out.exr
  shadowgraph capture scene.glb -o out.exr --size 1920x1080 --camera 0 --png out.png
  shadowgraph capture scene.glb -o out.exr --eye 3,1.7,4 --target 0,1,0 --fov 50
  shadowgraph capture scene.glb -o out.exr --deep layers.exr
  shadowgraph capture scene.glb -o out.exr --sun -0.4,-1,-0.3,100000 --layers color,Z,shadow")]
pub struct CaptureArguments {
    /// What is rendered.
    #[command(flatten)]
    pub frame: FrameArguments,
    /// The OpenEXR file to write
    #[arg(short, long, value_name = "FILE.exr", required_unless_present_any = ["png", "deep", "phases"])]
    pub output: Option<PathBuf>,
    /// A tone-mapped picture to look at as well
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
    /// A deep OpenEXR file as well: every layer of every pixel, with R, G, B, A and Z. Blended surfaces are composited as
    /// by `--transparency abuffer` then
    #[arg(long, value_name = "FILE.exr")]
    pub deep: Option<PathBuf>,
    /// Leave out what differs from run to run (the passes' times), so that equal frames make equal files
    #[arg(long)]
    pub reproducible: bool,
    /// Compression of the OpenEXR file, lossless all: none, rle, zips, zip, piz
    #[arg(long, value_name = "KIND", default_value = "zip")]
    pub compression: Compression,
    /// Debugging
    #[command(flatten)]
    pub debug: DebugArguments,
    /// For `bench capture`: render twice and print a line of JSON with the time of each phase
    #[arg(long, hide = true)]
    pub phases: bool,
}

/// Arguments of `graph`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  shadowgraph graph builtin:cornell --format dot | dot -Tsvg > frame.svg
  shadowgraph graph scene.glb --format html --times -o frame.html
  shadowgraph graph scene.glb --format json --layers Z > frame.json")]
pub struct GraphArguments {
    /// What is rendered.
    #[command(flatten)]
    pub frame: FrameArguments,
    /// As a drawing for Graphviz, as a page for a browser, as data, or as lines to read
    #[arg(long, value_enum, default_value_t = GraphFormat::Dot)]
    pub format: GraphFormat,
    /// The file to write; otherwise it is printed
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Run the frame and add what its passes take on the device; for html and json
    #[arg(long)]
    pub times: bool,
}

/// Form of a printed graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GraphFormat {
    /// Graphviz's language.
    Dot,
    /// A self-contained page.
    Html,
    /// One JSON object.
    Json,
    /// Lines to read.
    Text,
}

/// Arguments of `info`.
#[derive(Args, Clone, Debug)]
pub struct InfoArguments {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArguments,
}

/// Arguments of `bench`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Benchmarks:
  abuffer  layers of one colour, as many everywhere and by other distributions: building, sorting
           and compositing them, beside blending of the same fragments; long lists sorted in each way
  capture  whole captures, each in a process of its own: process start, device, loading, first-draw
           compilation, rendering, read-back, writing; cold (no compiled shaders on disk) and warm
  graph    chains and trees of 10 to 10 000 small passes: describing, planning, recording, memory
  write    writing of captures, by compression; needs no device
  voxelize voxels of spheres, from triangles in memory to bits in memory, uploads and read-back
           included

Examples:
  shadowgraph bench
  shadowgraph bench capture --scene scene.glb --runs 9 --json
  shadowgraph bench voxelize --case \"bitmask, 69696 triangles\"")]
pub struct BenchArguments {
    /// Which benchmark; all where there is none
    #[arg(value_enum)]
    pub name: Option<BenchName>,
    /// Only cases that have this text in their names, as they are printed
    #[arg(long, value_name = "TEXT", default_value = "", hide_default_value = true)]
    pub case: String,
    /// Print one JSON object a line: {"bench","case","metric","value","unit"}
    #[arg(long)]
    pub json: bool,
    /// Runs of each case; the median counts
    #[arg(long, value_name = "COUNT", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub runs: u32,
    /// Scene of `capture`
    #[arg(long, value_parser = arguments::scene, default_value = "builtin:courtyard")]
    pub scene: SceneSource,
    /// Size of the picture
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1280x720")]
    pub size: Size,
}

/// A benchmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BenchName {
    /// What the A-buffer costs a fragment.
    Abuffer,
    /// Whole captures.
    Capture,
    /// What a pass costs on the host.
    Graph,
    /// Writing files.
    Write,
    /// Voxels.
    Voxelize,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use clap::CommandFactory;
    use clap::error::ErrorKind;

    fn capture(arguments: &str) -> Result<CaptureArguments, ErrorKind> {
        let all = ["shadowgraph", "capture"].into_iter().chain(arguments.split_whitespace());
        match Cli::try_parse_from(all).map_err(|error| error.kind())?.command {
            Command::Capture(arguments) => Ok(arguments),
            _ => panic!("not a capture"),
        }
    }

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_capture_has_sensible_defaults() {
        let arguments = capture("scene.glb -o out.exr").unwrap();
        assert_eq!(arguments.frame.size.0, [1280, 720]);
        assert_eq!(arguments.frame.layers, Selection::All);
        assert_eq!(arguments.compression, Compression::default());
        assert!(!arguments.reproducible && !arguments.frame.float && !arguments.frame.device.validation);
    }

    #[test]
    fn every_option_of_a_capture_is_read() {
        let arguments = capture(
            "builtin:cornell -o o.exr --size 64x32 --eye -1,2,-3 --target -1,0,0 --up -0,0,-1 --fov 90 \
             --sun -1,-1,0,5 --environment 3 --layers Z,N --float --reproducible --png o.png --compression piz \
             --validation --device llvm",
        )
        .unwrap();
        assert_eq!(arguments.frame.eye, Some(Vec3::new(-1.0, 2.0, -3.0)));
        assert_eq!(arguments.frame.up, Some(Vec3::NEG_Z));
        assert_eq!(arguments.frame.sun.unwrap().illuminance, 5.0);
        assert_eq!(arguments.frame.environment, Some(3.0));
        assert_eq!(arguments.compression, Compression::Piz);
        assert_eq!(arguments.frame.device.device.as_deref(), Some("llvm"));
        assert!(arguments.frame.float && arguments.reproducible && arguments.frame.device.validation);
    }

    #[test]
    fn a_camera_is_named_or_placed() {
        assert_eq!(capture("s -o o.exr --camera 0 --eye 1,2,3").unwrap_err(), ErrorKind::ArgumentConflict);
        assert_eq!(capture("s -o o.exr --camera 0 --target 1,2,3").unwrap_err(), ErrorKind::ArgumentConflict);
        assert_eq!(capture("s -o o.exr --target 1,2,3").unwrap_err(), ErrorKind::MissingRequiredArgument);
        assert_eq!(capture("s -o o.exr --fov 40").unwrap_err(), ErrorKind::MissingRequiredArgument);
        assert!(capture("s -o o.exr --eye 1,2,3").is_ok());
    }

    #[test]
    fn a_capture_needs_somewhere_to_go() {
        assert_eq!(capture("s").unwrap_err(), ErrorKind::MissingRequiredArgument);
        assert!(capture("s --png o.png").is_ok());
        assert_eq!(capture("-o o.exr").unwrap_err(), ErrorKind::MissingRequiredArgument);
    }

    #[test]
    fn bad_values_are_refused() {
        let bad = [
            "--size 0x1",
            "--size 16385x1",
            "--eye 1,2",
            "--eye 1,2,inf",
            "--eye 0,0,1 --fov 180",
            "--eye 0,0,1 --fov -5",
            "--sun 0,0,0",
            "--sun 1,1,1,-5",
            "--layers ,",
            "--compression lzw",
            "--environment -1",
        ];
        for bad in bad {
            assert_eq!(capture(&format!("s -o o.exr {bad}")).unwrap_err(), ErrorKind::ValueValidation, "{bad}");
        }
        assert_eq!(capture("s -o o.exr --colour").unwrap_err(), ErrorKind::UnknownArgument);
    }
}

//! What `voxelize` takes.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::Vec3;
use shadowgraph::techniques::voxel::{Axis, FillRule};

use super::DeviceArguments;
use crate::arguments::{self, Resolution, SceneSource};

/// Arguments of `voxelize`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
A voxel is set where its centre is inside a solid (bitmask, stencil, winding), where a triangle touches it \
(conservative), where it is needed to separate a surface's sides (six-separating), or where a texel of the surface's \
atlas lies in it (atlas). bitmask --surface sets those in which a surface crosses the line through their column. \
Arrays are indexed [z,y,x]. Beside the file a .json says where the voxels are: voxel (i,j,k) has its centre at \
min + (i+1/2, j+1/2, k+1/2) * voxel_edge.

Examples:
  shadowgraph voxelize scene.glb --resolution 256 -o scene.npy
  shadowgraph voxelize scene.glb --resolution 64,32,64 --min -1,0,-1 --edge 2 -o scene.npy --json
  shadowgraph voxelize scene.glb --method conservative --attributes -o scene.vox
  shadowgraph voxelize scene.glb --camera 0 --resolution 320,180,128 -o scene.npy
  shadowgraph voxelize broken.glb --vote -o scene.binvox")]
pub struct VoxelizeArguments {
    /// A .gltf or .glb file, or a built-in scene: builtin:NAME
    #[arg(value_parser = arguments::scene)]
    pub scene: SceneSource,
    /// Voxels along each axis, or along x, y and z; the grid of one number is a cube. Up to 1024, and to 2048 for surfaces,
    /// which are found in bricks then
    #[arg(long, value_name = "N|X,Y,Z", default_value = "128")]
    pub resolution: Resolution,
    /// Lower corner of the grid in metres; otherwise the grid is around the scene
    #[arg(long, value_name = "X,Y,Z", value_parser = arguments::point, allow_hyphen_values = true, requires = "edge")]
    pub min: Option<Vec3>,
    /// Length of the grid along its axis with the most voxels, in metres
    #[arg(long, value_name = "METRES", value_parser = arguments::positive, allow_hyphen_values = true, requires = "min")]
    pub edge: Option<f32>,
    /// Voxelize what a camera of the scene sees, by name or by index from 0 (bitmask): columns are the pixels of a picture of
    /// X by Y, rows from the top, and the Z slices lie evenly between the nearest and the farthest the scene may be, from
    /// far to near
    #[arg(long, value_name = "NAME|INDEX", conflicts_with_all = ["min", "edge", "axis", "vote", "attributes"])]
    pub camera: Option<String>,
    /// The axis that columns of voxels run along. Which one matters only where a surface has holes
    #[arg(long, value_enum, default_value_t = AxisName::Z)]
    pub axis: AxisName,
    /// How voxels are found
    #[arg(long, value_enum, default_value_t = VoxelMethod::Bitmask)]
    pub method: VoxelMethod,
    /// Set what is inside of solids: what bitmask, stencil and winding do anyway
    #[arg(long, conflicts_with = "surface")]
    pub solid: bool,
    /// Set what surfaces lie in: with bitmask too, the others of them do anyway
    #[arg(long)]
    pub surface: bool,
    /// What is inside (stencil, winding): what surfaces wind around, the default, so that solids that overlap are one; or
    /// what lies behind an odd number of surfaces
    #[arg(long, value_enum)]
    pub rule: Option<RuleName>,
    /// Texels of the atlas along a voxel's edge (atlas), at least; otherwise 2
    #[arg(long, value_name = "COUNT", value_parser = arguments::positive)]
    pub texels: Option<f32>,
    /// Lay the atlas out by the meshes' second texture coordinates (atlas), not by axis
    #[arg(long)]
    pub second_uvs: bool,
    /// Make the atlas finer and finer (atlas), until every voxel of the thin surface holds a texel
    #[arg(long)]
    pub close: bool,
    /// Look along all three axes and let them vote on what is inside (bitmask, stencil, winding): for surfaces with holes
    #[arg(long, conflicts_with = "axis")]
    pub vote: bool,
    /// Write what surfaces are like in each voxel too: albedo as the colours of a .vox, and albedo, opacity, normal, area and
    /// emission as channels of an .exr or fields of a .sparse.npy
    #[arg(long)]
    pub attributes: bool,
    /// The file to write; its name says the format: .npy, .packed.npy or .sparse.npy (NumPy), .binvox, .vox
    /// (MagicaVoxel), .exr (a part a slice), .glb (a mesh to look at), .png (a picture of slices). What it means is written
    /// beside it, as .json
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Print one JSON object: what the .json file has, times and memory
    #[arg(long)]
    pub json: bool,
    /// The device
    #[command(flatten)]
    pub device: DeviceArguments,
}

impl VoxelizeArguments {
    /// Whether what is inside of surfaces is asked for.
    pub fn is_solid(&self) -> bool {
        self.method.is_solid() && !self.surface
    }
}

/// An axis of the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AxisName {
    /// World x.
    X,
    /// World y.
    Y,
    /// World z.
    Z,
}

impl From<AxisName> for Axis {
    fn from(name: AxisName) -> Self {
        match name {
            AxisName::X => Self::X,
            AxisName::Y => Self::Y,
            AxisName::Z => Self::Z,
        }
    }
}

/// A way to find voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum VoxelMethod {
    /// Solids, by XOR of column bits: inside is what lies behind an odd number of surfaces.
    Bitmask,
    /// Solids, counted slice by slice in a stencil buffer.
    Stencil,
    /// Solids, by winding numbers counted in one pass.
    Winding,
    /// Surfaces: every voxel that a triangle touches.
    Conservative,
    /// Surfaces: as few voxels as separate the two sides.
    SixSeparating,
    /// Surfaces: voxels that the texels of an atlas lie in. Made by axis, or of the second texture coordinates.
    Atlas,
}

impl VoxelMethod {
    /// Whether it finds what is inside of surfaces, which must be closed for that.
    pub fn is_solid(self) -> bool {
        matches!(self, Self::Bitmask | Self::Stencil | Self::Winding)
    }

    /// Whether there is a choice of what is inside.
    pub fn has_rule(self) -> bool {
        matches!(self, Self::Stencil | Self::Winding)
    }
}

/// A rule of what is inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RuleName {
    /// What surfaces wind around.
    NonZero,
    /// What lies behind an odd number of surfaces.
    EvenOdd,
}

impl From<RuleName> for FillRule {
    fn from(rule: RuleName) -> Self {
        match rule {
            RuleName::NonZero => Self::NonZero,
            RuleName::EvenOdd => Self::EvenOdd,
        }
    }
}

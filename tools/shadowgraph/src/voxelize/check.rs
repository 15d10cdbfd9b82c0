//! What does not go together, found before any work.

use shadowgraph::capture::VoxelFormat;

use crate::cli::{VoxelMethod, VoxelizeArguments};
use crate::failure::{Failure, Result};
use crate::output::check_name;

/// Most voxels an axis that are found as a whole.
const MOST_WHOLE: u32 = 1024;

/// What the file's name asks for.
pub(super) fn format(arguments: &VoxelizeArguments) -> Result<VoxelFormat> {
    let ends = VoxelFormat::ALL.map(VoxelFormat::end);
    check_name("--output", &arguments.output, &ends)?;
    Ok(VoxelFormat::of(&arguments.output).unwrap_or(VoxelFormat::Npy))
}

/// Whether surfaces are found in bricks: a whole grid does not fit.
pub(super) fn is_in_bricks(arguments: &VoxelizeArguments) -> bool {
    arguments.camera.is_none() && arguments.resolution.0.into_iter().any(|n| n > MOST_WHOLE)
}

/// Options that need others, or exclude them.
pub(super) fn arguments(arguments: &VoxelizeArguments, format: VoxelFormat) -> Result<()> {
    let input = |why: &str| Err(Failure::input(why));
    let method = arguments.method;
    let [x, y, z] = arguments.resolution.0;
    if arguments.min.is_none() && arguments.camera.is_none() && (x != y || y != z) {
        return input("a --resolution of three numbers needs --min and --edge, or --camera");
    }
    if arguments.rule.is_some() && !method.has_rule() {
        return input("--rule is for --method stencil and --method winding");
    }
    let of_atlas = arguments.texels.is_some() || arguments.second_uvs || arguments.close;
    if of_atlas && method != VoxelMethod::Atlas {
        return input("--texels, --second-uvs and --close are for --method atlas");
    }
    if arguments.solid && !method.is_solid() {
        return input("--solid is for --method bitmask, stencil and winding");
    }
    if arguments.surface && method.is_solid() && method != VoxelMethod::Bitmask {
        return input("--surface is for --method bitmask, conservative, six-separating and atlas");
    }
    if arguments.vote && !arguments.is_solid() {
        return input("--vote is for solids: --method bitmask, stencil and winding");
    }
    if arguments.camera.is_some() {
        camera(arguments, format)?;
    }
    if is_in_bricks(arguments) {
        bricks(arguments, format)?;
    }
    format.check(&arguments.output, arguments.resolution.0, arguments.attributes).map_err(Failure::input)
}

/// What is not for a camera's frustum.
fn camera(arguments: &VoxelizeArguments, format: VoxelFormat) -> Result<()> {
    if arguments.method != VoxelMethod::Bitmask {
        return Err(Failure::input("--camera is for --method bitmask"));
    }
    match format {
        VoxelFormat::Npy | VoxelFormat::PackedNpy | VoxelFormat::SparseNpy | VoxelFormat::Png => Ok(()),
        VoxelFormat::Binvox | VoxelFormat::Vox | VoxelFormat::Exr | VoxelFormat::Glb => {
            let why = "voxels of a camera's frustum are no cubes: .npy, .packed.npy, .sparse.npy and .png hold them";
            Err(Failure::input(why))
        }
    }
}

/// What is not for so many voxels.
fn bricks(arguments: &VoxelizeArguments, format: VoxelFormat) -> Result<()> {
    let refused = |what: &str| Err(Failure::input(format!("more than {MOST_WHOLE} voxels an axis are for {what}")));
    if !matches!(arguments.method, VoxelMethod::Conservative | VoxelMethod::SixSeparating) {
        return refused("surfaces: --method conservative and six-separating");
    }
    match format {
        VoxelFormat::PackedNpy | VoxelFormat::SparseNpy | VoxelFormat::Binvox | VoxelFormat::Vox | VoxelFormat::Png => {
            Ok(())
        }
        VoxelFormat::Npy | VoxelFormat::Exr | VoxelFormat::Glb => {
            refused(".vox, .binvox, .packed.npy, .sparse.npy and .png files")
        }
    }
}

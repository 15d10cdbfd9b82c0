//! Voxels as texels, for shaders that sample them.

use ash::vk;

use super::{VoxelSet, voxel_set};
use crate::graph::{ComputePass, Graph, ImageHandle, ImageShape};
use crate::shader::generated::blocks::TilesPush;
use crate::shader::generated::voxel::{tiles_comp, volume_comp};
use crate::{Error, Result};

/// What texels are: 1 where a voxel is set, else 0; between them a filter gives the share that is set.
pub const TEXEL: vk::Format = vk::Format::R8_UNORM;

/// Slices of a grid in the tiles of one image.
pub struct Tiles {
    /// Voxel (x, y, z) is texel `(z % across · width + x, z / across · height + y)`. Tiles behind the last slice are 0.
    pub image: ImageHandle,
    /// Tiles side by side.
    pub across: u32,
}

/// Voxels as a three-dimensional image: voxel (x, y, z) is texel (x, y, z), whatever the axis of the columns.
/// `name`: of the image and its pass.
///
/// # Errors
/// [`Error::Invalid`] where the device has no three-dimensional image of the grid's size, as for a grid of one slice.
pub fn volume_image(graph: &mut Graph, name: &str, voxels: &impl VoxelSet) -> Result<ImageHandle> {
    let (size, most) = (voxels.grid().size(), graph.caps().limits.max_image_dimension_3d);
    if size[2] < 2 || size.iter().any(|&n| n > most) {
        let why = format!("of {size:?} voxels is not one of the device's, of up to {most} along an axis and 2 slices");
        return Err(Error::invalid(format!("the image `{name}`"), format!("{why} at least; tiles may hold them")));
    }
    let image = graph.image(name, ImageShape { extent: size, ..ImageShape::new_2d(TEXEL, [1; 2]) });
    let mut pass = graph.compute(name, &volume_comp::SHADER);
    bind(&mut pass, voxels);
    let image = pass.write(volume_comp::TEXELS, image);
    dispatch(pass, voxels);
    Ok(image)
}

/// Voxels as a two-dimensional image, with a tile for each slice along z. `name`: of the image and its pass.
///
/// # Errors
/// [`Error::Invalid`] where the device's images are too small.
pub fn tiled_image(graph: &mut Graph, name: &str, voxels: &impl VoxelSet) -> Result<Tiles> {
    let ([width, height, depth], most) = (voxels.grid().size(), graph.caps().limits.max_image_dimension_2d);
    let across = tiles_across(depth, [width, height], most);
    let size = [across * width, depth.div_ceil(across) * height];
    if size.iter().any(|&n| n > most) {
        let why = format!("of {depth} slices of {width} × {height} voxels is more than the device's {most} × {most}");
        return Err(Error::invalid(format!("the image `{name}`"), why));
    }
    let mut image = graph.image(name, ImageShape::new_2d(TEXEL, size));
    if !depth.is_multiple_of(across) {
        image = graph.clear(format!("{name}.clear"), image, vk::ClearColorValue { float32: [0.0; 4] });
    }
    let mut pass = graph.compute(name, &tiles_comp::SHADER);
    bind(&mut pass, voxels);
    pass.push(&TilesPush { across });
    let image = pass.write(tiles_comp::TEXELS, image);
    dispatch(pass, voxels);
    Ok(Tiles { image, across })
}

/// How many of `count` tiles lie side by side so that all are about as high as wide, in an image of at most so many texels.
pub(super) fn tiles_across(count: u32, [width, height]: [u32; 2], most: u32) -> u32 {
    let square = (f64::from(count) * f64::from(height) / f64::from(width)).sqrt().ceil() as u32;
    square.max(count.div_ceil((most / height).max(1))).clamp(1, (most / width).max(1))
}

fn bind(pass: &mut ComputePass, voxels: &impl VoxelSet) {
    pass.uniform(volume_comp::VOXEL_GRID, &voxels.grid().block(voxels.axis()));
    voxel_set::bind(pass, voxels);
}

fn dispatch(pass: ComputePass, voxels: &impl VoxelSet) {
    let [width, height, depth] = voxels.grid().columns(voxels.axis());
    pass.dispatch([width, height, depth.div_ceil(32)]);
}

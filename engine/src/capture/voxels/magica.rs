//! MagicaVoxel's `.vox`, version 150: chunks of models and a scene graph that places them (*MagicaVoxel .vox File
//! Format* and its extension, ephtracy).

use std::io::Write;
use std::path::Path;

use super::super::png::to_srgb8;
use super::super::write_atomically;
use super::palette::{Color, palette};
use super::too_many;
use crate::Result;
use crate::techniques::voxel::Voxels;
use crate::techniques::voxel::attributes::VoxelAttributes;

/// Most voxels of a model along an axis.
const MODEL: u32 = 256;

/// Of voxels without surface, and of all without attributes: the first of the palette.
const GREY: Color = [200; 3];
/// Colours beside it. A palette has 255.
const MOST_COLORS: usize = 254;

pub(super) fn write(path: &Path, voxels: &Voxels, attributes: Option<&VoxelAttributes>) -> Result<()> {
    let color =
        |voxel| attributes?.get(voxel).filter(|own| own.area > 0.0).map(|own| own.albedo.to_array().map(to_srgb8));
    let (colors, places) = palette(voxels.grid().voxels().filter_map(color), MOST_COLORS);
    let models = models(voxels, |voxel| color(voxel).map_or(1, |color| 2 + places[&color] as u8));
    let mut chunks = Vec::new();
    for model in &models {
        append(&mut chunks, b"SIZE", &words(&model.size.map(|n| n as i32)));
        append(&mut chunks, b"XYZI", &[&words(&[model.voxels.len() as i32])[..], model.voxels.as_flattened()].concat());
    }
    // A node for the whole, a group, and a place and a shape for each model.
    append(&mut chunks, b"nTRN", &[words(&[0, 0, 1, -1, 0, 1]), words(&[0])].concat());
    let places: Vec<i32> = (0..models.len() as i32).map(|index| 2 + 2 * index).collect();
    append(&mut chunks, b"nGRP", &[words(&[1, 0, models.len() as i32]), words(&places)].concat());
    for (index, (model, &place)) in models.iter().zip(&places).enumerate() {
        let [x, y, z] = model.center;
        let at = format!("{x} {y} {z}");
        let frame = [words(&[1]), text("_t"), text(&at)].concat();
        append(&mut chunks, b"nTRN", &[words(&[place, 0, place + 1, -1, 0, 1]), frame].concat());
        append(&mut chunks, b"nSHP", &words(&[place + 1, 0, 1, index as i32, 0]));
    }
    let opaque = |[red, green, blue]: Color| [red, green, blue, 255];
    let mut table = [opaque(GREY); 256];
    table[1..].iter_mut().zip(colors).for_each(|(entry, color)| *entry = opaque(color));
    append(&mut chunks, b"RGBA", table.as_flattened());
    let Ok(length) = i32::try_from(chunks.len()) else {
        let why = format!("{} set voxels are more than 2 GiB, which is all that a .vox file holds", voxels.count());
        return Err(too_many(path, why));
    };
    write_atomically(path, |file| {
        file.write_all(b"VOX ")?;
        file.write_all(&words(&[150]))?;
        file.write_all(b"MAIN")?;
        file.write_all(&words(&[0, length]))?;
        file.write_all(&chunks)
    })
}

/// A part of the grid that fits into a model, in MagicaVoxel's axes: x, minus z, y of the world.
struct Model {
    size: [u32; 3],
    /// Of the voxel in its middle, in the whole.
    center: [u32; 3],
    /// Places, and the index of the colour.
    voxels: Vec<[u8; 4]>,
}

/// Models that hold something; `index`: of a voxel's colour, from 1.
fn models(voxels: &Voxels, index: impl Fn([u32; 3]) -> u8) -> Vec<Model> {
    let [width, height, depth] = voxels.grid().size();
    let whole = [width, depth, height];
    let starts = |axis: usize| (0..whole[axis]).step_by(MODEL as usize);
    let corners = starts(2).flat_map(|z| starts(1).flat_map(move |y| starts(0).map(move |x| [x, y, z])));
    let made = corners.map(|corner| {
        let size: [u32; 3] = std::array::from_fn(|axis| MODEL.min(whole[axis] - corner[axis]));
        let inside = (0..size[2]).flat_map(|z| (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| [x, y, z])));
        let at = |[x, y, z]: [u32; 3]| [corner[0] + x, corner[2] + z, depth - 1 - corner[1] - y];
        let set = inside.filter(|&place| voxels.get(at(place)));
        let found = set.map(|place| [place[0] as u8, place[1] as u8, place[2] as u8, index(at(place))]);
        let center = std::array::from_fn(|axis| corner[axis] + size[axis] / 2);
        Model { size, center, voxels: found.collect() }
    });
    made.filter(|model| !model.voxels.is_empty()).collect()
}

/// Adds a chunk without children.
fn append(chunks: &mut Vec<u8>, id: &[u8; 4], content: &[u8]) {
    chunks.extend_from_slice(id);
    chunks.extend_from_slice(&words(&[content.len() as i32, 0]));
    chunks.extend_from_slice(content);
}

fn words(values: &[i32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn text(text: &str) -> Vec<u8> {
    [&words(&[text.len() as i32])[..], text.as_bytes()].concat()
}

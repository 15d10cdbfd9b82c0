//! Voxel grids on disk, in the formats of arrays, of voxel tools, of pictures and of meshes.

mod binvox;
mod glb;
mod magica;
mod palette;
mod slices;
mod sparse;

use std::path::Path;

use super::{Capture, Channel, Compression, ExrOptions, Part, Samples, Value, write_exr, write_npy};
use crate::techniques::voxel::Voxels;
use crate::techniques::voxel::attributes::{Attribute, VoxelAttributes};
use crate::{Error, Result};

/// What a file of voxels is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VoxelFormat {
    /// NumPy array of `uint8`, 0 or 1, indexed `[z, y, x]`.
    Npy,
    /// NumPy array of `uint8`, eight voxels a byte along x, the first one the lowest bit, indexed `[z, y, x / 8]`:
    /// `numpy.unpackbits(array, axis=2, count=width, bitorder="little")` gives what [`VoxelFormat::Npy`] holds.
    PackedNpy,
    /// NumPy array of records, one for each set voxel: `voxel`, its x, y and z as `uint16`; with attributes also `albedo`,
    /// `opacity`, `normal`, `area` and `emission`, as `float32`. In the order of z, then y, then x.
    SparseNpy,
    /// binvox (Min, *binvox: 3D mesh voxelizer*): runs of equal voxels.
    Binvox,
    /// MagicaVoxel's models of at most 256 voxels an axis, y up as z up: in one grey, or with attributes in the albedo of
    /// their surfaces, of at most 254 colours, and grey where they have none.
    Vox,
    /// OpenEXR with a part a slice along z, `z0000` and on: x to the right, y up, channel `voxel`, `uint`. With attributes
    /// also albedo and opacity, as `R`, `G`, `B`, `A`, `normal.X` and on, `area`, `emission.R` and on, 32-bit floats.
    Exr,
    /// glTF binary: the faces between set and other voxels, in world space, equal neighbours merged.
    Glb,
    /// A picture of slices along z from the left and the top, x to the right, y up. Where there are too many, as many
    /// of them as fit into 4096 pixels, evenly spread.
    Png,
}

impl VoxelFormat {
    /// All of them.
    pub const ALL: [Self; 8] =
        [Self::Npy, Self::PackedNpy, Self::SparseNpy, Self::Binvox, Self::Vox, Self::Exr, Self::Glb, Self::Png];

    /// How names of such files end.
    pub fn end(self) -> &'static str {
        match self {
            Self::Npy => ".npy",
            Self::PackedNpy => ".packed.npy",
            Self::SparseNpy => ".sparse.npy",
            Self::Binvox => ".binvox",
            Self::Vox => ".vox",
            Self::Exr => ".exr",
            Self::Glb => ".glb",
            Self::Png => ".png",
        }
    }

    /// Whether it can hold attributes.
    pub fn holds_attributes(self) -> bool {
        matches!(self, Self::Vox | Self::Exr | Self::SparseNpy)
    }

    /// Whether so many voxels can be written, with attributes or without: some formats unfold the whole grid.
    ///
    /// # Errors
    /// [`Error::Invalid`] that says what would do.
    pub fn check(self, path: &Path, size: [u32; 3], with_attributes: bool) -> Result<()> {
        if with_attributes && !self.holds_attributes() {
            let why = format!("a {} file holds no attributes; .vox, .exr and .sparse.npy do", self.end());
            return Err(Error::invalid(format!("{}", path.display()), why));
        }
        let each: u64 = match self {
            Self::Npy => 1,
            Self::Exr => 4 * (1 + if with_attributes { VALUES.len() as u64 } else { 0 }),
            _ => 0,
        };
        let bytes = size.iter().fold(each, |bytes, &n| bytes.saturating_mul(n.into()));
        if bytes > MOST_UNFOLDED {
            let why = format!("{size:?} voxels take {} GiB in a {} file, which is too much", bytes >> 30, self.end());
            let other = if with_attributes { ".sparse.npy" } else { ".sparse.npy, .packed.npy" };
            let why = format!("{why}; {other} and .vox hold them in less");
            return Err(Error::invalid(format!("{}", path.display()), why));
        }
        Ok(())
    }

    /// The format that the name of a file asks for, in any case of letters.
    pub fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_string_lossy().to_lowercase();
        let asked = |format: &Self| name.ends_with(format.end());
        Self::ALL.into_iter().filter(asked).max_by_key(|format| format.end().len())
    }
}

/// Most bytes of a grid that is written as a whole.
const MOST_UNFOLDED: u64 = 4 << 30;

/// Writes voxels. The file appears whole or not at all, and the same voxels give the same bytes.
///
/// # Errors
/// [`Error::Io`] where the file cannot be written; [`Error::Invalid`] where the format cannot hold so much, as
/// [`VoxelFormat::check`] says of some.
pub fn write_voxels(path: &Path, voxels: &Voxels, format: VoxelFormat) -> Result<()> {
    write(path, voxels, None, format)
}

/// As [`write_voxels`], with what surfaces are like in them. For formats that [hold that](VoxelFormat::holds_attributes).
///
/// # Errors
/// As [`write_voxels`]; [`Error::Invalid`] for other formats.
pub fn write_voxel_attributes(path: &Path, attributes: &VoxelAttributes, format: VoxelFormat) -> Result<()> {
    write(path, attributes.voxels(), Some(attributes), format)
}

fn write(path: &Path, voxels: &Voxels, attributes: Option<&VoxelAttributes>, format: VoxelFormat) -> Result<()> {
    format.check(path, voxels.grid().size(), attributes.is_some())?;
    let [width, height, depth] = voxels.grid().size().map(|n| n as usize);
    match format {
        VoxelFormat::Npy => write_npy(path, &[depth, height, width], &voxels.bytes()),
        VoxelFormat::PackedNpy => write_npy(path, &[depth, height, width.div_ceil(8)], &packed(voxels)),
        VoxelFormat::SparseNpy => sparse::write(path, voxels, attributes),
        VoxelFormat::Binvox => binvox::write(path, voxels),
        VoxelFormat::Vox => magica::write(path, voxels, attributes),
        VoxelFormat::Exr => write_exr(path, &parts(voxels, attributes), &ExrOptions { compression: Compression::Rle }),
        VoxelFormat::Glb => glb::write(path, voxels),
        VoxelFormat::Png => slices::write(path, voxels),
    }
}

/// Eight voxels of a row a byte.
fn packed(voxels: &Voxels) -> Vec<u8> {
    let [width, height, depth] = voxels.grid().size().map(|n| n as usize);
    let mut bytes = Vec::with_capacity(width.div_ceil(8) * height * depth);
    for slab in voxels.slabs([0, 1, 2]) {
        for row in slab.rows() {
            bytes.extend(row.iter().flat_map(|word| word.to_le_bytes()).take(width.div_ceil(8)));
        }
    }
    bytes
}

/// A part a slice.
fn parts(voxels: &Voxels, attributes: Option<&VoxelAttributes>) -> Capture {
    let grid = voxels.grid();
    let [width, height, depth] = grid.size();
    let part = |z: u32| {
        let rows = || (0..height).rev().flat_map(|y| (0..width).map(move |x| [x, y, z]));
        let samples = rows().map(|voxel| u32::from(voxels.get(voxel))).collect();
        let mut channels = vec![Channel::new("voxel", Samples::U32(samples))];
        if let Some(attributes) = attributes {
            let value = |which: usize, voxel| attributes.get(voxel).map_or(0.0, |own| values(own)[which]);
            let channel = |(which, name): (usize, &&str)| {
                Channel::new(*name, Samples::F32(rows().map(|voxel| value(which, voxel)).collect()))
            };
            channels.extend(VALUES.iter().enumerate().map(channel));
        }
        Part { name: format!("z{z:04}"), size: [width, height], channels, ..Part::default() }
    };
    let mut capture = Capture { parts: (0..depth).map(part).collect(), ..Capture::default() };
    capture.metadata.add("shadowgraph/voxelGridMin", Value::Vec3(grid.min()));
    capture.metadata.add("shadowgraph/voxelEdge", Value::F32(grid.edge()));
    capture
}

/// Channels of a voxel's attributes.
const VALUES: [&str; 11] =
    ["R", "G", "B", "A", "normal.X", "normal.Y", "normal.Z", "area", "emission.R", "emission.G", "emission.B"];

fn values(own: &Attribute) -> [f32; VALUES.len()] {
    let (albedo, normal, emission) = (own.albedo, own.normal, own.emission);
    [
        albedo.x,
        albedo.y,
        albedo.z,
        own.opacity,
        normal.x,
        normal.y,
        normal.z,
        own.area,
        emission.x,
        emission.y,
        emission.z,
    ]
}

/// What is wrong with voxels for a format.
fn too_many(path: &Path, why: String) -> Error {
    Error::invalid(format!("{}", path.display()), why)
}

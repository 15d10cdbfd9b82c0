//! Set voxels alone, a record each, as a structured NumPy array: what a whole grid would be too large for.

use std::io::Write;
use std::path::Path;

use super::super::npy::header;
use super::super::write_atomically;
use super::values;
use crate::Result;
use crate::techniques::voxel::Voxels;
use crate::techniques::voxel::attributes::VoxelAttributes;

const VOXEL: &str = "('voxel', '<u2', (3,))";
const ATTRIBUTES: &str = "('albedo', '<f4', (3,)), ('opacity', '<f4'), ('normal', '<f4', (3,)), ('area', '<f4'), \
    ('emission', '<f4', (3,))";

pub(super) fn write(path: &Path, voxels: &Voxels, attributes: Option<&VoxelAttributes>) -> Result<()> {
    let fields = if attributes.is_some() { format!("[{VOXEL}, {ATTRIBUTES}]") } else { format!("[{VOXEL}]") };
    let header = header(&fields, &[voxels.count() as usize]);
    write_atomically(path, |file| {
        file.write_all(&header)?;
        for voxel in voxels.set() {
            voxel.iter().try_for_each(|&i| file.write_all(&(i as u16).to_le_bytes()))?;
            let own = attributes.and_then(|attributes| attributes.get(voxel)).map(values);
            own.iter().flatten().try_for_each(|value| file.write_all(&value.to_le_bytes()))?;
        }
        Ok(())
    })
}

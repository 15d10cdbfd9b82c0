//! glTF 2.0 binary: the boundary of the set voxels. Faces of one plane and side are merged into rectangles, greedily: a
//! run along a row grows over the rows behind it for as long as they have all of its faces.

use std::io::Write;
use std::path::Path;

use glam::Vec3;
use rustc_hash::FxHashMap;
use serde_json::json;

use super::super::write_atomically;
use super::too_many;
use crate::techniques::voxel::{Grid, Voxels};
use crate::{Error, Result};

pub(super) fn write(path: &Path, voxels: &Voxels) -> Result<()> {
    let mesh = Mesh::around(voxels);
    let bytes = 12 * mesh.corners.len() as u64 + 4 * mesh.indices.len() as u64;
    // Lengths in the file are of 32 bits.
    if bytes > u64::from(u32::MAX) - (1 << 20) {
        let why = format!("its mesh of {bytes} bytes is more than a .glb file holds; take fewer voxels");
        return Err(too_many(path, why));
    }
    let json = serde_json::to_vec(&mesh.document(voxels.grid())).map_err(|e| Error::io("write", path, e.into()))?;
    let spaces = vec![b' '; json.len().next_multiple_of(4) - json.len()];
    let lengths = [json.len() as u32 + spaces.len() as u32, bytes as u32];
    let all = 12 + 8 + lengths[0] + if bytes > 0 { 8 + lengths[1] } else { 0 };
    write_atomically(path, |file| {
        let words = |values: &[u32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
        file.write_all(&[&b"glTF"[..], &words(&[2, all, lengths[0]]), b"JSON", &json, &spaces].concat())?;
        if bytes > 0 {
            file.write_all(&[&words(&[lengths[1]])[..], b"BIN\0"].concat())?;
        }
        for corner in &mesh.corners {
            let place = place(voxels.grid(), *corner).to_array();
            file.write_all(&place.map(f32::to_le_bytes).concat())?;
        }
        mesh.indices.iter().try_for_each(|index| file.write_all(&index.to_le_bytes()))
    })
}

/// Rectangles as triangles, counterclockwise from outside.
#[derive(Default)]
struct Mesh {
    /// Corners of voxels, from the grid's lower corner.
    corners: Vec<[u32; 3]>,
    indices: Vec<u32>,
    known: FxHashMap<[u32; 3], u32>,
}

impl Mesh {
    fn around(voxels: &Voxels) -> Self {
        let mut mesh = Self::default();
        for axis in 0..3 {
            let order = [(axis + 1) % 3, (axis + 2) % 3, axis];
            let [width, height, _] = order.map(|axis| voxels.grid().size()[axis] as usize);
            // Outside of the grid nothing is set.
            let none = vec![0; width.div_ceil(64) * height];
            let mut before = none.clone();
            let mut plane = 0;
            let mut next = |behind: &[u64]| {
                mesh.plane(order, [width, height], plane, [behind, &before], false);
                mesh.plane(order, [width, height], plane, [&before, behind], true);
                before.copy_from_slice(behind);
                plane += 1;
            };
            voxels.slabs(order).for_each(|slab| slab.slices().for_each(&mut next));
            next(&none);
        }
        mesh
    }

    /// Faces in the plane before the voxels of an index: of voxels on the inner side of it, where those on the outer side are
    /// not set. `order`: axes along rows, from row to row, and from plane to plane.
    fn plane(
        &mut self,
        [across, along, _]: [usize; 3],
        [width, height]: [usize; 2],
        plane: u32,
        [inner, outer]: [&[u64]; 2],
        outward: bool,
    ) {
        let words: Vec<u64> = inner.iter().zip(outer).map(|(inner, outer)| inner & !outer).collect();
        if words.iter().all(|&word| word == 0) {
            return;
        }
        let row = |v: usize| &words[v * width.div_ceil(64)..];
        let at = (0..height).flat_map(|v| (0..width).map(move |u| (u, v)));
        let mut faces: Vec<bool> = at.map(|(u, v)| row(v)[u / 64] >> (u % 64) & 1 == 1).collect();
        for v in 0..height {
            let mut u = 0;
            while u < width {
                let length = faces[v * width + u..(v + 1) * width].iter().take_while(|&&face| face).count();
                if length == 0 {
                    u += 1;
                    continue;
                }
                let row = |v: usize| v * width + u..v * width + u + length;
                let rows = (v..height).take_while(|&v| faces[row(v)].iter().all(|&face| face)).count();
                (v..v + rows).for_each(|v| faces[row(v)].fill(false));
                let corners = [[u, v], [u + length, v], [u + length, v + rows], [u, v + rows]].map(|[u, v]| {
                    let mut corner = [plane; 3];
                    (corner[across], corner[along]) = (u as u32, v as u32);
                    corner
                });
                self.rectangle(corners, outward);
                u += length;
            }
        }
    }

    fn rectangle(&mut self, corners: [[u32; 3]; 4], outward: bool) {
        let [a, b, c, d] = corners.map(|corner| {
            *self.known.entry(corner).or_insert_with(|| {
                self.corners.push(corner);
                self.corners.len() as u32 - 1
            })
        });
        self.indices.extend(if outward { [a, b, c, a, c, d] } else { [a, c, b, a, d, c] });
    }

    /// The file's JSON.
    fn document(&self, grid: &Grid) -> serde_json::Value {
        let asset = json!({ "version": "2.0", "generator": concat!("shadowgraph ", env!("CARGO_PKG_VERSION")) });
        let scenes = json!([{ "nodes": [0] }]);
        // Meshes and buffers of nothing are not allowed.
        if self.corners.is_empty() {
            return json!({ "asset": asset, "scene": 0, "scenes": scenes, "nodes": [{ "name": "voxels" }] });
        }
        let places = self.corners.iter().map(|corner| place(grid, *corner));
        let (least, most) = places.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
        let split = 12 * self.corners.len();
        json!({
            "asset": asset,
            "scene": 0,
            "scenes": scenes,
            "nodes": [{ "name": "voxels", "mesh": 0 }],
            "meshes": [{ "name": "voxels", "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
            "accessors": [
                { "bufferView": 0, "componentType": 5126, "count": self.corners.len(), "type": "VEC3",
                  "min": least.to_array(), "max": most.to_array() },
                { "bufferView": 1, "componentType": 5125, "count": self.indices.len(), "type": "SCALAR" },
            ],
            "bufferViews": [
                { "buffer": 0, "byteLength": split, "target": 34962 },
                { "buffer": 0, "byteOffset": split, "byteLength": 4 * self.indices.len(), "target": 34963 },
            ],
            "buffers": [{ "byteLength": split + 4 * self.indices.len() }],
        })
    }
}

/// World space, metres.
fn place(grid: &Grid, corner: [u32; 3]) -> Vec3 {
    grid.min() + Vec3::from(corner.map(|n| n as f32)) * grid.edge()
}

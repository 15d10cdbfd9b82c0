//! Files of voxels, read back by what the formats' definitions say.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use glam::{DVec3, Vec3};
use shadowgraph::capture::{VoxelFormat, write_voxels};
use shadowgraph::scene::Scene;
use shadowgraph::techniques::voxel::{Grid, Voxels};
use shadowgraph_tests::exr_file;
use shadowgraph_tests::twin::voxel::volume;

/// A ball with a hole along z, a voxel apart from it, and a bar, in a grid of three different sizes.
fn solid() -> Voxels {
    let grid = Grid::new(Vec3::new(-1.0, 2.0, 0.5), 0.25, [300, 13, 21]).unwrap();
    let ball = |[x, y, z]: [u32; 3]| {
        let from = [x as i32 - 10, y as i32 - 6, z as i32 - 10];
        let [x, y, z] = from.map(|c| c * c);
        x + y + z < 40 && x + y > 2
    };
    let bar = |[x, y, z]: [u32; 3]| x >= 20 && [1, 2].contains(&y) && z == 20;
    Voxels::from_fn(&grid, |voxel| ball(voxel) || bar(voxel) || voxel == [0, 12, 0])
}

fn written(voxels: &Voxels, name: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    write_voxels(&path, voxels, VoxelFormat::of(&path).unwrap()).unwrap();
    fs::read(&path).unwrap()
}

/// Those set, in the order x, y, z.
fn set(voxels: &Voxels) -> BTreeSet<[u32; 3]> {
    voxels.set().collect()
}

#[test]
fn names_ask_for_formats() {
    let of = |name: &str| VoxelFormat::of(Path::new(name));
    assert_eq!(of("a/b.NPY"), Some(VoxelFormat::Npy));
    assert_eq!(of("b.packed.npy"), Some(VoxelFormat::PackedNpy));
    assert_eq!((of("b.obj"), of("npy"), of("..")), (None, None, None));
    for format in VoxelFormat::ALL {
        assert_eq!(of(&format!("b{}", format.end())), Some(format));
    }
}

#[test]
fn packed_arrays_hold_the_bytes_bits() {
    let voxels = solid();
    let (bytes, packed) = (written(&voxels, "v.npy"), written(&voxels, "v.packed.npy"));
    let header = |file: &[u8]| String::from_utf8_lossy(&file[..128]).into_owned();
    assert!(header(&bytes).contains("(21, 13, 300)") && header(&packed).contains("(21, 13, 38)"));
    let (bytes, packed) = (&bytes[128..], &packed[128..]);
    assert_eq!(bytes, voxels.bytes());
    let unpacked: Vec<u8> = packed.chunks(38).flat_map(|row| (0..300).map(|x| row[x / 8] >> (x % 8) & 1)).collect();
    assert_eq!(unpacked, bytes);
    // What pads a row is 0.
    assert!(packed.chunks(38).all(|row| row[37] >> 4 == 0));
}

#[test]
fn binvox_holds_runs_along_y() {
    let (voxels, file) = (solid(), written(&solid(), "v.binvox"));
    let end = file.windows(5).position(|five| five == b"data\n").unwrap() + 5;
    let header = String::from_utf8(file[..end].to_vec()).unwrap();
    assert_eq!(header, "#binvox 1\ndim 300 21 13\ntranslate -1 2 0.5\nscale 75\ndata\n");
    let runs = file[end..].as_chunks::<2>().0;
    let values: Vec<u8> = runs.iter().flat_map(|&[value, count]| vec![value; count.into()]).collect();
    assert_eq!(values.len(), 300 * 13 * 21);
    let found = (0..values.len()).filter(|&index| values[index] == 1);
    let places = found.map(|index| [index / (13 * 21), index % 13, index / 13 % 21].map(|n| n as u32));
    assert_eq!(places.collect::<BTreeSet<_>>(), set(&voxels));
}

/// Chunks of a `.vox` file behind its main one: names and contents.
fn chunks(file: &[u8]) -> Vec<(String, Vec<u8>)> {
    assert_eq!(&file[..16], b"VOX \x96\0\0\0MAIN\0\0\0\0");
    assert_eq!(word(file, 16) as usize, file.len() - 20);
    let (mut at, mut chunks) = (20, Vec::new());
    while at < file.len() {
        let length = word(file, at + 4) as usize;
        assert_eq!(word(file, at + 8), 0);
        let name = String::from_utf8(file[at..at + 4].to_vec()).unwrap();
        chunks.push((name, file[at + 12..at + 12 + length].to_vec()));
        at += 12 + length;
    }
    chunks
}

fn word(bytes: &[u8], at: usize) -> i32 {
    i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

#[test]
fn magica_voxel_models_stand_where_their_nodes_say() {
    let voxels = solid();
    let chunks = chunks(&written(&voxels, "v.vox"));
    let named = |name: &str| -> Vec<&[u8]> {
        chunks.iter().filter(|chunk| chunk.0 == name).map(|chunk| &chunk.1[..]).collect()
    };
    let (sizes, models) = (named("SIZE"), named("XYZI"));
    assert_eq!((sizes.len(), models.len(), named("RGBA")[0].len()), (2, 2, 1024));
    // The scene's own node has no place.
    let places: Vec<Vec<i32>> = named("nTRN")[1..]
        .iter()
        .map(|node| {
            let count = word(node, 34) as usize;
            assert_eq!((&node[32..34], node.len()), (&b"_t"[..], 38 + count));
            let text = String::from_utf8(node[38..].to_vec()).unwrap();
            text.split(' ').map(|n| n.parse().unwrap()).collect()
        })
        .collect();
    let mut found = BTreeSet::new();
    for ((size, model), place) in sizes.iter().zip(models).zip(places) {
        assert_eq!(word(model, 0) as usize, (model.len() - 4) / 4);
        for voxel in model[4..].as_chunks::<4>().0 {
            // A model's middle is at the place.
            let at = |axis: usize| i32::from(voxel[axis]) - word(size, 4 * axis) / 2 + place[axis];
            assert!((0..3).all(|axis| i32::from(voxel[axis]) < word(size, 4 * axis)) && voxel[3] == 1);
            found.insert([at(0), at(2), 20 - at(1)].map(|n| n as u32));
        }
    }
    assert_eq!(found, set(&voxels));
}

#[test]
fn every_slice_is_a_part() {
    let folder = tempfile::tempdir().unwrap();
    let (path, voxels) = (folder.path().join("v.exr"), solid());
    write_voxels(&path, &voxels, VoxelFormat::Exr).unwrap();
    let image = exr_file::image(&path);
    let mut found = BTreeSet::new();
    for (z, layer) in image.layer_data.iter().enumerate() {
        assert_eq!(layer.attributes.layer_name.as_ref().unwrap().to_string(), format!("z{z:04}"));
        let channel = &layer.channel_data.list[0];
        assert_eq!(channel.name.to_string(), "voxel");
        for (index, value) in channel.sample_data.values_as_f32().enumerate().filter(|(_, value)| *value != 0.0) {
            assert_eq!(value, 1.0);
            found.insert([index % 300, 12 - index / 300, z].map(|n| n as u32));
        }
    }
    assert_eq!((image.layer_data.len(), found), (21, set(&voxels)));
}

/// The volume that a mesh encloses is its voxels', and its triangles look outwards; the area is their faces'.
#[test]
fn meshes_enclose_the_voxels() {
    let folder = tempfile::tempdir().unwrap();
    let (path, voxels) = (folder.path().join("v.glb"), solid());
    write_voxels(&path, &voxels, VoxelFormat::Glb).unwrap();
    let scene = Scene::load(&path).unwrap();
    let primitive = &scene.meshes[0].primitives[0];
    let corner = |&index: &u32| primitive.positions[index as usize].as_dvec3();
    let triangles: Vec<[DVec3; 3]> =
        primitive.indices.as_chunks::<3>().0.iter().map(|triangle| triangle.each_ref().map(corner)).collect();
    let edge = f64::from(voxels.grid().edge());
    assert!((volume(&triangles) - voxels.count() as f64 * edge.powi(3)).abs() < 1e-6);
    let all = set(&voxels);
    let beside = |voxel: &[u32; 3], axis: usize, step: u32| {
        let mut other = *voxel;
        other[axis] = other[axis].wrapping_add(step);
        all.contains(&other)
    };
    let faces: usize = all
        .iter()
        .map(|voxel| (0..6).filter(|face| !beside(voxel, face / 2, if face % 2 == 0 { 1 } else { u32::MAX })).count())
        .sum();
    let area: f64 = triangles.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length()).sum();
    assert!((area - faces as f64 * edge * edge).abs() < 1e-6);
    // Merged: the bar alone has over a thousand faces.
    assert!(triangles.len() * 2 < faces, "{} triangles for {faces} faces", triangles.len());
    let min = voxels.grid().min().as_dvec3();
    let inside = triangles.iter().flatten().all(|corner| (((*corner - min) / edge).fract()).abs().max_element() < 1e-6);
    assert!(inside, "a corner is no voxel's");
}

#[test]
fn slices_go_from_the_left_and_the_top() {
    let voxels = Voxels::from_fn(&Grid::new(Vec3::ZERO, 1.0, [4, 3, 5]).unwrap(), |[x, y, z]| x == z && y == 0);
    let picture = image::load_from_memory(&written(&voxels, "v.png")).unwrap().into_luma8();
    // Three slices across, two down.
    assert_eq!(picture.dimensions(), (3 * 5 + 1, 2 * 4 + 1));
    let bright: Vec<[u32; 2]> = picture.enumerate_pixels().filter(|p| p.2.0[0] > 200).map(|p| [p.0, p.1]).collect();
    assert_eq!(bright, [[1, 3], [7, 3], [13, 3], [4, 7]]);
    // Long grids leave slices out, and no picture grows beyond what programs open.
    let long = Voxels::from_fn(&Grid::new(Vec3::ZERO, 1.0, [1000, 1000, 40]).unwrap(), |[_, _, z]| z == 1 || z == 38);
    let picture = image::load_from_memory(&written(&long, "v.png")).unwrap().into_luma8();
    assert_eq!(picture.dimensions(), (4 * 1001 + 1, 4 * 1001 + 1));
    assert_eq!([[1, 1], [3004, 3004]].map(|[x, y]| picture.get_pixel(x, y).0[0]), [235, 235]);
}

#[test]
fn sparse_arrays_are_records_of_set_voxels() {
    let voxels = solid();
    let file = written(&voxels, "v.sparse.npy");
    let length = usize::from(u16::from_le_bytes([file[8], file[9]]));
    let (header, records) = file[10..].split_at(length);
    let header = String::from_utf8_lossy(header).into_owned();
    assert!(
        header.contains("[('voxel', '<u2', (3,))]") && header.contains(&format!("({},)", voxels.count())),
        "{header}"
    );
    let read = |record: &[u8; 6]| [0, 2, 4].map(|i| u32::from(u16::from_le_bytes([record[i], record[i + 1]])));
    let found: Vec<_> = records.as_chunks().0.iter().map(read).collect();
    assert!(records.len() % 6 == 0 && found.iter().copied().eq(voxels.set()) && found.len() > 100);
}

#[test]
fn what_would_unfold_to_too_much_is_refused() {
    let check = |format: VoxelFormat, n: u32, attributes| format.check(Path::new("v"), [n; 3], attributes);
    assert!(check(VoxelFormat::Exr, 256, true).is_ok() && check(VoxelFormat::Npy, 1024, false).is_ok());
    for (format, n, attributes) in [(VoxelFormat::Exr, 1024, true), (VoxelFormat::Npy, 2048, false)] {
        let error = check(format, n, attributes).unwrap_err().to_string();
        assert!(error.contains("GiB") && error.contains(".sparse.npy"), "{error}");
    }
    assert!(check(VoxelFormat::SparseNpy, 2048, true).is_ok() && check(VoxelFormat::Npy, 8, true).is_err());
}

#[test]
fn grids_of_nothing_are_files_too() {
    let folder = tempfile::tempdir().unwrap();
    let empty = Voxels::from_fn(&Grid::new(Vec3::ZERO, 1.0, [3, 3, 3]).unwrap(), |_| false);
    for format in VoxelFormat::ALL {
        let path = folder.path().join(format!("v{}", format.end()));
        write_voxels(&path, &empty, format).unwrap();
        assert!(fs::metadata(&path).unwrap().len() > 0);
    }
    Scene::load(folder.path().join("v.glb")).unwrap();
}

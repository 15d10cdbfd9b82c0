//! Every file of the scene folder against the table in its `INDEX.md`.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{collections::BTreeMap, path::PathBuf};

use glam::Vec3;
use shadowgraph::scene::{AlphaMode, Camera, Mesh, Scene};

/// Folder of the test scenes: `SHADOWGRAPH_SCENES`, or `../shared/scenes` beside the checkout.
fn folder() -> Option<PathBuf> {
    if let Some(folder) = std::env::var_os("SHADOWGRAPH_SCENES") {
        return Some(folder.into());
    }
    let checkout = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap();
    let found = checkout.ancestors().skip(1).map(|up| up.join("shared/scenes")).find(|folder| folder.is_dir());
    if found.is_none() {
        eprintln!("skipped: scene folder (SHADOWGRAPH_SCENES is not set, ../shared/scenes is not there)");
    }
    found
}

/// A line of the table.
struct Row {
    file: String,
    stored: u64,
    drawn: u64,
    /// Materials by alpha mode; empty where the file has none.
    materials: BTreeMap<String, usize>,
    required: Vec<String>,
    cameras: usize,
    lights: usize,
    /// min x, y, z, max x, y, z, as printed.
    bounds: Vec<String>,
}

fn rows() -> Vec<(PathBuf, Row)> {
    let Some(folder) = folder() else { return Vec::new() };
    let index = std::fs::read_to_string(folder.join("INDEX.md")).unwrap();
    let rows = index.lines().filter(|line| line.starts_with("| ") && line.contains(".gl")).map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let file = cells[2].trim_matches('`').to_owned();
        let number = |text: &str| text.chars().filter(char::is_ascii_digit).collect::<String>().parse::<u64>().unwrap();
        let (stored, drawn) = match cells[3].split_once('(') {
            Some((stored, drawn)) => (number(stored), number(drawn)),
            None => (number(cells[3]), number(cells[3])),
        };
        let count = |what: &str| {
            let item = cells[7].split(", ").find_map(|item| item.strip_suffix(what));
            item.map_or(0, |item| item.trim().parse().unwrap())
        };
        let materials = cells[5].split(", ").filter(|cell| !cell.starts_with('('));
        let row = Row {
            stored,
            drawn,
            materials: materials
                .map(|cell| cell.split_once(' ').unwrap())
                .map(|(mode, count)| (mode.to_owned(), count.parse().unwrap()))
                .collect(),
            required: cells[6].split(", ").filter_map(|e| e.strip_suffix('*')).map(str::to_owned).collect(),
            cameras: count(" cam"),
            lights: count(" light defs"),
            bounds: cells[8].split(" .. ").flat_map(|corner| corner.split('/')).map(str::to_owned).collect(),
            file,
        };
        (folder.join(&row.file), row)
    });
    let rows: Vec<_> = rows.collect();
    assert!(rows.len() >= 60, "INDEX.md has only {} files", rows.len());
    rows
}

const SUPPORTED: [&str; 3] = ["KHR_mesh_quantization", "KHR_texture_transform", "KHR_materials_unlit"];

#[test]
fn every_file_loads_or_is_refused_as_the_index_says() {
    let mut wrong = Vec::new();
    for (path, row) in rows() {
        let refused: Vec<_> = row.required.iter().filter(|e| !SUPPORTED.contains(&e.as_str())).collect();
        match Scene::load(&path) {
            Ok(_) if !refused.is_empty() => wrong.push(format!("{}: loads in spite of {refused:?}", row.file)),
            Ok(scene) => wrong.extend(differences(&scene, &row)),
            Err(error) => {
                let text = error.to_string();
                let named = refused.iter().all(|e| text.contains(e.as_str())) && text.contains("supported are");
                if refused.is_empty() || !named {
                    wrong.push(text);
                }
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

fn differences(scene: &Scene, row: &Row) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut check = |what: &str, found: String, expected: String| {
        if found != expected {
            wrong.push(format!("{}: {what}: found {found}, expected {expected}", row.file));
        }
    };
    let stored: u64 = scene.meshes.iter().map(Mesh::triangle_count).sum();
    check("triangles stored", stored.to_string(), row.stored.to_string());
    check("triangles drawn", scene.triangle_count().to_string(), row.drawn.to_string());

    let mut materials = BTreeMap::new();
    // The last may be the default material of primitives that have none.
    for material in scene.materials.iter().filter(|material| material.name != "default") {
        let mode = match material.alpha_mode {
            AlphaMode::Opaque => "OPAQUE",
            AlphaMode::Mask { .. } => "MASK",
            AlphaMode::Blend => "BLEND",
            AlphaMode::Premultiplied | AlphaMode::Add => "none of glTF",
        };
        *materials.entry(mode.to_owned()).or_insert(0) += 1;
    }
    check("materials", format!("{materials:?}"), format!("{:?}", row.materials));
    check("cameras", scene.cameras.len().to_string(), row.cameras.to_string());
    // The index counts definitions, of which several nodes may make lights.
    check("has lights", (scene.lights.len() >= row.lights).to_string(), true.to_string());

    let bounds = scene.bounds().unwrap();
    // The index takes in points and lines, and leaves out instancing.
    let expected: Vec<String> = match row.file.as_str() {
        "MeshPrimitiveModes/MeshPrimitiveModes.gltf" => {
            ["-2.866", "-4", "0", "2.866", "-2", "0"].map(str::to_owned).to_vec()
        }
        "SimpleInstancing/SimpleInstancing.gltf" => {
            ["-1.667", "-1.667", "-1.667", "12.73", "12.73", "12.73"].map(str::to_owned).to_vec()
        }
        _ => row.bounds.clone(),
    };
    let found = [bounds.min, bounds.max].map(|corner| corner.to_array()).concat();
    for (found, printed) in found.iter().zip(&expected) {
        let value: f32 = printed.parse().unwrap();
        // Half of the last of four digits.
        let digit = 10f32.powf(value.abs().max(1e-12).log10().floor() - 3.0);
        // A coordinate that cancels to nearly nothing is exact to the rounding of the others only.
        let rounding = bounds.size().max_element() * 1e-7;
        if (found - value).abs() > (0.501 * digit).max(rounding) {
            check("bounds", format!("{found:?}"), format!("{expected:?}"));
        }
    }
    wrong
}

#[test]
fn lights_are_made_by_node() {
    let expected = [
        ("DungeonHall/DungeonHall.glb", 19),
        ("ShadowRoom/ShadowRoom.glb", 6),
        ("LightsPunctualLamp/LightsPunctualLamp.gltf", 5),
        ("LivingRoom/LivingRoom.gltf", 2),
        ("Pandora/Pandora.glb", 14),
    ];
    for (path, row) in rows() {
        let Some((_, count)) = expected.iter().find(|(file, _)| *file == row.file) else { continue };
        let scene = Scene::load(&path).unwrap();
        assert_eq!(scene.lights.len(), *count, "{}", row.file);
        let names: std::collections::HashSet<_> = scene.lights.iter().map(|light| &light.name).collect();
        assert_eq!(names.len(), *count, "{}", row.file);
        assert!(names.iter().all(|name| !name.contains('.')), "{names:?}");
    }
}

#[test]
fn attributes_keep_their_promises() {
    for (path, row) in rows() {
        let Ok(scene) = Scene::load(&path) else { continue };
        let mut names = std::collections::HashSet::new();
        assert!(scene.objects.iter().all(|object| names.insert(object.name.clone())), "{}: names", row.file);
        for primitive in scene.meshes.iter().flat_map(|mesh| &mesh.primitives) {
            let count = primitive.positions.len();
            let lengths = [primitive.normals.len(), primitive.tangents.len(), primitive.colors.len()];
            assert_eq!(lengths, [count; 3], "{}", row.file);
            assert_eq!([primitive.uvs[0].len(), primitive.uvs[1].len()], [count; 2], "{}", row.file);
            assert!(primitive.indices.iter().all(|&index| (index as usize) < count), "{}", row.file);
            assert_eq!(primitive.indices.len() % 3, 0, "{}", row.file);
            let unit = |v: Vec3| (v.length() - 1.0).abs() < 1e-5;
            assert!(primitive.normals.iter().all(|&normal| unit(normal)), "{}: normals", row.file);
            let mapped = scene.materials[primitive.material].normal_texture.is_some();
            for tangent in &primitive.tangents {
                let fits = if mapped { unit(tangent.truncate()) && tangent.w.abs() == 1.0 } else { tangent.w == 0.0 };
                assert!(fits, "{}: tangent {tangent}", row.file);
            }
        }
        for slot in scene.materials.iter().filter_map(|material| material.base_color_texture) {
            let texture = &scene.textures[slot.texture];
            assert_eq!(texture.pixels.len(), (texture.size[0] * texture.size[1] * 4) as usize, "{}", row.file);
        }
        for camera in &scene.cameras {
            let Camera { world_from_view: m, .. } = camera;
            assert!((m.determinant() - 1.0).abs() < 1e-5, "{}: camera {m}", row.file);
        }
    }
}

/// One square stored fourteen ways: all draw the same triangles with the same attributes.
#[test]
fn the_copies_of_the_accessor_zoo_are_equal() {
    let Some((path, _)) = rows().into_iter().find(|(_, row)| row.file.starts_with("AccessorZoo")) else { return };
    let scene = Scene::load(path).unwrap();
    assert_eq!(scene.objects.len(), 14);
    // Corners of the triangles around their middle, apart from how they are indexed and where they begin.
    let corners = |object: &shadowgraph::scene::Object| -> Vec<[i32; 9]> {
        let mut corners = Vec::new();
        let mesh = &scene.meshes[object.mesh];
        let middle = mesh.bounds().unwrap().center();
        for primitive in &mesh.primitives {
            for &index in &primitive.indices {
                let i = index as usize;
                let p = primitive.positions[i] - middle;
                let (uv, color) = (primitive.uvs[0][i], primitive.colors[i]);
                let values = [p.x, p.y, p.z, uv.x, uv.y, color.x, color.y, color.z, color.w];
                // The coarsest storage has steps of 1/255; the values stored are exact in it.
                corners.push(values.map(|v| (v * 1000.0).round() as i32));
            }
        }
        corners.sort_unstable();
        corners.dedup();
        corners
    };
    let first = corners(&scene.objects[0]);
    assert_eq!(first.len(), 4);
    for object in &scene.objects[1..] {
        assert_eq!(corners(object), first, "{}", object.name);
        let normal = |primitive: &shadowgraph::scene::Primitive| {
            primitive.indices.as_chunks::<3>().0.iter().all(|t| {
                let [a, b, c] = t.map(|i| primitive.positions[i as usize]);
                (b - a).cross(c - a).z > 0.0
            })
        };
        assert!(scene.meshes[object.mesh].primitives.iter().all(normal), "{} is turned away", object.name);
    }
}

#[test]
fn avocado_is_the_same_quantised() {
    let load = |file: &str| {
        let (path, _) = rows().into_iter().find(|(_, row)| row.file == file)?;
        Some(Scene::load(path).unwrap())
    };
    let (Some(float), Some(quantised)) =
        (load("Avocado/glTF/Avocado.gltf"), load("Avocado/glTF-Quantized/Avocado.gltf"))
    else {
        return;
    };
    // Corners in world space with their texture coordinates, KHR_texture_transform applied. The files order their
    // triangles differently, so that each corner looks for its match.
    let corners = |scene: &Scene| -> Vec<(Vec3, glam::Vec2)> {
        let object = &scene.objects[0];
        let primitive = &scene.meshes[object.mesh].primitives[0];
        let slot = scene.materials[primitive.material].base_color_texture.unwrap();
        let corner = |&i: &u32| {
            let position = object.world_from_object.transform_point3(primitive.positions[i as usize]);
            (position, (slot.transform * primitive.uvs[slot.uv_set][i as usize].extend(1.0)).truncate())
        };
        primitive.indices.iter().map(corner).collect()
    };
    let float = corners(&float);
    let quantised = corners(&quantised);
    assert_eq!(float.len(), 682 * 3);
    for (from, to) in [(&float, &quantised), (&quantised, &float)] {
        for (position, uv) in from {
            let near = to.iter().filter(|(other, _)| other.distance(*position) < 1e-5);
            let uv_distance = near.map(|(_, other)| other.distance(*uv)).fold(f32::INFINITY, f32::min);
            assert!(uv_distance < 5e-4, "{position} {uv}: {uv_distance}");
        }
    }
}

/// Tangents that MikkTSpace gives agree with those that an exporter stored.
#[test]
fn generated_tangents_agree_with_stored_ones() {
    let Some((path, _)) = rows().into_iter().find(|(_, row)| row.file == "Avocado/glTF/Avocado.gltf") else { return };
    let stored = Scene::load(&path).unwrap();
    // The same file without its TANGENT attributes.
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(path.parent().unwrap()).unwrap() {
        let from = entry.unwrap().path();
        std::fs::write(folder.path().join(from.file_name().unwrap()), std::fs::read(&from).unwrap()).unwrap();
    }
    let copy = folder.path().join("Avocado.gltf");
    let text = std::fs::read_to_string(&copy).unwrap();
    assert!(text.contains("\"TANGENT\""));
    std::fs::write(&copy, text.replace("\"TANGENT\"", "\"_OTHER\"")).unwrap();
    let generated = Scene::load(&copy).unwrap();

    let tangents = |scene: &Scene| -> Vec<glam::Vec4> {
        let primitive = &scene.meshes[0].primitives[0];
        primitive.indices.iter().map(|&i| primitive.tangents[i as usize]).collect()
    };
    let (a, b) = (tangents(&stored), tangents(&generated));
    assert_eq!(a.len(), b.len());
    let agree = a.iter().zip(&b).filter(|(a, b)| a.truncate().dot(b.truncate()) > 0.95 && a.w == b.w).count();
    assert!(agree as f32 > 0.97 * a.len() as f32, "{agree} of {} agree", a.len());
}

/// The model shows the same part of a texture twice: by its coordinates, and by a turn, a scale and an offset.
#[test]
fn texture_transforms_turn_the_right_way() {
    let Some((path, _)) = rows().into_iter().find(|(_, row)| row.file.starts_with("TextureTransformMultiTest")) else {
        return;
    };
    let scene = Scene::load(path).unwrap();
    // Coordinates at the corners of a quad, by position.
    let corners = |name: &str| -> Vec<(Vec3, glam::Vec2)> {
        let object = scene.objects.iter().find(|object| object.name == name).unwrap();
        let primitive = &scene.meshes[object.mesh].primitives[0];
        let slot = scene.materials[primitive.material].base_color_texture.unwrap();
        let uvs = primitive.uvs[slot.uv_set].iter();
        let transformed = uvs.map(|uv| (slot.transform * uv.extend(1.0)).truncate());
        primitive.positions.iter().copied().zip(transformed).collect()
    };
    let sample = corners("BaseColorSample");
    for name in ["BaseColorUV0", "BaseColorUV1"] {
        let corners = corners(name);
        assert_eq!(corners.len(), 4);
        for (position, uv) in corners {
            let (_, expected) =
                sample.iter().min_by(|a, b| a.0.distance(position).total_cmp(&b.0.distance(position))).unwrap();
            assert!(uv.distance(*expected) < 0.01, "{name} at {position}: {uv}, expected {expected}");
        }
    }
}

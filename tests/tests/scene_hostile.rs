//! Broken and hostile glTF files: an error that names the place, never a panic, a hang or a huge allocation.
#![allow(clippy::unwrap_used, missing_docs)]

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use serde_json::{Value, json};
use shadowgraph::scene::Scene;

/// Positions of a triangle, its normals, texture coordinates, and indices (u16): 36 + 36 + 24 + 6 bytes.
fn triangle_bytes() -> Vec<u8> {
    let floats: [f32; 24] = [
        0., 0., 0., 1., 0., 0., 0., 1., 0., // positions
        0., 0., 1., 0., 0., 1., 0., 0., 1., // normals
        0., 1., 1., 1., 0., 0., // coordinates
    ];
    let mut bytes: Vec<u8> = floats.iter().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2].iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    bytes
        .chunks(3)
        .flat_map(|chunk| {
            let bits = chunk.iter().fold(0u32, |bits, &byte| bits << 8 | u32::from(byte)) << (8 * (3 - chunk.len()));
            (0..4).map(move |i| match i <= chunk.len() {
                true => char::from(DIGITS[(bits >> (18 - 6 * i) & 63) as usize]),
                false => '=',
            })
        })
        .collect()
}

fn data_uri(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", base64(bytes))
}

/// A file that loads: one triangle with everything that the tests below break.
fn good() -> Value {
    let accessor = |offset: u32, component: u32, kind: &str| json!({ "bufferView": 0, "byteOffset": offset, "componentType": component, "count": 3, "type": kind });
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [
            { "mesh": 0, "name": "thing" },
            { "camera": 0, "name": "eye" },
            { "name": "sun", "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "name": "child" },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "directional", "name": "sun" }] } },
        "materials": [{ "name": "paint" }],
        "meshes": [{ "name": "tri", "primitives": [{
            "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 }, "indices": 3, "material": 0,
        }] }],
        "accessors": [
            accessor(0, 5126, "VEC3"), accessor(36, 5126, "VEC3"), accessor(72, 5126, "VEC2"), accessor(96, 5123, "SCALAR"),
        ],
        "bufferViews": [{ "buffer": 0, "byteLength": 102 }],
        "buffers": [{ "byteLength": 102, "uri": data_uri(&triangle_bytes()) }],
    })
}

fn in_folder(name: &str, bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn load(file: &Value) -> Result<Scene, String> {
    let (_folder, path) = in_folder("file.gltf", file.to_string().as_bytes());
    Scene::load(path).map_err(|error| error.to_string())
}

/// Sets the value at a JSON pointer; objects on the way are made where they are missing, null removes.
fn set(file: &mut Value, pointer: &str, value: Value) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = file.pointer_mut(parent).unwrap_or_else(|| panic!("no {parent}"));
    match parent {
        Value::Array(items) if key == "-" => items.push(value),
        Value::Array(items) => items[key.parse::<usize>().unwrap()] = value,
        Value::Object(fields) if value.is_null() => drop(fields.remove(key)),
        other => other[key] = value,
    }
}

fn broken(changes: &[(&str, Value)]) -> Value {
    let mut file = good();
    changes.iter().for_each(|(pointer, value)| set(&mut file, pointer, value.clone()));
    file
}

#[test]
fn the_good_file_loads() {
    let scene = load(&good()).unwrap();
    assert_eq!((scene.triangle_count(), scene.cameras.len(), scene.lights.len()), (1, 1, 1));
    assert_eq!(scene.objects[0].name, "thing");
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn errors_name_the_place() {
    let far = json!(4_000_000_000u32);
    let huge = json!(18_446_744_073_709_551_615u64);
    let cases: Vec<(Vec<(&str, Value)>, &str)> = vec![
        // Document.
        (vec![("/asset/version", json!("1.0"))], "asset: glTF version \"1.0\"; only 2.0 is supported"),
        (vec![("/asset/minVersion", json!("2.1"))], "glTF version \"2.1\""),
        (vec![("/asset", Value::Null)], "missing field `asset`"),
        (
            vec![("/extensionsRequired", json!(["KHR_draco_mesh_compression"]))],
            "KHR_draco_mesh_compression; supported are",
        ),
        (vec![("/scene", json!(7))], "scene: is 7, but there are 1 scenes"),
        (vec![("/scenes/0/nodes/0", json!(99))], "node 99 is used, but there are 4"),
        (vec![("/scenes/0/nodes/0", json!(-1))], "JSON"),
        // Hierarchy.
        (vec![("/nodes/0/children", json!([0]))], "node 0 \"thing\": is reached twice"),
        (vec![("/nodes/0/children", json!([3])), ("/nodes/3/children", json!([0]))], "is reached twice"),
        (
            vec![("/nodes/0/children", json!([3])), ("/nodes/1/children", json!([3]))],
            "node 3 \"child\": is reached twice",
        ),
        (vec![("/nodes/0/scale", json!([1e39, 1, 1]))], "node 0 \"thing\": has a transform that is not finite"),
        (vec![("/nodes/0/matrix", json!([1e38, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3e38, 0, 0, 1]))], "out of the range"),
        (vec![("/nodes/0/mesh", json!(5))], "uses mesh 5, but there are 1"),
        (vec![("/nodes/1/camera", json!(3))], "node 1 \"eye\": uses camera 3, but there are 1"),
        (vec![("/nodes/1/scale", json!([0, 0, 0]))], "its camera has no direction"),
        (vec![("/nodes/0/skin", json!(2))], "a node uses skin 2, but there are 0"),
        (vec![("/nodes/2/extensions/KHR_lights_punctual/light", json!(9))], "uses light 9, but there are 1"),
        // Cameras and lights.
        (vec![("/cameras/0/perspective/yfov", json!(-1))], "camera 0: yfov -1"),
        (vec![("/cameras/0/perspective/znear", json!(0))], "znear 0"),
        (vec![("/cameras/0/type", json!("fisheye"))], "neither a perspective nor an orthographic"),
        (vec![("/extensions/KHR_lights_punctual/lights/0/intensity", json!(-5))], "light 0 \"sun\": its intensity -5"),
        (vec![("/extensions/KHR_lights_punctual/lights/0/color", json!([1, -1, 0]))], "its color"),
        (vec![("/extensions/KHR_lights_punctual/lights/0/type", json!("laser"))], "none of directional, point, spot"),
        (
            vec![(
                "/extensions/KHR_lights_punctual/lights/0",
                json!({ "type": "spot", "spot": { "outerConeAngle": 9 } }),
            )],
            "cone angles 0 and 9",
        ),
        // Meshes.
        (vec![("/meshes/0/primitives/0/material", json!(4))], "mesh 0 \"tri\", primitive 0: uses material 4"),
        (vec![("/meshes/0/primitives/0/mode", json!(44))], "primitive 0: has a mode that glTF does not know"),
        (
            vec![("/meshes/0/primitives/0/attributes/POSITION", json!(77))],
            "primitive 0: uses accessor 77, but there are 4",
        ),
        (vec![("/meshes/0/primitives/0/attributes/POSITION", json!(2))], "Vec2 is not allowed here: 3 components"),
        (vec![("/meshes/0/primitives/0/indices", json!(0))], "indices: Vec3 is not allowed here"),
        (vec![("/accessors/1/count", json!(2))], "NORMAL has 2 elements, POSITION 3"),
        // Accessors.
        (vec![("/accessors/0/bufferView", json!(6))], "accessor 0: uses bufferView 6, but there are 1"),
        (vec![("/accessors/0/byteOffset", json!(80))], "are not within its 102 bytes"),
        (vec![("/accessors/0/byteOffset", huge.clone())], "are not within its 102 bytes"),
        (vec![("/accessors/0/byteOffset", json!(-4))], "JSON"),
        (vec![("/accessors/0/count", far.clone())], "4000000000 elements of 12 bytes"),
        (vec![("/accessors/0/count", huge.clone())], "are not within its 102 bytes"),
        (vec![("/accessors/0/componentType", json!(5))], "a type or component type that glTF does not know"),
        (vec![("/accessors/0/type", json!("VEC9"))], "a type or component type that glTF does not know"),
        (vec![("/accessors/0/componentType", json!(5125))], "32-bit integers are not allowed here"),
        (vec![("/accessors/3/componentType", json!(5122))], "unsigned integers are needed"),
        (vec![("/bufferViews/0/byteStride", json!(0))], "do not fit a byteStride of 0"),
        (vec![("/bufferViews/0/byteStride", huge.clone())], "are not within its 102 bytes"),
        // Zeros without a buffer cost nothing to ask for.
        (
            vec![("/accessors/0", json!({ "componentType": 5126, "type": "VEC3", "count": far }))],
            "asks for 48000000000 bytes",
        ),
        (vec![("/accessors/0", json!({ "componentType": 5126, "type": "VEC3", "count": huge }))], "asks for"),
        // Buffers.
        (vec![("/bufferViews/0/byteLength", json!(1000))], "1000 bytes from byte 0 are not within a buffer of 102"),
        (vec![("/bufferViews/0/byteOffset", huge.clone())], "are not within a buffer of 102 bytes"),
        (vec![("/bufferViews/0/buffer", json!(3))], "bufferView 0: uses buffer 3, but there are 1"),
        (vec![("/buffers/0/byteLength", json!(5000))], "buffer 0: says 5000 bytes, but its data has 102"),
        (vec![("/buffers/0/byteLength", huge.clone())], "but its data has 102"),
        (vec![("/buffers/0/uri", Value::Null)], "buffer 0: has no data"),
        (vec![("/buffers/0/uri", json!("missing%20file.bin"))], "missing file.bin"),
        (vec![("/buffers/0/uri", json!("%ff%fe.bin"))], "not UTF-8"),
        (vec![("/buffers/0/uri", json!("http://example.org/a.bin"))], "neither a data URI nor a path"),
        (vec![("/buffers/0/uri", json!("."))], "not a plain file"),
        (vec![("/buffers/0/uri", json!("data:;base64,A*"))], "base64"),
        // Materials.
        (vec![("/materials/0/alphaMode", json!("GLOW"))], "material 0 \"paint\": alphaMode"),
        (vec![("/materials/0/emissiveFactor", json!([1e39, 0, 0]))], "a factor is not a finite number"),
        (vec![("/materials/0/normalTexture", json!({ "index": 0 }))], "normalTexture is texture 0, but there are 0"),
    ];
    let mut wrong = Vec::new();
    for (changes, expected) in cases {
        match load(&broken(&changes)) {
            Ok(_) => wrong.push(format!("{changes:?} loads")),
            Err(error) if !error.contains(expected) => wrong.push(format!("{changes:?}: {error:?} lacks {expected:?}")),
            Err(error) => assert!(error.contains("file.gltf"), "{error} does not name the file"),
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn broken_values_in_buffers_are_errors() {
    let with_bytes = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = triangle_bytes();
        change(&mut bytes);
        load(&broken(&[("/buffers/0/uri", json!(data_uri(&bytes)))]))
    };
    for value in [f32::NAN, f32::INFINITY] {
        let error = with_bytes(&|bytes| bytes[16..20].copy_from_slice(&value.to_le_bytes())).unwrap_err();
        assert!(error.contains("mesh 0 \"tri\", primitive 0: POSITION of vertex 1 is not finite"), "{error}");
    }
    let error = with_bytes(&|bytes| bytes[98] = 3).unwrap_err();
    assert!(error.contains("mesh 0 \"tri\", primitive 0: index 3 is out of range: there are 3 vertices"), "{error}");
    // A normal that has no direction is replaced by that of the triangle.
    let scene = with_bytes(&|bytes| bytes[36..48].fill(0)).unwrap();
    assert_eq!(scene.meshes[0].primitives[0].normals[0], glam::Vec3::Z);
    let scene = with_bytes(&|bytes| bytes[44..48].copy_from_slice(&f32::NAN.to_le_bytes())).unwrap();
    assert_eq!(scene.meshes[0].primitives[0].normals[0], glam::Vec3::Z);
}

#[test]
fn sparse_accessors_are_checked() {
    let sparse = |indices: Value, count: u64| json!({ "count": count, "indices": indices, "values": { "bufferView": 0, "byteOffset": 0 } });
    let at = |offset: u32| json!({ "bufferView": 0, "byteOffset": offset, "componentType": 5123 });
    // Index 0, 1 and 2 lie at byte 96: zeros become the triangle.
    let zeros = |sparse| json!({ "componentType": 5126, "type": "VEC3", "count": 3, "sparse": sparse });
    let scene = load(&broken(&[("/accessors/0", zeros(sparse(at(96), 3)))])).unwrap();
    assert_eq!(scene.bounds().unwrap().max, glam::Vec3::new(1.0, 1.0, 0.0));
    for (sparse, expected) in [
        (sparse(at(14), 1), "sparse: index 16256 is out of range: there are 3 elements"),
        (sparse(at(96), 4_000_000_000), "are not within its 102 bytes"),
        (sparse(at(4_000_000_000), 1), "are not within its 102 bytes"),
        (sparse(json!({ "bufferView": 8, "componentType": 5123 }), 1), "uses bufferView 8"),
        (sparse(json!({ "bufferView": 0, "componentType": 5126 }), 1), "component type that glTF does not know"),
    ] {
        let error = load(&broken(&[("/accessors/0", zeros(sparse))])).unwrap_err();
        assert!(error.contains(expected), "{error:?} lacks {expected:?}");
    }
}

#[test]
fn containers_are_checked() {
    let glb = |json: &[u8], binary: &[u8]| {
        let mut bytes = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        for (kind, data, filler) in [(b"JSON", json, b' '), (b"BIN\0", binary, 0)] {
            let length = data.len().next_multiple_of(4);
            bytes.extend((length as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(data);
            bytes.resize(bytes.len().next_multiple_of(4), filler);
        }
        let length = bytes.len() as u32;
        bytes[8..12].copy_from_slice(&length.to_le_bytes());
        bytes
    };
    let load = |bytes: &[u8]| {
        let (_folder, path) = in_folder("file.glb", bytes);
        Scene::load(path).map_err(|error| error.to_string())
    };
    let whole = glb(broken(&[("/buffers/0/uri", Value::Null)]).to_string().as_bytes(), &triangle_bytes());
    assert_eq!(load(&whole).unwrap().triangle_count(), 1);
    // Cut off anywhere it is an error.
    for length in (0..whole.len()).step_by(7).chain([1, 4, 11, 12, 19, 20, whole.len() - 1]) {
        assert!(load(&whole[..length]).is_err(), "loads with {length} bytes");
    }
    let mut version = whole.clone();
    version[4] = 1;
    assert!(load(&version).unwrap_err().contains("GLB container: version 1; only version 2 is supported"));
    let mut chunk = whole.clone();
    chunk[12..16].fill(0xff);
    assert!(load(&chunk).unwrap_err().contains("the chunk at byte 12 says 4294967295 bytes"));
    let mut kind = whole.clone();
    kind[16] = b'X';
    assert!(load(&kind).unwrap_err().contains("the first chunk is not JSON"));
    assert!(load(b"{\"asset\": \xff\xfe}").unwrap_err().contains("not UTF-8"));
    assert!(load(b"not json").unwrap_err().contains("neither binary glTF"));
    assert!(load(b"{not json").unwrap_err().contains("JSON: key must be"));
    assert!(load(&b"[".repeat(100_000)).unwrap_err().contains("JSON"));
    assert!(load(b"").is_err());
    assert!(Scene::load(Path::new("no/such/file.glb")).unwrap_err().to_string().contains("no/such/file.glb"));
}

#[test]
fn broken_textures_name_file_and_material() {
    let textured = |image: Value| {
        let mut file = broken(&[
            ("/textures", json!([{ "source": 0 }])),
            ("/materials/0/pbrMetallicRoughness", json!({ "baseColorTexture": { "index": 0 } })),
        ]);
        set(&mut file, "/images", json!([image]));
        load(&file)
    };
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(3, 2, image::Rgb([10, 20, 30])).write_to(&mut png, image::ImageFormat::Png).unwrap();
    let png = png.into_inner();
    let scene = textured(json!({ "uri": data_uri(&png) })).unwrap();
    assert_eq!(scene.textures[0].size, [3, 2]);
    assert_eq!(scene.textures[0].pixels[..4], [10, 20, 30, 255]);

    let cut = &png[..png.len() - 20];
    let mut vast = png.clone();
    vast[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    for (image, expected) in [
        (json!({ "uri": "no such.png" }), vec!["material 0 \"paint\"", "no such.png"]),
        (json!({ "uri": data_uri(cut) }), vec!["material 0 \"paint\"", "image 0", "broken image"]),
        (json!({ "uri": data_uri(b"GIF89a...") }), vec!["material 0 \"paint\"", "neither PNG nor JPEG"]),
        (json!({ "uri": data_uri(&vast) }), vec!["material 0 \"paint\"", "image 0"]),
        (json!({ "uri": data_uri(b"") }), vec!["neither PNG nor JPEG"]),
        (json!({ "bufferView": 9, "mimeType": "image/png" }), vec!["material 0 \"paint\"", "uses bufferView 9"]),
        (json!({}), vec!["neither a URI nor a bufferView"]),
    ] {
        let error = textured(image).unwrap_err();
        assert!(expected.iter().all(|part| error.contains(part)), "{error:?} lacks one of {expected:?}");
    }
    let error = load(&broken(&[("/textures", json!([{}])), ("/materials/0/emissiveTexture", json!({ "index": 0 }))]));
    assert!(error.unwrap_err().contains("has no image in PNG or JPEG"));
}

#[test]
fn what_is_passed_over_is_said() {
    let scene = load(&broken(&[
        ("/extensionsUsed/-", json!("KHR_materials_iridescence")),
        ("/animations", json!([{ "channels": [], "samplers": [] }])),
        ("/meshes/0/primitives/-", json!({ "attributes": { "POSITION": 0 }, "mode": 0 })),
        ("/meshes/0/primitives/-", json!({ "attributes": { "NORMAL": 1 } })),
        ("/meshes/0/primitives/-", json!({ "attributes": { "POSITION": 0 }, "mode": 5, "indices": 4 })),
        (
            "/accessors/-",
            json!({ "bufferView": 0, "byteOffset": 96, "componentType": 5123, "count": 2, "type": "SCALAR" }),
        ),
    ]))
    .unwrap();
    for (warning, expected) in scene.warnings.iter().zip([
        "the optional extension KHR_materials_iridescence is not supported and has no effect",
        "1 animations are passed over: the scene is in its rest pose",
        "mesh 0 \"tri\", primitive 1 is passed over: it is Points, not triangles",
        "mesh 0 \"tri\", primitive 2 is passed over: it has no POSITION",
        "mesh 0 \"tri\", primitive 3 is passed over: it has no triangles",
    ]) {
        assert_eq!(warning, expected);
    }
    assert_eq!(scene.warnings.len(), 5, "{:?}", scene.warnings);
    assert_eq!(scene.triangle_count(), 1);
}

#[test]
fn transmission_is_taken_in() {
    let glass = json!({ "KHR_materials_transmission": { "transmissionFactor": 0.75 } });
    let extensions = json!(["KHR_lights_punctual", "KHR_materials_transmission"]);
    let mut file = broken(&[("/extensionsUsed", extensions), ("/materials/0/extensions", glass)]);
    set(&mut file, "/extensionsRequired", json!(["KHR_materials_transmission"]));
    let scene = load(&file).unwrap();
    assert!(scene.warnings.is_empty() && scene.materials[0].is_transmissive());
    assert_eq!(scene.materials[0].transmission, 0.75);
    // Where texels are cut away there is nothing to look through.
    set(&mut file, "/materials/0/alphaMode", json!("MASK"));
    let scene = load(&file).unwrap();
    assert!(scene.warnings[0].contains("transmission has no effect") && !scene.materials[0].is_blended());
    set(&mut file, "/materials/0/extensions/KHR_materials_transmission/transmissionTexture", json!({ "index": 9 }));
    set(&mut file, "/materials/0/alphaMode", json!("OPAQUE"));
    assert!(load(&file).unwrap_err().contains("transmissionTexture is texture 9"));
}

#[test]
fn a_long_chain_of_nodes_is_no_recursion() {
    let mut nodes: Vec<Value> = (1..60_000).map(|next| json!({ "children": [next] })).collect();
    nodes.push(json!({ "mesh": 0, "translation": [2, 0, 0] }));
    let scene = load(&broken(&[("/nodes", json!(nodes)), ("/scenes/0/nodes", json!([0]))])).unwrap();
    assert_eq!(scene.objects[0].world_from_object.w_axis.x, 2.0);
}

#[test]
fn skins_are_checked() {
    let skinned = |skin: Value| load(&broken(&[("/nodes/0/skin", json!(0)), ("/skins", json!([skin]))]));
    let error = skinned(json!({ "joints": [] })).unwrap_err();
    assert!(error.contains("skin 0: 0 joints"), "{error}");
    let error = skinned(json!({ "joints": [50] })).unwrap_err();
    assert!(error.contains("skin 0: joint node 50 is not part of a hierarchy"), "{error}");
    let error = skinned(json!({ "joints": [3] })).unwrap_err();
    assert!(error.contains("has no JOINTS_0 and WEIGHTS_0"), "{error}");
    let error = skinned(json!({ "joints": [3], "inverseBindMatrices": 0 })).unwrap_err();
    assert!(error.contains("Vec3 is not allowed here: 16 components"), "{error}");
}

/// Small real files, as (name, bytes).
fn small_files() -> Vec<(String, Vec<u8>)> {
    let mut files = vec![("good.gltf".to_owned(), good().to_string().into_bytes())];
    let checkout = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap();
    let folder = std::env::var_os("SHADOWGRAPH_SCENES")
        .map(PathBuf::from)
        .or_else(|| checkout.ancestors().skip(1).map(|up| up.join("shared/scenes")).find(|folder| folder.is_dir()));
    let Some(folder) = folder else {
        eprintln!("skipped: scene folder (SHADOWGRAPH_SCENES is not set, ../shared/scenes is not there)");
        return files;
    };
    for name in [
        "Box/glTF-Binary/Box.glb",
        "Box/glTF-Embedded/Box.gltf",
        "BoxInterleaved/BoxInterleaved.glb",
        "SimpleSkin/SimpleSkin.gltf",
        "SimpleSparseAccessor/glTF-Embedded/SimpleSparseAccessor.gltf",
        "UnlitTest/UnlitTest.glb",
        "TextureCoordinateTest/TextureCoordinateTest.glb",
        "Triangle/glTF-Embedded/Triangle.gltf",
    ] {
        files.push((name.rsplit('/').next().unwrap().to_owned(), std::fs::read(folder.join(name)).unwrap()));
    }
    files
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever a few bytes become, loading ends in a scene whose indices are in range or in an error.
    #[test]
    fn flipped_bytes_never_panic(
        choice in any::<prop::sample::Index>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in prop::option::weighted(0.1, any::<prop::sample::Index>()),
    ) {
        thread_local!(static FILES: Vec<(String, Vec<u8>)> = small_files());
        let (name, mut bytes) = FILES.with(|files| files[choice.index(files.len())].clone());
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let (_folder, path) = in_folder(&name, &bytes);
        if let Ok(scene) = Scene::load(path) {
            for primitive in scene.meshes.iter().flat_map(|mesh| &mesh.primitives) {
                let count = primitive.positions.len();
                prop_assert!(primitive.indices.iter().all(|&index| (index as usize) < count));
                prop_assert!(primitive.material < scene.materials.len());
                prop_assert!(primitive.positions.iter().all(|p| p.is_finite()));
            }
            prop_assert!(scene.objects.iter().all(|object| object.mesh < scene.meshes.len()));
            prop_assert!(scene.bounds().is_none_or(|bounds| bounds.size().is_finite()));
        }
    }
}

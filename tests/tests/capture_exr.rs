//! OpenEXR files: read back by the `exr` crate's reader and by OpenEXR's own tools.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use exr::prelude::{FlatSamples, f16};
use glam::{Mat4, Vec2, Vec3, Vec4};
use proptest::prelude::*;
use shadowgraph::capture::{
    Capture, Channel, Compression, ExrOptions, HalfReport, Metadata, Part, Samples, Value, write_exr,
};
use shadowgraph::scene::Camera;
use shadowgraph_tests::exr_file;

/// Bits of every channel, by part and channel name.
type Bits = BTreeMap<(String, String), (Vec<u32>, &'static str)>;

fn bits_written(capture: &Capture) -> Bits {
    let mut bits = Bits::new();
    for part in &capture.parts {
        for channel in &part.channels {
            let samples = match &channel.content.clone().into_samples().unwrap() {
                Samples::F16(v) => (v.iter().map(|x| u32::from(x.to_bits())).collect(), "half"),
                Samples::F32(v) => (v.iter().map(|x| x.to_bits()).collect(), "float"),
                Samples::U32(v) => (v.clone(), "uint"),
            };
            bits.insert((part.name.clone(), channel.name.clone()), samples);
        }
    }
    bits
}

/// The crate shows bytes as Latin-1.
fn utf8(text: &exr::meta::attribute::Text) -> String {
    String::from_utf8(text.as_slice().to_vec()).unwrap()
}

fn bits_read(path: &Path) -> Bits {
    let image = exr_file::image(path);
    let mut bits = Bits::new();
    for layer in &image.layer_data {
        let part = layer.attributes.layer_name.as_ref().map_or(String::new(), utf8);
        for channel in &layer.channel_data.list {
            let samples = match &channel.sample_data {
                FlatSamples::F16(v) => (v.iter().map(|x| u32::from(x.to_bits())).collect(), "half"),
                FlatSamples::F32(v) => (v.iter().map(|x| x.to_bits()).collect(), "float"),
                FlatSamples::U32(v) => (v.clone(), "uint"),
            };
            assert_eq!(samples.0.len(), layer.size.area());
            bits.insert((part.clone(), utf8(&channel.name)), samples);
        }
    }
    bits
}

/// Numbers without a pattern, the same every time.
fn noise(count: usize, seed: u32) -> impl Iterator<Item = u32> {
    let mut state = seed.wrapping_mul(0x9E37_79B9) | 1;
    std::iter::repeat_with(move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state
    })
    .take(count)
}

/// A frame of smooth, constant and random channels with a shadow map of another size.
fn sample_capture() -> Capture {
    let size = [67, 41];
    let pixels = 67 * 41;
    let smooth = |scale: f32| (0..pixels).map(|i| (i % 67) as f32 * scale + (i / 67) as f32).collect::<Vec<_>>();
    let mut depth = smooth(0.01);
    depth[..67].fill(f32::INFINITY);
    depth[100] = f32::NAN;
    let half = |scale: f32| smooth(scale).into_iter().map(f16::from_f32).collect::<Vec<_>>();
    let channels = vec![
        // Not in the order of the file on purpose.
        Channel::new("id.object", Samples::U32(noise(pixels, 7).map(|x| x % 5).collect())),
        Channel::new("Z", Samples::F32(depth)),
        Channel::new("R", Samples::F16(half(0.1))),
        Channel::new("G", Samples::F16(half(0.2))),
        Channel::new("B", Samples::F16(half(0.3))),
        Channel::new("A", Samples::F16(vec![f16::ONE; pixels])),
        Channel::new("N.X", Samples::F32(noise(pixels, 3).map(f32::from_bits).collect())),
        Channel::new("emissive.R", Samples::F16(vec![f16::ZERO; pixels])),
        Channel::new("shadow.a light with a name longer than 31 bytes: Sönne", Samples::F16(half(0.5))),
    ];
    let map =
        |seed| vec![Channel::new("depth", Samples::F32(noise(129 * 130, seed).map(|x| (x >> 20) as f32).collect()))];
    let mut metadata = Metadata::default();
    metadata.add_units(0.25);
    Capture {
        parts: vec![
            Part { name: "frame".into(), size, channels, ..Part::default() },
            Part { name: "shadow.sun.0".into(), size: [129, 130], channels: map(1), ..Part::default() },
            Part { name: "shadow.sun.1".into(), size: [130, 129], channels: map(2), ..Part::default() },
        ],
        metadata,
    }
}

fn write(capture: &Capture, compression: Compression, folder: &Path) -> std::path::PathBuf {
    let path = folder.join(format!("{}.exr", compression.name()));
    write_exr(&path, capture, &ExrOptions { compression }).unwrap();
    path
}

/// Runs one of OpenEXR's tools, or says that it is missing: a skipped test, and a failure in CI.
fn openexr(tool: &str, arguments: &[&Path]) -> Option<Output> {
    match Command::new(tool).args(arguments).output() {
        Ok(output) => {
            // exrinfo 3.1.5 exits with whatever its variable held.
            let failed = !output.status.success() && tool != "exrinfo";
            assert!(!failed, "{tool} {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
            Some(output)
        }
        Err(error) => {
            assert!(std::env::var_os("SHADOWGRAPH_CI").is_none_or(|v| v != "1"), "{tool} is missing: {error}");
            eprintln!("skipped: {tool} is not installed (Debian: openexr)");
            None
        }
    }
}

#[test]
fn every_compression_keeps_every_bit() {
    let folder = tempfile::tempdir().unwrap();
    let capture = sample_capture();
    for compression in Compression::ALL {
        let path = write(&capture, compression, folder.path());
        assert!(bits_read(&path) == bits_written(&capture), "{}", compression.name());
    }
}

#[test]
fn openexr_decodes_every_bit() {
    let folder = tempfile::tempdir().unwrap();
    let capture = sample_capture();
    for compression in Compression::ALL {
        let path = write(&capture, compression, folder.path());
        // OpenEXR's library decodes a part and encodes it anew, as tiles without compression; it copies the others.
        for index in 0..capture.parts.len() {
            let tiled = folder.path().join("tiled.exr");
            let (number, none) = (index.to_string(), "none");
            let arguments = [Path::new("-p"), Path::new(&number), Path::new("-z"), Path::new(none), &path, &tiled];
            let Some(_) = openexr("exrmaketiled", &arguments) else { return };
            assert!(bits_read(&tiled) == bits_written(&capture), "{} part {index}", compression.name());
        }
    }
}

#[test]
fn openexr_tools_read_the_header() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(&sample_capture(), Compression::default(), folder.path());
    let Some(output) = openexr("exrheader", &[&path]) else { return };
    let text = String::from_utf8_lossy(&output.stdout);
    let needed = [
        "N.X, 32-bit floating-point",
        "R, 16-bit floating-point",
        "id.object, 32-bit unsigned integer",
        "shadow.a light with a name longer than 31 bytes: Sönne",
        "name (type string): \"shadow.sun.1\"",
        "dataWindow (type box2i): (0 0) - (128 129)",
        "shadowgraph/exposure (type float): 0.25",
        "compression (type compression): zip",
    ];
    for needed in needed {
        assert!(text.contains(needed), "{needed:?} is not in {text}");
    }
    let Some(output) = openexr("exrinfo", &[&path]) else { return };
    assert!(String::from_utf8_lossy(&output.stdout).contains("'id.object': uint"));
}

#[test]
fn a_single_part_is_a_single_part_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut capture = sample_capture();
    capture.parts.truncate(1);
    for compression in Compression::ALL {
        let path = write(&capture, compression, folder.path());
        assert!(bits_read(&path) == bits_written(&capture), "{}", compression.name());
        let flags = u32::from_le_bytes(fs::read(&path).unwrap()[4..8].try_into().unwrap());
        assert_eq!(flags, 2 | 0x400, "version 2, long names, and no other flag");
    }
    capture.parts[0].channels.retain(|channel| channel.name.len() < 32);
    let path = write(&capture, Compression::Zip, folder.path());
    assert_eq!(fs::read(path).unwrap()[4..8], 2_u32.to_le_bytes());
}

#[test]
fn the_same_capture_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let mut capture = sample_capture();
    // Large enough for several blocks a thread, with attributes enough for an order to show.
    capture.parts[1].size = [256, 2048];
    let samples = Samples::F32(noise(256 * 2048, 9).map(|x| (x % 9) as f32).collect());
    capture.parts[1].channels[0].content = samples.into();
    for index in 0..20 {
        capture.metadata.add_text(format!("shadowgraph/fact{index}"), "x");
    }
    for compression in Compression::ALL {
        let first = fs::read(write(&capture, compression, folder.path())).unwrap();
        for _ in 0..3 {
            assert!(fs::read(write(&capture, compression, folder.path())).unwrap() == first, "{}", compression.name());
        }
    }
}

#[test]
fn parts_packed_ahead_give_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let plain = sample_capture();
    for compression in Compression::ALL {
        let wanted = fs::read(write(&plain, compression, folder.path())).unwrap();
        // None, one, all chunks of each part; and all, for another compression.
        for (packed_for, most) in [(compression, 0), (compression, 1), (compression, 99), (Compression::Rle, 99)] {
            let mut capture = plain.clone();
            for part in &mut capture.parts {
                let left = std::cell::Cell::new(most);
                part.pack(packed_for, || left.replace(left.get() - 1) > 0).unwrap();
            }
            let found = fs::read(write(&capture, compression, folder.path())).unwrap();
            assert_eq!(found, wanted, "{compression:?}, {most} chunks packed as {packed_for:?}");
        }
        // What was packed is what is written.
        let mut changed = plain.clone();
        changed.parts[1].pack(compression, || true).unwrap();
        let channel = &mut changed.parts[1].channels[0];
        let Samples::F32(values) = channel.content.clone().into_samples().unwrap() else { panic!() };
        *channel = Channel::new(channel.name.clone(), Samples::F32(vec![7.0; values.len()]));
        assert_eq!(fs::read(write(&changed, compression, folder.path())).unwrap(), wanted);
    }
    let mut empty = Part { name: "empty".into(), size: [4, 4], ..Part::default() };
    let said = empty.pack(Compression::Zip, || true).unwrap_err().to_string();
    assert!(said.contains("it has no channels"), "{said}");
}

#[test]
fn attributes_stand_in_the_order_given() {
    let folder = tempfile::tempdir().unwrap();
    let mut capture = sample_capture();
    let names: Vec<String> = (0..20).map(|index| format!("fact{}", (index * 7) % 20)).collect();
    names.iter().for_each(|name| capture.metadata.add_text(name, "x"));
    let bytes = fs::read(write(&capture, Compression::Zip, folder.path())).unwrap();
    let place = |name: &String| {
        let needle = [name.as_bytes(), b"\0string\0"].concat();
        bytes.windows(needle.len()).position(|window| window == needle).unwrap()
    };
    let places: Vec<usize> = names.iter().map(place).collect();
    assert!(places.is_sorted(), "{places:?}");
}

#[test]
fn deflate_shrinks_what_is_smooth() {
    let folder = tempfile::tempdir().unwrap();
    let smooth = (0..256 * 256).map(|i| (i % 256) as f32 / 256.0).collect();
    let part = Part {
        name: "frame".into(),
        size: [256, 256],
        channels: vec![Channel::new("Z", Samples::F32(smooth))],
        ..Part::default()
    };
    let capture = Capture { parts: vec![part], ..Capture::default() };
    let size = |compression| fs::metadata(write(&capture, compression, folder.path())).unwrap().len();
    assert!(size(Compression::None) > 256 * 256 * 4);
    // A line alone repeats little, 16 lines repeat each other.
    assert!(size(Compression::Zip) < 256 * 256 * 4 / 10, "{}", size(Compression::Zip));
    assert!(size(Compression::Zips) < 256 * 256 * 4 * 2 / 3, "{}", size(Compression::Zips));
}

#[test]
fn the_camera_projects_as_openexr_defines() {
    let size = [320, 180];
    let camera = Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::new(-2.0, 0.5, -4.0), Vec3::Y, 0.9, 0.1);
    let view = camera.view(size);
    let mut capture = sample_capture();
    capture.metadata.add_camera(&view, &camera.projection);
    let folder = tempfile::tempdir().unwrap();
    let path = write(&capture, Compression::Zip, folder.path());
    let image = exr_file::image(&path);
    let attributes = &image.layer_data[0].attributes;
    // Row vectors from the left, as OpenEXR multiplies.
    let times = |point: Vec3, matrix: [f32; 16]| {
        let point = [point.x, point.y, point.z, 1.0];
        let mut out = [0.0; 4];
        for (column, out) in out.iter_mut().enumerate() {
            *out = (0..4).map(|row| point[row] * matrix[4 * row + column]).sum();
        }
        Vec4::from_array(out)
    };
    let world_to_camera = attributes.world_to_camera.unwrap();
    let world_to_ndc = attributes.world_to_normalized_device.unwrap();
    let eye = view.eye();
    let right = view.world_from_view.x_axis.truncate();
    let up = view.world_from_view.y_axis.truncate();
    let forward = -view.world_from_view.z_axis.truncate();
    let close = |a: Vec3, b: Vec3| assert!(a.distance(b) < 1e-4, "{a} is not {b}");
    let distance = 5.0;
    let point = eye + distance * forward + 1.5 * right + 0.5 * up;
    close(times(point, world_to_camera).truncate(), Vec3::new(1.5, 0.5, distance));
    // Upper left corner of the picture: half the height is tan(fov / 2) at distance 1.
    let half_height = (0.45_f32).tan();
    let half_width = half_height * 320.0 / 180.0;
    for (x, y) in [(0.0, 0.0), (1.0, 1.0), (0.25, 0.75), (0.5, 0.5)] {
        let direction = forward + (2.0 * x - 1.0) * half_width * right + (1.0 - 2.0 * y) * half_height * up;
        let projected = times(eye + distance * direction, world_to_ndc);
        let ndc = projected.truncate() / projected.w;
        close(Vec3::new(ndc.x, ndc.y, 0.0), Vec3::new(x, y, 0.0));
    }
}

#[test]
fn metadata_survives() {
    let mut capture = sample_capture();
    capture.metadata.add_software("llvmpipe", "Mesa 22.3.6");
    capture.metadata.add_names("id.object", ["floor", "Säule \"1\""]).unwrap();
    let lost = HalfReport { clamped: 3, not_a_number: 1 };
    capture.metadata.add_half_reports([("R", lost), ("G", HalfReport::default())]).unwrap();
    capture.metadata.add_pass_times([("light.sun", 1.25)]).unwrap();
    capture.metadata.add("integer", Value::I32(-7));
    capture.metadata.add("double", Value::F64(0.1));
    capture.metadata.add("point", Value::Vec2(Vec2::new(1.0, 2.0)));
    capture.metadata.add("matrix", Value::Mat4(Mat4::from_translation(Vec3::new(1.0, 2.0, 3.0))));
    capture.parts[1].metadata.add_text("shadowgraph/light", "sun");
    let folder = tempfile::tempdir().unwrap();
    let path = write(&capture, Compression::Zip, folder.path());
    let image = exr_file::image(&path);
    let bytes = |name: &str| exr::meta::attribute::Text::from_slice_unchecked(name.as_bytes());
    let text = |part: usize, name: &str| match image.layer_data[part].attributes.other.get(&bytes(name)) {
        Some(exr::meta::attribute::AttributeValue::Text(text)) => utf8(text),
        other => panic!("{name}: {other:?}"),
    };
    assert_eq!(text(0, "shadowgraph/names/id.object"), r#"[null,"floor","Säule \"1\""]"#);
    assert_eq!(text(0, "shadowgraph/clamped"), r#"{"R":[3,1]}"#);
    assert_eq!(text(0, "shadowgraph/passes"), r#"[["light.sun",1.25]]"#);
    assert_eq!(text(0, "shadowgraph/driver"), "Mesa 22.3.6");
    assert_eq!(text(1, "shadowgraph/light"), "sun");
    let chromaticities = image.attributes.chromaticities.unwrap();
    assert_eq!((chromaticities.red.0, chromaticities.white.1), (0.64, 0.3290));
    let other = |name| image.layer_data[0].attributes.other.get(&bytes(name)).unwrap().clone();
    use exr::meta::attribute::AttributeValue as A;
    assert_eq!(other("integer"), A::I32(-7));
    assert_eq!(other("double"), A::F64(0.1));
    // A translation stands in the last row.
    assert!(matches!(other("matrix"), A::Matrix4x4(m) if m[12..] == [1.0, 2.0, 3.0, 1.0]));
}

#[test]
fn what_openexr_cannot_hold_is_refused() {
    fn refused(what: &str, change: impl FnOnce(&mut Capture)) {
        let folder = tempfile::tempdir().unwrap();
        let mut capture = sample_capture();
        change(&mut capture);
        let error = write_exr(&folder.path().join("x.exr"), &capture, &ExrOptions::default()).unwrap_err().to_string();
        assert!(error.contains(what), "{error:?} does not say {what:?}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "a file was left");
    }
    refused("no parts", |c| c.parts.clear());
    refused("no channels", |c| c.parts[1].channels.clear());
    refused("need names", |c| c.parts[1].name.clear());
    refused("two parts", |c| c.parts[1].name = "frame".into());
    refused("0×41", |c| c.parts[0].size[0] = 0);
    refused("2747 samples for 68×41 pixels", |c| c.parts[0].size[0] = 68);
    refused("two channels", |c| c.parts[0].channels[0].name = "Z".into());
    refused("empty", |c| c.parts[0].channels[0].name.clear());
    refused("zero byte", |c| c.parts[0].channels[0].name = "a\0b".into());
    refused("256 bytes", |c| c.parts[0].channels[0].name = "x".repeat(256));
    refused("two attributes", |c| c.metadata.add_text("shadowgraph/exposure", "again"));
    refused("meaning of its own", |c| c.metadata.add_text("channels", "R"));
}

#[test]
fn names_of_compressions_are_read_back() {
    for compression in Compression::ALL {
        assert_eq!(compression.name().parse::<Compression>().unwrap(), compression);
    }
    let error = "lzw".parse::<Compression>().unwrap_err().to_string();
    assert!(error.contains("lzw") && error.contains("none, rle, zips, zip, piz"), "{error}");
}

fn any_channel(pixels: usize) -> impl Strategy<Value = Samples> {
    // Few different values, or any: compressible or not.
    let value = prop_oneof![0..4_u32, any::<u32>()];
    (0..3, prop::collection::vec(value, pixels)).prop_map(|(kind, values)| match kind {
        0 => Samples::F16(values.into_iter().map(|x| f16::from_bits(x as u16)).collect()),
        1 => Samples::F32(values.into_iter().map(f32::from_bits).collect()),
        _ => Samples::U32(values),
    })
}

fn any_part() -> impl Strategy<Value = Part> {
    (1..40_u32, 1..70_u32).prop_flat_map(|(width, height)| {
        prop::collection::vec(any_channel((width * height) as usize), 1..5).prop_map(move |samples| Part {
            size: [width, height],
            channels: samples.into_iter().enumerate().map(|(i, s)| Channel::new(format!("c{i}"), s)).collect(),
            ..Part::default()
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_capture_comes_back(parts in prop::collection::vec(any_part(), 1..4), compression in 0..5_usize) {
        let mut capture = Capture { parts, ..Capture::default() };
        for (index, part) in capture.parts.iter_mut().enumerate() {
            part.name = format!("part{index}");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = write(&capture, Compression::ALL[compression], folder.path());
        prop_assert!(bits_read(&path) == bits_written(&capture));
    }
}

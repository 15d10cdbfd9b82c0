//! The program as a user runs it: exit codes, files, messages.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{AnyChannels, FlatSamples, Image, Layers, ReadChannels, ReadLayers, read};
use tempfile::TempDir;

/// Runs the program; compiled shaders are kept between tests.
fn run(folder: &TempDir, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_shadowgraph"))
        .args(arguments)
        .current_dir(folder)
        .env("SHADOWGRAPH_CACHE", Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache"))
        .output()
        .unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn succeeds(folder: &TempDir, arguments: &[&str]) -> Output {
    let output = run(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    output
}

/// Bad usage or bad input: exit code 2, a message that says `needed`, and no file.
fn is_refused(arguments: &[&str], needed: &str) {
    let folder = tempfile::tempdir().unwrap();
    let output = run(&folder, arguments);
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
    assert!(told.starts_with("error: ") && told.contains(needed), "{arguments:?}: {told:?} does not say {needed:?}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0, "{arguments:?} left a file");
}

type Exr = Image<Layers<AnyChannels<FlatSamples>>>;

fn open(folder: &TempDir, name: &str) -> Exr {
    let image = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    image.from_file(folder.path().join(name)).unwrap()
}

/// Samples of each channel of the frame.
fn channels(image: &Exr) -> BTreeMap<String, FlatSamples> {
    let channels = image.layer_data[0].channel_data.list.iter();
    channels.map(|channel| (channel.name.to_string(), channel.sample_data.clone())).collect()
}

fn attribute(image: &Exr, name: &str) -> Option<String> {
    let name = Text::from_slice_unchecked(name.as_bytes());
    match image.layer_data[0].attributes.other.get(&name)? {
        AttributeValue::Text(text) => Some(String::from_utf8(text.as_slice().to_vec()).unwrap()),
        other => panic!("{name}: {other:?}"),
    }
}

#[test]
fn help_is_no_failure_and_bad_usage_is() {
    let folder = tempfile::tempdir().unwrap();
    assert!(stdout(&succeeds(&folder, &["--help"])).contains("Exit codes"));
    assert!(stdout(&succeeds(&folder, &["capture", "--help"])).contains("Examples:"));
    assert!(stdout(&succeeds(&folder, &["--version"])).contains(env!("CARGO_PKG_VERSION")));
    assert_eq!(run(&folder, &[]).status.code(), Some(2));
    is_refused(&["render"], "render");
    is_refused(&["capture", "builtin:cornell"], "--output");
    is_refused(&["capture", "builtin:cornell", "-o", "o.exr", "--size", "0x9"], "1280x720");
    is_refused(&["capture", "builtin:cornell", "-o", "o.exr", "--eye", "1,2"], "three finite numbers");
    is_refused(&["capture", "builtin:cornell", "-o", "o.exr", "--compression", "lzw"], "piz");
    is_refused(&["bench", "nothing"], "capture, graph, write, voxelize");
}

#[test]
fn bad_input_is_refused_without_a_device() {
    let nowhere = "--device=there is no device of this name";
    is_refused(&["capture", "builtin:nothing", "-o", "o.exr", nowhere], "cornell");
    is_refused(&["capture", "missing.glb", "-o", "o.exr", nowhere], "missing.glb");
    is_refused(&["capture", "builtin:cornell", "-o", "o.png", nowhere], "must end in .exr");
    is_refused(&["capture", "builtin:cornell", "-o", "o.exr", "--png", "o.jpg", nowhere], "must end in .png");
    is_refused(&["capture", "builtin:cornell", "-o", "missing/o.exr", nowhere], "no such folder");
    is_refused(&["graph", "builtin:cornell", "-o", "missing/o.json", nowhere], "no such folder");
    is_refused(&["capture", "builtin:cornell", "-o", "o.exr", "--camera", "nobody", nowhere], "0 (front)");
    is_refused(&["capture", "builtin:cornell", "-o", "o.exr", "--eye=1,2,3", "--target=1,2,3", nowhere], "same point");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("broken.glb"), b"glTF").unwrap();
    let output = run(&folder, &["capture", "broken.glb", "-o", "o.exr", nowhere]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("broken.glb"));
}

#[test]
fn a_device_that_is_not_there_is_bad_usage() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(&folder, &["info", "--device", "there is no device of this name"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("there is no device of this name"), "{}", stderr(&output));
}

#[test]
fn info_names_device_and_driver() {
    let folder = tempfile::tempdir().unwrap();
    let info: serde_json::Value = serde_json::from_str(&stdout(&succeeds(&folder, &["info", "--json"]))).unwrap();
    let driver = info["device"]["driver_info"].as_str().unwrap();
    assert!(!driver.is_empty());
    let table = stdout(&succeeds(&folder, &["info"]));
    assert!(table.contains(driver));
    // Features by Vulkan's names, as in the table.
    let features = info["device"]["features"].as_array().unwrap();
    assert!(!features.is_empty());
    assert!(features.iter().all(|feature| table.contains(feature.as_str().unwrap())), "{features:?} in {table}");
}

#[test]
fn a_capture_has_every_layer() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["capture", "builtin:cornell", "-o", "o.exr", "--png", "o.png", "--size", "96x54", "--validation"];
    let output = succeeds(&folder, &arguments);
    assert!(stdout(&output).contains("o.exr") && stdout(&output).contains("o.png"), "{}", stdout(&output));
    let mut files: Vec<_> =
        fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    files.sort();
    assert_eq!(files, ["o.exr", "o.png"]);

    let image = open(&folder, "o.exr");
    let channels = channels(&image);
    let kind = |name: &str| match channels.get(name).unwrap_or_else(|| panic!("no {name}")) {
        FlatSamples::F16(_) => "half",
        FlatSamples::F32(_) => "float",
        FlatSamples::U32(_) => "uint",
    };
    for name in
        ["R", "G", "B", "A", "N.X", "albedo.R", "roughness", "metallic", "emissive.G", "direct.B", "shadow.lamp"]
    {
        assert_eq!(kind(name), "half", "{name}");
    }
    for name in ["Z", "P.X", "P.Y", "P.Z"] {
        assert_eq!(kind(name), "float", "{name}");
    }
    // Background and ids.
    let (FlatSamples::F32(depth), FlatSamples::U32(objects)) = (&channels["Z"], &channels["id.object"]) else {
        panic!()
    };
    let FlatSamples::F16(alpha) = &channels["A"] else { panic!() };
    assert_eq!(depth.len(), 96 * 54);
    let names: Vec<Option<String>> =
        serde_json::from_str(&attribute(&image, "shadowgraph/names/id.object").unwrap()).unwrap();
    let mut covered = 0;
    for ((depth, object), alpha) in depth.iter().zip(objects).zip(alpha) {
        assert_eq!(depth.is_finite(), *object != 0);
        assert_eq!(alpha.to_f32(), if *object == 0 { 0.0 } else { 1.0 });
        assert_eq!(names[*object as usize].is_some(), *object != 0);
        covered += u32::from(*object != 0);
    }
    assert!(covered > 1000 && covered < 96 * 54, "{covered}");
    // Shadow maps are parts of their own.
    assert!(image.layer_data.len() > 1);
    assert!(image.layer_data[0].attributes.world_to_camera.is_some());
    assert!(attribute(&image, "shadowgraph/driver").is_some_and(|driver| !driver.is_empty()));
    assert!(attribute(&image, "shadowgraph/passes").is_some());
}

#[test]
fn reproducible_captures_are_equal_files() {
    let folder = tempfile::tempdir().unwrap();
    let capture = |name: &str, more: &[&str]| {
        let arguments = ["capture", "builtin:cornell", "--size", "64x36", "-o", name];
        succeeds(&folder, &[&arguments, more].concat());
        fs::read(folder.path().join(name)).unwrap()
    };
    assert!(capture("a.exr", &["--reproducible"]) == capture("b.exr", &["--reproducible"]));
    assert!(attribute(&open(&folder, "a.exr"), "shadowgraph/passes").is_none());
    capture("c.exr", &[]);
    let same = |a: &Exr, b: &Exr| {
        a.layer_data
            .iter()
            .zip(&b.layer_data)
            .all(|(a, b)| format!("{:?}", a.channel_data) == format!("{:?}", b.channel_data))
    };
    assert!(same(&open(&folder, "a.exr"), &open(&folder, "c.exr")), "without times left out, the pixels are the same");
}

#[test]
fn layers_are_selected() {
    let folder = tempfile::tempdir().unwrap();
    let arguments =
        ["capture", "builtin:cornell", "--size", "64x36", "-o", "o.exr", "--layers", "Z,id", "--png", "o.png"];
    succeeds(&folder, &arguments);
    let image = open(&folder, "o.exr");
    let names: Vec<String> = channels(&image).into_keys().collect();
    assert_eq!(names, ["Z", "id.material", "id.object", "id.primitive"]);
    assert_eq!(image.layer_data.len(), 1);
    assert!(folder.path().join("o.png").is_file(), "the picture is rendered for the PNG all the same");
    is_refused(
        &["capture", "builtin:cornell", "-o", "o.exr", "--layers", "Z,colour"],
        "unknown layer \"colour\"; this scene has color, Z",
    );
}

#[test]
fn what_half_floats_cannot_hold_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["capture", "builtin:cornell", "--size", "64x36", "-o", "o.exr", "--sun=0,-0.2,-1,1e9"];
    let output = succeeds(&folder, &arguments);
    assert!(stderr(&output).contains("R: ") && stderr(&output).contains("clamped"), "{}", stderr(&output));
    let clamped = attribute(&open(&folder, "o.exr"), "shadowgraph/clamped").unwrap();
    let clamped: BTreeMap<String, [u64; 2]> = serde_json::from_str(&clamped).unwrap();
    let FlatSamples::F16(red) = &channels(&open(&folder, "o.exr"))["R"] else { panic!() };
    assert!(red.iter().all(|value| value.is_finite()));
    let greatest = red.iter().filter(|value| value.to_f32() == 65504.0).count() as u64;
    assert!(clamped["R"][0] > 0 && clamped["R"][0] <= greatest, "{clamped:?}");

    let output = succeeds(&folder, &[&arguments[..], &["--float"]].concat());
    assert_eq!(stderr(&output), "");
    let image = open(&folder, "o.exr");
    assert_eq!(attribute(&image, "shadowgraph/clamped").unwrap(), "{}");
    let FlatSamples::F32(red) = &channels(&image)["R"] else { panic!() };
    assert!(red.iter().any(|&value| value > 65504.0));
}

#[test]
fn frames_are_looked_into() {
    let folder = tempfile::tempdir().unwrap();
    let capture = |name: &str, more: &[&str]| {
        let layers = ["--layers", "albedo,Z", "--float", "--reproducible"];
        let first = ["capture", "builtin:cornell", "--size", "32x16", "-o", name];
        stdout(&succeeds(&folder, &[&first[..], &layers, more].concat()));
        channels(&open(&folder, name))
    };
    let plain = capture("plain.exr", &[]);
    assert_eq!(capture("serialized.exr", &["--serialize"]), plain);
    let without = capture("without.exr", &["--without", "gbuffer", "--dump", "gbuffer:depth"]);
    assert_ne!(without, plain);
    let FlatSamples::F32(albedo) = &without["albedo.R"] else { panic!("{:?}", without["albedo.R"]) };
    assert!(albedo.iter().all(|value| *value == 0.0));

    // The depth that the pass leaves, as an array of 1 layer, 16 rows, 32 columns, 1 component.
    capture("dump.exr", &["--dump", "gbuffer:depth"]);
    let array = fs::read(folder.path().join("dump.gbuffer.depth.npy")).unwrap();
    let header = String::from_utf8_lossy(&array[10..128]).into_owned();
    assert!(header.contains("'<f4'") && header.contains("(1, 16, 32, 1)"), "{header}");
    let values = array[array.len() - 4 * 16 * 32..].chunks_exact(4);
    let depth: Vec<f32> = values.map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect();
    // Reversed depth: what is there is greater than 0, and farther where it is less.
    let FlatSamples::F32(distance) = &plain["Z"] else { panic!("{:?}", plain["Z"]) };
    for (depth, distance) in depth.iter().zip(distance) {
        assert_eq!(*depth > 0.0, distance.is_finite(), "{depth} at {distance} m");
    }
    assert!(depth.iter().any(|depth| *depth > 0.0));
    assert!(folder.path().join("without.gbuffer.depth.npy").exists());

    for (option, value, told) in [
        ("--without", "nothing", "pass `nothing`: there are"),
        ("--dump", "gbuffer", "it is PASS:RESOURCE"),
        ("--dump", "gbuffer:nothing", "resource `nothing`: there are"),
    ] {
        is_refused(&["capture", "builtin:cornell", "--size", "32x16", "-o", "out.exr", option, value], told);
    }
}

#[test]
fn graphs_are_printed() {
    let folder = tempfile::tempdir().unwrap();
    let dot = stdout(&succeeds(&folder, &["graph", "builtin:cornell", "--size", "64x36"]));
    assert!(dot.starts_with("digraph"), "{dot}");
    let json = stdout(&succeeds(&folder, &["graph", "builtin:cornell", "--size", "64x36", "--format", "json"]));
    let graph: serde_json::Value = serde_json::from_str(&json).unwrap();
    let names: Vec<_> = graph["steps"].as_array().unwrap().iter().map(|step| step["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"gbuffer") && names.contains(&"lighting"), "{names:?}");
    assert!(dot.contains("gbuffer"));
    let lines = stdout(&succeeds(&folder, &["graph", "builtin:cornell", "--size", "64x36", "--format", "text"]));
    assert!(lines.contains("gbuffer"), "{lines}");
}

#[test]
fn graphs_with_checkpoints_are_whole() {
    let folder = tempfile::tempdir().unwrap();
    let graph = |format: &str| {
        let options = ["--size", "64x36", "--transparency", "abuffer", "--layers", "color", "--format", format];
        stdout(&succeeds(&folder, &[&["graph", "builtin:courtyard"], &options[..]].concat()))
    };
    let text = graph("text");
    let (first, second) = text.split_once("--- after the checkpoint `abuffer.totals`").unwrap();
    assert!(first.contains("`abuffer.count`") && second.contains("`abuffer.fill`"), "{text}");
    assert_eq!(graph("dot").matches("digraph").count(), 2);
    let json: serde_json::Value = serde_json::from_str(&graph("json")).unwrap();
    assert_eq!(json["later"][0]["after"], "abuffer.totals");
}

#[test]
fn a_graph_is_written_as_a_page_with_times() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["graph", "builtin:cornell", "--size", "64x36", "--format", "html", "--times", "-o", "frame.html"];
    assert_eq!(stdout(&succeeds(&folder, &arguments)), "");
    let page = fs::read_to_string(folder.path().join("frame.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
    let report = page.split_once("id=\"report\">").unwrap().1.split_once("</script>").unwrap().0;
    let report: serde_json::Value = serde_json::from_str(report).unwrap();
    let passes = report["steps"].as_array().unwrap().iter().filter(|step| step["kind"] == "pass");
    let times: Vec<_> = passes.map(|step| step["milliseconds"].as_f64().unwrap()).collect();
    assert!(times.len() > 2 && times.iter().all(|&time| time > 0.0), "{times:?}");

    is_refused(&["graph", "builtin:cornell", "--size", "64x36", "--times"], "--times: these forms have no times");
    let missing = run(&folder, &["graph", "builtin:cornell", "--size", "64x36", "-o", "nowhere/frame.dot"]);
    assert!(!missing.status.success() && stderr(&missing).contains("nowhere"), "{}", stderr(&missing));
}

/// Bench, case and metric of each line that a benchmark prints.
fn metrics(name: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["bench", name, "--json", "--runs", "1", "--size", "64x36", "--scene", "builtin:cornell"];
    let printed = stdout(&succeeds(&folder, &arguments));
    let metric = |line: &str| {
        let figure: serde_json::Value = serde_json::from_str(line).unwrap();
        let object = figure.as_object().unwrap();
        assert_eq!(object.keys().collect::<Vec<_>>(), ["bench", "case", "metric", "unit", "value"]);
        assert!(object["value"].as_f64().unwrap() >= 0.0);
        ["bench", "case", "metric"].map(|key| object[key].as_str().unwrap().to_string()).join(" ")
    };
    printed.lines().map(metric).collect()
}

#[test]
fn benchmarks_print_one_object_a_line() {
    let metrics = [metrics("capture"), metrics("write")].concat();
    for phase in
        ["process start", "device", "loading", "first-draw compilation", "rendering", "read-back", "writing", "total"]
    {
        for case in ["cold", "warm"] {
            assert!(metrics.contains(&format!("capture {case} {phase}")), "{case} {phase}");
        }
    }
    assert!(metrics.contains(&"write zip time".to_string()) && metrics.contains(&"write none size".to_string()));
}

#[test]
#[ignore = "takes minutes"]
fn every_benchmark_runs() {
    for name in ["graph", "voxelize", "abuffer"] {
        assert!(metrics(name).len() > 10, "{name}");
    }
}

/// Usually 5 to 8 times, on a busy machine as well, since both take turns in one process. Loops that are not unrolled any
/// more, or registers that became memory, took it to 20 and more.
#[test]
fn the_a_buffer_is_not_much_slower_to_blending() {
    let folder = tempfile::tempdir().unwrap();
    if !stdout(&succeeds(&folder, &["info"])).contains("Mesa 22.3") {
        return println!("skipped: the bound is that of Mesa 22.3's lavapipe");
    }
    let case = "arrays 256x256x8";
    let printed = stdout(&succeeds(&folder, &["bench", "abuffer", "--case", case, "--runs", "3", "--json"]));
    let figures = printed.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    let wanted = |figure: &serde_json::Value| figure["case"] == case && figure["metric"] == "whole to blending";
    let times: Vec<_> = figures.filter(wanted).map(|figure| figure["value"].as_f64().unwrap()).collect();
    println!("{times:?} times blending");
    assert!(times.iter().any(|&times| times > 0.0 && times < 16.0), "{times:?} times blending");
}

#[test]
fn techniques_of_transparency_take_their_settings() {
    let folder = tempfile::tempdir().unwrap();
    let courtyard = ["capture", "builtin:courtyard", "--size", "64x36", "--layers", "color", "--validation"];
    let with = |more: &[&'static str]| {
        let file = ["-o", "out.exr", "--reproducible"];
        succeeds(&folder, &[&courtyard[..], more, &file].concat());
        fs::read(folder.path().join("out.exr")).unwrap()
    };
    for (kind, option, values) in [
        ("adaptive", "--kept", ["2", "8"]),
        ("kbuffer", "--kept", ["1", "4"]),
        ("stochastic", "--samples", ["2", "64"]),
        ("weighted", "--weight", ["7", "10"]),
    ] {
        let written = values.map(|value| with(&["--transparency", kind, option, value]));
        assert!(written[0] != written[1], "{option} changes nothing");
        let text = String::from_utf8_lossy(&written[0]).into_owned();
        assert!(text.contains(&format!("\"transparency_setting\":{}", values[0])), "{kind}");
        is_refused(
            &["capture", "builtin:cornell", "-o", "o.exr", option, values[0]],
            &format!("{option} belongs to --transparency"),
        );
    }
    is_refused(&["capture", "builtin:cornell", "-o", "o.exr", "--transparency", "kbuffer", "--kept", "33"], "1..=32");
}

#[test]
fn layers_come_in_bands_where_memory_is_short() {
    let folder = tempfile::tempdir().unwrap();
    let courtyard =
        ["capture", "builtin:courtyard", "--size", "640x360", "--layers", "color", "--transparency", "abuffer"];
    let with = |more: &[&'static str]| {
        succeeds(&folder, &[&courtyard[..], &["-o", "out.exr", "--reproducible", "--float"], more].concat());
        fs::read(folder.path().join("out.exr")).unwrap()
    };
    assert!(with(&[]) == with(&["--layer-memory", "1"]), "another picture");
}

#[test]
fn layers_of_the_abuffer_come_by_number() {
    let folder = tempfile::tempdir().unwrap();
    let courtyard = ["capture", "builtin:courtyard", "--size", "64x36", "--transparency", "abuffer", "-o", "out.exr"];
    let with = |layers: &str| {
        succeeds(&folder, &[&courtyard[..], &["--validation", "--reproducible", "--layers", layers]].concat());
        let file = fs::read(folder.path().join("out.exr")).unwrap();
        let header = String::from_utf8_lossy(&file[..file.len().min(1 << 16)]).into_owned();
        ["abuffer.0.R", "abuffer.2.A", "abuffer.2.Z", "abuffer.count"].map(|channel| header.contains(channel))
    };
    assert_eq!(with("abuffer.2"), [false, true, true, false]);
    assert_eq!(with("abuffer"), [false, false, false, true]);
    is_refused(&[&courtyard[..], &["--layers", "abuffer.256"]].concat(), "abuffer.0 to abuffer.255");
}

#[test]
fn glass_throws_coloured_shadows() {
    let folder = tempfile::tempdir().unwrap();
    let courtyard = ["capture", "builtin:courtyard", "--size", "64x36", "--layers", "transmittance", "--validation"];
    let deep = ["--deep-shadows", "256", "--transparency", "abuffer", "-o", "out.exr"];
    succeeds(&folder, &[&courtyard[..], &deep].concat());
    let file = fs::read(folder.path().join("out.exr")).unwrap();
    assert!(String::from_utf8_lossy(&file).contains("transmittance.sun.R"));
    // Without them there is no such layer.
    is_refused(
        &[&courtyard[..], &["-o", "o.exr"]].concat(),
        "no layer \"transmittance\" here: it comes with --deep-shadows",
    );
    is_refused(&["capture", "builtin:cornell", "-o", "o.exr", "--deep-shadows", "4096"], "1..=2048");
}

#[test]
fn deep_pictures_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["capture", "builtin:courtyard", "--deep", "deep.exr", "--size", "64x36", "--validation"];
    let output = succeeds(&folder, &arguments);
    assert!(stdout(&output).contains("wrote deep.exr"), "{output:?}");
    // OpenEXR's mark of data that is not flat.
    let file = fs::read(folder.path().join("deep.exr")).unwrap();
    assert_eq!(file[..8], [0x76, 0x2f, 0x31, 0x01, 0x02, 0x08, 0, 0]);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    is_refused(&["capture", "builtin:courtyard", "--deep", "deep.png"], "must end in .exr");
}

#[test]
fn voxels_are_written_with_what_they_mean() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["voxelize", "builtin:cornell", "--resolution", "32", "--validation", "-o", "room.npy", "--json"];
    let told: serde_json::Value = serde_json::from_str(&stdout(&succeeds(&folder, &arguments))).unwrap();
    let beside: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("room.json")).unwrap()).unwrap();
    assert_eq!((&told["set"], &told["min"]), (&beside["set"], &beside["min"]));
    let array = fs::read(folder.path().join("room.npy")).unwrap();
    let (header, bytes) = array.split_at(array.len() - 32 * 32 * 32);
    assert!(String::from_utf8_lossy(header).contains("(32, 32, 32)"));
    let set = bytes.iter().filter(|&&byte| byte == 1).count();
    assert!(set > 0 && bytes.iter().all(|&byte| byte <= 1));
    assert_eq!(beside["set"], set);

    // The built-in room is open to the front, and its bounds are known.
    assert!(!beside["open_meshes"].as_array().unwrap().is_empty());
    let grid = ["--resolution", "8,4,2", "--min", "-1,0,-1", "--edge", "2", "-o", "part.npy"];
    let output = succeeds(&folder, &[&["voxelize", "builtin:cornell"], &grid[..]].concat());
    assert!(stdout(&output).contains("8×4×2") && stderr(&output).contains("is not closed"), "{output:?}");

    // The name says the format.
    for name in ["part.packed.npy", "part.sparse.npy", "part.binvox", "part.vox", "part.exr", "part.glb", "part.png"] {
        succeeds(&folder, &["voxelize", "builtin:cornell", "--resolution", "16", "-o", name]);
        assert!(fs::metadata(folder.path().join(name)).unwrap().len() > 0);
    }
    let shown = ["capture", "part.glb", "-o", "shown.exr", "--size", "16x16"];
    succeeds(&folder, &shown);

    // Colours of surfaces, and a vote where they have holes.
    for name in ["colors.vox", "colors.exr", "colors.sparse.npy"] {
        let surface = ["voxelize", "builtin:cornell", "--method", "conservative", "--resolution", "16"];
        succeeds(&folder, &[&surface[..], &["--attributes", "-o", name]].concat());
    }
    let vote = ["voxelize", "builtin:cornell", "--resolution", "16", "--vote", "-o", "vote.npy", "--json"];
    let output = succeeds(&folder, &vote);
    let told: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    let leaks = told["leaks"].as_array().unwrap();
    assert!(leaks.len() == 3 && leaks.iter().any(|count| count.as_u64() > Some(0)) && told["axis"] == "vote", "{told}");
    assert!(stderr(&output).contains("vote of three axes"));
    let refused = |more: &[&'static str], why| is_refused(&[&["voxelize", "builtin:cornell"], more].concat(), why);
    refused(&["--attributes", "-o", "o.npy"], ".vox, .exr and .sparse.npy");
    refused(&["--vote", "--method", "conservative", "-o", "o.npy"], "bitmask, stencil and winding");
    refused(&["--vote", "--axis", "x", "-o", "o.npy"], "cannot be used with");

    // More than fit as a whole.
    let fine = ["voxelize", "builtin:cornell", "--method", "six-separating", "--resolution", "1100,40,30"];
    let place = ["--min", "-1,0,-1", "--edge", "2", "-o", "fine.vox"];
    assert!(stdout(&succeeds(&folder, &[&fine[..], &place].concat())).contains("1100×40×30"));
    let colors = [&fine[..], &["--min", "-1,0,-1", "--edge", "2", "--attributes", "-o", "fine.sparse.npy"]].concat();
    succeeds(&folder, &colors);
    refused(&["--method", "conservative", "--resolution", "1024", "--attributes", "-o", "o.exr"], ".sparse.npy");
    refused(&["--resolution", "2048", "-o", "o.vox"], "for surfaces");
    refused(&["--resolution", "2048", "--method", "conservative", "-o", "o.npy"], ".packed.npy");

    // What a camera sees.
    let seen = ["voxelize", "builtin:cornell", "--camera", "front", "--resolution", "40,30,20", "--json"];
    for fill in ["--solid", "--surface"] {
        let output = succeeds(&folder, &[&seen[..], &[fill, "-o", "seen.npy"]].concat());
        let told: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
        assert_eq!((&told["camera"], &told["resolution"]), (&"front".into(), &serde_json::json!([40, 30, 20])));
        assert!(told["near"].as_f64() < told["far"].as_f64() && told["set"].as_u64() > Some(0), "{told}");
    }
    refused(&["--camera", "nobody", "-o", "o.npy"], "0 (front)");
    refused(&["--camera", "front", "-o", "o.vox"], "no cubes");
    refused(&["--camera", "front", "--method", "winding", "-o", "o.npy"], "--method bitmask");
    refused(&["--surface", "--method", "winding", "-o", "o.npy"], "--method bitmask, conservative");
    refused(&["--solid", "--method", "conservative", "-o", "o.npy"], "bitmask, stencil and winding");

    // Surfaces need not be closed.
    let surface = ["voxelize", "builtin:cornell", "--method", "conservative", "--resolution", "16", "-o", "walls.npy"];
    assert_eq!(stderr(&succeeds(&folder, &surface)).matches("warn").count(), 0);

    // Solids by every method.
    for method in ["bitmask", "stencil", "winding"] {
        let solid = ["voxelize", "builtin:cornell", "--method", method, "--resolution", "16", "-o", "solid.npy"];
        assert!(stdout(&succeeds(&folder, &solid)).contains("16×16×16"));
    }
    let winding = ["voxelize", "builtin:cornell", "--method", "winding", "--rule", "even-odd", "-o", "odd.npy"];
    succeeds(&folder, &winding);
    let beside: serde_json::Value = serde_json::from_slice(&fs::read(folder.path().join("odd.json")).unwrap()).unwrap();
    assert_eq!((&beside["method"], &beside["rule"]), (&"winding".into(), &"even-odd".into()));
    is_refused(&["voxelize", "builtin:cornell", "--rule", "even-odd", "-o", "odd.npy"], "--method winding");

    let voxelize = |more: &[&'static str]| [&["voxelize", "builtin:cornell", "-o", "o.npy"], more].concat();
    is_refused(&voxelize(&["--resolution", "0"]), "1 to 2048");
    is_refused(&voxelize(&["--resolution", "8,8,8,8"]), "64,32,64");
    is_refused(&voxelize(&["--resolution", "8,4,2"]), "--min and --edge");
    is_refused(&voxelize(&["--min", "0,0,0"]), "--edge");
    is_refused(&voxelize(&["--min", "0,0,0", "--edge", "-1"]), "greater than 0");
    is_refused(&["voxelize", "builtin:cornell", "-o", "o.obj"], ".npy, .packed.npy, .sparse.npy");
    is_refused(&["voxelize", "builtin:cornell", "-o", "no/o.npy"], "no such folder");
}

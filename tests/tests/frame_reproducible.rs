//! The same scene gives the same file, and leaves nothing behind.
#![allow(missing_docs, clippy::unwrap_used)]

use std::path::Path;

use shadowgraph::capture::{ExrOptions, FrameCapture, write_exr};
use shadowgraph::frame::FrameSettings;
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph_tests::device::isolated_device;
use shadowgraph_tests::exr_file::ExrFile;
use shadowgraph_tests::render::Subject;

/// Captures all layers into a file.
fn write(gpu: &Gpu, subject: &Subject, reproducible: bool, exposure: f32, path: &Path) {
    let view = subject.view();
    let mut settings = FrameSettings::new(view);
    settings.cascaded.resolution = 512;
    let scene = subject.scene.clone().upload(gpu).unwrap();
    let mut graph = Graph::new("frame", gpu.caps());
    let frame = settings.record(&mut graph, &scene);
    let plan = graph.compile(gpu).unwrap();
    let executed = Executor::new(gpu).execute(&plan, graph).unwrap();
    let request = FrameCapture {
        scene: &subject.scene,
        camera: &subject.camera,
        view: &view,
        caps: gpu.caps(),
        settings: &(),
        float: false,
        exposure,
        reproducible,
    };
    let captured = request.collect(&frame, &executed).unwrap();
    write_exr(path, &captured.capture, &ExrOptions::default()).unwrap();
}

#[test]
fn portable_two_reproducible_captures_are_the_same_bytes() {
    isolated_device("portable_two_reproducible_captures_are_the_same_bytes", |gpu| {
        let folder = tempfile::tempdir().unwrap();
        for name in ["cornell", "courtyard"] {
            let subject = Subject::builtin(name, [320, 180]);
            let bytes = ["a", "b"].map(|file| {
                let path = folder.path().join(file);
                write(gpu, &subject, true, 1e-4, &path);
                std::fs::read(path).unwrap()
            });
            assert!(bytes[0] == bytes[1], "{name}: {} and {} bytes that differ", bytes[0].len(), bytes[1].len());
            println!("{name}: twice the same {} bytes", bytes[0].len());
        }
    });
}

#[test]
fn two_captures_have_the_same_pixels_and_say_how_long_they_took() {
    isolated_device("two_captures_have_the_same_pixels_and_say_how_long_they_took", |gpu| {
        let folder = tempfile::tempdir().unwrap();
        let subject = Subject::builtin("courtyard", [320, 180]);
        let [a, b] = ["a", "b"].map(|file| {
            let path = folder.path().join(file);
            write(gpu, &subject, false, 1e-4, &path);
            ExrFile::read(&path)
        });
        assert!(a.parts.len() > 4, "frame and maps: {} parts", a.parts.len());
        assert_eq!(a.parts.len(), b.parts.len());
        for (a, b) in a.parts.iter().zip(&b.parts) {
            assert_eq!((&a.name, a.size), (&b.name, b.size));
            let names = |channels: &std::collections::BTreeMap<_, _>| channels.keys().cloned().collect::<Vec<String>>();
            assert_eq!(names(&a.channels), names(&b.channels));
            for (name, channel) in &a.channels {
                assert!(*channel == b.channels[name], "{}: {name} differs", a.name);
            }
        }
        let timed = a.parts[0].texts.contains_key("shadowgraph/passes");
        assert!(timed, "no times among {:?}", a.parts[0].texts.keys());
    });
}

#[test]
fn exposure_scales_radiance_alone() {
    isolated_device("exposure_scales_radiance_alone", |gpu| {
        let folder = tempfile::tempdir().unwrap();
        let subject = Subject::builtin("cornell", [160, 90]);
        let [once, twice] = [1e-4, 2e-4].map(|exposure| {
            let path = folder.path().join("exposed");
            write(gpu, &subject, true, exposure, &path);
            ExrFile::read(&path).parts.remove(0)
        });
        let mut scaled = 0;
        for (name, channel) in &once.channels {
            let radiance = ["R", "G", "B"].contains(&name.as_str())
                || ["direct.", "emissive."].iter().any(|layer| name.starts_with(layer));
            if !radiance {
                assert!(*channel == twice.channels[name], "{name} changed");
                continue;
            }
            // Half-floats keep 11 bits, fewer near 0.
            for (once, twice) in once.floats(name).iter().zip(twice.floats(name)) {
                assert!((2.0 * once - twice).abs() <= 1e-3 * twice + 1e-7, "{name}: {once}, then {twice}");
                scaled += usize::from(*twice > 0.0);
            }
        }
        assert!(scaled > 10_000, "{scaled} samples of radiance");
    });
}

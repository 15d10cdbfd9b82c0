//! Deep OpenEXR files, read and flattened by OpenEXR's own library.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use shadowgraph::capture::{DeepPicture, DeepSample, Metadata, Value, write_deep_exr};
use shadowgraph::frame::{FrameSettings, Selection};
use shadowgraph::scene::Scene;
use shadowgraph::techniques::surface::gbuffer::Precision;
use shadowgraph_tests::device;
use shadowgraph_tests::harness::{require_scene, skip};
use shadowgraph_tests::render::Subject;

/// The program of `openexr/read_deep.cpp`; none where it cannot be built.
static READER: LazyLock<Option<PathBuf>> = LazyLock::new(|| {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("openexr/read_deep.cpp");
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("read_deep");
    let mut compile = Command::new("g++");
    compile.args(["-O1", "-I/usr/include/OpenEXR", "-I/usr/include/Imath"]).arg(source).arg("-o").arg(&program);
    let built = compile.args(["-lOpenEXR", "-lIex", "-lImath"]).output();
    let why = match built {
        Ok(built) if built.status.success() => return Some(program),
        Ok(built) => String::from_utf8_lossy(&built.stderr).lines().next().unwrap_or_default().to_owned(),
        Err(error) => error.to_string(),
    };
    assert!(std::env::var_os("SHADOWGRAPH_CI").is_none_or(|value| value != "1"), "OpenEXR's library: {why}");
    skip(&format!("no OpenEXR library (Debian: libopenexr-dev): {why}"));
    None
});

/// What a file holds, as the library reads it, and the picture it makes of that; none where there is no library.
fn read(path: &Path) -> Option<(DeepPicture, Vec<[f32; 4]>)> {
    let program = READER.as_ref()?;
    let out = path.with_extension("bin");
    let done = Command::new(program).arg(path).arg(&out).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let bytes = std::fs::read(out).unwrap();
    let words: Vec<u32> = bytes.as_chunks().0.iter().map(|&word| u32::from_le_bytes(word)).collect();
    let size = [words[0], words[1]];
    let pixels = (size[0] * size[1]) as usize;
    let (counts, rest) = words[2..].split_at(pixels);
    let total = counts.iter().sum::<u32>() as usize;
    let value = |channel: usize, sample: usize| f32::from_bits(rest[channel * total + sample]);
    let sample =
        |i: usize| DeepSample { depth: value(4, i), color: [value(3, i), value(2, i), value(1, i), value(0, i)] };
    let samples = (0..total).map(sample).collect();
    let flat = rest[5 * total..].as_chunks::<4>().0.iter().map(|pixel| pixel.map(f32::from_bits)).collect();
    Some((DeepPicture { size, counts: counts.to_vec(), samples, metadata: Metadata::default() }, flat))
}

fn write(picture: &DeepPicture) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep.exr");
    write_deep_exr(&path, picture).unwrap();
    (folder, path)
}

/// Numbers without a pattern, which do not compress, and long lists of equal ones, which do.
fn made_up(size: [u32; 2], count: impl Fn(usize) -> u32) -> DeepPicture {
    let counts: Vec<u32> = (0..(size[0] * size[1]) as usize).map(count).collect();
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 9) as f32 / (1 << 23) as f32
    };
    let mut samples = Vec::new();
    for (pixel, &count) in counts.iter().enumerate() {
        for index in 0..count {
            let depth = 1.0 + index as f32 + if pixel % 3 == 0 { random() } else { 0.5 };
            let color = if pixel % 3 == 0 { [random(), random(), random(), random()] } else { [0.25, 0.5, 0.125, 0.5] };
            samples.push(DeepSample { depth, color });
        }
    }
    DeepPicture { size, counts, samples, metadata: Metadata::default() }
}

#[test]
fn openexr_reads_every_sample() {
    let pictures = [
        made_up([1, 1], |_| 1),
        made_up([1, 1], |_| 0),
        made_up([7, 5], |pixel| (pixel % 4) as u32),
        made_up([3, 600], |pixel| u32::from(pixel % 5 == 0)),
        made_up([40, 3], |pixel| if pixel == 41 { 70_000 } else { 2 }),
    ];
    for picture in pictures {
        let (_folder, path) = write(&picture);
        let Some((found, flat)) = read(&path) else { return };
        assert!(found == picture, "{:?}", picture.size);
        assert_eq!(flat.len(), picture.counts.len());
    }
}

#[test]
fn equal_pictures_are_equal_files_with_their_facts() {
    let mut picture = made_up([5, 4], |pixel| pixel as u32);
    picture.metadata.add("shadowgraph/exposure", Value::F32(0.5));
    let bytes = || {
        let (_folder, path) = write(&picture);
        std::fs::read(path).unwrap()
    };
    let (first, second) = (bytes(), bytes());
    assert!(first == second && first.windows(20).any(|bytes| bytes == b"shadowgraph/exposure"));
}

#[test]
fn pictures_that_cannot_be_are_refused() {
    let good = made_up([5, 4], |pixel| pixel as u32);
    let refused = |change: &dyn Fn(&mut DeepPicture), why: &str| {
        let mut picture = good.clone();
        change(&mut picture);
        let folder = tempfile::tempdir().unwrap();
        let error = write_deep_exr(&folder.path().join("deep.exr"), &picture).unwrap_err().to_string();
        assert!(error.contains(why), "{error}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    };
    refused(&|picture| picture.size = [0, 4], "must lie in 1");
    refused(&|picture| picture.size = [4, 4], "20 counts for 4×4");
    refused(&|picture| picture.samples.truncate(189), "189 samples where the counts say 190");
    refused(&|picture| picture.counts[3] = u32::MAX, "2 GiB");
    refused(&|picture| picture.metadata.add("channels", Value::I32(1)), "meaning of its own");
    refused(&|picture| picture.metadata.add("version", Value::I32(1)), "meaning of its own");
}

/// Flattened, a deep picture is the frame's picture, however finely layers are stored.
fn flattens_to_the_picture(scene: Scene, least: usize) {
    let subject = Subject::new(scene, [160, 90]);
    for precision in [Precision::Compact, Precision::Float] {
        flattens(&subject, precision, least);
    }
}

fn flattens(subject: &Subject, precision: Precision, least: usize) {
    let (deep, frame) = subject.capture_deep(device::shared(), |settings: &mut FrameSettings| {
        settings.precision = precision;
        settings.layers = Selection::Only(["color", "Z", "abuffer"].map(Into::into).to_vec());
    });
    let (_folder, path) = write(&deep);
    let Some((found, flat)) = read(&path) else { return };
    assert_eq!((&found.counts, &found.samples), (&deep.counts, &deep.samples));
    assert!(deep.samples.len() > least, "{} samples", deep.samples.len());
    let channel = |name: &str| frame.parts[0].floats(name);
    let color = ["R", "G", "B", "A"].map(channel);
    let (z, layers, front) = (channel("Z"), channel("abuffer.count"), channel("abuffer.front.Z"));
    let mut samples = &deep.samples[..];
    for (pixel, &count) in deep.counts.iter().enumerate() {
        let (own, rest) = samples.split_at(count as usize);
        samples = rest;
        // As many as the device counted, near to far, the opaque surface last.
        assert_eq!(count, layers[pixel] as u32 + u32::from(z[pixel].is_finite()));
        assert!(own.is_sorted_by(|a, b| a.depth <= b.depth), "pixel {pixel}: {own:?}");
        if z[pixel].is_finite() {
            assert_eq!(own.last().map(|sample| (sample.depth, sample.color[3])), Some((z[pixel], 1.0)));
        }
        if layers[pixel] > 0.0 {
            assert!((own[0].depth - front[pixel]).abs() <= 1e-5 * front[pixel], "{} {}", own[0].depth, front[pixel]);
        }
        for (component, plane) in color.iter().enumerate() {
            let (found, wanted) = (flat[pixel][component], plane[pixel]);
            assert!((found - wanted).abs() <= 1e-5 * wanted.abs() + 1e-6, "pixel {pixel}: {found}, not {wanted}");
        }
    }
}

#[test]
fn flattened_courtyards_are_their_pictures() {
    flattens_to_the_picture(Scene::builtin("courtyard").unwrap(), 160 * 60);
}

#[test]
fn flattened_glass_is_its_picture() {
    for name in ["LayeredGlass", "GlassTable"] {
        let end = if name == "GlassTable" { "glb" } else { "gltf" };
        let Some(path) = require_scene(&format!("{name}/{name}.{end}")) else { return };
        flattens_to_the_picture(Scene::load(path).unwrap(), 1000);
    }
}

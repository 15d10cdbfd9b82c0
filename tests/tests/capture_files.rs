//! PNG, NPY, half-floats, texels, and the promise that a file appears whole or not at all.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use ash::vk;
use half::f16;
use proptest::prelude::*;
use shadowgraph::capture::{
    HalfReport, PngOptions, Samples, ToneMap, auto_exposure, to_half, unpack, write_atomically, write_npy, write_png,
};

fn names(folder: &Path) -> Vec<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn a_failed_write_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.bin");
    let fail = |file: &mut io::BufWriter<fs::File>| {
        file.write_all(&vec![1; 1 << 20])?;
        Err(io::Error::other("injected"))
    };
    let error = write_atomically(&path, fail).unwrap_err().to_string();
    assert!(error.contains("x.bin") && error.contains("injected"), "{error}");
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn a_failed_write_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.bin");
    write_atomically(&path, |file| file.write_all(b"old")).unwrap();
    write_atomically(&path, |_| Err(io::Error::other("injected"))).unwrap_err();
    assert_eq!(fs::read(&path).unwrap(), b"old");
    // While a new one is being written the old one is still whole.
    write_atomically(&path, |file| {
        file.write_all(b"new")?;
        file.flush()?;
        assert_eq!(fs::read(&path)?, b"old");
        Ok(())
    })
    .unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
    assert_eq!(names(folder.path()), ["x.bin"]);
}

#[test]
fn a_panic_while_writing_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.bin");
    let panicked = std::panic::catch_unwind(|| write_atomically(&path, |_| panic!("injected")));
    assert!(panicked.is_err());
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn places_that_take_no_file_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), b"").unwrap();
    fs::create_dir(folder.path().join("folder")).unwrap();
    for bad in ["missing/x.exr", "file/x.exr", "folder", "", ".."] {
        let path = if bad.is_empty() { Path::new("").to_path_buf() } else { folder.path().join(bad) };
        let mut ran = false;
        let result = write_atomically(&path, |_| {
            ran = true;
            Ok(())
        });
        assert!(result.is_err() && !ran, "{bad:?}");
    }
    let mut left = names(folder.path());
    left.sort();
    assert_eq!(left, ["file", "folder"]);
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_devices_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (real, link) = (folder.path().join("real"), folder.path().join("link"));
    fs::write(&real, b"old").unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    write_atomically(&link, |file| file.write_all(b"new")).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read(&real).unwrap(), b"new");
    let error = write_atomically(Path::new("/dev/null"), |_| Ok(())).unwrap_err().to_string();
    assert!(error.contains("no regular file"), "{error}");
}

#[test]
fn names_may_be_as_long_as_the_system_allows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ä".repeat(127));
    write_atomically(&path, |file| file.write_all(b"x")).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"x");
}

#[test]
fn npy_has_the_documented_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.npy");
    let header = |bytes: &[u8]| {
        assert_eq!(bytes[..8], *b"\x93NUMPY\x01\x00");
        let end = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!(end % 64, 0, "data begins at a multiple of 64");
        assert_eq!(bytes[end - 1], b'\n');
        (String::from_utf8(bytes[10..end].to_vec()).unwrap().trim_end().to_string(), bytes[end..].to_vec())
    };
    write_npy(&path, &[2, 3], &[0.5_f32, -1.0, 2.0, f32::INFINITY, 4.0, 5.0]).unwrap();
    let (text, data) = header(&fs::read(&path).unwrap());
    assert_eq!(text, "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }");
    assert_eq!(data.len(), 24);
    assert_eq!(data[..8], [0, 0, 0, 0x3f, 0, 0, 0x80, 0xbf]);
    write_npy(&path, &[3], &[1_u8, 2, 3]).unwrap();
    let (text, data) = header(&fs::read(&path).unwrap());
    assert_eq!(text, "{'descr': '|u1', 'fortran_order': False, 'shape': (3,), }");
    assert_eq!(data, [1, 2, 3]);
    write_npy(&path, &[], &[0x0102_0304_u32]).unwrap();
    let (text, data) = header(&fs::read(&path).unwrap());
    assert_eq!(text, "{'descr': '<u4', 'fortran_order': False, 'shape': (), }");
    assert_eq!(data, [4, 3, 2, 1]);
    // Headers of every length are padded.
    for axes in 1..20 {
        write_npy(&path, &vec![1; axes], &[1_u8]).unwrap();
        header(&fs::read(&path).unwrap());
    }
}

#[test]
fn npy_refuses_a_shape_that_does_not_fit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.npy");
    for shape in [vec![5], vec![2, 2], vec![usize::MAX, 2]] {
        let error = write_npy(&path, &shape, &[1_u8, 2, 3]).unwrap_err().to_string();
        assert!(error.contains("number of values, 3"), "{error}");
    }
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn halves_are_clamped_and_counted() {
    let values =
        [0.0, -0.0, 1.0, 65504.0, 65504.1, 65520.0, 1e9, -1e9, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1e-9];
    let (halves, report) = to_half(&values);
    let expected = [0.0, -0.0, 1.0, 65504.0, 65504.0, 65504.0, 65504.0, -65504.0, 65504.0, -65504.0];
    for (half, expected) in halves.iter().zip(expected) {
        assert_eq!(half.to_bits(), f16::from_f32(expected).to_bits());
    }
    assert!(halves[10].is_nan());
    assert_eq!(halves[11], f16::ZERO);
    // The least f32 above 65504 counts, 65504 does not.
    assert_eq!(report, HalfReport { clamped: 6, not_a_number: 1 });
    assert_eq!(to_half(&[65504.0_f32.next_up()]).1.clamped, 1);
}

proptest! {
    /// Against the crate's conversion of single values, over blocks and their remainders.
    #[test]
    fn halves_agree_with_scalar_conversion(values in prop::collection::vec(any::<f32>(), 0..3000)) {
        let (halves, report) = to_half(&values);
        let mut expected = HalfReport::default();
        for (half, value) in halves.iter().zip(&values) {
            if value.is_nan() {
                expected.not_a_number += 1;
                prop_assert!(half.is_nan());
            } else if value.abs() > 65504.0 {
                expected.clamped += 1;
                prop_assert_eq!(half.to_f32(), 65504.0_f32.copysign(*value));
            } else {
                prop_assert_eq!(half.to_bits(), f16::from_f32(*value).to_bits());
            }
        }
        prop_assert_eq!(halves.len(), values.len());
        prop_assert_eq!(report, expected);
    }
}

#[test]
fn samples_narrow_only_floats() {
    let ids = Samples::U32(vec![70_000]);
    assert_eq!(ids.clone().into_half(), (ids, HalfReport::default()));
    let (narrow, report) = Samples::F32(vec![70_000.0]).into_half();
    assert_eq!((narrow, report.clamped), (Samples::F16(vec![f16::MAX]), 1));
    // What the device had to store as infinite counts too.
    let stored = Samples::F16(vec![f16::NEG_INFINITY, f16::ONE, f16::INFINITY, f16::NAN]);
    let (clamped, report) = stored.clone().into_half();
    let Samples::F16(values) = clamped else { panic!() };
    assert_eq!(values[..3], [f16::MIN, f16::ONE, f16::MAX]);
    assert_eq!(report, HalfReport { clamped: 2, not_a_number: 1 });
    assert_eq!(stored.into_f32()[..3], [f32::NEG_INFINITY, 1.0, f32::INFINITY]);
    assert_eq!(Samples::U32(vec![3]).into_float(), Samples::U32(vec![3]));
    assert_eq!(Samples::F16(vec![f16::ONE]).into_float(), Samples::F32(vec![1.0]));
}

#[test]
fn png_has_known_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.png");
    let pixels = [
        [0.0, 0.5, 1.0, 1.0],
        [2.0, -1.0, f32::NAN, 1.0],
        [0.214_041, 0.003, f32::INFINITY, 0.0],
        [0.25, 0.25, 0.25, 0.5],
    ];
    write_png(&path, [2, 2], &pixels, &PngOptions { exposure: 1.0, tone_map: ToneMap::Clip }).unwrap();
    let read = image::open(&path).unwrap();
    assert_eq!(read.color(), image::ColorType::Rgb8);
    // sRGB of 0.5 is 187.5 and of 0.25 is 136.96 in 255ths (IEC 61966-2-1).
    let expected: [u8; 12] = [0, 188, 255, 255, 0, 0, 127, 10, 255, 137, 137, 137];
    for (got, expected) in read.to_rgb8().as_raw().iter().zip(expected) {
        assert!(got.abs_diff(expected) <= 1, "{:?}", read.to_rgb8().as_raw());
    }
    // Exposure is a plain factor.
    let quarter: Vec<_> = pixels.iter().map(|pixel| pixel.map(|c| c / 4.0)).collect();
    let brighter = folder.path().join("brighter.png");
    write_png(&brighter, [2, 2], &quarter, &PngOptions { exposure: 4.0, tone_map: ToneMap::Clip }).unwrap();
    assert_eq!(fs::read(&path).unwrap(), fs::read(brighter).unwrap());
}

#[test]
fn png_refuses_what_is_no_picture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.png");
    let pixels = [[0.0; 4]; 4];
    for size in [[0, 0], [3, 1], [5, 1]] {
        assert!(write_png(&path, size, &pixels, &PngOptions::default()).is_err(), "{size:?}");
    }
    for exposure in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let options = PngOptions { exposure, ..PngOptions::default() };
        assert!(write_png(&path, [2, 2], &pixels, &options).is_err(), "{exposure}");
    }
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn the_neutral_curve_keeps_its_promises() {
    let neutral = |color| ToneMap::Neutral.apply(color);
    // Greys between the toe and the shoulder only lose the Fresnel offset of 0.04.
    for grey in [0.08, 0.2, 0.5, 0.79] {
        assert!((neutral([grey; 3])[0] - (grey - 0.04)).abs() < 1e-6, "{grey}");
    }
    // It rises and stays within [0, 1].
    let mut last = -1.0;
    for step in 0..4000 {
        let [red, green, blue] = neutral([step as f32 * 0.01, step as f32 * 0.005, 0.0]);
        assert!(red > last && red <= 1.0 && (0.0..=1.0).contains(&green) && (0.0..=1.0).contains(&blue), "{step}");
        last = red;
    }
    // Very bright colours turn white; the greatest does not become something else.
    for bright in [1e6, f32::MAX, f32::INFINITY] {
        let [red, green, blue] = neutral([bright, bright * 0.5, 0.0]);
        assert!(red > 0.99 && green > 0.95 && blue > 0.95, "{bright}: {red} {green} {blue}");
    }
}

#[test]
fn auto_exposure_brings_grey_to_middle_grey() {
    let grey = |value: f32| vec![[value, value, value, 1.0]; 100];
    assert!((auto_exposure(&grey(1000.0)) - 0.000_18).abs() < 1e-9);
    assert_eq!(auto_exposure(&grey(0.0)), 1.0);
    assert_eq!(auto_exposure(&[]), 1.0);
    // Background and what is not finite do not count.
    let mut pixels = grey(2.0);
    pixels.extend([[1e9, 1e9, 1e9, 0.0], [f32::NAN, 0.0, 0.0, 1.0], [f32::INFINITY, 1.0, 1.0, 1.0]]);
    assert!((auto_exposure(&pixels) - 0.09).abs() < 1e-6);
}

#[test]
fn texels_are_taken_apart() {
    use vk::Format as F;
    let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>();
    let rgba = unpack(F::R32G32B32A32_SFLOAT, &floats(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0])).unwrap();
    assert_eq!(rgba[0], Samples::F32(vec![1.0, 5.0]));
    assert_eq!(rgba[3], Samples::F32(vec![4.0, 8.0]));
    assert_eq!(unpack(F::D32_SFLOAT, &floats(&[0.5])).unwrap(), [Samples::F32(vec![0.5])]);
    let half = [f16::from_f32(1.5).to_le_bytes(), f16::from_f32(-2.0).to_le_bytes()].concat();
    let expected = [Samples::F16(vec![f16::from_f32(1.5)]), Samples::F16(vec![f16::from_f32(-2.0)])];
    assert_eq!(unpack(F::R16G16_SFLOAT, &half).unwrap(), expected);
    let ids = [7_u32.to_le_bytes(), 9_u32.to_le_bytes()].concat();
    assert_eq!(unpack(F::R32G32_UINT, &ids).unwrap(), [Samples::U32(vec![7]), Samples::U32(vec![9])]);
    assert_eq!(unpack(F::R8_UINT, &[3, 4]).unwrap(), [Samples::U32(vec![3, 4])]);
    assert_eq!(unpack(F::R8G8B8A8_UNORM, &[0, 51, 255, 102]).unwrap()[1], Samples::F32(vec![0.2]));
    let srgb = unpack(F::R8G8B8A8_SRGB, &[0, 188, 255, 128]).unwrap();
    let value = |index: usize| if let Samples::F32(values) = &srgb[index] { values[0] } else { panic!() };
    assert!((value(1) - 0.5029).abs() < 1e-4 && value(2) == 1.0, "{}", value(1));
    assert_eq!(value(3), 128.0 / 255.0, "alpha is linear");
    assert_eq!(unpack(F::D16_UNORM, &[0xff, 0xff]).unwrap(), [Samples::F32(vec![1.0])]);
    assert!(unpack(F::R32G32_UINT, &[0; 12]).unwrap_err().to_string().contains("12 bytes"));
    assert!(unpack(F::BC7_SRGB_BLOCK, &[0; 16]).unwrap_err().to_string().contains("BC7_SRGB_BLOCK"));
}

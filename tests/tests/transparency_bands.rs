//! The A-buffer band by band: the same picture within a budget of memory.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::DVec4;
use shadowgraph::techniques::transparency::abuffer::{ABuffer, NodeFormat};
use shadowgraph_tests::compare::Comparison;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{Check, Figure};
use shadowgraph_tests::soup::{Kitchen, Soup, background};
use shadowgraph_tests::twin::layers::{Fragment, composite};

/// Bytes of compact nodes, and of what long lists are sorted in.
fn bytes(nodes: u32, longest: u32) -> u64 {
    u64::from(nodes) * if longest > 16 { 48 } else { 16 }
}

/// Band by band of the picture's rows it is the same picture, in as little memory as is allowed: as many parts of what the
/// whole needs.
fn is_the_same(soup: Soup, parts: &[u64]) {
    let soup = soup.on_grid(shared().caps().limits.sub_pixel_bits);
    let mut kitchen = Kitchen::new(shared(), &soup);
    let of = |memory, bands| ABuffer { memory, bands, ..ABuffer::default() };
    let whole = kitchen.run(ABuffer::default(), false).unwrap();
    let needed = bytes(whole.nodes, whole.longest);
    for memory in parts.iter().map(|part| needed / part) {
        assert!(kitchen.run(of(memory, 24), false).unwrap() == whole, "{memory} of {needed} bytes");
    }
    // Too few bands, or a budget that does not hold a row: what the error says is enough, a byte less is not.
    for (memory, bands) in [(needed / 5, 3), (100, 24)] {
        let said = kitchen.run(of(memory, bands), false).unwrap_err().to_string();
        let advice = said.strip_suffix(" would do").and_then(|said| said.rsplit(' ').next()).unwrap();
        let memory = advice.parse().unwrap();
        assert!(kitchen.run(of(memory, bands), false).unwrap() == whole, "{said}");
        assert!(kitchen.run(of(memory - 1, bands), false).is_err(), "{said}");
    }
    silent(shared());
}

#[test]
fn portable_transparency_bands_make_the_same_picture() {
    is_the_same(Soup::random(4, [16, 32], 10, 64), &[5]);
}

#[test]
fn transparency_bands_make_the_same_picture_of_any_height() {
    is_the_same(Soup::random(3, [32, 64], 40, 12), &[1, 2, 5, 11]);
    is_the_same(Soup::random(19, [64, 128], 9, 0), &[1, 3, 11]);
}

/// Every pixel of layers over the whole picture, exactly, within a budget.
fn fits(soup: &Soup, memory: u64) -> Figure {
    let mut kitchen = Kitchen::new(shared(), soup);
    let format = NodeFormat::Float;
    let found = kitchen.run(ABuffer { format, memory, bands: 64, ..ABuffer::default() }, false).unwrap();
    let layers = soup.triangles.len() as u32 / 2;
    let behind = Soup { size: [2, 1], ..soup.clone() };
    let here = |fragments: &[Fragment]| composite(fragments, background());
    // Every pixel of a half has the same layers.
    let expected = behind.fragments().iter().map(|fragments| here(fragments)).collect::<Vec<_>>();
    let mut comparison = Comparison::new(format!("{} in {} MiB", soup.name, memory >> 20), soup.size, 1e-5);
    for (i, color) in found.color.iter().enumerate() {
        assert_eq!(found.count[i], layers as f32);
        let right = (i as u32 % soup.size[0]) >= soup.size[0] / 2;
        comparison.error(i, (DVec4::from(color.map(f64::from)) - expected[usize::from(right)]).abs().max_element());
    }
    // Counts, cursors and lists of pixels come on top: 64 bytes a pixel.
    let pixels = u64::from(soup.size[0]) * u64::from(soup.size[1]);
    let spare = 64 * pixels + (8 << 20);
    assert!(kitchen.memory <= memory + spare, "{} bytes of {memory} + {spare}", kitchen.memory);
    assert_eq!(found.report, [0; 3]);
    silent(shared());
    Check::new(comparison, 1.0, 0.0).demand()
}

/// 10,000 layers over the whole picture: 1.3 GB of nodes alone, in 80 MiB.
#[test]
fn transparency_bands_hold_10_000_full_screen_layers() {
    fits(&Soup::full_screen(20, [64, 64], 10_000, 1e-3), 80 << 20);
}

/// 64 layers at 1920×1080: 4.2 GB of nodes, and as many again in either image that they are sorted in.
#[test]
#[ignore = "takes a minute"]
fn transparency_bands_hold_64_layers_at_1920_by_1080() {
    fits(&Soup::full_screen(21, [1920, 1080], 64, 0.05), 512 << 20);
}

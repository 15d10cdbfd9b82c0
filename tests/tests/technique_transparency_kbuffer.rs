//! The k-buffer: exact as far as it keeps, by its formula beyond.
#![allow(missing_docs, clippy::unwrap_used)]

use shadowgraph::techniques::transparency::abuffer::{ABuffer, NodeFormat};
use shadowgraph::techniques::transparency::kbuffer::KBuffer;
use shadowgraph_tests::compare::Comparison;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Check};
use shadowgraph_tests::soup::{DEPTH_MARGIN, Kind, Kitchen, Random, Soup, background, beside_exact};
use shadowgraph_tests::twin::approximate::kept;
use shadowgraph_tests::twin::layers::close_call;

fn compare(soup: &Soup, k: u32, found: &[[f32; 4]]) -> Check {
    soup.compare_with(found, 1e-5, &format!("{k} kept"), |_, sorted| {
        (!close_call(sorted, DEPTH_MARGIN)).then(|| kept(sorted, k as usize, background()))
    })
}

#[test]
fn transparency_kbuffer_agrees_with_its_reference() {
    let mut rows = Vec::new();
    let soups = [
        Soup::random(1, [64, 64], 6, 0).with_any_alpha(),
        Soup::random(3, [32, 32], 40, 30).with_any_alpha(),
        Soup::interpenetrating([32, 32], 12),
        Soup::coplanar([64, 64], 21),
        Soup::random(16, [64, 64], 24, 3).made_of(&[Kind::Glass, Kind::Blend, Kind::Premultiplied]),
    ];
    for soup in soups {
        let mut kitchen = Kitchen::new(shared(), &soup);
        for kept in [1, 4, 32] {
            let found = kitchen.composite(&KBuffer { kept }, false).unwrap();
            rows.push(compare(&soup, kept, &found).demand());
        }
    }
    // Where no pixel has more, it is the A-buffer, bit for bit.
    let soup = Soup::coplanar([64, 64], 16).with_any_alpha();
    let mut kitchen = Kitchen::new(shared(), &soup);
    let exact = kitchen.run(ABuffer { format: NodeFormat::Float, ..ABuffer::default() }, false).unwrap();
    assert!(exact.longest > 4 && exact.longest <= 16);
    let found = kitchen.composite(&KBuffer { kept: 16 }, false).unwrap();
    let mut comparison = Comparison::new(format!("{}: A-buffer, bit for bit", soup.name), soup.size, 0.0);
    found.iter().zip(&exact.color).enumerate().for_each(|(i, (a, b))| comparison.same(i, a == b));
    rows.push(Check::new(comparison, 1.0, 0.0).demand());
    silent(shared());
    let picture = beside_exact(&KBuffer::default(), "Four layers kept (left); all layers (right)");
    figures::publish(shared(), "transparency", "kbuffer", &rows, Some(&picture));
}

/// Which layers are kept is nobody's race: in every order of draws the kept ones are the same, byte by byte where there
/// is no tail.
#[test]
fn portable_transparency_kbuffer_does_not_depend_on_the_order_of_draws() {
    let mut random = Random::new(5);
    let soup = Soup::coplanar([32, 32], 16).on_grid(shared().caps().limits.sub_pixel_bits);
    let mut kitchen = Kitchen::new(shared(), &soup);
    let first = kitchen.composite(&KBuffer { kept: 16 }, false).unwrap();
    for run in 0..6 {
        kitchen.shuffle(&mut random);
        assert!(kitchen.composite(&KBuffer { kept: 16 }, run % 2 == 1).unwrap() == first, "run {run}");
        compare(&soup, 3, &kitchen.composite(&KBuffer { kept: 3 }, run % 2 == 0).unwrap()).demand();
    }
    silent(shared());
}

#[test]
fn transparency_kbuffer_with_a_seeded_mistake_is_caught() {
    let soup = Soup::coplanar([64, 64], 21);
    let fails = |mistaken: &Soup, kept| {
        let found = Kitchen::new(shared(), mistaken).composite(&KBuffer { kept }, false).unwrap();
        compare(&soup, 4, &found).fails()
    };
    assert!(!fails(&soup, 4));
    // A layer too few is kept; ties the other way around; a layer a little denser.
    assert!(fails(&soup, 3));
    let mut turned = soup.clone();
    turned.triangles.reverse();
    assert!(fails(&turned, 4));
    let mut denser = soup.clone();
    denser.triangles[40].color[3] *= 0.99;
    assert!(fails(&denser, 4));
    silent(shared());
}

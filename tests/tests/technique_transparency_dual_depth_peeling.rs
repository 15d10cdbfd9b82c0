//! Dual depth peeling against the A-buffer and against a twin in double precision.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::DVec4;
use shadowgraph::techniques::transparency::abuffer::{ABuffer, Build, NodeFormat};
use shadowgraph::techniques::transparency::dual_depth_peeling::DualDepthPeeling;
use shadowgraph_tests::compare::Comparison;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Check};
use shadowgraph_tests::soup::{Kitchen, Random, Soup};

/// Nodes that round nothing. Layers from the back are composited in another order: the last bits differ.
const ABUFFER: ABuffer = ABuffer { build: Build::Arrays, format: NodeFormat::Float, exponent: 0, memory: u64::MAX };

fn soups() -> Vec<Soup> {
    vec![
        Soup::random(1, [64, 64], 6, 0).with_any_alpha(),
        Soup::random(3, [32, 32], 40, 30).with_any_alpha(),
        Soup::interpenetrating([32, 32], 12),
        Soup::coplanar([64, 64], 21),
    ]
}

#[test]
fn transparency_dual_depth_peeling_agrees_with_its_reference() {
    let mut rows = Vec::new();
    for soup in soups() {
        let mut kitchen = Kitchen::new(shared(), &soup);
        let found = kitchen.composite(&DualDepthPeeling::default(), false).unwrap();
        rows.push(soup.compare(&found, 1e-5, "color").demand());
        let layers = kitchen.run(ABUFFER, false).unwrap();
        assert!(layers.longest > 2);
        let mut comparison = Comparison::new(format!("{}: A-buffer", soup.name), soup.size, 1e-6);
        for (i, (a, b)) in found.iter().zip(&layers.color).enumerate() {
            comparison.error(i, (DVec4::from(a.map(f64::from)) - DVec4::from(b.map(f64::from))).abs().max_element());
        }
        rows.push(Check::new(comparison, 1.0, 0.0).demand());
    }
    silent(shared());
    figures::publish(shared(), "transparency", "dual_depth_peeling", &rows, None);
}

#[test]
fn portable_transparency_dual_depth_peeling_with_pulled_vertices() {
    let bits = shared().caps().limits.sub_pixel_bits;
    let soup = Soup::random(3, [32, 32], 40, 12).on_grid(bits);
    let mut kitchen = Kitchen::new(shared(), &soup);
    let found = kitchen.composite(&DualDepthPeeling::default(), false).unwrap();
    soup.compare(&found, 1e-5, "color").demand();
    assert!(kitchen.composite(&DualDepthPeeling::default(), true).unwrap() == found);
    silent(shared());
}

/// Every order of draws gives the same bytes: equal depths too.
#[test]
fn transparency_dual_depth_peeling_does_not_depend_on_the_order_of_draws() {
    let mut random = Random::new(5);
    let mut kitchen = Kitchen::new(shared(), &Soup::coplanar([64, 64], 21));
    let first = kitchen.composite(&DualDepthPeeling::default(), false).unwrap();
    for run in 0..8 {
        kitchen.reorder(|draws| {
            random.shuffle(draws);
            draws.sort_by_key(|draw| draw.class);
        });
        assert!(kitchen.composite(&DualDepthPeeling::default(), run % 2 == 1).unwrap() == first, "run {run}");
    }
    silent(shared());
}

/// More layers than are peeled end the frame, and the error says how many there are and how many fragments would go.
#[test]
fn transparency_dual_depth_peeling_loses_nothing_in_silence() {
    let soup = Soup::random(6, [32, 32], 8, 9);
    let fragments = soup.fragments();
    let most = fragments.iter().map(Vec::len).max().unwrap();
    let mut kitchen = Kitchen::new(shared(), &soup);
    let layers = most as u32;
    let whole = kitchen.composite(&DualDepthPeeling { layers }, false).unwrap();
    soup.compare(&whole, 1e-5, "color").demand();
    for layers in [most - 1, most / 2, 1, 0] {
        let lost: usize = fragments.iter().map(|fragments| fragments.len().saturating_sub(layers)).sum();
        let peeling = DualDepthPeeling { layers: layers as u32 };
        let said = kitchen.composite(&peeling, false).unwrap_err().to_string();
        let expected =
            format!("a pixel has {most} layers; {layers} are peeled, and {lost} fragments behind them would be lost");
        assert!(said.contains(&expected), "{said}");
    }
    // Nothing to peel.
    let nothing = Soup { triangles: Vec::new(), ..soup };
    let picture = Kitchen::new(shared(), &nothing).composite(&DualDepthPeeling { layers: 0 }, false).unwrap();
    nothing.compare(&picture, 0.0, "color").demand();
    silent(shared());
}

#[test]
fn transparency_dual_depth_peeling_with_a_seeded_mistake_is_caught() {
    let soup = Soup::coplanar([64, 64], 21);
    let fails = |mistaken: &Soup| {
        let found = Kitchen::new(shared(), mistaken).composite(&DualDepthPeeling::default(), false).unwrap();
        soup.compare(&found, 1e-5, "color").fails()
    };
    assert!(!fails(&soup));
    // A layer less; one a little denser; ties the other way around.
    let changed = |change: fn(&mut Soup)| {
        let mut soup = soup.clone();
        change(&mut soup);
        soup
    };
    assert!(fails(&changed(|s| s.triangles.truncate(41))));
    assert!(fails(&changed(|s| s.triangles[3].color[3] *= 0.99)));
    assert!(fails(&changed(|s| s.triangles.reverse())));
    silent(shared());
}

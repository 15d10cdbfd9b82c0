//! Depth peeling against the A-buffer, bit for bit, and against a twin in double precision.
#![allow(missing_docs, clippy::unwrap_used)]

use shadowgraph::techniques::transparency::depth_peeling::DepthPeeling;
use shadowgraph_tests::compare::Comparison;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Check};
use shadowgraph_tests::peeled;
use shadowgraph_tests::soup::{Kitchen, Soup};

#[test]
fn transparency_depth_peeling_agrees_with_its_reference() {
    let checks = peeled::with_references(&DepthPeeling::default(), |soup, found, layers| {
        let mut comparison = Comparison::new(format!("{}: A-buffer, bit for bit", soup.name), soup.size, 0.0);
        found.iter().zip(layers).enumerate().for_each(|(i, (a, b))| comparison.same(i, a == b));
        Check::new(comparison, 1.0, 0.0)
    });
    let picture = peeled::picture(&DepthPeeling::default(), 1);
    figures::publish(shared(), "transparency", "depth_peeling", &figures::demand(&checks), Some(&picture));
}

#[test]
fn portable_transparency_depth_peeling_with_pulled_vertices() {
    let bits = shared().caps().limits.sub_pixel_bits;
    let soup = Soup::random(3, [32, 32], 40, 12).on_grid(bits);
    let mut kitchen = Kitchen::new(shared(), &soup);
    let found = kitchen.composite(&DepthPeeling::default(), false).unwrap();
    soup.compare(&found, 1e-5, "color").demand();
    assert!(kitchen.composite(&DepthPeeling::default(), true).unwrap() == found);
    assert!(kitchen.run(peeled::ABUFFER, false).unwrap().color == found);
    silent(shared());
}

#[test]
fn transparency_depth_peeling_does_not_depend_on_the_order_of_draws() {
    peeled::orders_are_equal(&DepthPeeling::default());
}

#[test]
fn transparency_depth_peeling_loses_nothing_in_silence() {
    peeled::nothing_is_lost_in_silence(|layers| DepthPeeling { layers });
}

#[test]
fn transparency_depth_peeling_with_a_seeded_mistake_is_caught() {
    peeled::mistakes_are_seen(&DepthPeeling::default());
}

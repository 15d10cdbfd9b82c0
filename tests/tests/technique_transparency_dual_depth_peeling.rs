//! Dual depth peeling against the A-buffer and against a twin in double precision.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::DVec4;
use shadowgraph::techniques::transparency::dual_depth_peeling::DualDepthPeeling;
use shadowgraph_tests::compare::Comparison;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Check};
use shadowgraph_tests::peeled;
use shadowgraph_tests::soup::{Kitchen, Soup};

#[test]
fn transparency_dual_depth_peeling_agrees_with_its_reference() {
    // Layers from the back are composited in another order: the last bits differ.
    let checks = peeled::with_references(&DualDepthPeeling::default(), |soup, found, layers| {
        let mut comparison = Comparison::new(format!("{}: A-buffer", soup.name), soup.size, 1e-6);
        for (i, (a, b)) in found.iter().zip(layers).enumerate() {
            comparison.error(i, (DVec4::from(a.map(f64::from)) - DVec4::from(b.map(f64::from))).abs().max_element());
        }
        Check::new(comparison, 1.0, 0.0)
    });
    let picture = peeled::picture(&DualDepthPeeling::default(), 2);
    figures::publish(shared(), "transparency", "dual_depth_peeling", &figures::demand(&checks), Some(&picture));
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

#[test]
fn transparency_dual_depth_peeling_does_not_depend_on_the_order_of_draws() {
    peeled::orders_are_equal(&DualDepthPeeling::default());
}

#[test]
fn transparency_dual_depth_peeling_loses_nothing_in_silence() {
    peeled::nothing_is_lost_in_silence(|layers| DualDepthPeeling { layers });
}

#[test]
fn transparency_dual_depth_peeling_with_a_seeded_mistake_is_caught() {
    peeled::mistakes_are_seen(&DualDepthPeeling::default());
}

//! Moment-based transparency against its formulas in double precision.
#![allow(missing_docs, clippy::unwrap_used)]

use shadowgraph::techniques::transparency::moments::Moments;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Check};
use shadowgraph_tests::soup::{Kitchen, Random, Soup, background, beside_exact};
use shadowgraph_tests::twin::approximate::by_moments;

/// Nearest and farthest distance of any vertex: a soup's distance is 1 - depth.
fn range(soup: &Soup) -> [f64; 2] {
    let distances = soup.triangles.iter().flat_map(|t| t.depth).map(|depth| 1.0 - f64::from(depth));
    distances.fold([f64::INFINITY, 0.0], |[near, far], z| [z.min(near), z.max(far)])
}

fn compare(soup: &Soup, found: &[[f32; 4]]) -> Check {
    let [near, far] = range(soup);
    let place = |depth: f64| 2.0 * ((1.0 - depth) / near).ln() / (far / near).ln() - 1.0;
    soup.compare_with(found, 1e-3, "four moments", |_, fragments| {
        Some(by_moments(fragments, |f| place(f.depth), background()))
    })
}

#[test]
fn transparency_moments_agrees_with_its_reference() {
    let mut rows = Vec::new();
    let soups = [
        Soup::random(1, [64, 64], 6, 0).with_any_alpha(),
        Soup::random(3, [32, 32], 40, 30).with_any_alpha(),
        Soup::interpenetrating([32, 32], 12),
    ];
    for soup in soups {
        let found = Kitchen::new(shared(), &soup).composite(&Moments, false).unwrap();
        rows.push(compare(&soup, &found).demand());
    }
    // One layer is composited exactly.
    let single = Soup::random(2, [32, 32], 1, 0);
    let found = Kitchen::new(shared(), &single).composite(&Moments, false).unwrap();
    rows.push(single.compare(&found, 1e-6, "exact").demand());
    silent(shared());
    let picture = beside_exact(&Moments, "Four moments (left); all layers (right)");
    figures::publish(shared(), "transparency", "moments", &rows, Some(&picture));
}

#[test]
fn portable_transparency_moments_does_not_depend_on_the_order_of_draws() {
    let mut random = Random::new(5);
    let soup = Soup::random(3, [32, 32], 40, 12).on_grid(shared().caps().limits.sub_pixel_bits);
    let mut kitchen = Kitchen::new(shared(), &soup);
    for run in 0..4 {
        compare(&soup, &kitchen.composite(&Moments, run % 2 == 1).unwrap()).demand();
        kitchen.shuffle(&mut random);
    }
    silent(shared());
}

#[test]
fn transparency_moments_with_a_seeded_mistake_is_caught() {
    let soup = Soup::random(3, [32, 32], 20, 6);
    let fails = |mistaken: &Soup| {
        let found = Kitchen::new(shared(), mistaken).composite(&Moments, false).unwrap();
        compare(&soup, &found).fails()
    };
    assert!(!fails(&soup));
    // Near and far the other way around; a layer less; layers denser.
    let mut turned = soup.clone();
    turned.triangles.iter_mut().for_each(|t| t.depth = t.depth.map(|z| 1.0 - z));
    assert!(fails(&turned));
    let mut less = soup.clone();
    less.triangles.truncate(30);
    assert!(fails(&less));
    let mut denser = soup.clone();
    denser.triangles.iter_mut().for_each(|t| t.color[3] *= 0.95);
    assert!(fails(&denser));
    silent(shared());
}

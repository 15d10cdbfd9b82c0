//! Weighted blended transparency against its formula in double precision.
#![allow(missing_docs, clippy::unwrap_used)]

use shadowgraph::techniques::transparency::weighted::{Weight, Weighted};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Check};
use shadowgraph_tests::soup::{Kitchen, Random, Soup, background, beside_exact};
use shadowgraph_tests::twin::approximate::{weight, weighted};

const WEIGHTS: [(u32, Weight); 4] =
    [(7, Weight::Equation7), (8, Weight::Equation8), (9, Weight::Equation9), (10, Weight::Equation10)];

/// Against the formula; weights run over five decades, so sums of floats have an error of some 1e-6 of the largest.
fn compare(soup: &Soup, equation: u32, found: &[[f32; 4]]) -> Check {
    soup.compare_with(found, 2e-5, &format!("equation {equation}"), |_, fragments| {
        // Distance and ordinary depth of a soup are the same number.
        let of = |z: f64, alpha| weight(equation, z, z, alpha);
        Some(weighted(fragments, |f| of(1.0 - f.depth, f.color.w), background()))
    })
}

#[test]
fn transparency_weighted_agrees_with_its_reference() {
    let mut rows = Vec::new();
    let soups = [
        Soup::random(1, [64, 64], 6, 0).with_any_alpha(),
        Soup::random(3, [32, 32], 40, 30).with_any_alpha(),
        Soup::interpenetrating([32, 32], 12),
    ];
    for soup in soups {
        let mut kitchen = Kitchen::new(shared(), &soup);
        for (equation, weight) in WEIGHTS {
            let found = kitchen.composite(&Weighted { weight }, false).unwrap();
            rows.push(compare(&soup, equation, &found).demand());
        }
    }
    // One layer is composited exactly.
    let single = Soup::random(2, [32, 32], 1, 0);
    let found = Kitchen::new(shared(), &single).composite(&Weighted::default(), false).unwrap();
    rows.push(single.compare(&found, 1e-6, "exact").demand());
    silent(shared());
    let picture = beside_exact(&Weighted::default(), "Weights by equation 7 (left); all layers (right)");
    figures::publish(shared(), "transparency", "weighted", &rows, Some(&picture));
}

#[test]
fn portable_transparency_weighted_does_not_depend_on_the_order_of_draws() {
    let mut random = Random::new(5);
    let soup = Soup::random(3, [32, 32], 40, 12).on_grid(shared().caps().limits.sub_pixel_bits);
    let mut kitchen = Kitchen::new(shared(), &soup);
    for run in 0..4 {
        let found = kitchen.composite(&Weighted::default(), run % 2 == 1).unwrap();
        compare(&soup, 7, &found).demand();
        kitchen.shuffle(&mut random);
    }
    silent(shared());
}

#[test]
fn transparency_weighted_with_a_seeded_mistake_is_caught() {
    let soup = Soup::random(3, [32, 32], 20, 6);
    let fails = |mistaken: &Soup, weight| {
        let found = Kitchen::new(shared(), mistaken).composite(&Weighted { weight }, false).unwrap();
        compare(&soup, 7, &found).fails()
    };
    assert!(!fails(&soup, Weight::Equation7));
    assert!(fails(&soup, Weight::Equation8));
    let mut turned = soup.clone();
    turned.triangles.iter_mut().for_each(|t| t.depth = t.depth.map(|z| 1.0 - z));
    assert!(fails(&turned, Weight::Equation7));
    let mut denser = soup.clone();
    denser.triangles.iter_mut().for_each(|t| t.color[3] *= 0.99);
    assert!(fails(&denser, Weight::Equation7));
    silent(shared());
}

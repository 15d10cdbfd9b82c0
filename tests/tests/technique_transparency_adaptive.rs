//! Adaptive transparency against its definition in double precision.
#![allow(missing_docs, clippy::unwrap_used)]

use shadowgraph::frame::AdaptiveLists;
use shadowgraph::techniques::transparency::adaptive::Adaptive;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Check};
use shadowgraph_tests::soup::{DEPTH_MARGIN, Kind, Kitchen, Random, Soup, background, beside_exact};
use shadowgraph_tests::twin::approximate::adaptive;
use shadowgraph_tests::twin::layers::close_call;

fn technique(kept: u32) -> AdaptiveLists {
    AdaptiveLists { adaptive: Adaptive { kept }, exponent: 0, memory: u64::MAX }
}

/// Colours of RGB9E5, and of 10 bits what is let through.
fn compare(soup: &Soup, kept: u32, found: &[[f32; 4]]) -> Check {
    let check = soup.compare_with(found, 4e-3, &format!("{kept} nodes"), |_, sorted| {
        // Distance and ordinary depth of a soup are the same number.
        let expected = adaptive(sorted, kept as usize, |f| 1.0 - f.depth, background());
        expected.filter(|_| !close_call(sorted, DEPTH_MARGIN))
    });
    Check::new(check.comparison, 1.0, 0.2)
}

/// Alphas that nodes hold exactly, so that rounding does not decide which step goes.
fn exact(mut soup: Soup) -> Soup {
    let mut random = Random::new(13);
    soup.triangles.iter_mut().for_each(|triangle| triangle.color[3] = (1 + random.below(1023)) as f32 / 1023.0);
    soup
}

#[test]
fn transparency_adaptive_agrees_with_its_reference() {
    let mut rows = Vec::new();
    let soups = [
        exact(Soup::random(1, [64, 64], 6, 0)),
        exact(Soup::random(3, [32, 32], 0, 40)),
        exact(Soup::random(3, [32, 32], 30, 12)),
        Soup::random(24, [32, 32], 0, 24).thin(0.125),
    ];
    for soup in soups {
        let mut kitchen = Kitchen::new(shared(), &soup);
        for kept in [2, 8, 32] {
            let found = kitchen.composite(&technique(kept), false).unwrap();
            rows.push(compare(&soup, kept, &found).demand());
        }
    }
    // Where no pixel has more layers, it is exact: of glass too.
    let soup = Soup::random(25, [32, 32], 6, 20).made_of(&[Kind::Glass, Kind::Blend]);
    let found = Kitchen::new(shared(), &soup).composite(&technique(32), false).unwrap();
    rows.push(soup.compare(&found, 4e-3, "32 nodes, exact").demand());
    let picture = beside_exact(&technique(4), "Four nodes (left); all layers (right)");
    silent(shared());
    figures::publish(shared(), "transparency", "adaptive", &rows, Some(&picture));
}

#[test]
fn portable_transparency_adaptive_does_not_depend_on_the_order_of_draws() {
    let mut random = Random::new(5);
    let soup = exact(Soup::random(3, [32, 32], 40, 12)).on_grid(shared().caps().limits.sub_pixel_bits);
    let mut kitchen = Kitchen::new(shared(), &soup);
    let first = kitchen.composite(&technique(4), false).unwrap();
    compare(&soup, 4, &first).demand();
    for run in 0..6 {
        kitchen.shuffle(&mut random);
        assert!(kitchen.composite(&technique(4), run % 2 == 1).unwrap() == first, "run {run}");
    }
    silent(shared());
}

#[test]
fn transparency_adaptive_says_how_many_layers_it_takes() {
    let most = Adaptive { kept: 32 }.most_layers();
    let soup = Soup::full_screen(26, [4, 4], most as usize + 1, 0.01);
    let said = Kitchen::new(shared(), &soup).composite(&technique(32), false).unwrap_err().to_string();
    assert!(said.contains(&format!("{} layers; at most {most}", most + 1)), "{said}");
    // As many as it says are all there, though loops of one invocation end at 65,535 turns here.
    let soup = Soup::full_screen(26, [4, 4], most as usize, 2e-3);
    let found = Kitchen::new(shared(), &soup).composite(&technique(32), false).unwrap();
    let all = (1.0_f64 - (2.0_f64 / 1023.0)).powi(most as i32);
    let through = (f64::from(found[3][1]) - f64::from(found[0][1])).abs();
    assert!(through <= all, "{through} {all}");
    silent(shared());
}

#[test]
fn transparency_adaptive_with_a_seeded_mistake_is_caught() {
    let soup = exact(Soup::random(3, [32, 32], 0, 24));
    let fails = |mistaken: &Soup, kept| {
        let found = Kitchen::new(shared(), mistaken).composite(&technique(kept), false).unwrap();
        compare(&soup, 4, &found).fails()
    };
    assert!(!fails(&soup, 4));
    // A node too few; layers the other way around; a layer that hides less.
    assert!(fails(&soup, 3));
    let mut turned = soup.clone();
    turned.triangles.iter_mut().for_each(|t| t.depth = t.depth.map(|z| 1.0 - z));
    assert!(fails(&turned, 4));
    let mut denser = soup.clone();
    denser.triangles.iter_mut().for_each(|t| t.color[3] *= 0.95);
    assert!(fails(&denser, 4));
    silent(shared());
}

//! Stochastic transparency against its definition, with the same random numbers, and its error against the exact picture.
#![allow(missing_docs, clippy::unwrap_used)]

use shadowgraph::techniques::transparency::stochastic::Stochastic;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Check};
use shadowgraph_tests::soup::{BACKGROUND, DEPTH_MARGIN, Kitchen, Random, Soup, background, beside_exact};
use shadowgraph_tests::twin::approximate::{mask, stochastic};
use shadowgraph_tests::twin::layers::{close_call, composite};

fn compare(soup: &Soup, samples: u32, found: &[[f32; 4]]) -> Check {
    soup.compare_with(found, 1e-5, &format!("{samples} samples"), |i, sorted| {
        let pixel = [i as u32 % soup.size[0], i as u32 / soup.size[0]];
        let covered = |key: u32| mask(pixel, key, soup.triangles[key as usize].color[3], samples);
        (!close_call(sorted, DEPTH_MARGIN)).then(|| stochastic(sorted, samples, |f| covered(f.key), background()))
    })
}

#[test]
fn transparency_stochastic_agrees_with_its_reference() {
    let mut rows = Vec::new();
    let soups = [
        Soup::random(1, [64, 64], 6, 0).with_any_alpha(),
        Soup::random(3, [32, 32], 40, 30).with_any_alpha(),
        Soup::coplanar([64, 64], 21),
    ];
    for soup in soups {
        let mut kitchen = Kitchen::new(shared(), &soup);
        for samples in [1, 8, 64] {
            let found = kitchen.composite(&Stochastic { samples }, false).unwrap();
            rows.push(compare(&soup, samples, &found).demand());
        }
    }
    silent(shared());
    let picture = beside_exact(&Stochastic::default(), "Eight samples a pixel (left); all layers (right)");
    figures::publish(shared(), "transparency", "stochastic", &rows, Some(&picture));
}

/// Sixteen times as many samples, about a fourth of the error: it is noise, and no bias hides in it.
#[test]
fn transparency_stochastic_tends_to_the_exact_picture() {
    let soup = Soup::random(3, [64, 64], 0, 12).with_any_alpha();
    let mut kitchen = Kitchen::new(shared(), &soup);
    let mut error = |samples| {
        let found = kitchen.composite(&Stochastic { samples }, false).unwrap();
        let exact = soup.fragments();
        let squares = exact.iter().zip(&found).map(|(sorted, found)| {
            let found = glam::DVec4::from(found.map(f64::from));
            (composite(sorted, background()) - found).length_squared()
        });
        (squares.sum::<f64>() / exact.len() as f64).sqrt()
    };
    let errors = [4, 64].map(&mut error);
    let ratio = errors[0] / errors[1];
    assert!((2.8..5.5).contains(&ratio), "{errors:?} of background {BACKGROUND:?}");
    silent(shared());
}

#[test]
fn portable_transparency_stochastic_does_not_depend_on_the_order_of_draws() {
    let mut random = Random::new(5);
    let soup = Soup::random(3, [32, 32], 40, 12).on_grid(shared().caps().limits.sub_pixel_bits);
    let mut kitchen = Kitchen::new(shared(), &soup);
    for run in 0..4 {
        compare(&soup, 8, &kitchen.composite(&Stochastic::default(), run % 2 == 1).unwrap()).demand();
        kitchen.shuffle(&mut random);
    }
    silent(shared());
}

#[test]
fn transparency_stochastic_with_a_seeded_mistake_is_caught() {
    let soup = Soup::random(3, [32, 32], 20, 6);
    let fails = |mistaken: &Soup, samples| {
        let found = Kitchen::new(shared(), mistaken).composite(&Stochastic { samples }, false).unwrap();
        compare(&soup, 8, &found).fails()
    };
    assert!(!fails(&soup, 8));
    // A sample less; triangles in another order, so with other random numbers; layers denser.
    assert!(fails(&soup, 7));
    let mut turned = soup.clone();
    turned.triangles.reverse();
    assert!(fails(&turned, 8));
    let mut denser = soup.clone();
    denser.triangles.iter_mut().for_each(|t| t.color[3] *= 0.99);
    assert!(fails(&denser, 8));
    silent(shared());
}

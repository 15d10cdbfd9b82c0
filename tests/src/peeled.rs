//! What holds for both kinds of depth peeling, whose tests call these.

use shadowgraph::techniques::transparency::OrderIndependent;
use shadowgraph::techniques::transparency::abuffer::{ABuffer, Build, LongSort, NodeFormat};

use crate::device::{shared, silent};
use crate::figures::{Check, Picture};
use crate::soup::{Kind, Kitchen, Random, Soup};

/// An A-buffer whose nodes round nothing: what is peeled is not stored either.
pub const ABUFFER: ABuffer = ABuffer {
    build: Build::Arrays,
    format: NodeFormat::Float,
    exponent: 0,
    memory: u64::MAX,
    bands: 1,
    layers: 0,
    long_sort: LongSort::Blocks,
    samples: 1,
};

/// Against the twin in double precision, and against the A-buffer by what `compare` makes of a soup, the picture found and
/// the A-buffer's.
pub fn with_references(
    peeling: &dyn OrderIndependent,
    compare: impl Fn(&Soup, &[[f32; 4]], &[[f32; 4]]) -> Check,
) -> Vec<Check> {
    let soups = [
        Soup::random(1, [64, 64], 6, 0).with_any_alpha(),
        Soup::random(3, [32, 32], 40, 30).with_any_alpha(),
        Soup::interpenetrating([32, 32], 12),
        Soup::coplanar([64, 64], 21),
    ];
    // Layers that multiply channel by channel what lies behind them, and others.
    let every = [Kind::Glass, Kind::Blend, Kind::Premultiplied, Kind::Add];
    let glass =
        [Soup::random(16, [64, 64], 24, 3).made_of(&every), Soup::random(17, [32, 32], 12, 16).made_of(&[Kind::Glass])];
    let plain = soups.iter().map(|soup| (soup, ABUFFER));
    let tinted = glass.iter().map(|soup| (soup, ABuffer { format: NodeFormat::FloatTinted, ..ABUFFER }));
    let mut checks = Vec::new();
    for (soup, abuffer) in plain.chain(tinted) {
        let mut kitchen = Kitchen::new(shared(), soup);
        let found = composite(&mut kitchen, peeling, false);
        let layers = kitchen.run(abuffer, false).unwrap_or_else(|error| panic!("{error}"));
        assert!(layers.longest > 2);
        checks.extend([soup.compare(&found, 1e-5, "color"), compare(soup, &found, &layers.color)]);
    }
    silent(shared());
    checks
}

/// For the page: the picture, and beside it how many layers each pixel has, of which a round peels `layers_a_round`.
pub fn picture(peeling: &dyn OrderIndependent, layers_a_round: u32) -> Picture {
    let mut kitchen = Kitchen::new(shared(), &Soup::shown());
    let layers = kitchen.run(ABUFFER, false).unwrap_or_else(|error| panic!("{error}"));
    let rounds = |count: f32| (count / layers_a_round as f32).ceil() / (layers.longest.div_ceil(layers_a_round)) as f32;
    let rounds: Vec<_> = layers
        .count
        .iter()
        .map(|&count| [rounds(count).powf(2.2), rounds(count).powf(2.2), rounds(count).powf(2.2), 1.0])
        .collect();
    let caption = format!(
        "Triangles in front of each other, and how many rounds their pixels take (white: {})",
        layers.longest.div_ceil(layers_a_round)
    );
    kitchen.side_by_side(peeling, &rounds, &caption)
}

/// Every order of draws gives the same bytes: equal depths too.
pub fn orders_are_equal(peeling: &dyn OrderIndependent) {
    let mut random = Random::new(5);
    let mut kitchen = Kitchen::new(shared(), &Soup::coplanar([64, 64], 21));
    let first = composite(&mut kitchen, peeling, false);
    for run in 0..8 {
        kitchen.shuffle(&mut random);
        assert!(composite(&mut kitchen, peeling, run % 2 == 1) == first, "run {run}");
    }
    silent(shared());
}

/// More layers than are peeled end the frame, and the error says how many there are and how many fragments would go.
/// `of`: peeling of at most so many layers.
pub fn nothing_is_lost_in_silence<P: OrderIndependent>(of: impl Fn(u32) -> P) {
    let soup = Soup::random(6, [32, 32], 8, 9);
    let fragments = soup.fragments();
    let most = fragments.iter().map(Vec::len).max().unwrap_or(0);
    let mut kitchen = Kitchen::new(shared(), &soup);
    let whole = composite(&mut kitchen, &of(most as u32), false);
    soup.compare(&whole, 1e-5, "color").demand();
    for layers in [most - 1, most / 2, 1, 0] {
        let lost: usize = fragments.iter().map(|fragments| fragments.len().saturating_sub(layers)).sum();
        let said = kitchen.composite(&of(layers as u32), false).err().map(|error| error.to_string());
        let expected =
            format!("a pixel has {most} layers; {layers} are peeled, and {lost} fragments behind them would be lost");
        assert!(said.as_ref().is_some_and(|said| said.contains(&expected)), "{said:?}");
    }
    // Nothing to peel.
    let nothing = Soup { triangles: Vec::new(), ..soup };
    let picture = composite(&mut Kitchen::new(shared(), &nothing), &of(0), false);
    nothing.compare(&picture, 0.0, "color").demand();
    silent(shared());
}

/// Mistakes that the comparison with the twin must see.
pub fn mistakes_are_seen(peeling: &dyn OrderIndependent) {
    let soup = Soup::coplanar([64, 64], 21);
    let fails = |change: fn(&mut Soup)| {
        let mut mistaken = soup.clone();
        change(&mut mistaken);
        let found = composite(&mut Kitchen::new(shared(), &mistaken), peeling, false);
        soup.compare(&found, 1e-5, "color").fails()
    };
    assert!(!fails(|_| {}));
    // Glass of another colour, and glass that hides instead.
    let glass = Soup::random(17, [32, 32], 12, 8).made_of(&[Kind::Glass]);
    let fails_glass = |mistaken: &Soup| {
        let found = composite(&mut Kitchen::new(shared(), mistaken), peeling, false);
        glass.compare(&found, 1e-5, "color").fails()
    };
    assert!(!fails_glass(&glass));
    let mut turned = glass.clone();
    turned.triangles[5].color[0] *= 0.98;
    assert!(fails_glass(&turned) && fails_glass(&glass.clone().made_of(&[Kind::Blend])));
    // A layer less; one a little denser; ties the other way around.
    assert!(fails(|soup| soup.triangles.truncate(41)));
    assert!(fails(|soup| soup.triangles[3].color[3] *= 0.99));
    assert!(fails(|soup| soup.triangles.reverse()));
    silent(shared());
}

fn composite(kitchen: &mut Kitchen, peeling: &dyn OrderIndependent, pull: bool) -> Vec<[f32; 4]> {
    kitchen.composite(peeling, pull).unwrap_or_else(|error| panic!("{error}"))
}

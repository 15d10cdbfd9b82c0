//! The A-buffer against a twin that rasterises by Vulkan's rules and composites in double precision.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{DVec4, Mat4, Vec3};
use shadowgraph::capture::auto_exposure;
use shadowgraph::frame::Transparency;
use shadowgraph::gpu::Feature;
use shadowgraph::techniques::transparency::abuffer::{
    ABuffer, Build, IN_PLACE_MOST, LongSort, NodeFormat, Sizing, sample_counts,
};
use shadowgraph::techniques::transparency::depth_peeling::DepthPeeling;
use shadowgraph::techniques::transparency::fragments::Step;
use shadowgraph_tests::compare::Comparison;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::exr_file::Part;
use shadowgraph_tests::figures::{self, Check, Figure, Picture};
use shadowgraph_tests::harness::{is_long, skip};
use shadowgraph_tests::panes::{capture, compare, glass, panes};
use shadowgraph_tests::render::{Subject, only};
use shadowgraph_tests::soup::{DEPTH_MARGIN, Found, Kind, Kitchen, Random, Soup};
use shadowgraph_tests::twin::layers::close_call;

const LISTS: ABuffer = ABuffer {
    build: Build::Lists(Sizing::Counted),
    format: NodeFormat::Compact,
    exponent: 0,
    memory: u64::MAX,
    bands: 1,
    layers: 0,
    long_sort: LongSort::Blocks,
    samples: 1,
};
const ARRAYS: ABuffer = ABuffer { build: Build::Arrays, ..LISTS };

fn soups() -> Vec<Soup> {
    vec![
        Soup::random(1, [64, 64], 6, 0),
        Soup::random(2, [64, 32], 60, 0),
        Soup::random(3, [32, 32], 40, 30),
        Soup::random(4, [16, 16], 10, 512),
        Soup::interpenetrating([32, 32], 12),
        Soup::coplanar([64, 64], 21),
    ]
}

/// Layers of each pixel, exactly.
fn counts(soup: &Soup, found: &Found) -> Check {
    let mut comparison = Comparison::new(format!("{}: layers", soup.name), soup.size, 0.0);
    for (i, expected) in soup.fragments().iter().enumerate() {
        match soup.sure(i, expected) {
            true => comparison.error(i, f64::from(found.count[i]) - expected.len() as f64),
            false => comparison.leave_out(i, "near the opaque depth"),
        }
    }
    Check::new(comparison, 1.0, 0.01)
}

/// Colour and alpha of each pixel: the largest difference of a component.
fn colors(soup: &Soup, found: &Found, tolerance: f64, format: &str) -> Check {
    soup.compare(&found.color, tolerance, &format!("{format} color"))
}

/// What must hold of every run.
fn sound(found: &Found) {
    let sum: f64 = found.count.iter().map(|&count| f64::from(count)).sum();
    assert_eq!(sum, f64::from(found.nodes), "sum of the pixels' layers and nodes");
    assert_eq!(found.count.iter().fold(0.0f32, |a, &b| a.max(b)), found.longest as f32);
    assert_eq!(found.report, [0; 3]);
    assert!(found.counter.is_none_or(|counter| counter == found.nodes), "{found:?}");
    assert!(found.samples.is_none_or(|samples| samples == u64::from(found.nodes)), "{found:?}");
}

#[test]
fn transparency_abuffer_agrees_with_its_reference() {
    let mut rows = Vec::new();
    for soup in soups() {
        let mut kitchen = Kitchen::new(shared(), &soup);
        let found = kitchen.run(ARRAYS, false).unwrap();
        sound(&found);
        rows.push(counts(&soup, &found).demand());
        rows.push(colors(&soup, &found, 4e-3, "RGB9E5").demand());
        // Linked lists give the same bytes, and their counter and the occlusion query say the same.
        let lists = kitchen.run(LISTS, false).unwrap();
        sound(&lists);
        assert!(lists.counter.is_some() && lists.samples.is_some());
        assert!(lists.color == found.color && lists.count == found.count, "{}: lists differ", soup.name);
    }
    let soup = Soup::random(5, [32, 32], 40, 30).with_any_alpha();
    let mut kitchen = Kitchen::new(shared(), &soup);
    for (format, tolerance, name) in [(NodeFormat::Half, 2e-3, "half"), (NodeFormat::Float, 1e-5, "float")] {
        let arrays = kitchen.run(ABuffer { format, ..ARRAYS }, false).unwrap();
        let lists = kitchen.run(ABuffer { format, ..LISTS }, false).unwrap();
        sound(&arrays);
        sound(&lists);
        assert!(arrays.color == lists.color, "{name}: lists differ");
        rows.push(colors(&soup, &arrays, tolerance, name).demand());
    }
    // Layers that multiply channel by channel what lies behind them, and others that only add.
    let every = [Kind::Glass, Kind::Blend, Kind::Premultiplied, Kind::Add];
    let soups = [
        Soup::random(16, [64, 64], 24, 3).made_of(&every),
        Soup::random(17, [32, 32], 12, 48).made_of(&[Kind::Glass]),
        Soup::coplanar([32, 32], 21).made_of(&every),
    ];
    for (format, tolerance, name) in [
        (NodeFormat::CompactTinted, 4e-3, "RGB9E5, tinted"),
        (NodeFormat::HalfTinted, 2e-3, "half, tinted"),
        (NodeFormat::FloatTinted, 1e-5, "float, tinted"),
    ] {
        for soup in &soups {
            let mut kitchen = Kitchen::new(shared(), soup);
            let arrays = kitchen.run(ABuffer { format, ..ARRAYS }, false).unwrap();
            let lists = kitchen.run(ABuffer { format, ..LISTS }, false).unwrap();
            sound(&arrays);
            sound(&lists);
            assert!(arrays.color == lists.color, "{name}: lists differ");
            rows.push(colors(soup, &arrays, tolerance, name).demand());
        }
    }
    // Without glass, tinted nodes change nothing but rounding, and peeling has the same bits as nodes of one alpha.
    let soup =
        Soup::random(18, [64, 64], 24, 3).made_of(&[Kind::Add, Kind::Blend, Kind::Premultiplied]).with_any_alpha();
    let mut kitchen = Kitchen::new(shared(), &soup);
    let plain = kitchen.run(ABuffer { format: NodeFormat::Float, ..ARRAYS }, false).unwrap();
    rows.push(colors(&soup, &plain, 1e-5, "float").demand());
    assert!(kitchen.composite(&DepthPeeling::default(), false).unwrap() == plain.color);
    // Several samples a pixel, each against its own composite.
    if sample_counts(shared().caps()).contains(&4) {
        for soup in [Soup::random(2, [64, 32], 60, 0).leaning(9), Soup::random(3, [32, 32], 40, 30).leaning(-7)] {
            let found = Kitchen::new(shared(), &soup).run(ABuffer { samples: 4, ..ARRAYS }, false).unwrap();
            rows.push(soup.compare_samples(&found.color, 4, 4e-3, "4 samples, RGB9E5 color").demand());
        }
    }
    // So many layers that runs are merged across invocations; the farthest still count.
    let soup = Soup::random(10, [8, 8], 0, 5000).in_objects_of(100).thin(0.001);
    let mut kitchen = Kitchen::new(shared(), &soup);
    let arrays = kitchen.run(ABuffer { format: NodeFormat::Float, ..ARRAYS }, false).unwrap();
    let lists = kitchen.run(ABuffer { format: NodeFormat::Float, ..LISTS }, false).unwrap();
    sound(&arrays);
    assert!(arrays.longest > 4096 && arrays.color == lists.color);
    rows.push(counts(&soup, &arrays).demand());
    rows.push(colors(&soup, &arrays, 1e-5, "float").demand());
    // glTF's materials, lit and shadowed: panes in an order that is right only pixel by pixel.
    for subject in [panes(true), panes(false), crossing(), glass()] {
        rows.push(compare(&subject, &layers(&subject, Transparency::ABuffer)).demand());
    }
    // Glass is told from panes that only hide.
    assert!(compare(&glass(), &layers(&panes(false), Transparency::ABuffer)).fails());
    // The scene is one that no order of objects gets right.
    assert!(compare(&crossing(), &layers(&crossing(), Transparency::Sorted)).fails());
    silent(shared());
    publish(&rows);
}

/// Two panes that cut through each other among the others, of one object each.
fn crossing() -> Subject {
    panes(false).changed(|subject| {
        for (object, turn) in [(0, 0.9), (2, -0.7)] {
            let place = &mut subject.scene.objects[object].world_from_object;
            *place = Mat4::from_translation(Vec3::new(0.1, 0.0, 0.3)) * Mat4::from_rotation_y(turn);
        }
        subject.name = "panes through each other, lit".into();
        subject.scene.name = subject.name.clone();
    })
}

fn layers(subject: &Subject, transparency: Transparency) -> Part {
    let wanted = only(&["color"]);
    capture(shared(), subject, |settings| {
        wanted(settings);
        settings.transparency = transparency;
    })
}

/// Triangles of one sample a pixel, and of four beside them: each pixel six times as large.
fn edges() -> Picture {
    const LARGER: usize = 6;
    let soup = Soup::random(34, [64, 64], 9, 0);
    let mut kitchen = Kitchen::new(shared(), &soup);
    let both = [1, 4].map(|samples| kitchen.run(ABuffer { samples, ..ARRAYS }, false).unwrap().color);
    let side = soup.size[0] as usize * LARGER;
    let pixel = |i: usize| {
        let [x, y] = [i % (2 * side), i / (2 * side)];
        let [red, green, blue, _] = both[x / side][y / LARGER * 64 + x % side / LARGER];
        [red, green, blue]
    };
    Picture {
        size: [2 * side as u32, side as u32],
        pixels: (0..2 * side * side).map(pixel).collect(),
        exposure: 0.9,
        caption: "Triangles of one sample a pixel, and of four".into(),
    }
}

fn publish(rows: &[Figure]) {
    let picture = |subject: Subject, caption: &str| {
        let shown = subject.changed(|s| s.size = [480, 270]);
        let colors = layers(&shown, Transparency::ABuffer).vectors("", ["R", "G", "B"]);
        let pixels: Vec<[f32; 3]> = colors.iter().map(|c| c.as_vec3().to_array()).collect();
        let rgba: Vec<_> = pixels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
        Picture { size: shown.size, exposure: auto_exposure(&rgba), pixels, caption: caption.into() }
    };
    let through = picture(glass(), "Four panes of glass multiply what lies behind them, channel by channel");
    figures::publish_picture("techniques/transparency", "abuffer_glass", &through);
    if sample_counts(shared().caps()).contains(&4) {
        figures::publish_picture("techniques/transparency", "abuffer_samples", &edges());
    }
    let picture = picture(crossing(), "Two of four panes go through each other, before a wall");
    figures::publish(shared(), "transparency", "abuffer", rows, Some(&picture));
}

#[test]
fn portable_transparency_abuffer_loses_no_layer() {
    let bits = shared().caps().limits.sub_pixel_bits;
    for soup in [Soup::random(2, [64, 32], 60, 0), Soup::random(3, [32, 32], 40, 30)] {
        let soup = soup.on_grid(bits);
        let mut kitchen = Kitchen::new(shared(), &soup);
        let arrays = kitchen.run(ARRAYS, false).unwrap();
        sound(&arrays);
        counts(&soup, &arrays).demand();
        colors(&soup, &arrays, 4e-3, "RGB9E5").demand();
        let pulled = kitchen.run(ARRAYS, true).unwrap();
        assert!(pulled == arrays, "{}: vertices pulled by hand", soup.name);
        if shared().caps().has(Feature::OcclusionQueryPrecise) {
            let lists = kitchen.run(LISTS, false).unwrap();
            sound(&lists);
            assert!(lists.color == arrays.color, "{}: lists differ", soup.name);
        }
    }
    silent(shared());
}

/// Every order of draws, and every run, gives the same bytes: equal depths too.
#[test]
fn transparency_abuffer_does_not_depend_on_the_order_of_draws() {
    let mut random = Random::new(3);
    for soup in [Soup::coplanar([64, 64], 21), Soup::random(6, [32, 32], 120, 12)] {
        let mut kitchen = Kitchen::new(shared(), &soup);
        let first = kitchen.run(ARRAYS, false).unwrap();
        for run in 0..100 {
            // The triangles' numbers come from the index buffer here, so draws of parts of an object keep them.
            kitchen.shuffle(&mut random);
            let (arrays, lists) =
                (kitchen.run(ARRAYS, run % 2 == 1).unwrap(), kitchen.run(LISTS, run % 2 == 0).unwrap());
            assert!(arrays == first, "{}: run {run} differs", soup.name);
            assert!(lists.color == first.color && lists.count == first.count, "{}: lists of run {run}", soup.name);
        }
        // Draws of single triangles, in any order over all objects.
        kitchen.reorder(|draws| {
            let blended = draws.iter().filter(|draw| draw.class == shadowgraph::scene::DrawClass::Blend);
            let opaque = draws.iter().filter(|draw| draw.class != shadowgraph::scene::DrawClass::Blend).cloned();
            let mut single: Vec<_> = blended
                .flat_map(|draw| {
                    let starts = draw.indices.clone().step_by(3);
                    starts.map(|at| shadowgraph::scene::Draw { indices: at..at + 3, ..draw.clone() })
                })
                .collect();
            random.shuffle(&mut single);
            *draws = opaque.chain(single).collect();
        });
        assert!(kitchen.run(ARRAYS, true).unwrap() == first, "{}: single triangles", soup.name);
    }
    silent(shared());
}

/// 100 runs of one order give the same bytes: what threads race for is decided by depth and triangle alone.
#[test]
fn transparency_abuffer_gives_the_same_bytes_in_every_run() {
    let soup = Soup::random(15, [128, 64], 60, 24);
    let (mut arrays, mut lists) = (Kitchen::new(shared(), &soup), Kitchen::new(shared(), &soup));
    let first = arrays.run(ARRAYS, false).unwrap();
    assert!(first.longest > 16 && first.count.contains(&3.0), "short and long pixels");
    for run in 0..100 {
        assert!(arrays.run(ARRAYS, false).unwrap() == first, "arrays, run {run}");
        let lists = lists.run(LISTS, false).unwrap();
        assert!(lists.color == first.color && lists.count == first.count, "lists, run {run}");
    }
    silent(shared());
}

/// Too small a guess is found, told exactly, and made good in the same frame.
#[test]
fn transparency_abuffer_with_too_few_nodes_is_built_again() {
    let soup = Soup::random(8, [16, 16], 3, 1);
    let mut kitchen = Kitchen::new(shared(), &soup);
    let whole = kitchen.run(LISTS, false).unwrap();
    let capacities: Vec<u32> = match whole.nodes {
        n if n > 400 => (0..24).chain((24..n - 24).step_by(37)).chain(n - 24..=n + 1).collect(),
        n => (0..=n + 1).collect(),
    };
    for &capacity in &capacities {
        let build = Build::Lists(Sizing::Guessed(capacity));
        let found = kitchen.run(ABuffer { build, ..LISTS }, false).unwrap();
        assert_eq!(found.counter, Some(whole.nodes), "capacity {capacity}");
        assert!(found.color == whole.color && found.count == whole.count, "capacity {capacity}");
    }
    println!("{} capacities up to {}", capacities.len(), whole.nodes + 1);
    // From frame to frame: fewer, a few more, and many more than the last one had.
    assert_eq!(Sizing::after(80), Sizing::Guessed(90));
    let mut last = 0;
    for layers in [3, 2, 4, 12, 12] {
        let soup = Soup::random(8, [16, 16], layers, 1);
        let mut kitchen = Kitchen::new(shared(), &soup);
        let whole = kitchen.run(LISTS, false).unwrap();
        let found = kitchen.run(ABuffer { build: Build::Lists(Sizing::after(last)), ..LISTS }, false).unwrap();
        assert!(found.color == whole.color && found.count == whole.count, "{layers} layers after {last} nodes");
        last = found.counter.unwrap();
        assert_eq!(last, whole.nodes);
    }
    silent(shared());
}

/// Without room for all fragments the frame fails and says how much is needed; with just as much it is whole.
#[test]
fn transparency_abuffer_without_memory_says_how_much_it_needs() {
    let mut kitchen = Kitchen::new(shared(), &Soup::random(8, [16, 16], 3, 1));
    for build in [ARRAYS, LISTS, ABuffer { build: Build::Lists(Sizing::Guessed(u32::MAX)), ..LISTS }] {
        let whole = kitchen.run(ABuffer { memory: 1 << 20, ..build }, false).unwrap();
        let nodes = whole.counter.unwrap_or(whole.nodes);
        let needed = 16 * u64::from(nodes);
        let said = kitchen.run(ABuffer { memory: needed - 1, ..build }, false).unwrap_err().to_string();
        let expected = format!("{nodes} fragments need {needed} bytes; there may be {}", needed - 16);
        assert!(said.contains(&expected), "{said}");
        let enough = kitchen.run(ABuffer { memory: needed, ..build }, false).unwrap();
        assert!(enough.color == whole.color);
    }
    // More than the device has at once: 40 layers of 2048×2048.
    let soup = Soup::random(14, [2048, 2048], 0, 40);
    let said = Kitchen::new(shared(), &soup).run(ARRAYS, false).unwrap_err().to_string();
    assert!(said.contains("fragments need 2"), "{said}");
    silent(shared());
}

/// Fragments that come when nobody counted them are lost, and the device says how many: of lists those that are in none, of
/// arrays the pixels that were filled beyond their end.
#[test]
fn transparency_abuffer_tells_what_it_lost() {
    for soup in [Soup::random(8, [16, 16], 3, 1), Soup::random(2, [64, 32], 60, 0)] {
        let mut kitchen = Kitchen::new(shared(), &soup);
        let covered = soup.fragments().iter().filter(|fragments| !fragments.is_empty()).count() as u32;
        let whole = kitchen.run(LISTS, false).unwrap();
        assert_eq!(whole.report, [0; 3]);
        // The query counted half of them.
        kitchen.twice = Some(Step::Lists);
        let found = kitchen.run(LISTS, false).unwrap();
        assert_eq!((found.counter, found.report), (Some(2 * whole.nodes), [0, 0, whole.nodes]), "{}", soup.name);
        // A guess that was too small is made good.
        for capacity in [0, whole.nodes, 2 * whole.nodes] {
            let build = Build::Lists(Sizing::Guessed(capacity));
            assert_eq!(kitchen.run(ABuffer { build, ..LISTS }, false).unwrap().report, [0; 3], "{capacity}");
        }
        kitchen.twice = Some(match shared().caps().has(Feature::OrderedAttachments) {
            true => Step::ArraysInOrder,
            false => Step::Arrays,
        });
        assert_eq!(kitchen.run(ARRAYS, false).unwrap().report, [covered, 0, 0], "{}", soup.name);
    }
    silent(shared());
}

/// Colours beyond what a format holds are counted, and a larger unit holds them.
#[test]
fn transparency_abuffer_counts_what_it_clamps() {
    let mut soup = Soup::random(12, [16, 16], 0, 3);
    soup.triangles.iter_mut().for_each(|triangle| triangle.color = [9e4, 1.0, 1.0, 1.0]);
    let mut kitchen = Kitchen::new(shared(), &soup);
    let covered = soup.fragments().iter().filter(|fragments| !fragments.is_empty()).count() as u32;
    for build in [ARRAYS, LISTS] {
        for format in [NodeFormat::Compact, NodeFormat::Half, NodeFormat::HalfTinted] {
            let found = kitchen.run(ABuffer { format, ..build }, false).unwrap();
            assert_eq!(found.report, [0, covered, 0], "{format:?}");
            let found = kitchen.run(ABuffer { format, exponent: 1, ..build }, false).unwrap();
            assert_eq!(found.report, [0; 3], "{format:?}");
        }
        let found = kitchen.run(ABuffer { format: NodeFormat::Float, ..build }, false).unwrap();
        assert_eq!(found.report, [0; 3]);
    }
    silent(shared());
}

/// The nearest layer is where the twin has it.
#[test]
fn transparency_abuffer_knows_the_nearest_layer() {
    for soup in [Soup::interpenetrating([32, 32], 12), Soup::random(4, [16, 16], 0, 64)] {
        let found = Kitchen::new(shared(), &soup).run(ARRAYS, false).unwrap();
        let mut comparison = Comparison::new(format!("{}: nearest", soup.name), soup.size, 1e-6);
        for (i, sorted) in soup.fragments().iter().enumerate() {
            let expected = sorted.first().map_or(f64::INFINITY, |fragment| 1.0 - fragment.depth);
            let found = f64::from(found.front[i]);
            comparison.error(i, if found == expected { 0.0 } else { found - expected });
        }
        Check::new(comparison, 1.0, 0.0).demand();
    }
    silent(shared());
}

/// The layers of each pixel, one by one, against those that the twin sorted: colours, alpha, distance.
fn nearest(soup: &Soup, found: &Found, tolerance: f64) -> Vec<Check> {
    let sorted = soup.fragments();
    let check = |(k, (colors, distances)): (usize, &(Vec<[f32; 4]>, Vec<f32>))| {
        let mut comparison = Comparison::new(format!("{}: layer {k}", soup.name), soup.size, tolerance);
        for (i, own) in sorted.iter().enumerate() {
            if !soup.sure(i, own) || close_call(own, DEPTH_MARGIN) {
                comparison.leave_out(i, "near in depth");
                continue;
            }
            let color = own.get(k).map_or(DVec4::ZERO, |fragment| fragment.color);
            let distance = own.get(k).map_or(f64::INFINITY, |fragment| 1.0 - fragment.depth);
            let color = (DVec4::from(colors[i].map(f64::from)) - color).abs().max_element();
            let found = f64::from(distances[i]);
            comparison.error(i, color.max(if found == distance { 0.0 } else { (found - distance).abs() }));
        }
        Check::new(comparison, 1.0, 0.1)
    };
    found.layers.iter().enumerate().map(check).collect()
}

/// Every layer on request is the one that the twin has there, of arrays, of lists and of bands; the last one asked for is
/// one more than any pixel has.
#[test]
fn transparency_abuffer_gives_each_layer() {
    let soups = [
        (Soup::random(5, [32, 32], 12, 20).with_any_alpha(), NodeFormat::Float, 1e-5),
        (Soup::coplanar([32, 32], 12), NodeFormat::Float, 1e-5),
        (Soup::interpenetrating([32, 32], 12).made_of(&[Kind::Glass, Kind::Blend]), NodeFormat::CompactTinted, 4e-3),
    ];
    for (soup, format, tolerance) in soups.into_iter().take(if is_long() { 3 } else { 2 }) {
        let deepest = soup.fragments().iter().map(Vec::len).max().unwrap() as u32;
        let mut kitchen = Kitchen::new(shared(), &soup);
        let arrays = ABuffer { format, layers: deepest + 1, ..ARRAYS };
        let found = kitchen.run(arrays, false).unwrap();
        assert_eq!(found.layers.len() as u32, deepest + 1);
        for check in nearest(&soup, &found, tolerance) {
            check.demand();
        }
        assert!(found.layers[0].1 == found.front && found.layers[deepest as usize].1.iter().all(|z| z.is_infinite()));
        let lists = kitchen.run(ABuffer { build: Build::Lists(Sizing::Guessed(7)), ..arrays }, false).unwrap();
        assert!(lists.layers == found.layers, "{}: lists", soup.name);
        if deepest < 16 {
            let banded = kitchen.run(ABuffer { memory: 128 << 10, bands: 8, ..arrays }, false).unwrap();
            assert!(banded.layers == found.layers, "{}: bands", soup.name);
        }
        // One layer further back is another layer.
        let shifted = Found { layers: found.layers[1..].to_vec(), ..found };
        assert!(nearest(&soup, &shifted, tolerance)[0].fails());
    }
    silent(shared());
}

/// Every way to sort gives the same bytes: random orders, presorted and turned ones, ties, lists on both sides of what is
/// sorted in place, and of every length.
#[test]
fn transparency_abuffer_sorts_alike_by_every_method() {
    let most = IN_PLACE_MOST as usize;
    // Rectangles whose depth falls, grows, and falls and grows, in the order that they are drawn.
    let by_depth = |depth: fn(usize) -> usize| {
        let mut soup = Soup::random(21, [8, 8], 0, most);
        for (i, triangle) in soup.triangles.iter_mut().enumerate() {
            triangle.depth = [0.3 + depth(i / 2) as f32 / 2048.0; 3];
        }
        soup.in_objects_of(1000)
    };
    let mut soups = vec![
        Soup::random(22, [8, 8], 40, most + 9).in_objects_of(100),
        by_depth(|i| if i % 2 == 0 { i } else { 1000 - i }),
    ];
    if is_long() {
        soups.extend([by_depth(|i| i), by_depth(|i| 1000 - i), Soup::coplanar([32, 32], 40)]);
        soups.extend((17..70).map(|layers| Soup::random(layers as u64, [8, 8], 0, layers)));
    }
    for soup in soups {
        let mut kitchen = Kitchen::new(shared(), &soup);
        let blocks = kitchen.run(ARRAYS, false).unwrap();
        assert!(blocks.longest > 16, "{}", soup.name);
        for long_sort in [LongSort::Shell, LongSort::Heap, LongSort::Bitonic] {
            for build in [ARRAYS, LISTS] {
                let found = kitchen.run(ABuffer { long_sort, ..build }, false).unwrap();
                assert!(found.color == blocks.color && found.report == [0; 3], "{}: {long_sort:?}", soup.name);
            }
        }
    }
    silent(shared());
}

/// Nodes allocated by subgroups are no more and no less, and give the same bytes: small triangles and large ones, behind
/// and before what is opaque, of every format, with too few nodes too.
#[test]
fn transparency_abuffer_by_subgroups_is_the_same() {
    if !shared().caps().has(Feature::FragmentBallot) || !shared().caps().has(Feature::OcclusionQueryPrecise) {
        return skip("no ballots among fragments, or no precise occlusion queries");
    }
    let soup = Soup::random(23, [64, 64], 200, 9).on_grid(shared().caps().limits.sub_pixel_bits);
    let mut kitchen = Kitchen::new(shared(), &soup);
    for format in [NodeFormat::Compact, NodeFormat::Half] {
        let lists = kitchen.run(ABuffer { format, ..LISTS }, false).unwrap();
        for (sizing, pulled) in [(Sizing::Counted, false), (Sizing::Counted, true), (Sizing::Guessed(99), false)] {
            let found = kitchen.run(ABuffer { build: Build::SubgroupLists(sizing), format, ..LISTS }, pulled).unwrap();
            assert_eq!((found.counter, found.nodes), (Some(lists.nodes), lists.nodes), "{format:?}, {sizing:?}");
            assert!(found.color == lists.color && found.count == lists.count, "{format:?}, {sizing:?}");
        }
    }
    silent(shared());
}

#[test]
fn transparency_abuffer_with_a_seeded_mistake_is_caught() {
    let soup = Soup::random(1, [64, 64], 6, 0);
    let fails = |mistaken: &Soup| {
        let found = Kitchen::new(shared(), mistaken).run(ARRAYS, false).unwrap();
        (counts(&soup, &found).fails(), colors(&soup, &found, 4e-3, "RGB9E5").fails())
    };
    assert_eq!(fails(&soup), (false, false));
    let changed = |change: fn(&mut Soup)| {
        let mut soup = soup.clone();
        change(&mut soup);
        soup
    };
    // A triangle less; two in the other order; a layer a little denser; a vertex moved by a pixel.
    assert_eq!(fails(&changed(|s| s.triangles.truncate(5))), (true, true));
    assert_eq!(fails(&changed(|s| s.triangles[4].depth = s.triangles[4].depth.map(|z| 1.0 - z))), (true, true));
    assert_eq!(
        fails(&changed(|s| s.triangles.iter_mut().for_each(|t| t.color[3] = (t.color[3] - 0.02).abs()))),
        (false, true)
    );
    assert_eq!(fails(&changed(|s| s.triangles[1].corners[0][0] ^= 256)), (true, true));
    // Glass of another colour; glass that hides instead.
    let glass = Soup::random(17, [32, 32], 12, 8).made_of(&[Kind::Glass]);
    let tinted = |mistaken: &Soup| {
        let found =
            Kitchen::new(shared(), mistaken).run(ABuffer { format: NodeFormat::CompactTinted, ..ARRAYS }, false);
        colors(&glass, &found.unwrap(), 4e-3, "RGB9E5, tinted").fails()
    };
    assert!(!tinted(&glass));
    let mut turned = glass.clone();
    turned.triangles.iter_mut().for_each(|triangle| triangle.color[..3].rotate_left(1));
    assert!(tinted(&turned) && tinted(&glass.clone().made_of(&[Kind::Blend])));
    // Nodes of one alpha cannot have it.
    let plain = Kitchen::new(shared(), &glass).run(ARRAYS, false).unwrap();
    assert!(colors(&glass, &plain, 4e-3, "RGB9E5").fails());
    // Ties the other way around: only the order of equal depths changes.
    let stack = Soup::coplanar([64, 64], 21);
    let mut turned = stack.clone();
    turned.triangles.reverse();
    let found = Kitchen::new(shared(), &turned).run(ARRAYS, false).unwrap();
    assert!(!counts(&stack, &found).fails() && colors(&stack, &found, 4e-3, "RGB9E5").fails());
    silent(shared());
}

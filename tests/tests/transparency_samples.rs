//! The A-buffer of several samples a pixel, against a twin that rasterises at the standard sample locations.
#![allow(missing_docs, clippy::unwrap_used)]

use std::collections::BTreeMap;

use glam::{Mat4, Vec3, Vec4};
use shadowgraph::gpu::Feature;
use shadowgraph::scene::{DrawClass, Scene};
use shadowgraph::techniques::transparency::abuffer::{
    ABuffer, Build, LongSort, Node, NodeFormat, Sizing, sample_counts,
};
use shadowgraph_tests::compare::Comparison;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::Check;
use shadowgraph_tests::harness::skip;
use shadowgraph_tests::soup::{BACKGROUND, Flat, Found, Kind, Kitchen, Random, Soup, rectangle};
use shadowgraph_tests::tiny;
use shadowgraph_tests::twin::layers::{GRID, Seen};

/// Arrays of so many samples a pixel.
fn arrays(samples: u32) -> ABuffer {
    ABuffer { samples, ..ABuffer::default() }
}

fn lists(of: ABuffer, sizing: Sizing) -> ABuffer {
    ABuffer { build: Build::Lists(sizing), ..of }
}

/// Numbers of samples that this device has; a test without any is skipped.
fn counts() -> Vec<u32> {
    if !shared().caps().limits.standard_sample_locations {
        skip("standardSampleLocations: the twin knows no others");
        return Vec::new();
    }
    let counts = sample_counts(shared().caps());
    if counts.is_empty() {
        skip(&Feature::PostDepthCoverage.describe());
    }
    counts
}

fn on_grid(soup: Soup) -> Soup {
    soup.on_grid(shared().caps().limits.sub_pixel_bits)
}

/// The samples that each triangle is seen at, by its number.
type Masks = BTreeMap<u32, u32>;

fn masks_of(nodes: &[Node]) -> Masks {
    let mut masks = Masks::new();
    for node in nodes {
        // A device that clips a triangle makes several of it.
        let all = masks.entry(node.key).or_default();
        assert_eq!(*all & node.samples, 0, "a sample is covered twice by triangle {}", node.key);
        *all |= node.samples;
    }
    masks
}

fn masks_seen(seen: &[Seen]) -> Masks {
    seen.iter().map(|seen| (seen.fragment.key, seen.samples)).collect()
}

/// Which samples see which triangle: exactly, in every pixel.
fn masks(soup: &Soup, samples: u32, found: &[Vec<Node>]) -> Check {
    let mut comparison = Comparison::new(format!("{}: {samples} samples, masks", soup.name), soup.size, 0.0);
    for (i, seen) in soup.seen(samples).iter().enumerate() {
        match seen {
            Some(seen) => comparison.error(i, f64::from(u8::from(masks_of(&found[i]) != masks_seen(seen)))),
            None => comparison.leave_out(i, "near in depth"),
        }
    }
    Check::new(comparison, 1.0, 0.1)
}

fn colors(soup: &Soup, samples: u32, found: &Found, tolerance: f64) -> Check {
    soup.compare_samples(&found.color, samples, tolerance, &format!("{samples} samples, color"))
}

/// Pixels whose samples and centre all see the same triangles.
fn whole(soup: &Soup, samples: u32) -> Vec<bool> {
    let all = (1 << samples) - 1;
    let of = |(several, centre): (&Option<Vec<Seen>>, &Option<Vec<Seen>>)| {
        let (Some(several), Some(centre)) = (several, centre) else { return false };
        several.len() == centre.len() && several.iter().all(|seen| seen.samples == all)
    };
    soup.seen(samples).iter().zip(&soup.seen(1)).map(of).collect()
}

#[test]
fn portable_transparency_samples_are_exact() {
    for samples in counts() {
        let (mut edges, mut alike) = (0, 0);
        for soup in [
            Soup::random(2, [64, 32], 60, 0).leaning(9),
            Soup::random(3, [32, 32], 40, 30).leaning(-7),
            Soup::interpenetrating([32, 32], 12).leaning(5),
            Soup::coplanar([64, 64], 21).leaning(3),
        ] {
            let soup = on_grid(soup);
            let mut kitchen = Kitchen::new(shared(), &soup);
            let found = kitchen.run(arrays(samples), false).unwrap();
            masks(&soup, samples, &kitchen.nodes(arrays(samples), false).unwrap()).demand();
            colors(&soup, samples, &found, 4e-3).demand();
            assert_eq!(found.report, [0; 3]);
            assert!(kitchen.run(arrays(samples), true).unwrap() == found, "{}: vertices pulled by hand", soup.name);
            for sizing in [Sizing::Counted, Sizing::Guessed(7)] {
                let lists = kitchen.run(lists(arrays(samples), sizing), sizing == Sizing::Counted).unwrap();
                assert!(lists.color == found.color && lists.count == found.count, "{}: {sizing:?}", soup.name);
                assert_eq!((lists.counter, lists.report), (Some(found.nodes), [0; 3]));
            }
            // Edges are where both differ, and nowhere else.
            let single = kitchen.run(arrays(1), false).unwrap();
            let whole = whole(&soup, samples);
            let differ = |i: &usize| single.color[*i] != found.color[*i];
            let inside = (0..whole.len()).filter(|i| whole[*i]).collect::<Vec<_>>();
            assert_eq!(inside.iter().copied().filter(differ).collect::<Vec<_>>(), [0; 0], "{}", soup.name);
            edges += (0..whole.len()).filter(differ).count();
            alike += inside.len();
        }
        assert!(edges > 1000 && alike > 1000, "{edges} pixels are anti-aliased, {alike} are as with one sample");
    }
    silent(shared());
}

/// Every format of nodes, lists that are sorted in memory in every way, and bands.
#[test]
fn transparency_samples_are_kept_by_every_format() {
    let samples = 4;
    if !counts().contains(&samples) {
        return;
    }
    let kinds = [Kind::Glass, Kind::Blend, Kind::Premultiplied, Kind::Add];
    let plain = Soup::random(5, [32, 32], 40, 30).with_any_alpha().leaning(4);
    let glass = Soup::random(16, [64, 64], 24, 3).made_of(&kinds).leaning(4);
    let cases = [
        (&plain, NodeFormat::Half, 2e-3),
        (&plain, NodeFormat::Float, 1e-5),
        (&glass, NodeFormat::CompactTinted, 4e-3),
        (&glass, NodeFormat::HalfTinted, 2e-3),
        (&glass, NodeFormat::FloatTinted, 1e-5),
    ];
    for (soup, format, tolerance) in cases {
        let mut kitchen = Kitchen::new(shared(), soup);
        let of = ABuffer { format, ..arrays(samples) };
        let found = kitchen.run(of, false).unwrap();
        colors(soup, samples, &found, tolerance).demand();
        if format != NodeFormat::HalfTinted {
            masks(soup, samples, &kitchen.nodes(of, false).unwrap()).demand();
        }
        let lists = kitchen.run(lists(of, Sizing::Counted), false).unwrap();
        assert!(lists.color == found.color && lists.count == found.count, "{format:?}");
    }
    let long = Soup::random(4, [16, 16], 10, 512).leaning(5);
    let mut kitchen = Kitchen::new(shared(), &long);
    let of = ABuffer { format: NodeFormat::Float, ..arrays(samples) };
    let found = kitchen.run(of, false).unwrap();
    colors(&long, samples, &found, 1e-5).demand();
    let changed = [
        ABuffer { long_sort: LongSort::Shell, ..of },
        lists(ABuffer { long_sort: LongSort::Heap, ..of }, Sizing::Counted),
        ABuffer { memory: 3 << 20, bands: 8, ..of },
    ];
    for changed in changed {
        assert!(kitchen.run(changed, false).unwrap().color == found.color, "{changed:?}");
    }
    silent(shared());
}

/// Triangles that share edges blend once: what they cover together is as if it was one.
#[test]
fn transparency_samples_of_shared_edges_blend_once() {
    // A fan around a point, over the whole picture, and a strip of slivers.
    let size = [64, 64];
    let far = size.map(|side| i64::from(side) * GRID);
    let around = [[0, 0], [900, 0], [far[0], 0], [far[0], 7000], far, [9001, far[1]], [0, far[1]], [0, 3333]];
    let flat = |corners| Flat { corners, depth: [0.5; 3], color: [0.8, 0.4, 0.2, 0.6] };
    let mut soup = Soup::random(1, size, 0, 0);
    soup.name = "a fan".into();
    soup.per_object = 1000;
    let middle = [31 * GRID + 77, 17 * GRID + 201];
    soup.triangles = (0..8).map(|i| flat([middle, around[i], around[(i + 1) % 8]])).collect();
    let slivers = Soup {
        name: "slivers".into(),
        triangles: (0..97)
            .flat_map(|i| {
                let [left, right] = [i, i + 1].map(|i| i * far[0] / 97);
                rectangle([left, 0], [right, far[1]], [0.5; 4], [0.8, 0.4, 0.2, 0.6])
            })
            .collect(),
        ..soup.clone()
    };
    let whole = Soup { triangles: rectangle([0, 0], far, [0.5; 4], [0.8, 0.4, 0.2, 0.6]).into(), ..soup.clone() };
    for samples in counts() {
        let once = Kitchen::new(shared(), &whole).run(arrays(1), false).unwrap();
        for soup in [&soup, &slivers] {
            let mut kitchen = Kitchen::new(shared(), soup);
            let found = kitchen.run(arrays(samples), false).unwrap();
            let nodes = kitchen.nodes(arrays(samples), false).unwrap();
            let mut shared_pixels = 0;
            for (i, color) in found.color.iter().enumerate() {
                let error = (Vec4::from(*color) - Vec4::from(once.color[i])).abs().max_element();
                assert!(error < 1e-6, "{}, pixel {i}: {color:?}, not {:?}", soup.name, once.color[i]);
                let seen = nodes[i].iter().map(|node| node.samples);
                assert_eq!(seen.clone().sum::<u32>(), (1 << samples) - 1, "{}, pixel {i}: samples", soup.name);
                assert_eq!(seen.fold(0, |all, mask| all | mask), (1 << samples) - 1, "{}, pixel {i}", soup.name);
                shared_pixels += usize::from(nodes[i].len() > 1);
            }
            assert!(shared_pixels > 100, "{}: {shared_pixels} pixels have an edge", soup.name);
        }
    }
    silent(shared());
}

#[test]
fn transparency_samples_do_not_depend_on_the_order_of_draws() {
    let mut random = Random::new(4);
    let samples = 4;
    if !counts().contains(&samples) {
        return;
    }
    for soup in [Soup::coplanar([64, 64], 21).leaning(3), Soup::random(6, [32, 32], 120, 12).leaning(6)] {
        let mut kitchen = Kitchen::new(shared(), &soup);
        let first = kitchen.run(arrays(samples), false).unwrap();
        for run in 0..100 {
            kitchen.shuffle(&mut random);
            let found = match run % 4 {
                0 => kitchen.run(lists(arrays(samples), Sizing::Guessed(1 << 16)), run % 8 == 0).unwrap(),
                _ => kitchen.run(arrays(samples), run % 2 == 1).unwrap(),
            };
            assert!(found.color == first.color && found.count == first.count, "{}: run {run} differs", soup.name);
        }
        // Draws of single triangles, in any order over all objects.
        kitchen.reorder(|draws| {
            let (blended, opaque): (Vec<_>, Vec<_>) =
                draws.iter().cloned().partition(|draw| draw.class == DrawClass::Blend);
            let single = blended.iter().flat_map(|draw| {
                let starts = draw.indices.clone().step_by(3);
                starts.map(|at| shadowgraph::scene::Draw { indices: at..at + 3, ..draw.clone() })
            });
            let mut single: Vec<_> = single.collect();
            random.shuffle(&mut single);
            *draws = opaque.into_iter().chain(single).collect();
        });
        assert!(kitchen.run(arrays(samples), true).unwrap() == first, "{}: single triangles", soup.name);
    }
    silent(shared());
}

/// Of a pixel whose centre is not covered, attributes are taken from within the triangle.
#[test]
fn transparency_samples_extrapolate_nothing() {
    // Slivers a few pixels wide, each from a dark edge to a bright one.
    let size = [64, 64];
    let (low, high) = (0.25f32, 0.75f32);
    let mut scene: Scene = Soup::random(1, size, 0, 0).scene();
    scene.objects.clear();
    let at = |x: f32, y: f32| Vec3::new(x, y, 0.5);
    let slivers: Vec<_> = (0..12)
        .map(|i| {
            let x = 1.1 + 5.03 * i as f32;
            [at(x, 0.0), at(x + 2.3, 0.0), at(x + 1.15 + 0.31 * i as f32, 64.0)]
        })
        .collect();
    let mut primitive = tiny::triangles(&slivers, 1);
    primitive.colors = slivers.iter().flat_map(|_| [low, high, high]).map(|c| Vec4::new(c, c, c, 1.0)).collect();
    tiny::add(&mut scene, primitive, Mat4::IDENTITY);
    let soup = Soup::random(1, size, 0, 0);
    for samples in counts() {
        let mut kitchen = Kitchen::new(shared(), &soup);
        kitchen.scene = scene.clone().upload(shared()).unwrap();
        let of = ABuffer { format: NodeFormat::Float, ..arrays(samples) };
        let found = kitchen.run(of, false).unwrap();
        let nodes = kitchen.nodes(of, false).unwrap();
        let mut partial = 0;
        for (i, nodes) in nodes.iter().enumerate() {
            for node in nodes {
                let [red, ..] = node.color;
                assert!((low - 1e-5..=high + 1e-5).contains(&red), "pixel {i}, samples {:#b}: {red}", node.samples);
                partial += usize::from(node.samples != (1 << samples) - 1);
            }
            if let [node] = &nodes[..] {
                let share = node.samples.count_ones() as f32 / samples as f32;
                let expected = share * node.color[0] + (1.0 - share) * BACKGROUND[0];
                assert!((found.color[i][0] - expected).abs() < 1e-5, "pixel {i}");
            }
        }
        assert!(partial > 100, "{partial} pixels are covered in part");
    }
    silent(shared());
}

/// A layer as an image of its own is averaged over the pixel's samples.
#[test]
fn transparency_samples_weigh_each_layer() {
    for samples in counts() {
        let soup = Soup::random(5, [32, 32], 12, 4).with_any_alpha().leaning(5);
        let mut kitchen = Kitchen::new(shared(), &soup);
        let of = ABuffer { format: NodeFormat::Float, layers: 3, ..arrays(samples) };
        let found = kitchen.run(of, false).unwrap();
        for (k, (colors, distances)) in found.layers.iter().enumerate() {
            let mut comparison = Comparison::new(format!("{samples} samples: layer {k}"), soup.size, 1e-5);
            for (i, seen) in soup.seen(samples).iter().enumerate() {
                let Some(seen) = seen else {
                    comparison.leave_out(i, "near in depth");
                    continue;
                };
                // Fragments that share no sample are in an order, too.
                if seen.windows(2).any(|pair| pair[0].fragment.depth - pair[1].fragment.depth < 1e-6) {
                    comparison.leave_out(i, "near in depth");
                    continue;
                }
                let own = seen.get(k);
                let share = |seen: &Seen| f64::from(seen.samples.count_ones()) / f64::from(samples);
                let color = own.map_or(glam::DVec4::ZERO, |seen| seen.fragment.color * share(seen));
                let distance = own.map_or(f64::INFINITY, |seen| 1.0 - seen.fragment.depth);
                let off = f64::from(distances[i]) - distance;
                let error = (glam::DVec4::from(colors[i].map(f64::from)) - color).abs().max_element();
                comparison.error(i, error.max(if f64::from(distances[i]) == distance { 0.0 } else { off.abs() }));
            }
            Check::new(comparison, 1.0, 0.1).demand();
        }
    }
    silent(shared());
}

/// What cannot be done is refused, and what could be is named.
#[test]
fn portable_transparency_samples_that_are_not_there_are_refused() {
    let soup = Soup::random(1, [16, 16], 2, 0);
    let mut kitchen = Kitchen::new(shared(), &soup);
    let said = kitchen.run(arrays(16), false).unwrap_err().to_string();
    let because = match shared().caps().has(Feature::PostDepthCoverage) {
        true => "1 or one of",
        false => "which lacks PostDepthCoverage (VK_EXT_post_depth_coverage)",
    };
    assert!(said.contains("pass `abuffer`, slot `samples`: are 16 a pixel; 1 "), "{said}");
    assert!(said.contains(because), "{said}");
    for samples in counts() {
        let said = kitchen.composite(&arrays(samples), false).unwrap_err().to_string();
        assert!(said.contains("slot `opaque depth`: has 1 samples a pixel"), "{said}");
    }
}

#[test]
fn transparency_samples_with_a_seeded_mistake_are_caught() {
    let samples = 4;
    if !counts().contains(&samples) {
        return;
    }
    let soup = Soup::random(1, [64, 64], 6, 9).leaning(9);
    let fails = |mistaken: &Soup, samples: u32| {
        let mut kitchen = Kitchen::new(shared(), mistaken);
        let found = kitchen.run(arrays(samples), false).unwrap();
        let nodes = kitchen.nodes(arrays(samples), false).unwrap();
        (masks(&soup, 4, &nodes).fails(), colors(&soup, 4, &found, 4e-3).fails())
    };
    assert_eq!(fails(&soup, samples), (false, false));
    // One sample a pixel; an opaque edge that leans an eighth of a pixel more; a vertex as much further to the right.
    assert_eq!(fails(&soup, 1), (true, true));
    assert!(fails(&Soup { lean: soup.lean + GRID / 8, ..soup.clone() }, samples).0);
    let mut moved = soup.clone();
    moved.triangles[1].corners[0][0] += GRID / 8;
    assert_eq!(fails(&moved, samples), (true, true));
    silent(shared());
}

//! How much memory the project's own frames take, against what any placement of them must take.
#![allow(missing_docs, clippy::unwrap_used)]

use shadowgraph::frame::{FrameSettings, Selection};
use shadowgraph::graph::Graph;
use shadowgraph::techniques::surface::gbuffer::Precision;
use shadowgraph_tests::device;
use shadowgraph_tests::figures::{Figure, publish_page};
use shadowgraph_tests::packing::best_order;
use shadowgraph_tests::render::Subject;

/// Bytes of the heaps, without sharing, and at the best of 100 orders; all for one frame.
struct Row {
    heap: u64,
    alone: u64,
    bound: u64,
    best: u64,
}

fn row(subject: &Subject, change: impl FnOnce(&mut FrameSettings)) -> Row {
    let gpu = device::shared();
    let scene = subject.scene.clone().upload(gpu).unwrap();
    let mut settings = FrameSettings::new(subject.view());
    change(&mut settings);
    let mut graph = Graph::new("frame", gpu.caps());
    settings.record(&mut graph, &scene);
    let plan = graph.compile(gpu).unwrap();
    let figures = plan.statistics;
    Row {
        heap: figures.heap_bytes,
        alone: figures.unaliased_bytes,
        bound: figures.lower_bound_bytes,
        best: best_order(graph.description(), &plan, 100),
    }
}

#[test]
fn frames_take_little_memory() {
    let only = |layers: &'static [&str]| {
        move |settings: &mut FrameSettings| {
            settings.layers = Selection::Only(layers.iter().map(|layer| layer.to_string()).collect());
        }
    };
    let float = |settings: &mut FrameSettings| {
        settings.precision = Precision::Float;
        only(&["color"])(settings);
    };
    let size = [1280, 720];
    let courtyard = Subject::builtin("courtyard", size);
    let cornell = Subject::builtin("cornell", size);
    let mut rows = vec![
        ("courtyard, all layers", row(&courtyard, |_| {})),
        ("courtyard, `color`", row(&courtyard, only(&["color"]))),
        ("courtyard, `color` with a G-buffer of floats", row(&courtyard, float)),
        ("courtyard, `color`, `Z` and `N`", row(&courtyard, only(&["color", "Z", "N"]))),
        ("courtyard, the sun's mask", row(&courtyard, only(&["shadow"]))),
        ("cornell, `color`", row(&cornell, only(&["color"]))),
    ];
    if let Some(hall) = Subject::file("DungeonHall", size) {
        rows.push(("DungeonHall, `color`", row(&hall, only(&["color"]))));
    }

    let mut figures = Vec::new();
    for (what, Row { heap, alone, bound, best }) in rows {
        let [over_bound, over_best] = [bound, best].map(|least| heap as f64 / least.max(1) as f64);
        assert!(over_bound <= 1.02, "{what}: heaps of {heap} bytes for {bound} alive at once");
        let [heap, alone] = [heap, alone].map(|bytes| bytes as f64 / 1e6);
        let value = format!(
            "{heap:.1} MB for {alone:.1} MB; {over_bound:.3} of the bound, {over_best:.3} of the best of 100 orders"
        );
        figures.push(Figure { what: what.into(), value, bound: "at most 1.02 of the bound".into() });
    }
    publish_page("graph/memory.md", "frame_memory", &device::shared().caps().title(), &figures);
}

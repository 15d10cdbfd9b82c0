//! How long it takes to describe and to plan chains and trees of passes, and that it does not grow faster than they do.
#![allow(clippy::unwrap_used)]

use std::time::{Duration, Instant};

use ash::vk::PipelineStageFlags2 as Stages;
use shadowgraph::graph::description::{Access, Queue, VersionId};
use shadowgraph::graph::plan::{Plan, plan};
use shadowgraph_tests::hazard::{Draft, MadeUpDevice};

const COMPUTE: Stages = Stages::COMPUTE_SHADER;

/// Pass `i` reads image `i` and writes image `i + 1`.
fn chain(passes: usize) -> Draft {
    let mut draft = Draft::new("chain");
    let mut last: Option<VersionId> = None;
    for index in 0..passes {
        let image = draft.image(&format!("image{index}"), [64, 64]);
        last = Some(draft.pass(&format!("pass{index}"), Queue::Graphics, |pass| {
            if let Some(last) = last {
                pass.read("source", last, Access::sampled(COMPUTE));
            }
            pass.overwrite("target", image, Access::storage_image_write(COMPUTE))
        }));
    }
    draft.capture("last", last.unwrap());
    draft
}

/// Each pass reads what two others wrote, down to passes that read nothing.
fn tree(passes: usize) -> Draft {
    let mut draft = Draft::new("tree");
    let mut waiting = std::collections::VecDeque::new();
    for index in 0..passes {
        let image = draft.image(&format!("image{index}"), [64, 64]);
        let sources: Vec<VersionId> =
            if index < passes.div_ceil(2) { Vec::new() } else { waiting.drain(..waiting.len().min(2)).collect() };
        waiting.push_back(draft.pass(&format!("pass{index}"), Queue::Graphics, |pass| {
            for (slot, source) in sources.iter().enumerate() {
                pass.read(&format!("source{slot}"), *source, Access::sampled(COMPUTE));
            }
            pass.overwrite("target", image, Access::storage_image_write(COMPUTE))
        }));
    }
    draft.capture("root", waiting.pop_back().unwrap());
    draft
}

/// The shortest of several runs.
fn shortest<T>(runs: usize, mut run: impl FnMut() -> T) -> (Duration, T) {
    let mut best: Option<(Duration, T)> = None;
    for _ in 0..runs {
        let start = Instant::now();
        let result = run();
        let time = start.elapsed();
        if best.as_ref().is_none_or(|(known, _)| time < *known) {
            best = Some((time, result));
        }
    }
    best.unwrap()
}

fn planned(graph: fn(usize) -> Draft, passes: usize) -> (Duration, Plan) {
    let draft = graph(passes);
    let device = MadeUpDevice::one_queue();
    shortest(20_000 / passes + 3, || plan(&draft.description, &device).unwrap())
}

#[test]
#[ignore = "takes time, and is of use with optimisations alone"]
fn planning_takes_microseconds_a_pass() {
    for (name, graph) in [("chain", chain as fn(usize) -> Draft), ("tree", tree)] {
        for passes in [10, 100, 1000, 10_000] {
            let (described, _) = shortest(10, || graph(passes));
            let (time, plan) = planned(graph, passes);
            let each = |time: Duration| time.as_secs_f64() * 1e6 / passes as f64;
            println!(
                "{name} of {passes}: describe {:.3} us a pass, plan {:.3} us a pass, {} of {} bytes",
                each(described),
                each(time),
                plan.statistics.heap_bytes,
                plan.statistics.unaliased_bytes
            );
        }
    }
}

/// With room for a noisy machine: the quadratic takes a hundred times as long.
#[test]
#[ignore = "a busy machine fails it"]
fn planning_time_grows_with_the_number_of_passes() {
    for (name, graph) in [("chain", chain as fn(usize) -> Draft), ("tree", tree)] {
        let [short, long] = [1000, 10_000].map(|passes| planned(graph, passes).0.as_secs_f64());
        println!("{name}: 10000 passes take {:.1} times as long as 1000", long / short);
        assert!(long < 25.0 * short, "{name}: {long} s after {short} s");
    }
}

//! Frames made ready once and run many times.
#![allow(missing_docs, clippy::unwrap_used)]

use std::cell::Cell;

use ash::vk;
use shadowgraph::graph::{Executor, First, Graph, History, ImageShape};
use shadowgraph::shader::generated::bench::chain_comp as chain;
use shadowgraph_tests::device::isolated_device;

const SHAPE: ImageShape =
    ImageShape { format: vk::Format::R32_UINT, extent: [16, 16, 1], mips: 1, layers: 1, samples: 1 };

/// `start` cleared to 7, and five passes that add what `added` says.
fn describe<'f>(graph: &mut Graph<'f>, added: &'f Cell<u32>) {
    let start = graph.image("start", SHAPE);
    let mut last = graph.clear("clear", start, vk::ClearColorValue { uint32: [7, 0, 0, 0] });
    for number in 0..5 {
        let to = graph.image(format!("sum {number}"), SHAPE);
        let mut pass = graph.compute(format!("add {number}"), &chain::SHADER);
        pass.read(chain::FROM, &last).push_with(move || added.get() + number);
        last = pass.write(chain::TO, to);
        pass.dispatch([16, 16, 1]);
    }
    graph.capture("result", &last);
}

#[test]
fn a_prepared_frame_runs_again_with_other_push_constants() {
    isolated_device("a_prepared_frame_runs_again_with_other_push_constants", |gpu| {
        let added = Cell::new(0);
        let mut executor = Executor::new(gpu);
        let mut graph = Graph::new("frame", gpu.caps());
        describe(&mut graph, &added);
        let plan = graph.compile(gpu).unwrap();
        let mut prepared = executor.prepare(&plan, graph).unwrap();
        let mut kept = Vec::new();
        for (run, instruments) in [(1, true), (100, false), (3, true)] {
            added.set(run);
            executor.instruments(instruments);
            // What another frame leaves in the shared memory does not matter.
            let mut other = Graph::new("other", gpu.caps());
            let noise = other.image("noise", SHAPE);
            let noise = other.clear("fill", noise, vk::ClearColorValue { uint32: [99, 0, 0, 0] });
            other.capture("noise", &noise);
            let other_plan = other.compile(gpu).unwrap();
            executor.execute(&other_plan, other).unwrap();

            let executed = executor.run(&mut prepared).unwrap();
            kept.push((7 + 5 * run + 10, executed));
        }
        // Each run reads back into memory of its own.
        for (expected, executed) in &kept {
            let texels = executed.capture("result").unwrap().texels::<u32>().unwrap();
            assert_eq!(texels, vec![*expected; 256]);
        }
        // Made ready while instruments were on: passes are timed.
        let names: Vec<_> = kept[0].1.passes.iter().map(|pass| pass.name.as_str()).collect();
        assert_eq!(names, ["clear", "add 0", "add 1", "add 2", "add 3", "add 4", "read back result"]);
    });
}

#[test]
fn frames_that_depend_on_the_last_one_are_refused() {
    isolated_device("frames_that_depend_on_the_last_one_are_refused", |gpu| {
        let mut executor = Executor::new(gpu);
        let mut graph = executor.graph("frame");
        let first = First::Color(vk::ClearColorValue::default());
        let History { previous, next, .. } = graph.history_image("light", SHAPE, first);
        let mut pass = graph.compute("add", &chain::SHADER);
        pass.read(chain::FROM, &previous).push(&1u32);
        let next = pass.write(chain::TO, next);
        pass.dispatch([16, 16, 1]);
        graph.capture("result", &next);
        let plan = graph.compile(gpu).unwrap();
        let Err(error) = executor.prepare(&plan, graph) else { panic!("it was made ready") };
        assert!(error.to_string().contains("histories or checkpoints"), "{error}");
    });
}

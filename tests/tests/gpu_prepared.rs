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
fn a_frame_described_alike_takes_the_same_plan() {
    isolated_device("a_frame_described_alike_takes_the_same_plan", |gpu| {
        let added = Cell::new(0);
        let mut executor = Executor::new(gpu);
        let mut last = None;
        for (run, more) in [(1, false), (5, false), (9, true), (13, true), (2, false)] {
            added.set(run);
            let mut graph = executor.graph("frame");
            describe(&mut graph, &added);
            if more {
                let image = graph.image("more", SHAPE);
                let image = graph.clear("clear more", image, vk::ClearColorValue { uint32: [run, 0, 0, 0] });
                graph.capture("more", &image);
            }
            let plan = executor.plan(&graph).unwrap();
            assert_eq!(*plan, graph.compile(gpu).unwrap());
            let same = last.replace((more, plan.clone())).is_some_and(|(_, last)| std::sync::Arc::ptr_eq(&last, &plan));
            assert_eq!(same, run == 5 || run == 13, "run {run}");
            let executed = executor.execute(&plan, graph).unwrap();
            let texels = executed.capture("result").unwrap().texels::<u32>().unwrap();
            assert_eq!(texels, vec![7 + 5 * run + 10; 256]);
            if more {
                assert_eq!(executed.capture("more").unwrap().texels::<u32>().unwrap(), vec![run; 256]);
            }
        }
    });
}

#[test]
fn a_plan_found_again_has_the_mistakes_of_its_own_frame() {
    isolated_device("a_plan_found_again_has_the_mistakes_of_its_own_frame", |gpu| {
        let added = Cell::new(1);
        let mut executor = Executor::new(gpu);
        let mut graph = executor.graph("frame");
        describe(&mut graph, &added);
        let plan = executor.plan(&graph).unwrap();
        executor.execute(&plan, graph).unwrap();
        let mut graph = executor.graph("frame");
        describe(&mut graph, &added);
        // The description is the same; what the typed layer saw is not.
        let mut other = Graph::new("other", gpu.caps());
        let image = other.image("image", SHAPE);
        graph.compute("half", &chain::SHADER).read(chain::FROM, &image);
        let text = executor.plan(&graph).unwrap_err().to_string();
        assert!(text.contains("handle of another graph"), "{text}");
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

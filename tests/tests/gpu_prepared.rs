//! Frames made ready once and run many times.
#![allow(missing_docs, clippy::unwrap_used)]

use std::cell::Cell;

use ash::vk;
use shadowgraph::graph::{Executed, Executor, First, Graph, ImageShape};
use shadowgraph::shader::generated::bench::{chain_comp as chain, join_comp as join};
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
fn host_memory_of_captures_is_used_again_once_nobody_looks() {
    isolated_device("host_memory_of_captures_is_used_again_once_nobody_looks", |gpu| {
        let added = Cell::new(1);
        let mut executor = Executor::new(gpu);
        let mut frame = |capture: bool| {
            let mut graph = Graph::new("frame", gpu.caps());
            match capture {
                true => describe(&mut graph, &added),
                false => _ = graph.image("unused", SHAPE),
            }
            let plan = graph.compile(gpu).unwrap();
            executor.execute(&plan, graph).unwrap()
        };
        let buffers = || gpu.live_objects().iter().filter(|object| object.contains("capture result")).count();
        let held = frame(true);
        drop(frame(true));
        assert_eq!(buffers(), 2, "the first frame's capture is still held");
        drop(frame(true));
        assert_eq!(buffers(), 2, "the third frame reads back where the second did");
        drop(held);
        (0..4).for_each(|_| drop(frame(false)));
        assert_eq!(buffers(), 1, "what the third frame used may still be wanted");
        drop(frame(false));
        assert_eq!(buffers(), 0, "nobody wanted it for five submissions");
    });
}

/// Adds `added` to what the last frame left; a first frame finds 7. `mask` is a history that no frame but the first one
/// writes, and each adds it.
fn accumulate<'f>(graph: &mut Graph<'f>, added: &'f Cell<u32>) {
    let first = |value| First::Color(vk::ClearColorValue { uint32: [value, 0, 0, 0] });
    let light = graph.history_image("light", SHAPE, first(7));
    let mask = graph.history_image("mask", SHAPE, first(100));
    if mask.is_first {
        let next = graph.clear("mask", mask.next, vk::ClearColorValue { uint32: [1, 0, 0, 0] });
        graph.capture("mask", &next);
    }
    let mut pass = graph.compute("add", &chain::SHADER);
    pass.read(chain::FROM, &light.previous).push_with(|| added.get());
    let next = pass.write(chain::TO, light.next);
    pass.dispatch([16, 16, 1]);
    let sum = graph.image("sum", SHAPE);
    let mut pass = graph.compute("sum", &join::SHADER);
    pass.read(join::LEFT, &next).read(join::RIGHT, &mask.previous);
    let sum = pass.write(join::SUM, sum);
    pass.dispatch([16, 16, 1]);
    graph.capture("light", &next);
    graph.capture("sum", &sum);
}

fn texels(executed: &Executed, name: &str) -> Vec<u32> {
    executed.capture(name).unwrap().texels::<u32>().unwrap()
}

#[test]
fn histories_of_a_prepared_frame_take_turns() {
    isolated_device("histories_of_a_prepared_frame_take_turns", |gpu| {
        let added = Cell::new(0);
        let mut executor = Executor::new(gpu);
        let mut light = 7;
        let execute = |executor: &mut Executor, value| {
            added.set(value);
            let mut graph = executor.graph("frame");
            accumulate(&mut graph, &added);
            let plan = executor.plan(&graph).unwrap();
            executor.execute(&plan, graph).unwrap()
        };
        // Two frames: the first one reads the first value of `mask`, the second one what the first one wrote.
        for (value, mask) in [(1, 100), (10, 1)] {
            light += value;
            let executed = execute(&mut executor, value);
            assert_eq!(texels(&executed, "light"), vec![light; 256]);
            assert_eq!(texels(&executed, "sum"), vec![light + mask; 256]);
        }
        let more = Cell::new(0);
        for runs in [3, 2] {
            let mut graph = executor.graph("frame");
            accumulate(&mut graph, &more);
            let plan = executor.plan(&graph).unwrap();
            let mut prepared = executor.prepare(&plan, graph).unwrap();
            for run in 0..runs {
                more.set(1000 + run);
                light += more.get();
                let executed = executor.run(&mut prepared).unwrap();
                assert_eq!(texels(&executed, "light"), vec![light; 256], "run {run} of {runs}");
                assert_eq!(texels(&executed, "sum"), vec![light + 1; 256], "run {run} of {runs}");
            }
            // A frame that is executed goes on with what the runs left.
            light += 5;
            assert_eq!(texels(&execute(&mut executor, 5), "light"), vec![light; 256]);
            // So the prepared one does not fit any more.
            let error = executor.run(&mut prepared).err().unwrap().to_string();
            assert!(error.contains("another frame went on with it"), "{error}");
        }
    });
}

#[test]
fn what_changes_from_run_to_run_is_not_prepared() {
    isolated_device("what_changes_from_run_to_run_is_not_prepared", |gpu| {
        let added = Cell::new(1);
        let mut executor = Executor::new(gpu);
        let refused = |executor: &mut Executor, why: &str| {
            let mut graph = executor.graph("frame");
            accumulate(&mut graph, &added);
            let plan = graph.compile(gpu).unwrap();
            let error = executor.prepare(&plan, graph).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(error.contains(why), "{error}");
        };
        refused(&mut executor, "has no last frame: execute a frame like it first");
        let mut graph = executor.graph("frame");
        accumulate(&mut graph, &added);
        let plan = graph.compile(gpu).unwrap();
        executor.execute(&plan, graph).unwrap();
        // `mask` was written, and now is read by compute shaders: the next frame finds it so.
        refused(&mut executor, "is left in another state than it is found in: execute a frame like it once more");
        let mut graph = executor.graph("frame");
        accumulate(&mut graph, &added);
        let plan = graph.compile(gpu).unwrap();
        executor.execute(&plan, graph).unwrap();
        let mut graph = executor.graph("frame");
        accumulate(&mut graph, &added);
        let plan = graph.compile(gpu).unwrap();
        let mut prepared = executor.prepare(&plan, graph).unwrap();
        executor.run(&mut prepared).unwrap();
        executor.forget_history("light");
        let error = executor.run(&mut prepared).err().unwrap().to_string();
        assert!(error.contains("history `light` of a prepared frame: was forgotten"), "{error}");

        let mut graph = executor.graph("frame");
        let image = graph.image("image", SHAPE);
        let image = graph.clear("clear", image, vk::ClearColorValue::default());
        let read = graph.checkpoint::<u32>("read", &image);
        let sized = graph.buffer_after(&read, "sized", |values| 4 + u64::from(values[0]));
        let sized = graph.fill("fill", sized, 1);
        graph.capture("sized", &sized);
        let plan = graph.compile(gpu).unwrap();
        let error = executor.prepare(&plan, graph).err().unwrap().to_string();
        assert!(error.contains("has checkpoints: sizes follow from what the host reads"), "{error}");
    });
}

//! How long it takes to describe and to plan chains and trees of passes, and that it does not grow faster than they do.
#![allow(clippy::unwrap_used)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::time::{Duration, Instant};

use ash::vk::PipelineStageFlags2 as Stages;
use shadowgraph::graph::description::{Access, Queue, Shape, VersionId};
use shadowgraph::graph::plan::{Plan, Planned, plan};
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
    for (name, graph) in SHAPES {
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

#[test]
#[ignore = "takes time, and is of use with optimisations alone"]
fn planning_for_other_sizes_takes_a_part_of_it() {
    for (name, graph) in SHAPES {
        let first = graph(1000).description;
        let with_size = |every: usize| {
            let mut second = first.clone();
            for resource in second.resources.iter_mut().step_by(every) {
                let Shape::Image(shape) = &mut resource.shape else { continue };
                shape.extent = [128, 128, 1];
            }
            second
        };
        let device = MadeUpDevice::one_queue();
        let planned = Planned::new(&first, &device).unwrap();
        for (what, second) in [("all", with_size(1)), ("every fifth", with_size(5))] {
            let again = || planned.resized(&first, &second, &device);
            let Some(kept) = again() else {
                println!("{name} of 1000, {what} of other sizes: steps come in another order");
                continue;
            };
            assert_eq!(*kept.plan, plan(&second, &device).unwrap());
            let mut times = [Vec::new(), Vec::new()];
            for _ in 0..51 {
                let began = cpu_time();
                plan(&second, &device).unwrap();
                let between = cpu_time();
                again();
                times[0].push(between - began);
                times[1].push(cpu_time() - between);
            }
            let [anew, again] = times.map(|mut times| {
                times.sort();
                times[times.len() / 2].as_secs_f64() * 1e3
            });
            let part = again / anew;
            println!(
                "{name} of 1000, {what} of other sizes: {anew:.3} us a pass from nothing, {again:.3} again, {part:.2}"
            );
        }
    }
}

/// Planning asks for memory in proportion to the number of passes: exact, and alike on every machine.
#[test]
fn planning_takes_memory_in_proportion() {
    for (name, graph) in SHAPES {
        let [short, long] = [1000, 10_000].map(|passes| {
            let draft = graph(passes);
            let before = asked();
            plan(&draft.description, &MadeUpDevice::one_queue()).unwrap();
            let after = asked();
            [after[0] - before[0], after[1] - before[1]]
        });
        let growth = [0, 1].map(|what| long[what] as f64 / short[what] as f64);
        println!(
            "{name}: 10000 passes ask {:.2} times as often as 1000, and for {:.2} times as much",
            growth[0], growth[1]
        );
        assert!(growth.iter().all(|growth| *growth <= 10.5), "{name}: {long:?} allocations and bytes after {short:?}");
    }
}

/// CPU time of this thread, so other work on the machine adds little; medians of runs that take turns. Ten times the
/// passes no longer fit into the processor's caches and take up to thirty times as long; a quadratic step would make it
/// a hundred times.
#[test]
fn planning_time_is_not_quadratic() {
    for (name, graph) in SHAPES {
        let drafts = [1000, 10_000].map(graph);
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..7 {
            for (draft, times) in drafts.iter().zip(&mut times) {
                let before = cpu_time();
                plan(&draft.description, &MadeUpDevice::one_queue()).unwrap();
                times.push(cpu_time() - before);
            }
        }
        let [short, long] = times.map(|mut times| {
            times.sort();
            times[times.len() / 2].as_secs_f64()
        });
        println!("{name}: 10000 passes take {:.1} times as long as 1000", long / short);
        assert!(long < 60.0 * short, "{name}: {long} s after {short} s");
    }
}

/// Makes a graph of so many passes.
type Make = fn(usize) -> Draft;

const SHAPES: [(&str, Make); 2] = [("chain", chain), ("tree", tree)];

/// CPU time of this thread.
fn cpu_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// Counts what each thread asks for.
struct Counting;

thread_local! {
    static ASKED: Cell<[u64; 2]> = const { Cell::new([0; 2]) };
}

/// How often this thread asked for memory, and for how many bytes.
fn asked() -> [u64; 2] {
    ASKED.get()
}

fn count(bytes: usize) {
    // A thread that ends has no counts any more.
    let _ = ASKED.try_with(|asked| asked.set([asked.get()[0] + 1, asked.get()[1] + bytes as u64]));
}

// SAFETY: the system's allocator does it all.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size);
        // SAFETY: as the caller promises.
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

//! What a pass costs on the host: frames of many compute passes over 64×64 texels that do next to nothing.
//!
//! A chain writes image after image from the one before; a tree adds images two by two. Times are medians, divided by
//! the number of passes.

use std::cell::Cell;
use std::time::Instant;

use ash::vk;
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executed, Executor, Graph, ImageHandle, ImageShape};
use shadowgraph::shader::generated::bench::{chain_comp as chain, join_comp as join};

use super::{Measurement, median};
use crate::cli::{BenchArguments, DeviceArguments};
use crate::failure::{Failure, Result};
use crate::session;

const SIZE: [u32; 2] = [64, 64];
const PASSES: [usize; 4] = [10, 100, 1000, 10_000];

/// Chains and trees of 10 to 10 000 passes.
pub fn run(arguments: &BenchArguments, tell: &mut impl FnMut(Measurement) -> Result<()>) -> Result<()> {
    let gpu = session::open(&DeviceArguments::default())?;
    let measured = PASSES.iter().try_for_each(|&passes| {
        for shape in [Shape::Chain, Shape::Tree] {
            let case = format!("{} {passes}", shape.name());
            if !arguments.wants(&case) {
                continue;
            }
            for (metric, value, unit) in measure(&gpu, shape, passes, arguments.runs as usize)? {
                tell(Measurement { bench: "graph", case: case.clone(), metric: metric.into(), value, unit })?;
            }
        }
        Ok(())
    });
    let closed = session::close(gpu);
    measured.and(closed)
}

#[derive(Clone, Copy)]
enum Shape {
    Chain,
    Tree,
}

impl Shape {
    fn name(self) -> &'static str {
        match self {
            Self::Chain => "chain",
            Self::Tree => "tree",
        }
    }

    /// Describes a frame, and says what each texel of the result is to be.
    fn describe<'f>(self, graph: &mut Graph<'f>, passes: usize, added: &'f Cell<u32>) -> u32 {
        let shape = ImageShape::new_2d(vk::Format::R32_UINT, SIZE);
        let zero = graph.image("start", shape);
        let start = graph.clear("clear", zero, vk::ClearColorValue::default());
        let (last, expected) = match self {
            Self::Chain => {
                let mut last = start;
                for number in 0..passes as u32 {
                    last = add(graph, number, &last, shape, added);
                }
                (last, passes as u32 * added.get())
            }
            Self::Tree => {
                // Leaves and joins: a tree of `n` passes has about `n / 2` leaves.
                let leaves = passes.div_ceil(2).max(1);
                let mut level: Vec<ImageHandle> = Vec::with_capacity(leaves);
                for number in 0..leaves as u32 {
                    level.push(add(graph, number, &start, shape, added));
                }
                let mut joins = 0..;
                while level.len() > 1 {
                    let mut images = level.into_iter();
                    level = Vec::new();
                    while let Some(left) = images.next() {
                        level.push(match images.next() {
                            Some(right) => sum(graph, joins.next().unwrap_or(0), &left, &right, shape),
                            None => left,
                        });
                    }
                }
                let root = level.pop().unwrap_or(start);
                (root, leaves as u32 * added.get())
            }
        };
        graph.capture("result", &last);
        expected
    }
}

fn add<'f>(
    graph: &mut Graph<'f>,
    number: u32,
    from: &ImageHandle,
    shape: ImageShape,
    added: &'f Cell<u32>,
) -> ImageHandle {
    let to = graph.image(("sum", number), shape);
    let mut pass = graph.compute(("add", number), &chain::SHADER);
    pass.read(chain::FROM, from).push_with(|| added.get());
    let to = pass.write(chain::TO, to);
    pass.dispatch([SIZE[0], SIZE[1], 1]);
    to
}

fn sum(graph: &mut Graph, number: u32, left: &ImageHandle, right: &ImageHandle, shape: ImageShape) -> ImageHandle {
    let to = graph.image(("both", number), shape);
    let mut pass = graph.compute(("join", number), &join::SHADER);
    pass.read(join::LEFT, left).read(join::RIGHT, right);
    let to = pass.write(join::SUM, to);
    pass.dispatch([SIZE[0], SIZE[1], 1]);
    to
}

type Figure = (&'static str, f64, &'static str);

fn measure(gpu: &Gpu, shape: Shape, passes: usize, runs: usize) -> Result<Vec<Figure>> {
    let added = Cell::new(1);
    let mut executor = Executor::new(gpu);
    executor.instruments(false);
    let per_pass = |seconds: Vec<f64>| median(seconds) * 1e6 / passes as f64;
    let (mut describing, mut planning, mut rebuilding) = (Vec::new(), Vec::new(), Vec::new());
    let mut first = 0.0;
    let mut bytes = 0;

    // 1. Everything anew each frame; only what is on the device stays.
    for run in 0..=runs {
        added.set(run as u32 + 1);
        let began = Instant::now();
        let mut graph = executor.graph("bench");
        let expected = shape.describe(&mut graph, passes, &added);
        let described = began.elapsed();
        let plan = graph.compile(gpu).map_err(shadowgraph::Error::from)?;
        let planned = began.elapsed();
        let executed = executor.execute(&plan, graph)?;
        check(&executed, expected)?;
        let total = planned + executed.recording;
        bytes = plan.statistics.heap_bytes;
        if run == 0 {
            first = total.as_secs_f64();
            continue;
        }
        describing.push(described.as_secs_f64());
        planning.push((planned - described).as_secs_f64());
        rebuilding.push(total.as_secs_f64());
    }

    // 2. The frame is described anew each time, and takes the plan of the last one.
    let mut again = Vec::new();
    for run in 0..=runs {
        added.set(run as u32 + 1);
        let began = Instant::now();
        let mut graph = executor.graph("bench");
        let expected = shape.describe(&mut graph, passes, &added);
        let plan = executor.plan(&graph).map_err(shadowgraph::Error::from)?;
        let planned = began.elapsed();
        let executed = executor.execute(&plan, graph)?;
        check(&executed, expected)?;
        if run > 0 {
            again.push((planned + executed.recording).as_secs_f64());
        }
    }

    // 3. A frame made ready once, with other push constants each time.
    let mut graph = Graph::new("bench", gpu.caps());
    shape.describe(&mut graph, passes, &added);
    let plan = graph.compile(gpu).map_err(shadowgraph::Error::from)?;
    let mut prepared = executor.prepare(&plan, graph)?;
    let mut recording = Vec::new();
    let mut expected_of_one = 0;
    for run in 0..=4 * runs {
        added.set(run as u32 + 1);
        let executed = executor.run(&mut prepared)?;
        if run == 0 {
            expected_of_one = texel(&executed)?;
            continue;
        }
        check(&executed, expected_of_one.wrapping_mul(added.get()))?;
        recording.push(executed.recording.as_secs_f64());
    }
    Ok(vec![
        ("describe", per_pass(describing), "us/pass"),
        ("plan", per_pass(planning), "us/pass"),
        ("rebuild, all", per_pass(rebuilding), "us/pass"),
        ("rebuild, same plan", per_pass(again), "us/pass"),
        ("record, steady", per_pass(recording), "us/pass"),
        ("first frame", first * 1e3, "ms"),
        ("transient memory", bytes as f64 / 1024.0, "KiB"),
    ])
}

fn texel(executed: &Executed) -> Result<u32> {
    let texels = executed.capture("result")?.texels::<u32>()?;
    let first = texels.first().copied().unwrap_or_default();
    if texels.iter().any(|&texel| texel != first) {
        return Err(Failure::failed("the passes did not write every texel alike"));
    }
    Ok(first)
}

fn check(executed: &Executed, expected: u32) -> Result<()> {
    match texel(executed)? {
        found if found == expected => Ok(()),
        found => Err(Failure::failed(format!("the passes gave {found}, not {expected}"))),
    }
}

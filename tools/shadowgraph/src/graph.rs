//! `graph`: shows the render graph of a frame.

use std::io::Write as _;

use shadowgraph::capture::write_atomically;
use shadowgraph::frame::FrameSettings;
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::description::Description;
use shadowgraph::graph::plan::Plan;
use shadowgraph::graph::report::{self, Report};
use shadowgraph::graph::{Executed, Executor, Graph};
use shadowgraph::scene::GpuScene;

use crate::cli::{GraphArguments, GraphFormat};
use crate::failure::{Failure, Result};
use crate::output::{check_folder, print};
use crate::session;
use crate::view;

/// Plans the frame that `capture` would render, and prints or writes the plan.
pub fn run(arguments: &GraphArguments) -> Result<()> {
    if arguments.times && matches!(arguments.format, GraphFormat::Dot | GraphFormat::Text) {
        return Err(Failure::input("--times: these forms have no times; use it with --format html or json"));
    }
    arguments.output.as_ref().map_or(Ok(()), |path| check_folder("--output", path))?;
    let scene = session::load(&arguments.frame)?;
    let camera = view::camera(&arguments.frame, &scene)?;
    let gpu = session::open(&arguments.frame.device)?;
    let scene = scene.upload(&gpu)?;
    let settings = session::frame_settings(&arguments.frame, &scene, &camera)?;
    let shown = show(arguments, &gpu, &scene, &settings);
    drop(scene);
    let closed = session::close(gpu);
    let text = shown?;
    closed?;
    match &arguments.output {
        Some(path) => Ok(write_atomically(path, |file| writeln!(file, "{}", text.trim_end()))?),
        None => print(text.trim_end()),
    }
}

fn show(arguments: &GraphArguments, gpu: &Gpu, scene: &GpuScene, settings: &FrameSettings) -> Result<String> {
    let mut graph = Graph::new("frame", gpu.caps());
    session::record(settings, &mut graph, scene)?;
    let plan = graph.compile(gpu).map_err(shadowgraph::Error::from)?;
    let description = graph.description();
    // What follows a checkpoint has sizes that only a run can tell.
    let executed = match (arguments.times, description.checkpoints.is_empty()) {
        (true, _) => Some(run_frames(gpu, scene, settings, 2)?),
        (false, false) => Some(run_frames(gpu, scene, settings, 1)?),
        (false, true) => None,
    };
    let later = executed.as_ref().map_or(&[][..], |executed| &executed.later);
    let report = || {
        let mut report = Report::new(description, &plan);
        report.add_segments(description, later);
        if let Some(executed) = executed.as_ref().filter(|_| arguments.times) {
            report.add_times(&executed.passes);
        }
        report
    };
    let every = |form: fn(&Description, &Plan) -> String, between: fn(&str) -> String| {
        let rest = later.iter().zip(&description.checkpoints);
        let rest = rest.map(|(one, point)| between(&point.name.to_string()) + &form(&one.description, &one.plan));
        form(description, &plan) + &rest.collect::<String>()
    };
    match arguments.format {
        GraphFormat::Dot => Ok(every(report::dot, |_| "\n".into())),
        GraphFormat::Text => Ok(every(report::text, |name| format!("\n--- after the checkpoint `{name}`\n"))),
        GraphFormat::Json => report().json().map_err(Failure::failed),
        GraphFormat::Html => report::html(&report()).map_err(Failure::failed),
    }
}

/// The last of some frames in a row: in the first one drivers compile.
fn run_frames(gpu: &Gpu, scene: &GpuScene, settings: &FrameSettings, count: usize) -> Result<Executed> {
    let mut executor = Executor::new(gpu);
    let mut frame = || session::render(&mut executor, gpu, scene, settings, |_| Ok(()), |_, _| {});
    for _ in 1..count {
        frame()?;
    }
    Ok(frame()?.1)
}

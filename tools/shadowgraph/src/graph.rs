//! `graph`: shows the render graph of a frame.

use std::io::Write as _;

use shadowgraph::capture::write_atomically;
use shadowgraph::frame::FrameSettings;
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::report::{self, Report};
use shadowgraph::graph::{Executor, Graph, PassTime};
use shadowgraph::scene::GpuScene;

use crate::cli::{GraphArguments, GraphFormat};
use crate::failure::{Failure, Result};
use crate::output::print;
use crate::session;
use crate::view;

/// Plans the frame that `capture` would render, and prints or writes the plan.
pub fn run(arguments: &GraphArguments) -> Result<()> {
    if arguments.times && matches!(arguments.format, GraphFormat::Dot | GraphFormat::Text) {
        return Err(Failure::input("--times: these forms have no times; use it with --format html or json"));
    }
    let scene = session::load(&arguments.frame)?;
    let camera = view::camera(&arguments.frame, &scene)?;
    let gpu = session::open(&arguments.frame.device)?;
    let scene = scene.upload(&gpu)?;
    let settings = session::frame_settings(&arguments.frame, &scene, &camera);
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
    let report = || -> Result<Report> {
        let mut report = Report::new(description, &plan);
        if arguments.times {
            report.add_times(&measure(gpu, scene, settings)?);
        }
        Ok(report)
    };
    match arguments.format {
        GraphFormat::Dot => Ok(report::dot(description, &plan)),
        GraphFormat::Text => Ok(report::text(description, &plan)),
        GraphFormat::Json => report()?.json().map_err(Failure::failed),
        GraphFormat::Html => report::html(&report()?).map_err(Failure::failed),
    }
}

/// What the passes take in the second frame: in the first one drivers compile.
fn measure(gpu: &Gpu, scene: &GpuScene, settings: &FrameSettings) -> Result<Vec<PassTime>> {
    let mut executor = Executor::new(gpu);
    let mut frame = || session::render(&mut executor, gpu, scene, settings, |_| Ok(()));
    frame()?;
    Ok(frame()?.1.passes)
}

//! `graph`: prints the render graph of a frame.

use shadowgraph::graph::Graph;
use shadowgraph::graph::report::{self, Report};

use crate::cli::{GraphArguments, GraphFormat};
use crate::failure::{Failure, Result};
use crate::output::print;
use crate::session;
use crate::view;

/// Plans the frame that `capture` would render, and prints the plan.
pub fn run(arguments: &GraphArguments) -> Result<()> {
    let scene = session::load(&arguments.frame)?;
    let camera = view::camera(&arguments.frame, &scene)?;
    let gpu = session::open(&arguments.frame.device)?;
    let scene = scene.upload(&gpu)?;
    let settings = session::frame_settings(&arguments.frame, &scene, &camera);
    let mut graph = Graph::new("frame", gpu.caps());
    session::record(&settings, &mut graph, &scene)?;
    let plan = graph.compile(&gpu).map_err(shadowgraph::Error::from)?;
    let description = graph.description();
    let text = match arguments.format {
        GraphFormat::Dot => report::dot(description, &plan),
        GraphFormat::Json => Report::new(description, &plan).json().map_err(Failure::failed)?,
        GraphFormat::Text => report::text(description, &plan),
    };
    drop(graph);
    drop(scene);
    session::close(gpu)?;
    print(text.trim_end())
}

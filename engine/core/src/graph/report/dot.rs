//! A plan as a graph in the DOT language of Graphviz: steps in order, resources on the edges.

use std::fmt::Write;

use super::build::part;
use super::path::{critical_path, makers};
use crate::graph::description::{Description, Queue};
use crate::graph::plan::{Plan, Work};

/// The plan as a DOT graph. Each step is a box, with its place in the order and the barriers before it; each edge is
/// a version that goes from the pass that made it to one that uses it. Culled passes are dashed, with their reason; the
/// critical path has thick edges.
pub fn dot(description: &Description, plan: &Plan) -> String {
    let mut out = String::new();
    let mut line = |text: String| {
        // Writing to a string does not fail.
        let _ = writeln!(out, "{text}");
    };
    line(format!("digraph {} {{", quoted(&description.name)));
    line(
        "  rankdir=LR; node [shape=box, style=filled, fontname=\"sans-serif\"]; edge [fontname=\"sans-serif\"];".into(),
    );
    for (index, step) in plan.steps.iter().enumerate() {
        let (name, shape) = match step.work {
            Work::Pass(pass) => (description.passes[pass.0 as usize].name.as_str(), "box"),
            Work::ReadBack(root) => (description.roots[root].name.as_str(), "note"),
        };
        let barriers = match step.barriers.len() {
            0 => String::new(),
            1 => "\n1 barrier".into(),
            count => format!("\n{count} barriers"),
        };
        let label = quoted(&format!("{index}: {name}{barriers}"));
        let color = color(step.queue);
        line(format!("  {} [label={label}, shape={shape}, fillcolor=\"{color}\"];", node(step.work)));
    }
    for (pass, reason) in &plan.culled {
        let name = &description.passes[pass.0 as usize].name;
        let label = quoted(&format!("{name}\nculled: {}", reason.explain(description)));
        let style = "style=\"dashed\", fontcolor=\"#777777\"";
        line(format!("  {} [label={label}, {style}];", node(Work::Pass(*pass))));
    }
    let path = critical_path(description, plan, |_| 1.0);
    let critical: Vec<(Work, Work)> =
        path.windows(2).map(|pair| (plan.steps[pair[0]].work, plan.steps[pair[1]].work)).collect();
    for step in &plan.steps {
        for (version, dashed) in step.work.uses(description) {
            let known = &description.versions[version.0 as usize];
            let resource = &description.resources[known.resource.0 as usize];
            let label = format!("{} {}", resource.name, part(&resource.shape, &known.range));
            let style = if dashed { ", style=dotted" } else { "" };
            for from in makers(description, version) {
                let thick = if critical.contains(&(Work::Pass(from), step.work)) { ", penwidth=3" } else { "" };
                let (from, to) = (node(Work::Pass(from)), node(step.work));
                line(format!("  {from} -> {to} [label={}{style}{thick}];", quoted(label.trim_end())));
            }
        }
    }
    line("}".into());
    out
}

fn node(work: Work) -> String {
    match work {
        Work::Pass(pass) => format!("pass{}", pass.0),
        Work::ReadBack(root) => format!("readback{root}"),
    }
}

fn color(queue: Queue) -> &'static str {
    match queue {
        Queue::Graphics => "#cfe3ff",
        Queue::Compute => "#ffe3c2",
        Queue::Transfer => "#d9f2d0",
    }
}

/// As a string of the DOT language.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n"))
}

//! A plan as lines of text: steps in order, each with the barriers before it; culled passes; memory.

use std::fmt::Write;

use ash::vk::PipelineStageFlags2 as Stages;

use crate::graph::description::{Access, Description, Range, Shape};
use crate::graph::plan::{Barriers, Ownership, Plan};

/// The plan in words, a line for each step, barrier, culled pass and placement.
pub fn text(description: &Description, plan: &Plan) -> String {
    let mut out = String::new();
    for batch in &plan.batches {
        if !plan.is_single_queue() {
            let waits: Vec<_> = batch.waits.iter().map(|wait| format!("{:?} {}", wait.queue, wait.value)).collect();
            let waits = if waits.is_empty() { String::new() } else { format!(", waits for {}", waits.join(", ")) };
            line(&mut out, 0, &format!("{:?} {}{waits}:", batch.queue, batch.signal));
        }
        let indent = usize::from(!plan.is_single_queue());
        for step in batch.steps.iter().map(|&index| &plan.steps[index]) {
            barriers(&mut out, indent + 1, description, &step.barriers);
            line(&mut out, indent, &step.work.describe(description));
        }
        if !batch.release.is_empty() {
            line(&mut out, indent, "release");
            barriers(&mut out, indent + 1, description, &batch.release);
        }
    }
    if !plan.finally.is_empty() {
        line(&mut out, 0, "finally");
        barriers(&mut out, 1, description, &plan.finally);
    }
    for (pass, reason) in &plan.culled {
        let name = &description.passes[pass.0 as usize].name;
        line(&mut out, 0, &format!("culled `{name}`: {}", reason.explain(description)));
    }
    for placement in &plan.placements {
        let name = &description.resources[placement.resource.0 as usize].name;
        let (start, end) = (placement.offset, placement.offset + placement.size);
        let [first, last] = placement.steps;
        line(&mut out, 0, &format!("heap {} {start}..{end}: `{name}`, steps {first} to {last}", placement.heap));
    }
    out
}

fn line(out: &mut String, indent: usize, text: &str) {
    // Writing to a string does not fail.
    let _ = writeln!(out, "{:1$}{text}", "", indent * 2);
}

fn barriers(out: &mut String, indent: usize, description: &Description, barriers: &Barriers) {
    for barrier in &barriers.memory {
        let what = change(&barrier.from, &barrier.to, None);
        line(out, indent, &format!("memory: {what} -- {}", barrier.reason.explain(description)));
    }
    for barrier in &barriers.buffers {
        let resource = &description.resources[barrier.resource.0 as usize];
        let part = part(&resource.shape, &barrier.range);
        let what = change(&barrier.from, &barrier.to, barrier.ownership);
        let why = barrier.reason.explain(description);
        line(out, indent, &format!("`{}`{part}: {what} -- {why}", resource.name));
    }
    for barrier in &barriers.images {
        let resource = &description.resources[barrier.resource.0 as usize];
        let part = part(&resource.shape, &barrier.range);
        let what = change(&barrier.from, &barrier.to, barrier.ownership);
        let [from, to] = [barrier.from, barrier.to].map(|access| format!("{:?}", access.layout));
        let layout = if from == to { from } else { format!("{from} -> {to}") };
        let why = barrier.reason.explain(description);
        line(out, indent, &format!("`{}`{part}: {layout}, {what} -- {why}", resource.name));
    }
}

/// Scopes before and after.
fn change(from: &Access, to: &Access, ownership: Option<Ownership>) -> String {
    let give = ownership.map_or(String::new(), |ownership| format!(", family {} -> {}", ownership.from, ownership.to));
    format!("{} -> {}{give}", scope(from), scope(to))
}

fn scope(access: &Access) -> String {
    let stages = if access.stages == Stages::NONE { "nothing".into() } else { format!("{:?}", access.stages) };
    if access.mask.is_empty() { stages } else { format!("{stages} ({:?})", access.mask) }
}

/// A range, where it is not all.
fn part(shape: &Shape, range: &Range) -> String {
    let part = super::data::part(shape, range);
    if part.is_empty() { part } else { format!(" {part}") }
}

//! A plan as lines of text: steps in order, each with the barriers before it; culled passes; memory.

use std::fmt::Write;

use ash::vk::PipelineStageFlags2 as Stages;

use super::path::critical_path;
use crate::graph::description::{Access, Description, Range, Shape};
use crate::graph::plan::{Barriers, Ownership, Plan};

/// The plan in words, a line for each step, barrier, culled pass and placement.
pub fn text(description: &Description, plan: &Plan) -> String {
    let mut out = String::new();
    for batch in &plan.batches {
        if !plan.is_single_queue() {
            let waits =
                batch.waits.iter().map(|wait| format!("{:?} {} before {:?}", wait.queue, wait.value, wait.stages));
            let waits: Vec<_> = waits.collect();
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
    let path = critical_path(description, plan, |_| 1.0);
    if !path.is_empty() {
        let names: Vec<_> = path.iter().map(|&step| plan.steps[step].work.describe(description)).collect();
        let what = format!("critical path, {} of {} steps: {}", path.len(), plan.steps.len(), names.join(", "));
        line(&mut out, 0, &what);
    }
    heaps(&mut out, description, plan);
    out
}

/// Names of placements in the map.
const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789";

/// The map has at most so many rows of bytes and columns of steps.
const ROWS: u64 = 12;
const COLUMNS: usize = 96;

/// What lies where and when: a list, and a map of each heap with time to the right and bytes upwards.
fn heaps(out: &mut String, description: &Description, plan: &Plan) {
    for (index, placement) in plan.placements.iter().enumerate() {
        let name = &description.resources[placement.resource.0 as usize].name;
        let (start, end) = (placement.offset, placement.offset + placement.size);
        let [first, last] = placement.steps;
        let letter = LETTERS[index % LETTERS.len()] as char;
        line(out, 0, &format!("heap {} {start}..{end}: {letter} `{name}`, steps {first} to {last}", placement.heap));
    }
    let columns = plan.steps.len().min(COLUMNS);
    for (number, heap) in plan.heaps.iter().enumerate() {
        for row in (0..ROWS).rev() {
            let byte = (u128::from(heap.size) * u128::from(2 * row + 1) / u128::from(2 * ROWS)) as u64;
            let at = |column: usize| {
                let step = column * plan.steps.len() / columns;
                let here = |p: &&crate::graph::plan::Placement| {
                    let bytes = (p.offset..p.offset + p.size).contains(&byte);
                    p.heap == number && bytes && p.steps[0] <= step && step <= p.steps[1]
                };
                let found = plan.placements.iter().position(|placement| here(&placement));
                found.map_or('.', |index| LETTERS[index % LETTERS.len()] as char)
            };
            let cells: String = (0..columns).map(at).collect();
            line(out, 0, &format!("heap {number} map {byte:>12} {cells}"));
        }
    }
    let figures = plan.statistics;
    let saved = figures.unaliased_bytes.saturating_sub(figures.heap_bytes);
    let (heap, all, bound) = (figures.heap_bytes, figures.unaliased_bytes, figures.lower_bound_bytes);
    line(out, 0, &format!("heaps hold {heap} bytes of {all}: {saved} saved, lower bound {bound}"));
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
    let part = super::build::part(shape, range);
    if part.is_empty() { part } else { format!(" {part}") }
}

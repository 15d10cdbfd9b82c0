//! The hazard checker must be able to fail: barriers, bits of barriers, waits and placements are taken away or moved,
//! and it has to notice. What it does not notice was not needed: that measures how minimal plans are.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use ash::vk::{AccessFlags2 as Mask, PipelineStageFlags2 as Stages};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use shadowgraph::graph::description::{Access, Description};
use shadowgraph::graph::plan::{Barriers, Hazard, Plan, Reason, plan};
use shadowgraph::graph::report::text;
use shadowgraph_tests::figures::{Figure, publish_page};
use shadowgraph_tests::harness;
use shadowgraph_tests::hazard::{MadeUpDevice, check, greedy_calls, recipes};

/// The same graphs in every run.
fn graphs(count: usize, passes: usize) -> Vec<(Description, MadeUpDevice, Plan)> {
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let recipes = recipes(passes);
    let mut graph = || {
        let recipe = recipes.new_tree(&mut runner).unwrap().current();
        let (description, device) = (recipe.description(), recipe.device());
        let plan = plan(&description, &device).unwrap();
        (description, device, plan)
    };
    (0..count).map(|_| graph()).collect()
}

/// Every place of a plan that holds barriers.
fn places(plan: &mut Plan) -> Vec<&mut Barriers> {
    let steps = plan.steps.iter_mut().map(|step| &mut step.barriers);
    let releases = plan.batches.iter_mut().map(|batch| &mut batch.release);
    steps.chain(releases).chain([&mut plan.finally]).collect()
}

/// Scopes and reason of the barrier of this number in a place.
fn barrier(barriers: &mut Barriers, index: usize) -> (&mut Access, &mut Access, Reason) {
    let images = barriers.images.iter_mut().map(|b| (&mut b.from, &mut b.to, b.reason));
    let buffers = barriers.buffers.iter_mut().map(|b| (&mut b.from, &mut b.to, b.reason));
    let memory = barriers.memory.iter_mut().map(|b| (&mut b.from, &mut b.to, b.reason));
    images.chain(buffers).chain(memory).nth(index).unwrap()
}

fn remove(barriers: &mut Barriers, index: usize) {
    let (images, buffers) = (barriers.images.len(), barriers.buffers.len());
    if index < images {
        barriers.images.remove(index);
    } else if index < images + buffers {
        barriers.buffers.remove(index - images);
    } else {
        barriers.memory.remove(index - images - buffers);
    }
}

/// Every barrier of a plan, by place and number.
fn all(plan: &Plan) -> Vec<(usize, usize)> {
    let counts: Vec<usize> = places(&mut plan.clone()).iter().map(|barriers| barriers.len()).collect();
    counts.iter().enumerate().flat_map(|(place, &count)| (0..count).map(move |index| (place, index))).collect()
}

/// Name of a rule.
fn rule(hazard: Hazard) -> &'static str {
    match hazard {
        Hazard::ReadAfterWrite => "read after write",
        Hazard::WriteAfterRead => "write after read",
        Hazard::WriteAfterWrite => "write after write",
        Hazard::Layout => "layout",
        Hazard::First => "first use",
        Hazard::Alias { .. } => "alias",
        Hazard::Ownership => "ownership",
        Hazard::Final => "final state",
        Hazard::Host => "host",
    }
}

#[test]
fn every_rule_switched_off_is_noticed() {
    let mut counts: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for (description, device, planned) in graphs(400, 24) {
        for name in ALL_RULES {
            let mut plan = planned.clone();
            let off = |reason: &Reason| rule(reason.hazard) == *name;
            let mut dropped = 0;
            for barriers in places(&mut plan) {
                let before = barriers.len();
                barriers.images.retain(|barrier| !off(&barrier.reason));
                barriers.buffers.retain(|barrier| !off(&barrier.reason));
                barriers.memory.retain(|barrier| !off(&barrier.reason));
                dropped += before - barriers.len();
            }
            if dropped > 0 {
                let count = counts.entry(name).or_default();
                count[0] += 1;
                count[1] += usize::from(!check(&description, &plan, &device).is_empty());
            }
        }
    }
    for name in ALL_RULES {
        let [with, noticed] = counts.get(name).copied().unwrap_or_default();
        println!("{name}: switched off in {with} graphs, noticed in {noticed}");
        assert!(with > 10, "{name}: the graphs do not exercise it");
        assert!(noticed * 100 >= with * 95, "{name}: noticed in {noticed} of {with} graphs");
    }
}

const ALL_RULES: &[&str] = &[
    "read after write",
    "write after read",
    "write after write",
    "layout",
    "first use",
    "alias",
    "ownership",
    "final state",
    "host",
];

#[test]
fn waits_for_other_queues_are_needed() {
    let (mut with, mut noticed) = (0, 0);
    for (description, device, planned) in graphs(300, 24) {
        for batch in 0..planned.batches.len() {
            for wait in 0..planned.batches[batch].waits.len() {
                let mut plan = planned.clone();
                plan.batches[batch].waits.remove(wait);
                with += 1;
                noticed += usize::from(!check(&description, &plan, &device).is_empty());
            }
        }
    }
    println!("waits: {with} taken away, {noticed} noticed");
    assert!(with > 100 && noticed * 100 >= with * 90, "{noticed} of {with}");
}

#[test]
fn memory_moved_onto_other_memory_is_noticed() {
    let (mut with, mut noticed) = (0, 0);
    for (description, device, planned) in graphs(300, 24) {
        for index in 1..planned.placements.len() {
            let (one, other) = (planned.placements[index - 1], planned.placements[index]);
            let alive_together = one.steps[0] <= other.steps[1] && other.steps[0] <= one.steps[1];
            if one.heap == other.heap && alive_together && planned.is_single_queue() {
                let mut plan = planned.clone();
                plan.placements[index].offset = one.offset;
                plan.heaps[one.heap].size += other.size + other.offset;
                with += 1;
                noticed += usize::from(!check(&description, &plan, &device).is_empty());
            }
        }
    }
    println!("placements: {with} moved, {noticed} noticed");
    assert!(with > 50 && noticed == with, "{noticed} of {with}");
}

/// Calls of `vkCmdPipelineBarrier2`, against those of a planner that puts each barrier right before the pass that needs
/// it, over the same steps and memory.
fn barrier_calls() -> Figure {
    let (mut ours, mut greedy, mut more) = (0, 0, 0);
    let mut ratios = Vec::new();
    for passes in [24, 100] {
        for (description, device, planned) in graphs(300, passes) {
            if planned.is_single_queue() {
                let calls = greedy_calls(&description, &planned, &device);
                let own = planned.statistics.barrier_calls;
                ours += own;
                greedy += calls;
                more += usize::from(own > calls);
                if own > calls {
                    println!("{own} calls, {calls} of a greedy planner:\n{}", text(&description, &planned));
                }
                ratios.push(own as f64 / calls.max(1) as f64);
            }
        }
    }
    ratios.sort_by(f64::total_cmp);
    let (median, worst) = (ratios[ratios.len() / 2], ratios[ratios.len() - 1]);
    println!(
        "{ours} barrier calls, {greedy} of a greedy planner, in {} graphs; ratio median {median:.3}, worst {worst:.3}",
        ratios.len()
    );
    assert!(ratios.len() > 200 && more == 0, "more calls in {more} graphs");
    let value = format!("{ours} of {greedy}; median {median:.3}, worst {worst:.3}");
    Figure { what: "barrier calls, of a greedy planner's".into(), value, bound: "never more".into() }
}

#[test]
fn barriers_are_few_and_their_bits_are_needed() {
    let count = if harness::is_long() { 2_000 } else { 300 };
    let (mut minimal, mut minimal_bits) = (0, 0);
    let mut spare: BTreeMap<String, usize> = BTreeMap::new();
    let mut barriers = 0;
    for (description, device, planned) in graphs(count, 24) {
        let needed = |plan: &Plan| !check(&description, plan, &device).is_empty();
        let (mut whole, mut bits) = (true, true);
        for (place, index) in all(&planned) {
            barriers += 1;
            let mut plan = planned.clone();
            let reason = barrier(places(&mut plan)[place], index).2;
            remove(places(&mut plan)[place], index);
            if !needed(&plan) {
                whole = false;
                *spare.entry(format!("barrier, {}", rule(reason.hazard))).or_default() += 1;
                continue;
            }
            for (side, kind, bit) in bits_of(&mut planned.clone(), place, index) {
                let mut plan = planned.clone();
                let places = places(&mut plan);
                let (from, to, reason) = barrier(places.into_iter().nth(place).unwrap(), index);
                let access = if side == "from" { from } else { to };
                if kind == "stage" {
                    access.stages &= !Stages::from_raw(bit);
                } else {
                    access.mask &= !Mask::from_raw(bit);
                }
                if !needed(&plan) {
                    bits = false;
                    *spare.entry(format!("{side} {kind}, {}", rule(reason.hazard))).or_default() += 1;
                }
            }
        }
        let waits = planned.batches.iter().enumerate().flat_map(|(batch, known)| {
            let waits = known.waits.iter().enumerate();
            waits.flat_map(move |(index, wait)| each(wait.stages.as_raw()).map(move |bit| (batch, index, bit)))
        });
        for (batch, index, bit) in waits {
            let mut plan = planned.clone();
            plan.batches[batch].waits[index].stages &= !Stages::from_raw(bit);
            if !needed(&plan) {
                bits = false;
                *spare.entry("wait stage".into()).or_default() += 1;
            }
        }
        minimal += usize::from(whole);
        minimal_bits += usize::from(whole && bits);
    }
    println!(
        "{barriers} barriers in {count} graphs; no barrier to spare in {minimal}, no bit either in {minimal_bits}"
    );
    println!("to spare: {spare:?}");
    assert!(minimal_bits * 100 >= count * 95, "to spare: {spare:?}");
    let share = |part: usize| format!("{:.1} % of {count} graphs", part as f64 * 100.0 / count as f64);
    let row = |what: &str, part| Figure { what: what.into(), value: share(part), bound: "95 %".into() };
    let none = row("no barrier to spare", minimal);
    let no_bit = row("no barrier, stage bit, access bit or stage of a semaphore to spare", minimal_bits);
    let figures = [none, no_bit, barrier_calls()];
    publish_page(
        "graph/barriers.md",
        "plan_mutation",
        "made-up devices with one to three queues; no device is needed",
        &figures,
    );
}

/// Single bits of a mask.
fn each(bits: u64) -> impl Iterator<Item = u64> {
    (0..64).map(|bit| 1 << bit).filter(move |bit| bits & bit != 0)
}

/// Stages and accesses of a barrier, bit by bit.
fn bits_of(plan: &mut Plan, place: usize, index: usize) -> Vec<(&'static str, &'static str, u64)> {
    let places = places(plan);
    let barriers = places.into_iter().nth(place).unwrap();
    let (from, to, _) = barrier(barriers, index);
    let (stages, mask, next_stages, next_mask) = (from.stages, from.mask, to.stages, to.mask);
    let from_bits = each(stages.as_raw()).map(|bit| ("from", "stage", bit));
    let from_mask = each(mask.as_raw()).map(|bit| ("from", "access", bit));
    let to_bits = each(next_stages.as_raw()).map(|bit| ("to", "stage", bit));
    let to_mask = each(next_mask.as_raw()).map(|bit| ("to", "access", bit));
    from_bits.chain(from_mask).chain(to_bits).chain(to_mask).collect()
}

//! The order of passes: deterministic, dependent ones apart, memory freed early.
#![allow(clippy::unwrap_used)]

use ash::vk::PipelineStageFlags2 as Stages;
use proptest::prelude::*;
use shadowgraph::graph::description::{Access, Queue, VersionId};
use shadowgraph::graph::plan::plan;
use shadowgraph_tests::hazard::{Draft, MadeUpDevice, check, recipes};

const FRAGMENT: Stages = Stages::FRAGMENT_SHADER;

/// A pass that reads images and writes one.
fn draw(draft: &mut Draft, name: &str, from: &[VersionId]) -> VersionId {
    let image = draft.image(&format!("{name}'s"), [8, 8]);
    draft.pass(name, Queue::Graphics, |pass| {
        for (index, &version) in from.iter().enumerate() {
            pass.read(&format!("in{index}"), version, Access::sampled(FRAGMENT));
        }
        pass.overwrite("out", image, Access::color_attachment(false))
    })
}

/// Names of passes and read-backs, in order.
fn order(draft: &Draft) -> Vec<String> {
    let device = MadeUpDevice::one_queue();
    let plan = plan(&draft.description, &device).unwrap();
    assert_eq!(check(&draft.description, &plan, &device), Vec::<String>::new());
    plan.steps.iter().map(|step| step.work.describe(&draft.description).replace('`', "")).collect()
}

/// ```text
/// a1 ─► a2 ─► a3 ┐
///                ├─► end
/// b1 ─► b2 ─► b3 ┘
/// ```
/// Recorded one chain after the other, run in turns: no pass comes right behind the one it waits for.
#[test]
fn independent_chains_take_turns() {
    let mut draft = Draft::new("frame");
    let mut ends = Vec::new();
    for chain in ["a", "b"] {
        let first = draw(&mut draft, &format!("{chain}1"), &[]);
        let second = draw(&mut draft, &format!("{chain}2"), &[first]);
        ends.push(draw(&mut draft, &format!("{chain}3"), &[second]));
    }
    let end = draw(&mut draft, "end", &ends);
    draft.capture("end", end);
    assert_eq!(order(&draft), ["a1", "b1", "a2", "b2", "a3", "b3", "end", "the read-back of end"]);
}

/// ```text
/// s1 ─► l1 ┐
/// s2 ─► l2 ├─► sum
/// s3 ─► l3 ┘
/// ```
/// Each shadow map is used before many others are made: at most two are alive.
#[test]
fn memory_is_freed_early() {
    let mut draft = Draft::new("frame");
    let maps: Vec<_> = (1..=3).map(|index| draw(&mut draft, &format!("s{index}"), &[])).collect();
    let lit: Vec<_> =
        maps.iter().enumerate().map(|(index, &map)| draw(&mut draft, &format!("l{}", index + 1), &[map])).collect();
    let sum = draw(&mut draft, "sum", &lit);
    draft.capture("sum", sum);
    assert_eq!(order(&draft), ["s1", "s2", "l1", "l2", "s3", "l3", "sum", "the read-back of sum"]);
}

/// ```text
/// x0 ─► [read-back of first] ─► over ─► [read-back of second]
/// other ─► [read-back of other]
/// ```
/// Copies come last, but for those of what is written over.
#[test]
fn read_backs_come_last_where_they_can() {
    let mut draft = Draft::new("frame");
    let first = draw(&mut draft, "first", &[]);
    let second = draft.pass("over", Queue::Graphics, |pass| pass.write("color", first, Access::color_attachment(true)));
    let other = draw(&mut draft, "other", &[]);
    draft.capture("first", first);
    draft.capture("second", second);
    draft.capture("other", other);
    let expected =
        ["first", "other", "the read-back of first", "over", "the read-back of other", "the read-back of second"];
    assert_eq!(order(&draft), expected);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_same_graph_has_the_same_plan(recipe in recipes(24)) {
        let (description, device) = (recipe.description(), recipe.device());
        prop_assert_eq!(plan(&description, &device), plan(&description, &device));
    }
}

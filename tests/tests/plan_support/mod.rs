//! What the tests of graph errors share.
#![allow(dead_code, missing_docs, clippy::unwrap_used)]

use ash::vk::PipelineStageFlags2 as Stages;
use shadowgraph::graph::ErrorKind;
use shadowgraph::graph::description::{Access, Queue, VersionId};
use shadowgraph::graph::plan::plan;
use shadowgraph_tests::hazard::{Draft, MadeUpDevice};

pub const COMPUTE: Stages = Stages::COMPUTE_SHADER;
pub const FRAGMENT: Stages = Stages::FRAGMENT_SHADER;

/// Plans for one queue, and compares the errors: kinds and lines.
pub fn expect(draft: &Draft, kinds: &[ErrorKind], lines: &[&str]) {
    expect_on(&MadeUpDevice::one_queue(), draft, kinds, lines);
}

pub fn expect_on(device: &MadeUpDevice, draft: &Draft, kinds: &[ErrorKind], lines: &[&str]) {
    let errors = plan(&draft.description, device).unwrap_err();
    let found: Vec<_> = errors.errors.iter().map(|error| error.kind).collect();
    let printed: Vec<_> = errors.errors.iter().map(|error| error.to_string()).collect();
    assert_eq!(printed, lines);
    assert_eq!(found, kinds);
}

/// A pass that fills a buffer, captured.
pub fn right() -> (Draft, VersionId) {
    let mut draft = Draft::new("g");
    let buffer = draft.buffer("numbers", 64);
    let filled = draft.pass("fill", Queue::Graphics, |pass| pass.overwrite("out", buffer, Access::transfer_write()));
    draft.capture("numbers", filled);
    (draft, filled)
}

//! Exact plans for made-up devices with two and three queue families: submissions, waits, ownership.
#![allow(clippy::unwrap_used)]

use ash::vk::{self, PipelineStageFlags2 as Stages};
use shadowgraph::graph::ImageShape;
use shadowgraph::graph::description::{Access, Origin, Queue, Shape};
use shadowgraph::graph::plan::{Plan, plan};
use shadowgraph::graph::report::text;
use shadowgraph_tests::hazard::{Draft, MadeUpDevice, check};

const COMPUTE: Stages = Stages::COMPUTE_SHADER;
const FRAGMENT: Stages = Stages::FRAGMENT_SHADER;

fn planned(draft: &Draft, device: &MadeUpDevice) -> Plan {
    let plan = plan(&draft.description, device).unwrap();
    assert_eq!(check(&draft.description, &plan, device), Vec::<String>::new());
    plan
}

/// Compares a plan, without memory and without the reasons behind its barriers.
fn expect(draft: &Draft, device: &MadeUpDevice, lines: &[&str]) {
    let all = text(&draft.description, &planned(draft, device));
    let kept = all.lines().filter(|line| !line.starts_with("heap") && !line.starts_with("critical path"));
    let bare: Vec<&str> = kept.filter_map(|line| line.split(" -- ").next()).collect();
    assert_eq!(bare, lines);
}

/// ```text
/// graphics: gbuffer ──depth──────────────────┬─► light ──► [read-back]
/// compute:              └──► occlusion ──ao──┘
/// graphics:  shadow ──map────────────────────┘
/// ```
fn frame() -> Draft {
    let mut draft = Draft::new("frame");
    let (depth, map, ao) = (draft.depth("depth", [8, 8]), draft.depth("map", [8, 8]), draft.image("ao", [8, 8]));
    let color = draft.image("color", [8, 8]);
    let write = Access::depth_attachment_write();
    let depth = draft.pass("gbuffer", Queue::Graphics, |pass| pass.overwrite("depth", depth, write));
    let ao = draft.pass("occlusion", Queue::Compute, |pass| {
        pass.read("depth", depth, Access::sampled(COMPUTE));
        pass.overwrite("ao", ao, Access::storage_image_write(COMPUTE))
    });
    let map = draft.pass("shadow", Queue::Graphics, |pass| pass.overwrite("map", map, write));
    let color = draft.pass("light", Queue::Graphics, |pass| {
        pass.read("ao", ao, Access::sampled(FRAGMENT));
        pass.read("map", map, Access::sampled(FRAGMENT));
        pass.overwrite("color", color, Access::color_attachment(false))
    });
    draft.capture("color", color);
    draft
}

#[test]
fn compute_runs_beside_graphics() {
    expect(
        &frame(),
        &MadeUpDevice::two_queues(),
        &[
            "Graphics 1:",
            "    `depth`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE)",
            "    `map`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE)",
            "  `gbuffer`",
            "  release",
            "    `depth`: ATTACHMENT_OPTIMAL -> READ_ONLY_OPTIMAL, EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE) -> nothing, family 0 -> 1",
            "Graphics 2:",
            "  `shadow`",
            "Compute 1, waits for Graphics 1 before COMPUTE_SHADER:",
            "    `depth`: ATTACHMENT_OPTIMAL -> READ_ONLY_OPTIMAL, COMPUTE_SHADER -> COMPUTE_SHADER (SHADER_SAMPLED_READ), family 0 -> 1",
            "    `ao`: UNDEFINED -> GENERAL, nothing -> COMPUTE_SHADER (SHADER_STORAGE_WRITE)",
            "  `occlusion`",
            "  release",
            "    `ao`: GENERAL -> READ_ONLY_OPTIMAL, COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> nothing, family 1 -> 0",
            "Graphics 3, waits for Compute 1 before FRAGMENT_SHADER:",
            "    `map`: ATTACHMENT_OPTIMAL -> READ_ONLY_OPTIMAL, EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE) -> FRAGMENT_SHADER (SHADER_SAMPLED_READ)",
            "    `ao`: GENERAL -> READ_ONLY_OPTIMAL, FRAGMENT_SHADER -> FRAGMENT_SHADER (SHADER_SAMPLED_READ), family 1 -> 0",
            "    `color`: UNDEFINED -> ATTACHMENT_OPTIMAL, COLOR_ATTACHMENT_OUTPUT -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
            "  `light`",
            "    `color`: ATTACHMENT_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> COPY (TRANSFER_READ)",
            "  the read-back of `color`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
        ],
    );
}

/// Two queues of one family hand nothing over.
#[test]
fn one_family_needs_no_ownership() {
    let device = MadeUpDevice { families: [Some(0), Some(0), None], ..MadeUpDevice::one_queue() };
    expect(
        &frame(),
        &device,
        &[
            "Graphics 1:",
            "    `depth`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE)",
            "    `map`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE)",
            "  `gbuffer`",
            "Graphics 2:",
            "  `shadow`",
            "Compute 1, waits for Graphics 1 before COMPUTE_SHADER:",
            "    `depth`: ATTACHMENT_OPTIMAL -> READ_ONLY_OPTIMAL, COMPUTE_SHADER -> COMPUTE_SHADER (SHADER_SAMPLED_READ)",
            "    `ao`: UNDEFINED -> GENERAL, nothing -> COMPUTE_SHADER (SHADER_STORAGE_WRITE)",
            "  `occlusion`",
            "Graphics 3, waits for Compute 1 before FRAGMENT_SHADER:",
            "    `map`: ATTACHMENT_OPTIMAL -> READ_ONLY_OPTIMAL, EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE) -> FRAGMENT_SHADER (SHADER_SAMPLED_READ)",
            "    `ao`: GENERAL -> READ_ONLY_OPTIMAL, FRAGMENT_SHADER -> FRAGMENT_SHADER (SHADER_SAMPLED_READ)",
            "    `color`: UNDEFINED -> ATTACHMENT_OPTIMAL, COLOR_ATTACHMENT_OUTPUT -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
            "  `light`",
            "    `color`: ATTACHMENT_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> COPY (TRANSFER_READ)",
            "  the read-back of `color`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
        ],
    );
}

#[test]
fn one_queue_takes_everything() {
    let plan = planned(&frame(), &MadeUpDevice::one_queue());
    assert!(plan.is_single_queue());
    assert!(plan.steps.iter().all(|step| step.queue == Queue::Graphics));
    assert_eq!(plan.batches[0].steps, [0, 1, 2, 3, 4]);
}

/// ```text
/// transfer: upload ──data──┐
/// compute:                 └─► simulate ──particles──┐
/// graphics:                                          └─► draw ──► [read-back]
/// ```
#[test]
fn three_families_hand_over() {
    let mut draft = Draft::new("frame");
    let (data, particles) = (draft.buffer("data", 64), draft.buffer("particles", 64));
    let color = draft.image("color", [8, 8]);
    let data = draft.pass("upload", Queue::Transfer, |pass| pass.overwrite("to", data, Access::copy_write()));
    let particles = draft.pass("simulate", Queue::Compute, |pass| {
        pass.read("data", data, Access::storage_buffer_read(COMPUTE));
        pass.overwrite("particles", particles, Access::storage_buffer_write(COMPUTE))
    });
    let color = draft.pass("draw", Queue::Graphics, |pass| {
        pass.read("particles", particles, Access::vertex());
        pass.overwrite("color", color, Access::color_attachment(false))
    });
    draft.capture("color", color);
    expect(
        &draft,
        &MadeUpDevice::three_queues(),
        &[
            "Transfer 1:",
            "  `upload`",
            "  release",
            "    `data`: COPY (TRANSFER_WRITE) -> nothing, family 1 -> 2",
            "Compute 1, waits for Transfer 1 before COMPUTE_SHADER:",
            "    `data`: COMPUTE_SHADER -> COMPUTE_SHADER (SHADER_STORAGE_READ), family 1 -> 2",
            "  `simulate`",
            "  release",
            "    `particles`: COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> nothing, family 2 -> 0",
            "Graphics 1, waits for Compute 1 before VERTEX_ATTRIBUTE_INPUT:",
            "    `particles`: VERTEX_ATTRIBUTE_INPUT -> VERTEX_ATTRIBUTE_INPUT (VERTEX_ATTRIBUTE_READ), family 2 -> 0",
            "    `color`: UNDEFINED -> ATTACHMENT_OPTIMAL, COLOR_ATTACHMENT_OUTPUT -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
            "  `draw`",
            "    `color`: ATTACHMENT_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> COPY (TRANSFER_READ)",
            "  the read-back of `color`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
        ],
    );
}

/// ```text
/// history (graphics' own) ──► filter (compute), which writes it ──► back to graphics, to be sampled
/// ```
#[test]
fn imports_are_lent_and_given_back() {
    let mut draft = Draft::new("frame");
    let shape = Shape::Image(ImageShape::new_2d(vk::Format::R8G8B8A8_UNORM, [8, 8]));
    let sampled = Access::sampled(FRAGMENT);
    let history = draft.resource("history", shape, Origin::Imported { before: sampled, after: Some(sampled) });
    let history = draft
        .pass("filter", Queue::Compute, |pass| pass.write("image", history, Access::storage_image_read_write(COMPUTE)));
    draft.keep("history", history);
    expect(
        &draft,
        &MadeUpDevice::two_queues(),
        &[
            "Graphics 1:",
            "  release",
            "    `history`: READ_ONLY_OPTIMAL -> GENERAL, FRAGMENT_SHADER -> nothing, family 0 -> 1",
            "Compute 1, waits for Graphics 1 before COMPUTE_SHADER:",
            "    `history`: READ_ONLY_OPTIMAL -> GENERAL, COMPUTE_SHADER -> COMPUTE_SHADER (SHADER_STORAGE_READ | SHADER_STORAGE_WRITE), family 0 -> 1",
            "  `filter`",
            "  release",
            "    `history`: GENERAL -> READ_ONLY_OPTIMAL, COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> nothing, family 1 -> 0",
            "Graphics 2, waits for Compute 1 before ALL_COMMANDS:",
            "finally",
            "  `history`: GENERAL -> READ_ONLY_OPTIMAL, ALL_COMMANDS -> FRAGMENT_SHADER (SHADER_SAMPLED_READ), family 1 -> 0",
        ],
    );
}

/// Whoever writes the buffer after the frame waits for the stage it is left to, and so for readers on another queue.
///
/// ```text
/// settings (left to vertex shaders) ──► simulate (compute)
/// ```
#[test]
fn what_another_queue_reads_is_left_behind_a_semaphore() {
    let device = MadeUpDevice { families: [Some(0), Some(0), None], ..MadeUpDevice::one_queue() };
    let mut draft = Draft::new("frame");
    let uniform = Access::uniform(vk::PipelineStageFlags2::VERTEX_SHADER);
    let origin = Origin::Imported { before: uniform, after: Some(uniform) };
    let settings = draft.resource("settings", Shape::Buffer { size: 64 }, origin);
    let state = draft.buffer("state", 64);
    let state = draft.pass("simulate", Queue::Compute, |pass| {
        pass.read("settings", settings, Access::uniform(COMPUTE));
        pass.overwrite("state", state, Access::storage_buffer_write(COMPUTE))
    });
    draft.keep("state", state);
    expect(
        &draft,
        &device,
        &[
            "Graphics 1:",
            "Compute 1, waits for Graphics 1 before COMPUTE_SHADER:",
            "  `simulate`",
            "Graphics 2, waits for Compute 1 before VERTEX_SHADER:",
        ],
    );
}

/// ```text
/// compute:  clear ─► append0 ┐          one queue for both, since both own the list at once
/// graphics:          append1 ┴─► sort
/// ```
#[test]
fn unordered_writers_share_a_queue() {
    let mut draft = Draft::new("frame");
    let list = draft.buffer("list", 64);
    let write = Access::storage_buffer_read_write(COMPUTE);
    let list = draft.pass("clear", Queue::Compute, |pass| pass.overwrite("list", list, Access::clear()));
    let forks = draft.fork(list, 2);
    let one = draft.pass("append0", Queue::Compute, |pass| pass.write("list", forks[0], write));
    let two = draft.pass("append1", Queue::Graphics, |pass| pass.write("list", forks[1], write));
    let list = draft.join(&[one, two]);
    draft.capture("list", list);
    let plan = planned(&draft, &MadeUpDevice::two_queues());
    let queues: Vec<_> = plan.steps.iter().map(|step| step.queue).collect();
    assert_eq!(queues, [Queue::Compute, Queue::Graphics, Queue::Graphics, Queue::Graphics]);
}

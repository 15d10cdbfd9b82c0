//! Exact plans of small graphs on one queue: order and barriers.
#![allow(clippy::unwrap_used)]

use ash::vk::{self, ImageAspectFlags as Aspects, PipelineStageFlags2 as Stages};
use shadowgraph::graph::ImageShape;
use shadowgraph::graph::description::{Access, Origin, Queue, Range, Shape, VersionId};
use shadowgraph::graph::plan::plan;
use shadowgraph::graph::report::text;
use shadowgraph_tests::hazard::{Draft, MadeUpDevice, check};

const COMPUTE: Stages = Stages::COMPUTE_SHADER;
const FRAGMENT: Stages = Stages::FRAGMENT_SHADER;
const GRAPHICS: Queue = Queue::Graphics;

/// The plan on one queue, without its memory; the checker finds nothing wrong with it.
fn planned(draft: &Draft) -> Vec<String> {
    let device = MadeUpDevice::one_queue();
    let plan = plan(&draft.description, &device).unwrap();
    assert_eq!(check(&draft.description, &plan, &device), Vec::<String>::new());
    let all = text(&draft.description, &plan);
    all.lines().filter(|line| !line.starts_with("heap") && !line.starts_with("critical path")).map(Into::into).collect()
}

/// Compares a plan, without the reasons behind its barriers.
fn expect(draft: &Draft, lines: &[&str]) {
    let bare = |line: String| line.split(" -- ").next().map(Into::into);
    assert_eq!(planned(draft).into_iter().filter_map(bare).collect::<Vec<String>>(), lines);
}

fn color(pass: &mut shadowgraph_tests::hazard::PassDraft, version: VersionId) -> VersionId {
    pass.overwrite("color", version, Access::color_attachment(false))
}

/// ```text
/// prepass ──depth──► shade (tests depth, samples it too) ──color──► [read-back]
/// ```
#[test]
fn depth_is_tested_and_sampled_in_one_layout() {
    let mut draft = Draft::new("frame");
    let (depth, target) = (draft.depth("depth", [8, 8]), draft.image("color", [8, 8]));
    let depth =
        draft.pass("prepass", GRAPHICS, |pass| pass.overwrite("depth", depth, Access::depth_attachment_write()));
    let target = draft.pass("shade", GRAPHICS, |pass| {
        pass.read("depth", depth, Access::depth_attachment_read());
        pass.read("depth_map", depth, Access::sampled(FRAGMENT));
        color(pass, target)
    });
    draft.capture("color", target);
    expect(
        &draft,
        &[
            "  `depth`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE)",
            "`prepass`",
            "  `depth`: ATTACHMENT_OPTIMAL -> READ_ONLY_OPTIMAL, EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE) -> FRAGMENT_SHADER | EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_READ | SHADER_SAMPLED_READ)",
            "  `color`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
            "`shade`",
            "  `color`: ATTACHMENT_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> COPY (TRANSFER_READ)",
            "the read-back of `color`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
        ],
    );
}

/// ```text
///          ┌─► blur (compute)
/// draw ──x─┤
///          └─► light (fragment) ──► [read-back of both]
/// ```
/// The second reader's stage is let in by the first reader's barrier.
#[test]
fn readers_in_one_layout_share_a_barrier() {
    let mut draft = Draft::new("frame");
    let (x, a, b) = (draft.image("x", [8, 8]), draft.image("a", [8, 8]), draft.image("b", [8, 8]));
    let x = draft.pass("draw", GRAPHICS, |pass| color(pass, x));
    let a = draft.pass("blur", GRAPHICS, |pass| {
        pass.read("x", x, Access::sampled(COMPUTE));
        pass.overwrite("a", a, Access::storage_image_write(COMPUTE))
    });
    let b = draft.pass("light", GRAPHICS, |pass| {
        pass.read("x", x, Access::sampled(FRAGMENT));
        color(pass, b)
    });
    draft.capture("a", a);
    draft.capture("b", b);
    expect(
        &draft,
        &[
            "  `x`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
            "`draw`",
            "  `x`: ATTACHMENT_OPTIMAL -> READ_ONLY_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> FRAGMENT_SHADER | COMPUTE_SHADER (SHADER_SAMPLED_READ)",
            "  `a`: UNDEFINED -> GENERAL, nothing -> COMPUTE_SHADER (SHADER_STORAGE_WRITE)",
            "  `b`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
            "`blur`",
            "`light`",
            "  `a`: GENERAL -> TRANSFER_SRC_OPTIMAL, COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> COPY (TRANSFER_READ)",
            "  `b`: ATTACHMENT_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> COPY (TRANSFER_READ)",
            "the read-back of `a`",
            "the read-back of `b`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
        ],
    );
}

/// ```text
/// fill ──n0──► count ──n1──► draw (indirect)
///        └───► show                       show reads n0, so it comes before count
/// ```
#[test]
fn writes_wait_for_readers_without_memory() {
    let mut draft = Draft::new("frame");
    let (n, seen, target) = (draft.buffer("n", 16), draft.buffer("seen", 16), draft.image("color", [8, 8]));
    let n0 = draft.pass("fill", GRAPHICS, |pass| pass.overwrite("n", n, Access::clear()));
    let n1 = draft.pass("count", GRAPHICS, |pass| pass.write("n", n0, Access::storage_buffer_read_write(COMPUTE)));
    let seen = draft.pass("show", GRAPHICS, |pass| {
        pass.read("n", n0, Access::storage_buffer_read(COMPUTE));
        pass.overwrite("seen", seen, Access::storage_buffer_write(COMPUTE))
    });
    let target = draft.pass("draw", GRAPHICS, |pass| {
        pass.read("indirect", n1, Access::indirect());
        color(pass, target)
    });
    draft.capture("seen", seen);
    draft.capture("color", target);
    expect(
        &draft,
        &[
            "`fill`",
            "  `n`: CLEAR (TRANSFER_WRITE) -> COMPUTE_SHADER (SHADER_STORAGE_READ)",
            "`show`",
            "  memory: COMPUTE_SHADER -> COMPUTE_SHADER",
            "`count`",
            "  `n`: COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> DRAW_INDIRECT (INDIRECT_COMMAND_READ)",
            "  `seen`: COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> COPY (TRANSFER_READ)",
            "  `color`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
            "`draw`",
            "the read-back of `seen`",
            "  `color`: ATTACHMENT_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> COPY (TRANSFER_READ)",
            "the read-back of `color`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
        ],
    );
}

/// ```text
/// draw0 ─► layer 0 ┐
/// draw1 ─► layer 1 ┴─► light
/// ```
#[test]
fn layers_are_written_in_any_order_and_read_together() {
    let mut draft = Draft::new("frame");
    let shape = ImageShape::new_2d(vk::Format::D32_SFLOAT, [8, 8]).layers(2);
    let map = draft.resource("map", Shape::Image(shape), Origin::Transient);
    let target = draft.image("color", [8, 8]);
    let layer = |layer| Range::Image { aspects: Aspects::DEPTH, mips: [0, 1], layers: [layer, layer + 1] };
    let parts = [0, 1].map(|index| draft.split(map, layer(index)));
    let parts = [0, 1].map(|index| {
        let name = format!("draw{index}");
        draft.pass(&name, GRAPHICS, |pass| pass.overwrite("depth", parts[index], Access::depth_attachment_write()))
    });
    let map = draft.join(&parts);
    let target = draft.pass("light", GRAPHICS, |pass| {
        pass.read("map", map, Access::sampled(FRAGMENT));
        color(pass, target)
    });
    draft.capture("color", target);
    expect(
        &draft,
        &[
            "  `map` layers 0..1: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE)",
            "  `map` layers 1..2: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE)",
            "`draw0`",
            "`draw1`",
            "  `map` layers 0..1: ATTACHMENT_OPTIMAL -> READ_ONLY_OPTIMAL, EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE) -> FRAGMENT_SHADER (SHADER_SAMPLED_READ)",
            "  `map` layers 1..2: ATTACHMENT_OPTIMAL -> READ_ONLY_OPTIMAL, EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE) -> FRAGMENT_SHADER (SHADER_SAMPLED_READ)",
            "  `color`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
            "`light`",
            "  `color`: ATTACHMENT_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> COPY (TRANSFER_READ)",
            "the read-back of `color`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
        ],
    );
}

/// ```text
/// mip 0 ─► down1 ─► mip 1 ─► down2 ─► mip 2, all joined ─► [read-back]
/// ```
#[test]
fn mips_are_made_one_from_another() {
    let mut draft = Draft::new("frame");
    let shape = ImageShape::new_2d(vk::Format::R8G8B8A8_UNORM, [8, 8]).mips(3);
    let image = draft.resource("chain", Shape::Image(shape), Origin::Transient);
    let mip = |mip| Range::Image { aspects: Aspects::COLOR, mips: [mip, mip + 1], layers: [0, 1] };
    let mut parts = [0, 1, 2].map(|index| draft.split(image, mip(index)));
    parts[0] = draft.pass("draw", GRAPHICS, |pass| color(pass, parts[0]));
    for index in 1..3 {
        parts[index] = draft.pass(&format!("down{index}"), GRAPHICS, |pass| {
            pass.read("from", parts[index - 1], Access::sampled(COMPUTE));
            pass.overwrite("to", parts[index], Access::storage_image_write(COMPUTE))
        });
    }
    let chain = draft.join(&parts);
    draft.capture("chain", chain);
    expect(
        &draft,
        &[
            "  `chain` mips 0..1: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
            "`draw`",
            "  `chain` mips 0..1: ATTACHMENT_OPTIMAL -> READ_ONLY_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> COMPUTE_SHADER (SHADER_SAMPLED_READ)",
            "  `chain` mips 1..2: UNDEFINED -> GENERAL, nothing -> COMPUTE_SHADER (SHADER_STORAGE_WRITE)",
            "`down1`",
            "  `chain` mips 0..1: READ_ONLY_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COMPUTE_SHADER -> COPY (TRANSFER_READ)",
            "  `chain` mips 1..2: GENERAL -> READ_ONLY_OPTIMAL, COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> COMPUTE_SHADER (SHADER_SAMPLED_READ)",
            "  `chain` mips 2..3: UNDEFINED -> GENERAL, nothing -> COMPUTE_SHADER (SHADER_STORAGE_WRITE)",
            "`down2`",
            "  `chain` mips 1..2: READ_ONLY_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COMPUTE_SHADER -> COPY (TRANSFER_READ)",
            "  `chain` mips 2..3: GENERAL -> TRANSFER_SRC_OPTIMAL, COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> COPY (TRANSFER_READ)",
            "the read-back of `chain`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
        ],
    );
}

/// ```text
///         ┌─► append0 (fragment) ┐
/// clear ──┤                      ├─► sort
///         └─► append1 (compute)  ┘
/// ```
/// The two unordered writers have no barrier between them.
#[test]
fn unordered_writers_share_a_barrier() {
    let mut draft = Draft::new("frame");
    let list = draft.buffer("list", 64);
    let list = draft.pass("clear", GRAPHICS, |pass| pass.overwrite("list", list, Access::clear()));
    let forks = draft.fork(list, 2);
    let one = draft
        .pass("append0", GRAPHICS, |pass| pass.write("list", forks[0], Access::storage_buffer_read_write(FRAGMENT)));
    let two = draft
        .pass("append1", GRAPHICS, |pass| pass.write("list", forks[1], Access::storage_buffer_read_write(COMPUTE)));
    let list = draft.join(&[one, two]);
    let list =
        draft.pass("sort", GRAPHICS, |pass| pass.write("list", list, Access::storage_buffer_read_write(COMPUTE)));
    draft.capture("list", list);
    expect(
        &draft,
        &[
            "`clear`",
            "  `list`: CLEAR (TRANSFER_WRITE) -> FRAGMENT_SHADER | COMPUTE_SHADER (SHADER_STORAGE_READ | SHADER_STORAGE_WRITE)",
            "`append0`",
            "`append1`",
            "  `list`: FRAGMENT_SHADER | COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> COMPUTE_SHADER (SHADER_STORAGE_READ | SHADER_STORAGE_WRITE)",
            "`sort`",
            "  `list`: COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> COPY (TRANSFER_READ)",
            "the read-back of `list`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
        ],
    );
}

/// ```text
/// depth ──► copy depth (reads the depth aspect)
/// stencil ─► mark (writes the stencil aspect meanwhile)
/// ```
#[test]
fn depth_is_read_while_stencil_is_written() {
    let mut draft = Draft::new("frame");
    let shape = ImageShape::new_2d(vk::Format::D32_SFLOAT_S8_UINT, [8, 8]);
    let both = draft.resource("depth stencil", Shape::Image(shape), Origin::Transient);
    let target = draft.image("color", [8, 8]);
    let both = draft.pass("clear", GRAPHICS, |pass| pass.overwrite("both", both, Access::depth_attachment_write()));
    let aspect = |aspects| Range::Image { aspects, mips: [0, 1], layers: [0, 1] };
    let depth = draft.split(both, aspect(Aspects::DEPTH));
    let stencil = draft.split(both, aspect(Aspects::STENCIL));
    let (target, stencil) = draft.pass("mark", GRAPHICS, |pass| {
        pass.read("depth", depth, Access::depth_attachment_read());
        pass.read("depth_map", depth, Access::sampled(FRAGMENT));
        (color(pass, target), pass.write("stencil", stencil, Access::depth_attachment_write()))
    });
    draft.capture("color", target);
    draft.capture("stencil", stencil);
    expect(
        &draft,
        &[
            "  `depth stencil`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE)",
            "`clear`",
            "  `depth stencil` DEPTH: ATTACHMENT_OPTIMAL -> READ_ONLY_OPTIMAL, EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE) -> FRAGMENT_SHADER | EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_READ | SHADER_SAMPLED_READ)",
            "  `depth stencil` STENCIL: ATTACHMENT_OPTIMAL, EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE) -> EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_READ | DEPTH_STENCIL_ATTACHMENT_WRITE)",
            "  `color`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
            "`mark`",
            "  `depth stencil` STENCIL: ATTACHMENT_OPTIMAL -> TRANSFER_SRC_OPTIMAL, EARLY_FRAGMENT_TESTS | LATE_FRAGMENT_TESTS (DEPTH_STENCIL_ATTACHMENT_WRITE) -> COPY (TRANSFER_READ)",
            "  `color`: ATTACHMENT_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> COPY (TRANSFER_READ)",
            "the read-back of `color`",
            "the read-back of `stencil`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
        ],
    );
}

/// ```text
/// draw ──c1──► [read-back of c1] ──► over ──c2──► [read-back of c2]
/// ```
#[test]
fn what_is_written_over_is_read_back_before() {
    let mut draft = Draft::new("frame");
    let target = draft.image("color", [8, 8]);
    let first = draft.pass("draw", GRAPHICS, |pass| color(pass, target));
    let second = draft.pass("over", GRAPHICS, |pass| pass.write("color", first, Access::color_attachment(true)));
    draft.capture("first", first);
    draft.capture("second", second);
    expect(
        &draft,
        &[
            "  `color`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
            "`draw`",
            "  `color`: ATTACHMENT_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> COPY (TRANSFER_READ)",
            "the read-back of `first`",
            "  `color`: TRANSFER_SRC_OPTIMAL -> ATTACHMENT_OPTIMAL, COPY -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_READ | COLOR_ATTACHMENT_WRITE)",
            "`over`",
            "  `color`: ATTACHMENT_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> COPY (TRANSFER_READ)",
            "the read-back of `second`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
        ],
    );
}

/// ```text
/// window (arrives undefined) ──► draw ──► is left to be shown
/// history (arrives sampled) ──► draw, is left as it is
/// ```
#[test]
fn imports_arrive_and_are_left() {
    let mut draft = Draft::new("frame");
    let shape = Shape::Image(ImageShape::new_2d(vk::Format::R8G8B8A8_UNORM, [8, 8]));
    let origin = Origin::Imported { before: Access::NONE, after: Some(Access::present()) };
    let window = draft.resource("window", shape.clone(), origin);
    let sampled = Access::sampled(FRAGMENT);
    let origin = Origin::Imported { before: sampled, after: Some(sampled) };
    let history = draft.resource("history", shape, origin);
    let window = draft.pass("draw", GRAPHICS, |pass| {
        pass.read("history", history, sampled);
        color(pass, window)
    });
    draft.keep("window", window);
    expect(
        &draft,
        &[
            "  `window`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
            "`draw`",
            "finally",
            "  `window`: ATTACHMENT_OPTIMAL -> PRESENT_SRC_KHR, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> nothing",
        ],
    );
}

/// ```text
/// draw ─x─► blur ─y─► [read-back]
/// debug ─z                        nobody needs z
/// post ◄─z─ more ◄─               nor what reads it
/// ```
#[test]
fn passes_are_culled_with_reasons() {
    let mut draft = Draft::new("frame");
    let [x, y, z, w] = ["x", "y", "z", "w"].map(|name| draft.image(name, [8, 8]));
    let x = draft.pass("draw", GRAPHICS, |pass| color(pass, x));
    let _ = draft.pass("old", GRAPHICS, |pass| color(pass, y));
    let z = draft.pass("debug", GRAPHICS, |pass| {
        pass.read("x", x, Access::sampled(FRAGMENT));
        color(pass, z)
    });
    draft.pass("post", GRAPHICS, |pass| {
        pass.read("z", z, Access::sampled(FRAGMENT));
        color(pass, w)
    });
    draft.pass("look", GRAPHICS, |pass| pass.read("x", x, Access::sampled(FRAGMENT)));
    draft.capture("x", x);
    expect(
        &draft,
        &[
            "  `x`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
            "`draw`",
            "  `x`: ATTACHMENT_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> COPY (TRANSFER_READ)",
            "the read-back of `x`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
            "culled `old`: nothing reads `y`, which it writes; no root needs it",
            "culled `debug`: only culled passes read `z`, which it writes: `post`",
            "culled `post`: nothing reads `w`, which it writes; no root needs it",
            "culled `look`: it writes nothing and has no side effect",
        ],
    );
}

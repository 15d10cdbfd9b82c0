//! Exact plans over resources that outlive a plan: histories from frame to frame, and checkpoints.
#![allow(clippy::unwrap_used)]

mod plan_support;

use ash::vk::{self, ImageAspectFlags as Aspects};
use plan_support::{COMPUTE, FRAGMENT, expect};
use shadowgraph::graph::description::{
    Access, Checkpoint, Description, Origin, Queue, Range, ResourceId, Shape, Source, State, VersionId,
};
use shadowgraph::graph::plan::{Plan, Segment, Usage, plan, segment};
use shadowgraph::graph::report::text;
use shadowgraph::graph::{ErrorKind, ImageShape};
use shadowgraph_tests::hazard::{Draft, Frame, MadeUpDevice, check_frames, check_segments};

const GRAPHICS: Queue = Queue::Graphics;

/// The plan in words, without reasons and memory.
fn lines(description: &Description, plan: &Plan) -> Vec<String> {
    let all = text(description, plan);
    let steps = all.lines().filter(|line| !line.starts_with("heap") && !line.starts_with("critical path"));
    steps.filter_map(|line| line.split(" -- ").next().map(Into::into)).collect()
}

fn state(range: Range, access: Access, holds: bool) -> State {
    State { range, access, holds }
}

/// Ends of a resource.
fn ends(plan: &Plan, resource: u32) -> Vec<State> {
    plan.ends.iter().filter(|end| end.resource == ResourceId(resource)).map(|end| end.state).collect()
}

/// ```text
/// previous ──► resolve ──► next ──► show ──► [read-back]
///    ▲                      │
///    └──── next frame ──────┘
/// ```
fn temporal(states: [&[State]; 2], first: bool) -> Draft {
    let mut draft = Draft::new("frame");
    let shape = Shape::Image(ImageShape::new_2d(vk::Format::R8G8B8A8_UNORM, [8, 8]));
    let kept = |before: &[State], needed| Origin::Kept { before: before.to_vec(), after: None, needed };
    let mut previous = draft.resource("previous", shape.clone(), kept(states[0], false));
    let next = draft.resource("next", shape, kept(states[1], true));
    if first {
        previous = draft.pass("begin", GRAPHICS, |pass| pass.overwrite("it", previous, Access::clear()));
    }
    let target = draft.image("target", [8, 8]);
    let next = draft.pass("resolve", GRAPHICS, |pass| {
        pass.read("previous", previous, Access::sampled(COMPUTE));
        pass.overwrite("next", next, Access::storage_image_write(COMPUTE))
    });
    let target = draft.pass("show", GRAPHICS, |pass| {
        pass.read("next", next, Access::sampled(FRAGMENT));
        pass.overwrite("color", target, Access::color_attachment(false))
    });
    draft.capture("target", target);
    draft
}

#[test]
fn the_first_frame_begins_its_history_and_the_others_go_on_with_it() {
    let device = MadeUpDevice::one_queue();
    let mut frames = Vec::new();
    let mut states = [Vec::new(), Vec::new()];
    for index in 0..3 {
        let draft = temporal([&states[0], &states[1]], index == 0);
        let plan = plan(&draft.description, &device).unwrap();
        let forget = |state: State| State { holds: false, ..state };
        states = [ends(&plan, 1), ends(&plan, 0).into_iter().map(forget).collect()];
        let carried =
            if index == 0 { Vec::new() } else { vec![(ResourceId(0), ResourceId(1)), (ResourceId(1), ResourceId(0))] };
        frames.push(Frame { description: draft.description, plan, carried });
    }
    assert_eq!(check_frames(&frames, &device), Vec::<String>::new());
    let whole = Range::Image { aspects: Aspects::COLOR, mips: [0, 1], layers: [0, 1] };
    for frame in &frames {
        assert_eq!(ends(&frame.plan, 0), [state(whole, Access::sampled(COMPUTE), true)]);
        assert_eq!(ends(&frame.plan, 1), [state(whole, Access::sampled(FRAGMENT), true)]);
    }
    let rest = [
        "`resolve`",
        "  `next`: GENERAL -> READ_ONLY_OPTIMAL, COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> FRAGMENT_SHADER (SHADER_SAMPLED_READ)",
        "  `target`: UNDEFINED -> ATTACHMENT_OPTIMAL, nothing -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)",
        "`show`",
        "  `target`: ATTACHMENT_OPTIMAL -> TRANSFER_SRC_OPTIMAL, COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE) -> COPY (TRANSFER_READ)",
        "the read-back of `target`",
        "finally",
        "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
    ];
    let first = [
        "  `previous`: UNDEFINED -> TRANSFER_DST_OPTIMAL, nothing -> CLEAR (TRANSFER_WRITE)",
        "`begin`",
        "  `previous`: TRANSFER_DST_OPTIMAL -> READ_ONLY_OPTIMAL, CLEAR (TRANSFER_WRITE) -> COMPUTE_SHADER (SHADER_SAMPLED_READ)",
        "  `next`: UNDEFINED -> GENERAL, nothing -> COMPUTE_SHADER (SHADER_STORAGE_WRITE)",
    ];
    // `show` of the last frame read what is `previous` now, `resolve` what is `next` now.
    let later = [
        "  `previous`: READ_ONLY_OPTIMAL, FRAGMENT_SHADER -> COMPUTE_SHADER (SHADER_SAMPLED_READ)",
        "  `next`: UNDEFINED -> GENERAL, COMPUTE_SHADER -> COMPUTE_SHADER (SHADER_STORAGE_WRITE)",
    ];
    assert_eq!(lines(&frames[0].description, &frames[0].plan), [&first[..], &rest].concat());
    for frame in &frames[1..] {
        assert_eq!(lines(&frame.description, &frame.plan), [&later[..], &rest].concat());
    }
}

/// What read the buffer before the frame, by a stage that no pass of this one reads it by, is waited for as well, and
/// is handed on where nobody writes. A single stage of copies belongs to all of them.
///
/// ```text
/// buffer ─┬─► copy
///         ├─► any transfer
///         └─► (write)
/// ```
#[test]
fn readers_before_the_frame_are_not_forgotten() {
    let vertex = Access::uniform(vk::PipelineStageFlags2::VERTEX_SHADER);
    let known = vertex.merge(Access { layout: vk::ImageLayout::UNDEFINED, ..Access::transfer_read() });
    for writes in [false, true] {
        let mut draft = Draft::new("frame");
        let whole = Range::Buffer([0, 64]);
        let origin = Origin::Kept { before: vec![state(whole, known, true)], after: None, needed: writes };
        let buffer = draft.resource("buffer", Shape::Buffer { size: 64 }, origin);
        for (pass, access) in [("copy", Access::copy_read()), ("any transfer", Access::transfer_read())] {
            let copy = draft.buffer(pass, 64);
            let copied = draft.pass(pass, GRAPHICS, |pass| {
                pass.read("source", buffer, access);
                pass.overwrite("it", copy, Access::copy_write())
            });
            draft.keep(pass, copied);
        }
        if writes {
            let write = Access::storage_buffer_write(COMPUTE);
            draft.pass("write", GRAPHICS, |pass| pass.overwrite("it", buffer, write));
        }
        let plan = plan(&draft.description, &MadeUpDevice::one_queue()).unwrap();
        if writes {
            let all = lines(&draft.description, &plan);
            let waits = "  memory: VERTEX_SHADER | ALL_TRANSFER -> COMPUTE_SHADER";
            assert!(all.iter().any(|line| line == waits), "{all:#?}");
        } else {
            assert_eq!(ends(&plan, 0), [state(whole, known, true)]);
        }
    }
}

/// A segment's plans, each from what the one before it left.
fn segments(description: &Description, device: &MadeUpDevice) -> Vec<Segment> {
    let mut segments: Vec<Segment> = Vec::new();
    for index in 0..=description.checkpoints.len() {
        let ends = segments.last().map_or(&[][..], |last| &last.plan.ends);
        segments.push(segment(description, index, ends, device).unwrap());
    }
    assert_eq!(check_segments(description, &segments, device), Vec::<String>::new());
    segments
}

/// ```text
/// count ──counter──► [checkpoint] ──► build ──nodes──► resolve ──► [read-back]
///   └──heads, scratch──────────────────┘ heads
/// ```
fn a_buffer() -> Draft {
    let mut draft = Draft::new("a-buffer");
    let (counter, heads, scratch) =
        (draft.buffer("counter", 16), draft.buffer("heads", 256), draft.buffer("scratch", 64));
    let scratch = draft.pass("draft", GRAPHICS, |pass| pass.overwrite("it", scratch, Access::clear()));
    let (counter, heads) = draft.pass("count", GRAPHICS, |pass| {
        pass.read("scratch", scratch, Access::storage_buffer_read(FRAGMENT));
        let counter = pass.overwrite("counter", counter, Access::storage_buffer_read_write(FRAGMENT));
        (counter, pass.overwrite("heads", heads, Access::storage_buffer_write(FRAGMENT)))
    });
    draft.checkpoint("count", counter);
    let (nodes, color) = (draft.buffer("nodes", 128), draft.image("color", [8, 8]));
    let (heads, nodes) = draft.pass("build", GRAPHICS, |pass| {
        let heads = pass.write("heads", heads, Access::storage_buffer_read_write(FRAGMENT));
        (heads, pass.overwrite("nodes", nodes, Access::storage_buffer_write(FRAGMENT)))
    });
    let color = draft.pass("resolve", GRAPHICS, |pass| {
        pass.read("heads", heads, Access::storage_buffer_read(COMPUTE));
        pass.read("nodes", nodes, Access::storage_buffer_read(COMPUTE));
        pass.overwrite("color", color, Access::storage_image_write(COMPUTE))
    });
    draft.capture("color", color);
    draft
}

#[test]
fn what_follows_a_checkpoint_begins_where_the_rest_ended() {
    let (draft, device) = (a_buffer(), MadeUpDevice::one_queue());
    let segments = segments(&draft.description, &device);
    assert_eq!(
        lines(&segments[0].description, &segments[0].plan),
        [
            "`draft`",
            "  `scratch`: CLEAR (TRANSFER_WRITE) -> FRAGMENT_SHADER (SHADER_STORAGE_READ)",
            "`count`",
            "  `counter`: FRAGMENT_SHADER (SHADER_STORAGE_WRITE) -> COPY (TRANSFER_READ)",
            "the read-back of `checkpoint count`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
        ]
    );
    assert_eq!(
        lines(&segments[1].description, &segments[1].plan),
        [
            "  `heads`: FRAGMENT_SHADER (SHADER_STORAGE_WRITE) -> FRAGMENT_SHADER (SHADER_STORAGE_READ | SHADER_STORAGE_WRITE)",
            "`build`",
            "  `heads`: FRAGMENT_SHADER (SHADER_STORAGE_WRITE) -> COMPUTE_SHADER (SHADER_STORAGE_READ)",
            "  `nodes`: FRAGMENT_SHADER (SHADER_STORAGE_WRITE) -> COMPUTE_SHADER (SHADER_STORAGE_READ)",
            "  `color`: UNDEFINED -> GENERAL, nothing -> COMPUTE_SHADER (SHADER_STORAGE_WRITE)",
            "`resolve`",
            "  `color`: GENERAL -> TRANSFER_SRC_OPTIMAL, COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> COPY (TRANSFER_READ)",
            "the read-back of `color`",
            "finally",
            "  memory: COPY (TRANSFER_WRITE) -> HOST (HOST_READ)",
        ]
    );
    // `plan` plans up to the first checkpoint.
    assert_eq!(plan(&draft.description, &device).unwrap(), segments[0].plan);
    // What is alive over the checkpoint has no place in the heaps that the segments share.
    let heads = ResourceId(1);
    assert!(segments.iter().all(|segment| segment.plan.placement(heads).is_none()));
    // It is made once, for the uses of both.
    let Some(Usage::Buffer(usage)) = segments[0].plan.usages[1] else { panic!("heads is a buffer") };
    assert_eq!(usage, vk::BufferUsageFlags::STORAGE_BUFFER);
}

/// ```text
/// clear ─┬─► first ──► [checkpoint]        ┌─► sum ──► [read-back]
///        └────────────────────► second ────┘ joined
/// ```
#[test]
fn unordered_writers_may_stand_on_both_sides_of_a_checkpoint() {
    let mut draft = Draft::new("frame");
    let (list, count, sum) = (draft.buffer("list", 64), draft.buffer("count", 16), draft.buffer("sum", 16));
    let list = draft.pass("clear", GRAPHICS, |pass| pass.overwrite("it", list, Access::clear()));
    let forks = draft.fork(list, 2);
    let append = Access::storage_buffer_read_write(COMPUTE);
    let (first, count) = draft.pass("first", GRAPHICS, |pass| {
        (pass.write("list", forks[0], append), pass.overwrite("count", count, Access::storage_buffer_write(COMPUTE)))
    });
    draft.checkpoint("count", count);
    let second = draft.pass("second", GRAPHICS, |pass| pass.write("list", forks[1], append));
    let list = draft.join(&[first, second]);
    let sum = draft.pass("sum", GRAPHICS, |pass| {
        pass.read("list", list, Access::uniform(COMPUTE));
        pass.overwrite("sum", sum, Access::storage_buffer_write(COMPUTE))
    });
    draft.capture("sum", sum);
    let segments = segments(&draft.description, &MadeUpDevice::one_queue());
    assert_eq!(
        lines(&segments[1].description, &segments[1].plan)[..4],
        [
            "  `list`: COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> COMPUTE_SHADER (SHADER_STORAGE_READ | SHADER_STORAGE_WRITE)",
            "`second`",
            "  `list`: COMPUTE_SHADER (SHADER_STORAGE_WRITE) -> COMPUTE_SHADER (UNIFORM_READ)",
            "`sum`",
        ]
    );
    // The version that is still to be written is a fork there too.
    let source = |version: VersionId| &segments[1].description.versions[version.0 as usize].source;
    assert_eq!([source(first), source(forks[1])], [&Source::Fork { of: VersionId(3) }; 2]);
}

#[test]
fn checkpoints_cut_between_passes() {
    let device = MadeUpDevice::one_queue();
    let said = |change: &dyn Fn(&mut Checkpoint)| -> Vec<String> {
        let mut draft = a_buffer();
        change(&mut draft.description.checkpoints[0]);
        let errors = plan(&draft.description, &device).unwrap_err().errors;
        assert!(errors.iter().all(|error| error.kind == ErrorKind::BadCheckpoint));
        errors.iter().map(ToString::to_string).collect()
    };
    assert_eq!(
        said(&|checkpoint| checkpoint.passes = 1),
        ["checkpoint `count` cuts through pass `count`; a pass is recorded whole before it or whole after it"]
    );
    assert_eq!(
        said(&|checkpoint| checkpoint.passes = 9),
        [
            "checkpoint `count` stands behind 9 passes, 6 versions and 3 resources; checkpoints stand one behind the other, \
          within the description"
        ]
    );
    assert_eq!(
        said(&|checkpoint| checkpoint.root = Some(1)),
        ["checkpoint `count` does not read anything made before it; it reads a root that is read back"]
    );
    assert_eq!(
        said(&|checkpoint| checkpoint.resources = 2),
        ["checkpoint `count` comes before a resource that was used before it; a resource is made before its versions"]
    );
    let beyond = segment(&a_buffer().description, 2, &[], &device).unwrap_err();
    assert_eq!(beyond.errors[0].to_string(), "there is no segment 2; the last one is 1");
}

/// ```text
/// fill ──n0──► over ──n1──► [checkpoint] ──► late reads n0
/// ```
#[test]
fn what_is_read_after_a_checkpoint_is_still_there() {
    let mut draft = Draft::new("frame");
    let (n, late) = (draft.buffer("n", 16), draft.buffer("late", 16));
    let n0 = draft.pass("fill", GRAPHICS, |pass| pass.overwrite("n", n, Access::clear()));
    let n1 = draft.pass("over", GRAPHICS, |pass| pass.overwrite("n", n0, Access::clear()));
    draft.checkpoint("now", n1);
    let late = draft.pass("late", GRAPHICS, |pass| {
        pass.read("n", n0, Access::copy_read());
        pass.overwrite("late", late, Access::copy_write())
    });
    draft.capture("late", late);
    expect(
        &draft,
        &[ErrorKind::BadCheckpoint],
        &[
            "`over` comes before checkpoint `now` but waits for `late`, which comes after it, because of `n`; what is read \
           after a checkpoint is not written over before it",
        ],
    );
}

#[test]
fn states_that_resources_arrive_in_can_be() {
    let mut draft = Draft::new("g");
    let whole = Range::Buffer([0, 64]);
    let kept = |before: Vec<State>| Origin::Kept { before, after: None, needed: false };
    let read = Access::storage_buffer_read(COMPUTE);
    let both = vec![state(whole, read, true), state(Range::Buffer([32, 48]), read, true)];
    let _: VersionId = draft.resource("two states", Shape::Buffer { size: 64 }, kept(both));
    draft.resource("outside", Shape::Buffer { size: 64 }, kept(vec![state(Range::Buffer([32, 80]), read, true)]));
    let image = Shape::Image(ImageShape::new_2d(vk::Format::R8G8B8A8_UNORM, [8, 8]));
    let range = Range::Image { aspects: Aspects::COLOR, mips: [0, 1], layers: [0, 1] };
    draft.resource("nothing", image, kept(vec![state(range, Access::NONE, true)]));
    expect(
        &draft,
        &[ErrorKind::BadImport; 3],
        &[
            "resource `two states`: arrives in two states of bytes 0..64 and bytes 32..48; each part arrives in one state",
            "resource `outside`: arrives in a state of bytes 32..80, which is not a part of it; it has bytes 0..64",
            "resource `nothing`: holds something in layout UNDEFINED; what holds something has another layout",
        ],
    );
}

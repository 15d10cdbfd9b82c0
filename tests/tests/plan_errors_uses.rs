//! Mistakes in uses, roots and order, with the exact words that planning has for them; those of resources and versions
//! are in `plan_errors.rs`.
#![allow(clippy::unwrap_used)]

mod plan_support;

use plan_support::{COMPUTE, FRAGMENT, expect, expect_on, right};

use ash::vk;
use shadowgraph::graph::description::{Access, Origin, Queue, Shape, VersionId};
use shadowgraph::graph::plan::plan;
use shadowgraph::graph::{ErrorKind, ImageShape};
use shadowgraph_tests::hazard::{Draft, MadeUpDevice};

#[test]
fn who_writes_makes_a_version() {
    let (mut draft, filled) = right();
    draft.pass("quiet", Queue::Compute, |pass| pass.read("out", filled, Access::storage_buffer_write(COMPUTE)));
    draft.pass("loud", Queue::Compute, |pass| pass.write("in", filled, Access::storage_buffer_read(COMPUTE)));
    expect(
        &draft,
        &[ErrorKind::WriteMismatch, ErrorKind::WriteMismatch],
        &[
            "pass `quiet`, slot `out`, resource `numbers`: writes (SHADER_STORAGE_WRITE) but makes no version; \
             a use that writes makes the next version",
            "pass `loud`, slot `in`, resource `numbers`: makes a version but does not write (SHADER_STORAGE_READ); \
             a use that only reads makes no version",
        ],
    );
}

#[test]
fn formats_allow_their_uses() {
    let (mut draft, filled) = right();
    let color = draft.image("color", [8, 8]);
    let depth = draft.depth("depth", [8, 8]);
    let graphics = Queue::Graphics;
    draft.pass("a", graphics, |pass| pass.overwrite("depth", color, Access::depth_attachment_write()));
    draft.pass("b", graphics, |pass| pass.overwrite("image", depth, Access::storage_image_write(COMPUTE)));
    draft.pass("c", graphics, |pass| pass.read("vertices", filled, Access::color_attachment(true)));
    let general = Access { layout: vk::ImageLayout::READ_ONLY_OPTIMAL, ..Access::storage_image_write(COMPUTE) };
    let stencil = draft.image("more", [8, 8]);
    draft.pass("d", graphics, |pass| pass.overwrite("image", stencil, general));
    draft.pass("e", graphics, |pass| pass.read("vertices", filled, Access { stages: COMPUTE, ..Access::vertex() }));
    draft.pass("f", graphics, |pass| pass.read("nothing", filled, Access::NONE));
    let errors = plan(&draft.description, &MadeUpDevice::one_queue()).unwrap_err();
    let kinds: Vec<_> = errors.errors.iter().map(|error| error.kind).collect();
    assert_eq!(kinds[..2], [ErrorKind::WrongUsage; 2]);
    let printed: Vec<_> = errors.errors.iter().map(|error| error.to_string()).collect();
    let expected = [
        "pass `a`, slot `depth`, resource `color`: DEPTH_STENCIL_ATTACHMENT_READ on aspects COLOR of format \
         R8G8B8A8_UNORM; it works on DEPTH | STENCIL",
        "pass `a`, slot `depth`, resource `color`: DEPTH_STENCIL_ATTACHMENT_WRITE on aspects COLOR of format \
         R8G8B8A8_UNORM; it works on DEPTH | STENCIL",
        "pass `b`, slot `image`, resource `depth`: SHADER_STORAGE_WRITE on aspects DEPTH of format D32_SFLOAT; \
         it works on COLOR",
        "pass `c`, slot `vertices`, resource `numbers`: writes (COLOR_ATTACHMENT_WRITE) but makes no version; \
         a use that writes makes the next version",
        "pass `c`, slot `vertices`, resource `numbers`: COLOR_ATTACHMENT_READ | COLOR_ATTACHMENT_WRITE on a buffer; \
         allowed are INDIRECT_COMMAND_READ | INDEX_READ | VERTEX_ATTRIBUTE_READ | UNIFORM_READ | TRANSFER_READ | \
         TRANSFER_WRITE | SHADER_STORAGE_READ | SHADER_STORAGE_WRITE",
        "pass `d`, slot `image`, resource `more`: SHADER_STORAGE_WRITE in layout READ_ONLY_OPTIMAL; \
         it works in [GENERAL]",
        "pass `e`, slot `vertices`, resource `numbers`: VERTEX_ATTRIBUTE_READ by stages COMPUTE_SHADER; \
         it is done by VERTEX_ATTRIBUTE_INPUT",
        "pass `f`, slot `nothing`, resource `numbers`: uses nothing of a buffer; \
         allowed are INDIRECT_COMMAND_READ | INDEX_READ | VERTEX_ATTRIBUTE_READ | UNIFORM_READ | TRANSFER_READ | \
         TRANSFER_WRITE | SHADER_STORAGE_READ | SHADER_STORAGE_WRITE",
    ];
    assert_eq!(printed, expected);
}

#[test]
fn devices_allow_the_uses_of_formats() {
    let mut draft = Draft::new("g");
    let color = draft.image("color", [8, 8]);
    let stored =
        draft.pass("store", Queue::Graphics, |pass| pass.overwrite("out", color, Access::storage_image_write(COMPUTE)));
    draft.capture("color", stored);
    let forbidden = vec![(vk::Format::R8G8B8A8_UNORM, vk::ImageUsageFlags::from_raw(!0x3))];
    let device = MadeUpDevice { forbidden, ..MadeUpDevice::one_queue() };
    expect_on(
        &device,
        &draft,
        &[ErrorKind::WrongUsage],
        &["pass `store`, slot `out`, resource `color`: the device does not allow STORAGE for format R8G8B8A8_UNORM; \
           it allows TRANSFER_SRC | TRANSFER_DST"],
    );
}

#[test]
fn queues_have_the_stages_of_their_passes() {
    let (mut draft, filled) = right();
    draft.pass("draw", Queue::Compute, |pass| pass.read("uniform", filled, Access::uniform(FRAGMENT)));
    expect(
        &draft,
        &[ErrorKind::WrongQueue],
        &["pass `draw`, slot `uniform`, resource `numbers`: stages FRAGMENT_SHADER on the Compute queue; \
           it has DRAW_INDIRECT | COMPUTE_SHADER | ALL_TRANSFER | COPY | CLEAR; the Graphics queue has all"],
    );
}

#[test]
fn uses_of_one_pass_go_together() {
    let (mut draft, filled) = right();
    let color = draft.image("color", [8, 8]);
    let write = Access::storage_image_read_write(COMPUTE);
    let first = draft.pass("first", Queue::Graphics, |pass| pass.overwrite("out", color, write));
    draft.pass("feedback", Queue::Graphics, |pass| {
        pass.read("in", first, Access::sampled(COMPUTE));
        pass.write("out", first, write);
    });
    draft.pass("layouts", Queue::Graphics, |pass| {
        pass.read("texture", filled, Access::uniform(COMPUTE));
        pass.read("numbers", filled, Access::storage_buffer_read(COMPUTE));
    });
    let second = draft.image("second", [8, 8]);
    let second = draft.pass("second", Queue::Graphics, |pass| pass.overwrite("out", second, write));
    draft.pass("two layouts", Queue::Graphics, |pass| {
        pass.read("texture", second, Access::sampled(COMPUTE));
        pass.read("image", second, Access::storage_image_read(COMPUTE));
    });
    let third =
        draft.pass("third", Queue::Graphics, |pass| pass.write("out", filled, Access::storage_buffer_write(COMPUTE)));
    draft.pass("two times", Queue::Graphics, |pass| {
        pass.read("old", filled, Access::uniform(COMPUTE));
        pass.read("new", third, Access::uniform(COMPUTE));
    });
    let errors = plan(&draft.description, &MadeUpDevice::one_queue()).unwrap_err();
    let printed: Vec<_> = errors.errors.iter().map(|error| error.to_string()).collect();
    let expected = [
        "pass `feedback`, slot `out`, resource `color`: is also used by slot `in`, and one of them writes; \
         what a pass writes it uses once; a storage access can read and write",
        "pass `two layouts`, slot `image`, resource `second`: needs layout GENERAL where slot `texture` needs \
         READ_ONLY_OPTIMAL; a pass sees an image in one layout",
        "pass `two times`, slot `new`, resource `numbers`: slot `old` reads other contents of the same memory; \
         a pass sees one version of a resource",
    ];
    assert_eq!(printed[..3], expected);
    assert!(errors.errors[..3].iter().all(|error| error.kind == ErrorKind::ConflictingUses));
}

#[test]
fn imports_are_left_in_a_layout() {
    let (mut draft, _) = right();
    let shape = Shape::Image(ImageShape::new_2d(vk::Format::R8G8B8A8_UNORM, [8, 8]));
    let origin = Origin::Imported { before: Access::NONE, after: Some(Access::NONE) };
    let window = draft.resource("window", shape, origin);
    draft.pass("show", Queue::Graphics, |pass| pass.read("in", window, Access::sampled(FRAGMENT)));
    expect(
        &draft,
        &[ErrorKind::BadImport, ErrorKind::ReadBeforeWrite],
        &[
            "resource `window`: is to be left in layout UNDEFINED; any layout but UNDEFINED and PREINITIALIZED is allowed",
            "pass `show`, slot `in`, resource `window`: reads what nobody has written; \
             write it first, or say that its earlier contents do not matter",
        ],
    );
}

#[test]
fn roots_hold_something() {
    let (mut draft, _) = right();
    let never = draft.buffer("never", 4);
    draft.capture("never", never);
    let mut shape = ImageShape::new_2d(vk::Format::R8G8B8A8_UNORM, [8, 8]);
    shape.samples = 4;
    let samples = draft.resource("samples", Shape::Image(shape), Origin::Transient);
    let drawn =
        draft.pass("draw", Queue::Graphics, |pass| pass.overwrite("out", samples, Access::color_attachment(false)));
    draft.capture("samples", drawn);
    expect(
        &draft,
        &[ErrorKind::EmptyRoot, ErrorKind::WrongUsage],
        &[
            "resource `never`: nobody writes what root `never` asks for; a root is written by a pass, or imported",
            "resource `samples`: root `samples` has 4 samples a texel; \
             only images with 1 sample are read back: resolve it",
        ],
    );
}

#[test]
fn kept_roots_are_not_written_over() {
    let (mut draft, filled) = right();
    draft.keep("first", filled);
    let next =
        draft.pass("next", Queue::Compute, |pass| pass.write("out", filled, Access::storage_buffer_write(COMPUTE)));
    draft.capture("next", next);
    expect(
        &draft,
        &[ErrorKind::OverwrittenRoot],
        &["pass `next`, resource `numbers`: writes over what root `first` keeps; \
           keep the last version, or capture this one, which copies it before"],
    );
}

#[test]
fn passes_do_not_wait_for_one_another() {
    let mut draft = Draft::new("g");
    let (x, y) = (draft.buffer("x", 4), draft.buffer("y", 4));
    let [read, write] = [Access::storage_buffer_read(COMPUTE), Access::storage_buffer_write(COMPUTE)];
    let later = VersionId(3);
    let x1 = draft.pass("a", Queue::Compute, |pass| {
        pass.read("y", later, read);
        pass.overwrite("x", x, write)
    });
    let y1 = draft.pass("b", Queue::Compute, |pass| {
        pass.read("x", x1, read);
        pass.overwrite("y", y, write)
    });
    assert_eq!(y1, later);
    draft.capture("x", x1);
    expect(
        &draft,
        &[ErrorKind::Cycle],
        &["`a` waits for `b` because of `y`, `b` waits for `a` because of `x`; \
           a pass reads versions that can all be there at once"],
    );
}

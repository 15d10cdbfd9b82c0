//! Every kind of mistake in a description, with the exact words that planning has for it.
#![allow(clippy::unwrap_used)]

mod plan_support;

use plan_support::{COMPUTE, FRAGMENT, expect, right};

use ash::vk::{self, ImageAspectFlags as Aspects};
use shadowgraph::graph::description::{
    Access, Origin, PassId, Queue, Range, ResourceId, Root, Shape, Source, Version, VersionId,
};
use shadowgraph::graph::plan::plan;
use shadowgraph::graph::{ErrorKind, ImageShape};
use shadowgraph_tests::hazard::{Draft, MadeUpDevice};

#[test]
fn a_right_description_has_no_error() {
    assert!(plan(&right().0.description, &MadeUpDevice::one_queue()).is_ok());
}

#[test]
fn all_errors_come_at_once_one_a_line() {
    let mut draft = Draft::new("frame");
    let color = draft.image("color", [8, 8]);
    draft.pass("empty", Queue::Graphics, |_| ());
    draft.pass("late", Queue::Graphics, |pass| pass.read("tex", color, Access::sampled(FRAGMENT)));
    let errors = plan(&draft.description, &MadeUpDevice::one_queue()).unwrap_err();
    let expected = "graph `frame` has 2 errors:\n  \
        pass `empty`: uses nothing; it reads or writes something, or has a side effect\n  \
        pass `late`, slot `tex`, resource `color`: reads what nobody has written; \
        write it first, or say that its earlier contents do not matter";
    assert_eq!(errors.to_string(), expected);
}

#[test]
fn names_are_unique() {
    let (mut draft, filled) = right();
    draft.buffer("numbers", 4);
    draft.pass("fill", Queue::Graphics, |pass| pass.read("in", filled, Access::copy_read()));
    draft.capture("numbers", filled);
    expect(
        &draft,
        &[ErrorKind::DuplicateName; 3],
        &[
            "2 passes are named `fill`; each needs a name of its own",
            "2 resources are named `numbers`; each needs a name of its own",
            "2 captures are named `numbers`; each needs a name of its own",
        ],
    );
}

#[test]
fn shapes_can_be() {
    let (mut draft, _) = right();
    let image = |extent, mips, layers, samples| {
        let format = vk::Format::R8G8B8A8_UNORM;
        Shape::Image(ImageShape { format, extent, mips, layers, samples })
    };
    draft.buffer("none", 0);
    draft.resource("flat", image([8, 0, 1], 1, 1, 1), Origin::Transient);
    draft.resource("deep", image([8, 8, 4], 1, 2, 1), Origin::Transient);
    draft.resource("long", image([8, 8, 1], 5, 1, 1), Origin::Transient);
    draft.resource("odd", image([8, 8, 1], 1, 1, 3), Origin::Transient);
    let shape = ImageShape::new_2d(vk::Format::UNDEFINED, [1, 1]);
    draft.resource("what", Shape::Image(shape), Origin::Transient);
    let kinds = [
        ErrorKind::BadShape,
        ErrorKind::BadShape,
        ErrorKind::BadShape,
        ErrorKind::BadShape,
        ErrorKind::BadShape,
        ErrorKind::BadShape,
        ErrorKind::BadRange,
    ];
    expect(
        &draft,
        &kinds,
        &[
            "resource `none`: a buffer of 0 bytes; a buffer has at least one",
            "resource `flat`: an image of 8x0x1 texels and 1 layers; each is at least 1",
            "resource `deep`: 2 layers of a 3D image; a 3D image has 1",
            "resource `long`: 5 mip levels for 8x8x1 texels; 1 to 4 are allowed",
            "resource `odd`: 3 samples a texel; 1, 2, 4, 8, 16, 32 or 64 are allowed",
            "resource `what`: an image without a format; give it one",
            "resource `none`: bytes 0..0 is not a part of it; it has bytes 0..0",
        ],
    );
}

#[test]
fn ids_are_those_of_the_description() {
    let (mut draft, filled) = right();
    draft.description.roots.push(Root { name: "lost".into(), version: VersionId(99), read_back: true });
    draft.pass("reader", Queue::Graphics, |pass| pass.read("in", VersionId(98), Access::copy_read()));
    let whole = Range::Buffer([0, 64]);
    draft.version(ResourceId(97), whole, Source::Initial);
    draft.version(ResourceId(0), whole, Source::Split { of: VersionId(96) });
    draft.version(ResourceId(0), whole, Source::Pass { pass: PassId(95), from: filled });
    expect(
        &draft,
        &[ErrorKind::UnknownId; 5],
        &[
            "version 2 is of resource 97, which there is not; the description has 1 resources",
            "resource `numbers`: version 3 is made from version 96, which there is not; the description has 5 versions",
            "resource `numbers`: version 4 is made by pass 95, which there is not; the description has 2 passes",
            "pass `reader`, slot `in`: uses version 98, which there is not; the description has 5 versions",
            "root `lost` is version 99, which there is not; the description has 5 versions",
        ],
    );
}

#[test]
fn versions_come_from_older_ones_of_their_resource() {
    let (mut draft, filled) = right();
    let other = draft.buffer("other", 64);
    let whole = Range::Buffer([0, 64]);
    draft.version(ResourceId(0), whole, Source::Split { of: VersionId(3) });
    draft.version(ResourceId(0), whole, Source::Split { of: other });
    draft.version(ResourceId(0), Range::Buffer([0, 32]), Source::Fork { of: filled });
    draft.version(ResourceId(0), Range::Buffer([0, 32]), Source::Join { of: vec![filled] });
    draft.version(ResourceId(0), whole, Source::Pass { pass: PassId(0), from: filled });
    expect(
        &draft,
        &[ErrorKind::BadVersion; 5],
        &[
            "resource `numbers`: version 3 is made from version 3; a version is made from versions recorded before it",
            "resource `numbers`: version 4 is made from version 2 of `other`; \
             a version is made from versions of its own resource",
            "resource `numbers`: bytes 0..32 does not cover bytes 0..64; \
             a written or forked version covers what it is made from",
            "resource `numbers`: bytes 0..32 leaves out some of bytes 0..64; a joined version holds all of its parts",
            "pass `fill`, resource `numbers`: 0 of its uses make version 7 from version 1; exactly one use makes it",
        ],
    );
}

#[test]
fn a_use_makes_its_own_version() {
    let (mut draft, filled) = right();
    draft.description.uses_of_mut(PassId(0))[0].makes = Some(VersionId(0));
    draft.description.passes[0].name = "thief".into();
    let _ = filled;
    expect(
        &draft,
        &[ErrorKind::BadVersion, ErrorKind::BadVersion],
        &[
            "pass `thief`, resource `numbers`: 0 of its uses make version 1 from version 0; exactly one use makes it",
            "pass `thief`, slot `out`: makes version 0, which is not of its making; \
             a use makes a version whose source is its pass",
        ],
    );
}

#[test]
fn ranges_lie_in_their_resource() {
    let (mut draft, filled) = right();
    draft.split(filled, Range::Buffer([32, 65]));
    draft.split(filled, Range::Image { aspects: Aspects::COLOR, mips: [0, 1], layers: [0, 1] });
    let image = draft.image("color", [8, 8]);
    draft.split(image, Range::Image { aspects: Aspects::DEPTH, mips: [0, 1], layers: [0, 1] });
    expect(
        &draft,
        &[ErrorKind::BadRange, ErrorKind::BadVersion, ErrorKind::BadRange, ErrorKind::BadRange, ErrorKind::BadVersion],
        &[
            "resource `numbers`: bytes 32..65 is not a part of it; it has bytes 0..64",
            "resource `numbers`: bytes 32..65 is split from bytes 0..64; a part lies in its whole",
            "resource `numbers`: mips 0..1, layers 0..1, aspects COLOR is not a part of it; it has bytes 0..64",
            "resource `color`: mips 0..1, layers 0..1, aspects DEPTH is not a part of it; \
             it has mips 0..1, layers 0..1, aspects COLOR",
            "resource `color`: mips 0..1, layers 0..1, aspects DEPTH is split from mips 0..1, layers 0..1, \
             aspects COLOR; a part lies in its whole",
        ],
    );
}

#[test]
fn each_resource_has_one_first_version_of_all_of_it() {
    let (mut draft, _) = right();
    draft.version(ResourceId(0), Range::Buffer([0, 8]), Source::Initial);
    expect(
        &draft,
        &[ErrorKind::BadInitial, ErrorKind::BadInitial],
        &[
            "resource `numbers`: its first version covers bytes 0..8; it covers all: bytes 0..64",
            "resource `numbers`: has 2 first versions; it has exactly one",
        ],
    );
}

#[test]
fn a_version_is_replaced_once() {
    let (mut draft, filled) = right();
    let write = Access::storage_buffer_read_write(COMPUTE);
    draft.pass("one", Queue::Compute, |pass| pass.write("a", filled, write));
    draft.pass("two", Queue::Compute, |pass| pass.write("b", filled, write));
    expect(
        &draft,
        &[ErrorKind::TwoWriters],
        &["pass `two`, slot `b`, resource `numbers`: writes over contents that `one` writes over too; \
           each version is replaced once: write over the other's result, or split or fork before"],
    );
}

#[test]
fn parts_that_are_written_are_disjoint() {
    let (mut draft, filled) = right();
    let write = Access::storage_buffer_read_write(COMPUTE);
    let first = draft.split(filled, Range::Buffer([0, 40]));
    let second = draft.split(filled, Range::Buffer([32, 64]));
    draft.pass("one", Queue::Compute, |pass| pass.write("a", first, write));
    draft.pass("two", Queue::Compute, |pass| pass.write("b", second, write));
    expect(
        &draft,
        &[ErrorKind::OverlappingSplits],
        &["pass `two`, slot `b`, resource `numbers`: writes a part (bytes 32..64) that overlaps one that `one` \
           writes (bytes 0..40); parts of one version that are written are disjoint"],
    );
}

#[test]
fn joined_parts_cover_once() {
    let (mut draft, filled) = right();
    let parts = [[0, 16], [32, 64], [0, 40]].map(|bytes| draft.split(filled, Range::Buffer(bytes)));
    draft.join(&[parts[0], parts[1]]);
    draft.join(&[parts[2], parts[1]]);
    let fork = draft.fork(filled, 1)[0];
    draft.join(&[fork, parts[0]]);
    expect(
        &draft,
        &[ErrorKind::BadJoin; 3],
        &[
            "resource `numbers`: the joined parts (bytes 0..16; bytes 32..64) leave a gap; \
             together they hold bytes 0..64 exactly once",
            "resource `numbers`: the joined parts (bytes 0..40; bytes 32..64) overlap; \
             together they hold bytes 0..64 exactly once",
            "resource `numbers`: unordered versions are joined with others; \
             forks of one version are joined with one another",
        ],
    );
}

#[test]
fn unordered_writers_are_joined_before_anything_else() {
    let (mut draft, filled) = right();
    let write = Access::storage_buffer_read_write(COMPUTE);
    let forks = draft.fork(filled, 3);
    let one = draft.pass("one", Queue::Compute, |pass| pass.write("append", forks[0], write));
    draft.pass("again", Queue::Compute, |pass| pass.write("append", one, write));
    draft.pass("reader", Queue::Compute, |pass| pass.read("list", one, Access::storage_buffer_read(COMPUTE)));
    draft.pass("copy", Queue::Transfer, |pass| pass.write("to", forks[1], Access::copy_write()));
    draft.split(one, Range::Buffer([0, 8]));
    draft.keep("kept", forks[2]);
    let allowed = "join the unordered writers before anything else is done with what they write";
    expect(
        &draft,
        &[ErrorKind::BadFork; 5],
        &[
            &format!(
                "pass `again`, slot `append`, resource `numbers`: writes over what one unordered writer wrote; {allowed}"
            ),
            "pass `copy`, slot `to`, resource `numbers`: is an unordered writer by TRANSFER_WRITE; \
             unordered writers write storage buffers and storage images, by atomics",
            &format!("resource `numbers`: a version of one unordered writer is split or forked; {allowed}"),
            "pass `reader`, slot `list`, resource `numbers`: reads the version of one unordered writer; \
             join the unordered writers first",
            "resource `numbers`: root `kept` is a version of one unordered writer; join the unordered writers first",
        ],
    );
}

/// ```text
/// x0 ── a ── x1 ──► b reads x1, writes y1
/// y0 ── b ── y1 ──► a reads y1
/// ```
#[test]
fn broken_versions_do_not_break_what_follows() {
    let (mut draft, filled) = right();
    let broken = draft.split(filled, Range::Buffer([8, 4]));
    let joined = draft.join(&[broken]);
    draft.pass("reader", Queue::Graphics, |pass| pass.read("in", joined, Access::copy_read()));
    draft.capture("joined", joined);
    let Version { range, .. } = draft.description.versions[joined.0 as usize];
    assert_eq!(range, Range::Buffer([8, 4]));
    expect(
        &draft,
        &[ErrorKind::BadRange, ErrorKind::BadRange],
        &[
            "resource `numbers`: bytes 8..4 is not a part of it; it has bytes 0..64",
            "resource `numbers`: bytes 8..4 is not a part of it; it has bytes 0..64",
        ],
    );
}

#[test]
fn resources_fit_into_memory() {
    let (mut draft, _) = right();
    let huge = draft.buffer("huge", u64::MAX);
    let huge = draft.pass("fill all", Queue::Graphics, |pass| pass.overwrite("out", huge, Access::transfer_write()));
    draft.capture("huge", huge);
    expect(
        &draft,
        &[ErrorKind::BadShape],
        &["resource `huge`: takes 18446744073709551615 bytes, aligned to 16; at most 1099511627776 are allowed"],
    );
}

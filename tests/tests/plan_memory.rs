//! Where transients lie: exact offsets of small graphs, alignment, granularity, memory types.
#![allow(clippy::unwrap_used)]

use ash::vk::PipelineStageFlags2 as Stages;
use proptest::prelude::*;
use shadowgraph::graph::description::{Access, Description, Queue, Range, Version, VersionId};
use shadowgraph::graph::plan::{Hazard, Plan, Work, lifetimes, plan};
use shadowgraph_tests::hazard::{Draft, MadeUpDevice, check, recipes};

const FRAGMENT: Stages = Stages::FRAGMENT_SHADER;

fn planned(description: &Description, device: &MadeUpDevice) -> Plan {
    let plan = plan(description, device).unwrap();
    assert_eq!(check(description, &plan, device), Vec::<String>::new());
    plan
}

/// Name, heap, first byte, end, first and last step of every transient.
fn map(draft: &Draft, plan: &Plan) -> Vec<(String, usize, [u64; 2], [usize; 2])> {
    let name = |placement: &shadowgraph::graph::plan::Placement| {
        draft.description.resources[placement.resource.0 as usize].name.to_string()
    };
    let bytes = |p: &shadowgraph::graph::plan::Placement| [p.offset, p.offset + p.size];
    plan.placements.iter().map(|p| (name(p), p.heap, bytes(p), p.steps)).collect()
}

/// A chain of passes, each reading one image and writing the next, of these widths (8 high, 4 bytes a texel).
fn chain(widths: &[u32]) -> (Draft, VersionId) {
    let mut draft = Draft::new("chain");
    let mut last: Option<VersionId> = None;
    for (index, &width) in widths.iter().enumerate() {
        let image = draft.image(&format!("i{index}"), [width, 8]);
        let next = draft.pass(&format!("p{index}"), Queue::Graphics, |pass| {
            if let Some(last) = last {
                pass.read("in", last, Access::sampled(FRAGMENT));
            }
            pass.overwrite("out", image, Access::color_attachment(false))
        });
        last = Some(next);
    }
    let last = last.unwrap();
    draft.capture("last", last);
    (draft, last)
}

/// ```text
/// p0 ─i0─► p1 ─i1─► p2 ─i2─► p3 ─i3─► [read-back]
///
/// 512 ┤      ██i1██████        ██i3████
/// 256 ┤
///   0 ┤██i0██████    ██i2██████
/// ```
#[test]
fn a_chain_takes_two_images() {
    let (draft, _) = chain(&[8; 4]);
    let plan = planned(&draft.description, &MadeUpDevice::one_queue());
    let expected = [
        ("i0".into(), 0, [0, 256], [0, 1]),
        ("i1".into(), 0, [256, 512], [1, 2]),
        ("i2".into(), 0, [0, 256], [2, 3]),
        ("i3".into(), 0, [256, 512], [3, 4]),
    ];
    assert_eq!(map(&draft, &plan), expected);
    let figures = plan.statistics;
    assert_eq!((figures.heap_bytes, figures.lower_bound_bytes, figures.unaliased_bytes), (512, 512, 1024));
}

/// What the device does not allocate at once lies in several heaps: two of the chain's images are 512 bytes.
#[test]
fn heaps_are_no_larger_than_the_device_allocates() {
    let (draft, _) = chain(&[8; 4]);
    let planned = |most_at_once: u64| {
        let plan = planned(&draft.description, &MadeUpDevice { most_at_once, ..MadeUpDevice::one_queue() });
        plan.heaps.iter().map(|heap| heap.size).collect::<Vec<_>>()
    };
    assert_eq!(planned(512), [512]);
    assert_eq!(planned(511), [256; 4]);
    // What does not fit by itself is for the device to refuse.
    assert_eq!(planned(100), [256; 4]);
}

#[test]
fn a_chain_of_a_thousand_takes_two_images() {
    let (draft, _) = chain(&[64; 1000]);
    let plan = plan(&draft.description, &MadeUpDevice::one_queue()).unwrap();
    assert_eq!(plan.statistics.heap_bytes, 2 * 64 * 8 * 4);
}

/// ```text
/// p0 ─i0 (big)─► p1 ─i1─► p2 ─i2─► p3 ─i3 (big)─► [read-back]
///
/// 2304 ┤██i0████  ██i2████
/// 2048 ┤██i0████
///  ... ┤██i0████          ██i3████
///    0 ┤██i0██████████i1, ██i3████
/// ```
#[test]
fn images_of_different_sizes_share_memory() {
    let (draft, _) = chain(&[64, 8, 8, 64]);
    let plan = planned(&draft.description, &MadeUpDevice::one_queue());
    let figures = plan.statistics;
    assert_eq!((figures.heap_bytes, figures.lower_bound_bytes, figures.unaliased_bytes), (2304, 2304, 4608));
}

/// ```text
/// fill ─b─► draw (reads b) ─i─► post (reads i) ─o─► [read-back]
///
/// 556 ┤██b█████
/// 512 ┤██b███████████  ██o████
/// 256 ┤    ██i████████
///   0 ┤
/// ```
/// The buffer's memory becomes the last image's.
#[test]
fn a_buffer_gives_its_memory_to_an_image() {
    let mut draft = Draft::new("frame");
    let (b, i, o) = (draft.buffer("b", 300), draft.image("i", [8, 8]), draft.image("o", [8, 8]));
    let b = draft.pass("fill", Queue::Graphics, |pass| pass.overwrite("b", b, Access::clear()));
    let i = draft.pass("draw", Queue::Graphics, |pass| {
        pass.read("b", b, Access::uniform(FRAGMENT));
        pass.overwrite("i", i, Access::color_attachment(false))
    });
    let o = draft.pass("post", Queue::Graphics, |pass| {
        pass.read("i", i, Access::sampled(FRAGMENT));
        pass.overwrite("o", o, Access::color_attachment(false))
    });
    draft.capture("o", o);
    let plan = planned(&draft.description, &MadeUpDevice::one_queue());
    let expected =
        [("b".into(), 0, [256, 556], [0, 1]), ("i".into(), 0, [0, 256], [1, 2]), ("o".into(), 0, [256, 512], [2, 3])];
    assert_eq!(map(&draft, &plan), expected);
    let barriers = &plan.steps[2].barriers;
    let old = shadowgraph::graph::description::ResourceId(0);
    let taken = barriers.images.iter().find(|barrier| barrier.reason.hazard == Hazard::Alias { old }).unwrap();
    assert!(taken.discards());
    assert_eq!((taken.from.stages, taken.to.stages), (FRAGMENT, Stages::COLOR_ATTACHMENT_OUTPUT));

    // With a granularity of 4096 the buffer and the images share no block of it.
    let device = MadeUpDevice { granularity: 4096, ..MadeUpDevice::one_queue() };
    let coarse = planned(&draft.description, &device);
    let offsets: Vec<_> = coarse.placements.iter().map(|placement| placement.offset).collect();
    assert_eq!(offsets, [0, 4096, 0]);

    // Buffers that cannot lie where images can have a heap of their own.
    let device = MadeUpDevice { type_bits: [1, 1, 2], ..MadeUpDevice::one_queue() };
    let apart = planned(&draft.description, &device);
    let heaps: Vec<_> = apart.heaps.iter().map(|heap| (heap.type_bits, heap.size)).collect();
    assert_eq!(heaps, [(2, 300), (1, 512)]);
}

/// What is captured lives to its copy; what is kept lives to the end of the frame.
#[test]
fn roots_are_not_aliased_away() {
    let (mut draft, _) = chain(&[8; 3]);
    let first = VersionId(1);
    draft.capture("first", first);
    let plan_captured = planned(&draft.description, &MadeUpDevice::one_queue());
    assert_eq!(plan_captured.statistics.heap_bytes, 3 * 256);

    let (mut draft, _) = chain(&[8; 6]);
    draft.keep("first", first);
    let kept = planned(&draft.description, &MadeUpDevice::one_queue());
    let placement = kept.placement(shadowgraph::graph::description::ResourceId(0)).unwrap();
    assert_eq!(placement.steps, [0, kept.steps.len() - 1]);
    assert_eq!(kept.statistics.heap_bytes, 3 * 256);
}

/// What two ranges of one resource share.
fn common(a: Range, b: Range) -> Range {
    let both = |a: [u32; 2], b: [u32; 2]| [a[0].max(b[0]), a[1].min(b[1])];
    match (a, b) {
        (Range::Image { aspects, mips, layers }, Range::Image { aspects: a, mips: m, layers: l }) => {
            Range::Image { aspects: aspects & a, mips: both(mips, m), layers: both(layers, l) }
        }
        (Range::Buffer(a), Range::Buffer(b)) => Range::Buffer([a[0].max(b[0]), a[1].min(b[1])]),
        (a, _) => a,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Lifetimes hold all that steps use, each part once, from the first step that uses it to the last.
    #[test]
    fn lifetimes_go_from_first_to_last_use(recipe in recipes(24)) {
        let description = recipe.description();
        let plan = plan(&description, &recipe.device()).unwrap();
        let mut used: Vec<(usize, &Version)> = Vec::new();
        for (index, step) in plan.steps.iter().enumerate() {
            let mut add = |version: VersionId| used.push((index, &description.versions[version.0 as usize]));
            match step.work {
                Work::Pass(pass) => {
                    let pass = &description.passes[pass.0 as usize];
                    description.uses_of(pass).iter().for_each(|used| add(used.version));
                }
                Work::ReadBack(root) => add(description.roots[root].version),
            }
        }
        let lifetimes = lifetimes(&description, &plan);
        for (place, life) in lifetimes.iter().enumerate() {
            let uses = used.iter().filter(|(_, v)| v.resource == life.resource && v.range.overlaps(&life.range));
            let steps: Vec<usize> = uses.map(|(step, _)| *step).collect();
            prop_assert_eq!(life.steps, [steps[0], steps[steps.len() - 1]], "{:?}", life);
            let twice = lifetimes[..place].iter().any(|other| {
                other.resource == life.resource && other.range.overlaps(&life.range)
            });
            prop_assert!(!twice, "{:?} is told twice", life);
        }
        for (step, version) in used {
            let parts = lifetimes.iter().filter(|life| life.resource == version.resource);
            let held = parts.map(|life| common(life.range, version.range));
            prop_assert_eq!(held.map(|part| part.amount()).sum::<u64>(), version.range.amount(), "step {}", step);
        }
    }
}

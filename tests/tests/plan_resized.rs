//! A frame that is described as an earlier one was, but for sizes, gets the plan that it would get from nothing.
#![allow(clippy::unwrap_used)]

mod plan_support;

use std::cell::Cell;

use ash::vk;
use plan_support::{COMPUTE, FRAGMENT};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use shadowgraph::graph::description::{Access, Description, Origin, PassId, Queue, Range, Shape};
use shadowgraph::graph::plan::{Planned, plan};
use shadowgraph_tests::harness;
use shadowgraph_tests::hazard::{Draft, MadeUpDevice, Recipe, recipes};

/// With images of other extents and buffers of other lengths, where these are used as a whole.
fn resized(description: &Description, factor: impl Fn(usize) -> u32) -> Description {
    let mut resized = description.clone();
    for (index, resource) in resized.resources.iter_mut().enumerate() {
        let (factor, old) = (factor(index), resource.shape.clone());
        let mine = |version: &&shadowgraph::graph::description::Version| version.resource.0 as usize == index;
        match &mut resource.shape {
            Shape::Image(shape) => shape.extent = shape.extent.map(|n| if n > 1 { n * factor } else { n }),
            Shape::Buffer { size } => {
                let whole = description.versions.iter().filter(mine).all(|version| version.range == old.whole());
                if whole && !matches!(resource.origin, Origin::Kept { .. }) {
                    *size *= u64::from(factor);
                }
            }
        }
        let whole = resource.shape.whole();
        let of_all = resized.versions.iter_mut().filter(|version| version.resource.0 as usize == index);
        of_all.filter(|version| version.range == old.whole()).for_each(|version| version.range = whole);
    }
    resized
}

/// Random graphs with other sizes: of how many the plan was found again from the first one's.
fn sweep(factors: impl Strategy<Value = Vec<u8>>, factor: impl Fn(&[u8], usize) -> u32) -> [u32; 2] {
    let counts = Cell::new([0; 2]);
    let cases = if harness::is_long() { 20_000 } else { 500 };
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    let judge = |(recipe, factors): (Recipe, Vec<u8>)| {
        let (first, device) = (recipe.description(), recipe.device());
        let second = resized(&first, |index| factor(&factors, index));
        let planned = Planned::new(&first, &device).map_err(|errors| TestCaseError::fail(errors.to_string()))?;
        let wanted = plan(&second, &device).map_err(|errors| TestCaseError::fail(errors.to_string()))?;
        let again = planned.resized(&first, &second, &device);
        let [all, found] = counts.get();
        counts.set([all + 1, found + u32::from(again.is_some())]);
        if let Some(again) = again {
            prop_assert_eq!(&*again.plan, &wanted);
            // And back.
            if let Some(back) = again.resized(&second, &first, &device) {
                prop_assert_eq!(back.plan, planned.plan);
            }
        }
        Ok(())
    };
    TestRunner::new(config).run(&(recipes(24), factors), judge).unwrap();
    counts.get()
}

#[test]
fn random_graphs_get_the_plan_that_they_get_from_nothing() {
    let [all, found] = sweep(prop::collection::vec(any::<u8>(), 1), |factors, _| 1 + u32::from(factors[0] % 4));
    println!("all of {all} graphs' sizes changed alike: {found} planned again from what there was");
    assert!(f64::from(found) >= 0.9 * f64::from(all), "{found} of {all}");
    let each = |factors: &[u8], index: usize| 1 + u32::from(factors[index % factors.len()] % 3);
    let [all, found] = sweep(prop::collection::vec(any::<u8>(), 8..32), each);
    println!("each of {all} graphs' sizes changed by itself: {found} planned again from what there was");
    assert!(f64::from(found) >= 0.5 * f64::from(all), "{found} of {all}");
}

/// ```text
/// image ──► blur ──► count ──► [read-back]
/// ```
fn frame(side: u32, bytes: u64) -> Draft {
    let mut draft = Draft::new("frame");
    let [image, blurred] = ["image", "blurred"].map(|name| draft.image(name, [side; 2]));
    let counts = draft.buffer("counts", bytes);
    let image =
        draft.pass("draw", Queue::Graphics, |pass| pass.overwrite("color", image, Access::color_attachment(false)));
    let blurred = draft.pass("blur", Queue::Graphics, |pass| {
        pass.read("image", image, Access::sampled(FRAGMENT));
        pass.overwrite("color", blurred, Access::color_attachment(false))
    });
    let counts = draft.pass("count", Queue::Graphics, |pass| {
        pass.read("image", blurred, Access::sampled(COMPUTE));
        pass.overwrite("counts", counts, Access::storage_buffer_write(COMPUTE))
    });
    draft.capture("counts", counts);
    draft
}

#[test]
fn lengths_and_memory_are_those_of_the_new_sizes() {
    let device = MadeUpDevice::one_queue();
    let (small, large) = (frame(64, 256).description, frame(256, 4096).description);
    let planned = Planned::new(&small, &device).unwrap();
    let again = planned.resized(&small, &large, &device).unwrap();
    assert_eq!(*again.plan, plan(&large, &device).unwrap());
    assert!(again.plan.statistics.heap_bytes > planned.plan.statistics.heap_bytes);
    let ranges: Vec<Range> =
        again.plan.steps.iter().flat_map(|step| &step.barriers.buffers).map(|barrier| barrier.range).collect();
    assert!(!ranges.is_empty() && ranges.iter().all(|range| *range == Range::Buffer([0, 4096])), "{ranges:?}");
}

#[test]
fn what_differs_in_more_than_sizes_is_planned_from_nothing() {
    let device = MadeUpDevice::one_queue();
    let first = frame(64, 256).description;
    let planned = Planned::new(&first, &device).unwrap();
    let refused = |change: &dyn Fn(&mut Description)| {
        let mut second = frame(128, 256).description;
        change(&mut second);
        planned.resized(&first, &second, &device).is_none()
    };
    let image = |description: &mut Description, change: &dyn Fn(&mut shadowgraph::graph::ImageShape)| {
        let Shape::Image(shape) = &mut description.resources[0].shape else { panic!("an image") };
        change(shape);
    };
    assert!(!refused(&|_| ()));
    assert!(refused(&|second| image(second, &|shape| shape.format = vk::Format::R16G16B16A16_SFLOAT)));
    assert!(refused(&|second| image(second, &|shape| shape.samples = 4)));
    assert!(refused(&|second| image(second, &|shape| shape.extent[0] = 0)));
    assert!(refused(&|second| second.passes[1].queue = Queue::Compute));
    assert!(refused(&|second| second.uses_of_mut(PassId(1))[0].access = Access::sampled(COMPUTE)));
    assert!(refused(&|second| second.passes[1].name = "other".into()));
    assert!(refused(&|second| second.roots.clear()));
    assert!(refused(&|second| second.resources[1].shape = Shape::Buffer { size: 16 }));
    // Versions that do not cover what they did.
    assert!(refused(&|second| second.resources[2].shape = Shape::Buffer { size: 1024 }));
}

//! How close heaps come to the lower bound, to the smallest packing there is, and to other orders of the passes, on
//! distributions of graphs that are the same in every run.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use shadowgraph::graph::description::{Access, Description, Queue, VersionId};
use shadowgraph::graph::plan::{Plan, plan};
use shadowgraph_tests::figures::{Figure, publish_page};
use shadowgraph_tests::hazard::{Draft, MadeUpDevice, recipes};
use shadowgraph_tests::packing::{Block, best_order, smallest};

/// A graph with its plan for a device with one queue and no granularity.
struct Case {
    description: Description,
    device: MadeUpDevice,
    plan: Plan,
}

impl Case {
    fn new(description: Description, device: MadeUpDevice) -> Self {
        let device = MadeUpDevice { granularity: 1, families: [Some(0), None, None], ..device };
        let plan = plan(&description, &device).unwrap();
        Self { description, device, plan }
    }

    /// By heap.
    fn blocks(&self) -> Vec<Vec<Block>> {
        let alignments = [self.device.image_alignment, self.device.buffer_alignment];
        let mut heaps: BTreeMap<usize, Vec<Block>> = BTreeMap::new();
        for placement in &self.plan.placements {
            heaps.entry(placement.heap).or_default().push(Block::new(&self.description, placement, alignments));
        }
        heaps.into_values().collect()
    }

    fn over_bound(&self) -> f64 {
        let figures = self.plan.statistics;
        figures.heap_bytes as f64 / figures.lower_bound_bytes.max(1) as f64
    }
}

/// Random graphs with so many transients.
fn random(count: usize, passes: usize, seed: u8, transients: std::ops::RangeInclusive<usize>) -> Vec<Case> {
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let recipes = recipes(passes);
    let mut cases = Vec::new();
    while cases.len() < count {
        let recipe = recipes.new_tree(&mut runner).unwrap().current();
        let case = Case::new(recipe.description(), recipe.device());
        if transients.contains(&case.plan.placements.len()) {
            cases.push(case);
        }
    }
    cases
}

/// Frames of 150 to 400 passes: each writes one image or buffer of a random size and reads up to three of the last
/// sixteen; one in twelve is kept for a read-back at the end.
fn frames(count: usize) -> Vec<Case> {
    let mut random = 0x1234_5678_9abc_def1_u64;
    let mut below = |end: u64| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        random % end
    };
    let compute = ash::vk::PipelineStageFlags2::COMPUTE_SHADER;
    let mut frame = |_| {
        let mut draft = Draft::new("frame");
        let mut made: Vec<(VersionId, bool)> = Vec::new();
        for pass in 0..150 + below(251) {
            let is_image = below(4) > 0;
            let new = match is_image {
                true => draft.image(&format!("i{pass}"), [8 << below(6), 8 << below(6)]),
                false => draft.buffer(&format!("b{pass}"), 16 + below(100_000)),
            };
            let reads: Vec<usize> = (0..below(4))
                .map(|_| made.len().saturating_sub(1 + below(16) as usize))
                .filter(|&i| i < made.len())
                .collect();
            let version = draft.pass(&format!("p{pass}"), Queue::Graphics, |draft| {
                let mut read: Vec<usize> = Vec::new();
                for index in reads.into_iter().chain(made.len().checked_sub(1)) {
                    let (version, is_image) = made[index];
                    if !read.contains(&index) {
                        read.push(index);
                        let access = match is_image {
                            true => Access::sampled(compute),
                            false => Access::storage_buffer_read(compute),
                        };
                        draft.read(&format!("r{}", read.len()), version, access);
                    }
                }
                match is_image {
                    true => draft.overwrite("out", new, Access::storage_image_write(compute)),
                    false => draft.overwrite("out", new, Access::storage_buffer_write(compute)),
                }
            });
            if below(12) == 0 {
                draft.capture(&format!("c{pass}"), version);
            }
            made.push((version, is_image));
        }
        draft.capture("last", made.last().unwrap().0);
        let alignments = [[256, 16], [4096, 256], [1024, 64]][below(3) as usize];
        let [image_alignment, buffer_alignment] = alignments;
        Case::new(draft.description, MadeUpDevice { image_alignment, buffer_alignment, ..MadeUpDevice::one_queue() })
    };
    (0..count).map(&mut frame).collect()
}

/// Median, worst and share of at most `limit`.
fn spread(name: &str, mut ratios: Vec<f64>, limit: f64) -> [f64; 3] {
    ratios.sort_by(f64::total_cmp);
    let (median, worst) = (ratios[ratios.len() / 2], ratios[ratios.len() - 1]);
    let within = ratios.iter().filter(|&&ratio| ratio <= limit).count();
    println!("{name}: median {median:.4}, worst {worst:.4}, at most {limit} in {within} of {}", ratios.len());
    [median, worst, within as f64 / ratios.len() as f64]
}

/// A row of the page, and its figures.
fn figure(what: &str, spread: [f64; 3], limit: f64, bound: &str) -> Figure {
    let [median, worst, within] = spread;
    let value = format!("median {median:.4}, worst {worst:.4}, at most {limit} in {:.1} %", within * 100.0);
    Figure { what: what.into(), value, bound: bound.into() }
}

/// Against the lower bound, the most bytes alive at once; against the smallest packing there is; and the bound, which
/// depends on the order of the passes, against the best of 100 random orders.
#[test]
fn heaps_are_small() {
    let mut figures = Vec::new();

    let cases = random(400, 60, 11, 1..=usize::MAX);
    let found = spread("random graphs", cases.iter().map(Case::over_bound).collect(), 1.02);
    assert!(found[0] <= 1.02 && found[2] >= 0.95, "{found:?}");
    let what = "heap over lower bound, 400 random graphs of up to 60 passes";
    figures.push(figure(what, found, 1.02, "median at most 1.02"));

    let cases = frames(200);
    assert!(cases.iter().all(|case| case.plan.placements.len() > 100));
    let found = spread("frames", cases.iter().map(Case::over_bound).collect(), 1.02);
    assert!(found[0] <= 1.02 && found[1] <= 1.15, "{found:?}");
    let what = "heap over lower bound, 200 frames of more than 100 transients";
    figures.push(figure(what, found, 1.02, "median at most 1.02, worst at most 1.15"));

    let cases = random(10, 1000, 13, 101..=usize::MAX);
    let found = spread("large random graphs", cases.iter().map(Case::over_bound).collect(), 1.02);
    assert!(found[0] <= 1.02 && found[1] <= 1.15, "{found:?}");
    let what = "heap over lower bound, 10 random graphs of more than 100 transients";
    figures.push(figure(what, found, 1.02, "median at most 1.02, worst at most 1.15"));

    let found = over_smallest();
    assert!(found[2] >= 0.99, "{found:?}");
    let what = "heap over the smallest packing, 1000 random graphs of up to 12 transients";
    figures.push(figure(what, found, 1.1, "at most 1.1 in 99 %"));

    let cases = random(200, 60, 19, 8..=usize::MAX);
    let ratio = |case: &Case| {
        let best = best_order(&case.description, &case.plan, 100);
        case.plan.statistics.lower_bound_bytes as f64 / best.max(1) as f64
    };
    let found = spread("bound over the best of 100 orders", cases.iter().map(ratio).collect(), 1.0);
    assert!(found[0] <= 1.1, "{found:?}");
    let what = "lower bound over that of the best of 100 random orders, 200 random graphs";
    figures.push(figure(what, found, 1.0, "median at most 1.1"));

    publish_page("graph/memory.md", "plan_packing", "made-up devices with one queue; no device is needed", &figures);
}

fn over_smallest() -> [f64; 3] {
    let cases = random(1000, 30, 17, 2..=12);
    let mut ratios = Vec::new();
    for case in &cases {
        let best: Option<u64> = case.blocks().iter().map(|blocks| smallest(blocks)).sum();
        ratios.extend(best.map(|best| case.plan.statistics.heap_bytes as f64 / best as f64));
    }
    println!("solved exactly: {} of {}", ratios.len(), cases.len());
    assert!(ratios.len() * 100 >= cases.len() * 99);
    spread("heap over smallest packing", ratios, 1.1)
}

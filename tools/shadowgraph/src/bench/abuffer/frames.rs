//! Frames that composite layers in some way, and how long they take.

use ash::vk;
use glam::Vec3;
use shadowgraph::gpu::{Feature, FormatInfo, Gpu, blend};
use shadowgraph::graph::description::Shape;
use shadowgraph::graph::{Executed, Executor, Graph, ImageHandle, ImageShape, Load};
use shadowgraph::scene::{Camera, View, depth};
use shadowgraph::shader::Program;
use shadowgraph::shader::generated::bench::{layers_blend_frag, layers_vert};
use shadowgraph::techniques::transparency::OrderIndependent;
use shadowgraph::techniques::transparency::abuffer::{ABuffer, Build, LongSort, Sizing};
use shadowgraph::techniques::transparency::depth_peeling::DepthPeeling;
use shadowgraph::techniques::transparency::dual_depth_peeling::DualDepthPeeling;
use shadowgraph::techniques::transparency::fragments::{Fragments, Step};
use shadowgraph::techniques::transparency::kbuffer::KBuffer;
use shadowgraph::techniques::transparency::moments::Moments;
use shadowgraph::techniques::transparency::stochastic::Stochastic;
use shadowgraph::techniques::transparency::weighted::{Weight, Weighted};

use super::layers::{Layers, NEAR};
use crate::bench::median;
use crate::failure::Result;

/// A way to composite the layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing: what the rest of the frame takes.
    Nothing,
    /// Fixed-function blending into half-floats, in the order of draws.
    Blend,
    /// The A-buffer by counted arrays.
    Arrays,
    /// The A-buffer by linked lists.
    Lists,
    /// The same, nodes allocated by subgroups where the device has them.
    SubgroupLists,
    /// The A-buffer by counted arrays, long lists sorted so.
    Sorted(LongSort),
    /// The A-buffer by counted arrays, of so many samples a pixel.
    Samples(u32),
    /// One of the others.
    Other(usize),
    /// So many bytes filled with a number.
    Filled(u64),
}

/// What the A-buffer is compared with, and at how many layers.
pub const OTHERS: [(&str, &dyn OrderIndependent); 6] = [
    ("dual depth peeling", &DualDepthPeeling { layers: 32 }),
    ("depth peeling", &DepthPeeling { layers: 32 }),
    ("k-buffer of 4", &KBuffer { kept: 4 }),
    ("moments", &Moments),
    ("stochastic, 8 samples", &Stochastic { samples: 8 }),
    ("weighted", &Weighted { weight: Weight::Equation7 }),
];

/// Seconds of a frame, in all and of its two parts.
#[derive(Clone, Copy)]
pub struct Times {
    pub whole: f64,
    pub build: f64,
    pub sort: f64,
    /// Bytes of its images and buffers, without sharing.
    pub memory: u64,
}

/// Median times of each kind, in turns: the whole of frames whose passes are not timed, as timing takes time.
pub fn medians<const N: usize>(gpu: &Gpu, kinds: [Kind; N], layers: Layers, runs: u32) -> Result<[Times; N]> {
    let (mut timed, mut plain) = (Executor::new(gpu), Executor::new(gpu));
    plain.instruments(false);
    let mut all = [const { Vec::new() }; N];
    // What is made at first use is in the first turn alone.
    for turn in 0..=runs {
        for (kind, all) in kinds.into_iter().zip(&mut all) {
            let parts = times(&execute(gpu, &mut timed, kind, layers)?);
            let whole = execute(gpu, &mut plain, kind, layers)?.running.as_secs_f64();
            if turn > 0 {
                all.push(Times { whole, ..parts });
            }
        }
    }
    Ok(all.map(|all| {
        let of = |part: fn(&Times) -> f64| median(all.iter().map(part).collect());
        let memory = all.last().map_or(0, |times| times.memory);
        Times { whole: of(|times| times.whole), build: of(|times| times.build), sort: of(|times| times.sort), memory }
    }))
}

/// Runs a frame of one kind.
pub fn execute(gpu: &Gpu, executor: &mut Executor, kind: Kind, layers: Layers) -> Result<Executed> {
    let size = layers.size;
    let mut graph = Graph::new("bench", gpu.caps());
    let samples = if let Kind::Samples(count) = kind { count } else { 1 };
    let depth = cleared_depth(&mut graph, size, samples);
    let format = match kind {
        Kind::Blend => vk::Format::R16G16B16A16_SFLOAT,
        _ => vk::Format::R32G32B32A32_SFLOAT,
    };
    let color = graph.image("color", ImageShape::new_2d(format, size));
    let color = graph.clear("background", color, vk::ClearColorValue::default());
    let color = match kind {
        Kind::Nothing => color,
        Kind::Blend => blended(&mut graph, layers, &depth, color),
        Kind::Arrays => composited(&mut graph, ABuffer::default(), layers, &depth, color),
        Kind::Lists => {
            let build = Build::Lists(Sizing::Counted);
            composited(&mut graph, ABuffer { build, ..ABuffer::default() }, layers, &depth, color)
        }
        Kind::SubgroupLists => {
            let build = match gpu.caps().has(Feature::FragmentBallot) {
                true => Build::SubgroupLists(Sizing::Counted),
                false => Build::Lists(Sizing::Counted),
            };
            composited(&mut graph, ABuffer { build, ..ABuffer::default() }, layers, &depth, color)
        }
        Kind::Sorted(long_sort) => {
            composited(&mut graph, ABuffer { long_sort, ..ABuffer::default() }, layers, &depth, color)
        }
        Kind::Samples(samples) => {
            composited(&mut graph, ABuffer { samples, ..ABuffer::default() }, layers, &depth, color)
        }
        Kind::Filled(bytes) => {
            let filled = graph.buffer("abuffer.least", bytes / 4 * 4);
            let filled = graph.fill("abuffer.least", filled, 1);
            graph.keep("least", &filled);
            color
        }
        Kind::Other(other) => OTHERS[other].1.composite(&mut graph, &view(size), &depth, &layers, color),
    };
    graph.keep("color", &color);
    graph.keep("depth", &depth);
    let plan = graph.compile(gpu).map_err(shadowgraph::Error::from)?;
    Ok(executor.execute(&plan, graph)?)
}

/// Sums over the passes of a frame.
fn times(executed: &Executed) -> Times {
    let sum = |sorts: bool| {
        let own = executed.passes.iter().filter(|pass| pass.name.starts_with("abuffer."));
        let sorting = |name: &str| [".resolve.", ".long.", ".sorted."].iter().any(|part| name.contains(part));
        own.filter(|pass| sorting(&pass.name) == sorts).map(|pass| pass.seconds).sum()
    };
    // Sizes that followed from a checkpoint are known to the last segment.
    let memory = executed.later.last().map_or(0, |segment| {
        let own = segment.description.resources.iter().filter(|resource| resource.name.starts_with("abuffer."));
        own.map(|resource| bytes(&resource.shape)).sum()
    });
    Times { whole: executed.running.as_secs_f64(), build: sum(false), sort: sum(true), memory }
}

fn bytes(shape: &Shape) -> u64 {
    match shape {
        Shape::Buffer { size } => *size,
        Shape::Image(image) => FormatInfo::of(image.format).map_or(0, |format| format.bytes(image.extent)),
    }
}

fn cleared_depth(graph: &mut Graph, size: [u32; 2], samples: u32) -> ImageHandle {
    let depth = graph.image("depth", ImageShape::new_2d(vk::Format::D32_SFLOAT, size).samples(samples));
    let mut pass = graph.raster("depth", vec![Program::new(&layers_vert::SHADER, None).depth(depth::CLOSER, true)]);
    let depth = pass.depth(depth, Load::Clear(depth::CLEAR));
    pass.draw(|_| Ok(()));
    depth
}

fn blended(graph: &mut Graph, layers: Layers, depth: &ImageHandle, color: ImageHandle) -> ImageHandle {
    let program = Program::new(&layers_vert::SHADER, Some(&layers_blend_frag::SHADER));
    let mut pass = graph.raster("blend", vec![program.depth(depth::CLOSER, false).blend(blend::over())]);
    pass.depth_test(depth);
    let color = pass.color(layers_blend_frag::COLOR, color, Load::Keep);
    pass.draw(layers.draw(Step::Count));
    color
}

fn composited(
    graph: &mut Graph,
    abuffer: ABuffer,
    layers: Layers,
    depth: &ImageHandle,
    color: ImageHandle,
) -> ImageHandle {
    let view = view(depth.size());
    abuffer.record(graph, &view, depth, &layers, color).color
}

/// Only how far layers are depends on it.
fn view(size: [u32; 2]) -> View {
    Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0, NEAR).view(size)
}

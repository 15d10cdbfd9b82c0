//! What the A-buffer costs a fragment, beside blending of the same fragments, beside the other techniques, and beside the
//! bytes that must move at least: layers of one colour.

mod layers;

use ash::vk;
use glam::Vec3;
use shadowgraph::gpu::{Feature, FormatInfo, Gpu, blend};
use shadowgraph::graph::description::Shape;
use shadowgraph::graph::{Executor, Graph, ImageHandle, ImageShape, Load};
use shadowgraph::scene::{Camera, View, depth};
use shadowgraph::shader::Program;
use shadowgraph::shader::generated::bench::{layers_blend_frag, layers_vert};
use shadowgraph::techniques::transparency::OrderIndependent;
use shadowgraph::techniques::transparency::abuffer::{ABuffer, Build, LongSort, Sizing, sample_counts};
use shadowgraph::techniques::transparency::depth_peeling::DepthPeeling;
use shadowgraph::techniques::transparency::dual_depth_peeling::DualDepthPeeling;
use shadowgraph::techniques::transparency::fragments::{Fragments, Step};
use shadowgraph::techniques::transparency::kbuffer::KBuffer;
use shadowgraph::techniques::transparency::moments::Moments;
use shadowgraph::techniques::transparency::stochastic::Stochastic;
use shadowgraph::techniques::transparency::weighted::{Weight, Weighted};

use self::layers::{Layers, Lengths, NEAR};
use super::Measurement;
use crate::cli::{BenchArguments, DeviceArguments};
use crate::failure::Result;
use crate::session;

const LAYERS: [u32; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
const SIDES: [u32; 4] = [128, 256, 512, 1024];
/// Lengths of lists that are no more all the same.
const LENGTHS: [(&str, Lengths); 2] =
    [("a spot of 260", Lengths::Spot(256)), ("exponential of 8", Lengths::Exponential(8))];
/// Lists that are sorted in each way.
const LONG: [u32; 6] = [17, 24, 32, 64, 128, 256];
const LONG_SORTS: [(&str, LongSort); 4] = [
    ("blocks", LongSort::Blocks),
    ("shell", LongSort::Shell),
    ("heap", LongSort::Heap),
    ("bitonic", LongSort::Bitonic),
];
/// Of a compact node of an array, and of a texel of the picture.
const NODE_BYTES: f64 = 16.0;
const COLOR_BYTES: f64 = 16.0;

/// A way to composite the layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
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

const KINDS: [Kind; 4] = [Kind::Nothing, Kind::Blend, Kind::Arrays, Kind::Lists];

/// What the A-buffer is compared with, and at how many layers.
const OTHERS: [(&str, &dyn OrderIndependent); 6] = [
    ("dual depth peeling", &DualDepthPeeling { layers: 32 }),
    ("depth peeling", &DepthPeeling { layers: 32 }),
    ("k-buffer of 4", &KBuffer { kept: 4 }),
    ("moments", &Moments),
    ("stochastic, 8 samples", &Stochastic { samples: 8 }),
    ("weighted", &Weighted { weight: Weight::Equation7 }),
];
const COMPARED: [u32; 2] = [8, 32];

/// Least seconds of a frame, in all and of its two parts.
#[derive(Clone, Copy)]
struct Times {
    whole: f64,
    build: f64,
    sort: f64,
    /// Bytes of its images and buffers, without sharing.
    memory: u64,
}

/// Layers at one resolution, and one number of layers over resolutions; how times grow, as slopes of straight lines
/// through the logarithms.
pub fn run(arguments: &BenchArguments, tell: &mut impl FnMut(Measurement) -> Result<()>) -> Result<()> {
    let gpu = session::open(&DeviceArguments::default())?;
    let measured = measure_all(&gpu, arguments, tell);
    let closed = session::close(gpu);
    measured.and(closed)
}

fn measure_all(gpu: &Gpu, arguments: &BenchArguments, tell: &mut impl FnMut(Measurement) -> Result<()>) -> Result<()> {
    let mut growth = Vec::new();
    for layers in LAYERS {
        let case = format!("256x256x{layers}");
        let whole = measure(gpu, Layers::constant([256, 256], layers), &case, arguments, tell)?;
        if COMPARED.contains(&layers) {
            compare(gpu, [256, 256], layers, arguments, tell)?;
        }
        growth.extend(whole.filter(|_| (4..=128).contains(&layers)).map(|whole| (f64::from(layers), whole)));
    }
    if let Some(slope) = slope(&growth) {
        tell(figure("arrays".into(), "growth by layers, 4 to 128", slope, "slope"))?;
    }
    let mut growth = Vec::new();
    for side in SIDES {
        let case = format!("{side}x{side}x8");
        let whole = measure(gpu, Layers::constant([side, side], 8), &case, arguments, tell)?;
        growth.extend(whole.map(|whole| (f64::from(side * side), whole)));
    }
    if let Some(slope) = slope(&growth) {
        tell(figure("arrays".into(), "growth by pixels, 8 layers", slope, "slope"))?;
    }
    for (name, lengths) in LENGTHS {
        measure(gpu, Layers { size: [256, 256], lengths }, &format!("256x256, {name}"), arguments, tell)?;
    }
    sample_counts(gpu.caps()).into_iter().try_for_each(|count| samples(gpu, count, arguments, tell))?;
    LONG.into_iter().try_for_each(|length| sorts(gpu, length, arguments, tell))
}

/// Tells what several samples a pixel take, to one.
fn samples(
    gpu: &Gpu,
    count: u32,
    arguments: &BenchArguments,
    tell: &mut impl FnMut(Measurement) -> Result<()>,
) -> Result<()> {
    let case = format!("{count} samples 512x512x8");
    if !arguments.wants(&case) {
        return Ok(());
    }
    let layers = Layers::constant([512, 512], 8);
    let kinds = [Kind::Nothing, Kind::Arrays, Kind::Samples(count)];
    let [nothing, single, several] = best(gpu, kinds, layers, arguments.runs)?;
    let whole = |times: Times| (times.whole - nothing.whole).max(1e-9);
    tell(figure(case.clone(), "whole", whole(several) * 1e9 / layers.fragments(), "ns/fragment"))?;
    tell(figure(case.clone(), "to one sample", whole(several) / whole(single), "times"))?;
    tell(figure(case.clone(), "build to one sample", several.build / single.build.max(1e-9), "times"))?;
    tell(figure(case, "sort, composite to one sample", several.sort / single.sort.max(1e-9), "times"))
}

/// Tells what sorting and compositing of long lists takes in each way.
fn sorts(
    gpu: &Gpu,
    length: u32,
    arguments: &BenchArguments,
    tell: &mut impl FnMut(Measurement) -> Result<()>,
) -> Result<()> {
    let case = |name: &str| format!("sort by {name}, {length}");
    if !LONG_SORTS.iter().any(|(name, _)| arguments.wants(&case(name))) {
        return Ok(());
    }
    let layers = Layers::constant([128, 128], length);
    let times = best(gpu, LONG_SORTS.map(|(_, sort)| Kind::Sorted(sort)), layers, arguments.runs)?;
    for ((name, _), own) in LONG_SORTS.into_iter().zip(times) {
        let case = case(name);
        tell(figure(case.clone(), "sort, composite", own.sort * 1e9 / layers.fragments(), "ns/fragment"))?;
        tell(figure(case, "to blocks", own.sort / times[0].sort.max(1e-9), "times"))?;
    }
    Ok(())
}

/// Tells the figures of a case that is asked for, and gives the seconds that arrays take in all.
fn measure(
    gpu: &Gpu,
    layers: Layers,
    case: &str,
    arguments: &BenchArguments,
    tell: &mut impl FnMut(Measurement) -> Result<()>,
) -> Result<Option<f64>> {
    let case = |kind: &str| format!("{kind} {case}");
    if !["blend", "arrays", "lists", "subgroup lists"].iter().any(|kind| arguments.wants(&case(kind))) {
        return Ok(None);
    }
    // Each node is written and read once, and so is the colour of each pixel that has some.
    let least = 2.0 * (NODE_BYTES * layers.fragments() + COLOR_BYTES * layers.pixels());
    let [nothing, blend, arrays, lists] = KINDS;
    let kinds = [nothing, blend, arrays, lists, Kind::SubgroupLists, Kind::Filled(least as u64)];
    let [nothing, blend, arrays, lists, subgroup_lists, filled] = best(gpu, kinds, layers, arguments.runs)?;
    let filling = (filled.whole - nothing.whole).max(1e-9);
    let fragments = layers.fragments();
    let nanoseconds = |seconds: f64| seconds * 1e9 / fragments;
    let blending = (blend.whole - nothing.whole).max(1e-9);
    tell(figure(case("blend"), "whole", nanoseconds(blending), "ns/fragment"))?;
    for (kind, times) in [("arrays", arrays), ("lists", lists), ("subgroup lists", subgroup_lists)] {
        let whole = times.whole - nothing.whole;
        tell(figure(case(kind), "build", nanoseconds(times.build), "ns/fragment"))?;
        tell(figure(case(kind), "sort, composite", nanoseconds(times.sort), "ns/fragment"))?;
        tell(figure(case(kind), "whole", nanoseconds(whole), "ns/fragment"))?;
        tell(figure(case(kind), "whole to blending", whole / blending, "times"))?;
        tell(figure(case(kind), "whole to filling the least bytes", whole / filling, "times"))?;
        tell(figure(case(kind), "memory", times.memory as f64 / fragments, "bytes/fragment"))?;
        tell(figure(case(kind), "memory to the least bytes", times.memory as f64 / (least / 2.0), "times"))?;
    }
    Ok(Some(arrays.whole - nothing.whole))
}

/// Tells what the other techniques take of the same fragments, and the A-buffer beside them.
fn compare(
    gpu: &Gpu,
    size: [u32; 2],
    layers: u32,
    arguments: &BenchArguments,
    tell: &mut impl FnMut(Measurement) -> Result<()>,
) -> Result<()> {
    let fragments = f64::from(size[0]) * f64::from(size[1]) * f64::from(layers);
    for (other, (name, _)) in OTHERS.into_iter().enumerate() {
        let case = format!("{name} {}x{}x{layers}", size[0], size[1]);
        if !arguments.wants(&case) {
            continue;
        }
        let kinds = [Kind::Nothing, Kind::Arrays, Kind::Other(other)];
        let whole = best(gpu, kinds, Layers::constant(size, layers), arguments.runs)?.map(|times| times.whole);
        let [arrays, other] = [whole[1], whole[2]].map(|seconds| (seconds - whole[0]).max(1e-9));
        tell(figure(case.clone(), "whole", other * 1e9 / fragments, "ns/fragment"))?;
        tell(figure(case, "arrays to it", arrays / other, "times"))?;
    }
    Ok(())
}

/// Least times of each kind, in turns.
fn best<const N: usize>(gpu: &Gpu, kinds: [Kind; N], layers: Layers, runs: u32) -> Result<[Times; N]> {
    let mut executor = Executor::new(gpu);
    let none = Times { whole: f64::INFINITY, build: f64::INFINITY, sort: f64::INFINITY, memory: 0 };
    let mut best = [none; N];
    for _ in 0..=runs {
        for (kind, best) in kinds.into_iter().zip(&mut best) {
            let times = frame(gpu, &mut executor, kind, layers)?;
            best.whole = best.whole.min(times.whole);
            best.build = best.build.min(times.build);
            best.sort = best.sort.min(times.sort);
            best.memory = times.memory;
        }
    }
    Ok(best)
}

fn figure(case: String, metric: &str, value: f64, unit: &'static str) -> Measurement {
    Measurement { bench: "abuffer", case, metric: metric.into(), value, unit }
}

/// Slope of the straight line nearest to the points' logarithms.
fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let logarithms: Vec<_> = points.iter().map(|(x, y)| (x.ln(), y.max(1e-9).ln())).collect();
    let count = logarithms.len().max(1) as f64;
    let mean_x = logarithms.iter().map(|(x, _)| x).sum::<f64>() / count;
    let mean_y = logarithms.iter().map(|(_, y)| y).sum::<f64>() / count;
    let across: f64 = logarithms.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    (points.len() > 1).then(|| across / logarithms.iter().map(|(x, _)| (x - mean_x).powi(2)).sum::<f64>().max(1e-12))
}

/// Runs a frame of one kind.
fn frame(gpu: &Gpu, executor: &mut Executor, kind: Kind, layers: Layers) -> Result<Times> {
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
    let executed = executor.execute(&plan, graph)?;
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
    Ok(Times { whole: executed.running.as_secs_f64(), build: sum(false), sort: sum(true), memory })
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

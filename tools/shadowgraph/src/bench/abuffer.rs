//! What the A-buffer costs a fragment, beside blending of the same fragments and beside the other techniques: full-screen
//! layers of one colour.

use ash::vk;
use glam::Vec3;
use shadowgraph::gpu::{Gpu, blend};
use shadowgraph::graph::{Executor, Graph, ImageHandle, ImageShape, Load, RasterPass};
use shadowgraph::scene::{Camera, View, depth};
use shadowgraph::shader::Program;
use shadowgraph::shader::generated::bench::{self as shaders, layers_blend_frag, layers_vert};
use shadowgraph::shader::generated::transparency::count_frag;
use shadowgraph::techniques::transparency::OrderIndependent;
use shadowgraph::techniques::transparency::abuffer::{ABuffer, Build, Sizing};
use shadowgraph::techniques::transparency::depth_peeling::DepthPeeling;
use shadowgraph::techniques::transparency::dual_depth_peeling::DualDepthPeeling;
use shadowgraph::techniques::transparency::fragments::{Draw, Fragments, Step};
use shadowgraph::techniques::transparency::kbuffer::KBuffer;
use shadowgraph::techniques::transparency::moments::Moments;
use shadowgraph::techniques::transparency::stochastic::Stochastic;
use shadowgraph::techniques::transparency::weighted::{Weight, Weighted};

use super::Measurement;
use crate::cli::{BenchArguments, DeviceArguments};
use crate::failure::Result;
use crate::session;

const LAYERS: [u32; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
/// Near plane, metres.
const NEAR: f32 = 0.1;
const SIDES: [u32; 4] = [128, 256, 512, 1024];

/// Layers over the whole picture.
#[derive(Clone, Copy)]
struct Layers(u32);

impl<'f> Fragments<'f> for Layers {
    fn programs(&self, step: Step) -> Vec<Program> {
        let fragment = match step {
            Step::Samples => None,
            Step::Count => Some(&count_frag::SHADER),
            Step::Arrays => Some(&shaders::layers_array_frag::SHADER),
            Step::ArraysInOrder => Some(&shaders::layers_array_in_order_frag::SHADER),
            Step::Lists => Some(&shaders::layers_list_frag::SHADER),
            Step::Peel => Some(&shaders::layers_peel_frag::SHADER),
            Step::PeelBothEnds => Some(&shaders::layers_peel_both_ends_frag::SHADER),
            Step::Weigh => Some(&shaders::layers_weigh_frag::SHADER),
            Step::KeepDepths => Some(&shaders::layers_keep_depths_frag::SHADER),
            Step::KeepTags => Some(&shaders::layers_keep_tags_frag::SHADER),
            Step::KeepColors => Some(&shaders::layers_keep_colors_frag::SHADER),
            Step::AddMoments => Some(&shaders::layers_add_moments_frag::SHADER),
            Step::AddByMoments => Some(&shaders::layers_add_by_moments_frag::SHADER),
            Step::SampleDepths => Some(&shaders::layers_sample_depths_frag::SHADER),
            Step::AddBySamples => Some(&shaders::layers_add_by_samples_frag::SHADER),
        };
        vec![Program::new(&layers_vert::SHADER, fragment)]
    }

    fn bind(&self, _: &mut RasterPass<'_, 'f>, _: Step) {}

    fn draw(&self, _: Step) -> Draw<'f> {
        let layers = self.0;
        Box::new(move |recorder| {
            recorder.push(&layers);
            recorder.draw(0..3, 0..layers);
            Ok(())
        })
    }

    fn distances(&self) -> [f32; 2] {
        // Depths from one near plane on.
        [NEAR, NEAR * (1 << 24) as f32]
    }
}

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
    /// One of the others.
    Other(usize),
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
}

/// Layers at one resolution, and one number of layers over resolutions; how times grow, as slopes of straight lines
/// through the logarithms.
pub fn run(arguments: &BenchArguments, tell: &mut impl FnMut(Measurement) -> Result<()>) -> Result<()> {
    let gpu = session::open(&DeviceArguments::default())?;
    let measured = measure_all(&gpu, arguments.runs, tell);
    let closed = session::close(gpu);
    measured.and(closed)
}

fn measure_all(gpu: &Gpu, runs: u32, tell: &mut impl FnMut(Measurement) -> Result<()>) -> Result<()> {
    let mut growth = Vec::new();
    for layers in LAYERS {
        let whole = measure(gpu, [256, 256], layers, runs, tell)?;
        if COMPARED.contains(&layers) {
            compare(gpu, [256, 256], layers, runs, tell)?;
        }
        growth.extend((4..=128).contains(&layers).then_some((f64::from(layers), whole)));
    }
    tell(figure("arrays".into(), "growth by layers, 4 to 128", slope(&growth), "slope"))?;
    let mut growth = Vec::new();
    for side in SIDES {
        let whole = measure(gpu, [side, side], 8, runs, tell)?;
        growth.push((f64::from(side * side), whole));
    }
    tell(figure("arrays".into(), "growth by pixels, 8 layers", slope(&growth), "slope"))
}

/// Tells the figures, and gives the seconds that arrays take in all.
fn measure(
    gpu: &Gpu,
    size: [u32; 2],
    layers: u32,
    runs: u32,
    tell: &mut impl FnMut(Measurement) -> Result<()>,
) -> Result<f64> {
    let [nothing, blend, arrays, lists] = best(gpu, KINDS, size, layers, runs)?;
    let fragments = f64::from(size[0]) * f64::from(size[1]) * f64::from(layers);
    let nanoseconds = |seconds: f64| seconds * 1e9 / fragments;
    let blending = (blend.whole - nothing.whole).max(1e-9);
    let case = |kind: &str| format!("{kind} {}x{}x{layers}", size[0], size[1]);
    tell(figure(case("blend"), "whole", nanoseconds(blending), "ns/fragment"))?;
    for (kind, times) in [("arrays", arrays), ("lists", lists)] {
        let whole = times.whole - nothing.whole;
        tell(figure(case(kind), "build", nanoseconds(times.build), "ns/fragment"))?;
        tell(figure(case(kind), "sort, composite", nanoseconds(times.sort), "ns/fragment"))?;
        tell(figure(case(kind), "whole", nanoseconds(whole), "ns/fragment"))?;
        tell(figure(case(kind), "whole to blending", whole / blending, "times"))?;
    }
    Ok(arrays.whole - nothing.whole)
}

/// Tells what the other techniques take of the same fragments, and the A-buffer beside them.
fn compare(
    gpu: &Gpu,
    size: [u32; 2],
    layers: u32,
    runs: u32,
    tell: &mut impl FnMut(Measurement) -> Result<()>,
) -> Result<()> {
    let fragments = f64::from(size[0]) * f64::from(size[1]) * f64::from(layers);
    for (other, (name, _)) in OTHERS.into_iter().enumerate() {
        let kinds = [Kind::Nothing, Kind::Arrays, Kind::Other(other)];
        let whole = best(gpu, kinds, size, layers, runs)?.map(|times| times.whole);
        let [arrays, other] = [whole[1], whole[2]].map(|seconds| (seconds - whole[0]).max(1e-9));
        let case = format!("{name} {}x{}x{layers}", size[0], size[1]);
        tell(figure(case.clone(), "whole", other * 1e9 / fragments, "ns/fragment"))?;
        tell(figure(case, "arrays to it", arrays / other, "times"))?;
    }
    Ok(())
}

/// Least times of each kind, in turns.
fn best<const N: usize>(gpu: &Gpu, kinds: [Kind; N], size: [u32; 2], layers: u32, runs: u32) -> Result<[Times; N]> {
    let mut executor = Executor::new(gpu);
    let none = Times { whole: f64::INFINITY, build: f64::INFINITY, sort: f64::INFINITY };
    let mut best = [none; N];
    for _ in 0..=runs {
        for (kind, best) in kinds.into_iter().zip(&mut best) {
            let times = frame(gpu, &mut executor, kind, size, layers)?;
            best.whole = best.whole.min(times.whole);
            best.build = best.build.min(times.build);
            best.sort = best.sort.min(times.sort);
        }
    }
    Ok(best)
}

fn figure(case: String, metric: &str, value: f64, unit: &'static str) -> Measurement {
    Measurement { bench: "abuffer", case, metric: metric.into(), value, unit }
}

/// Slope of the straight line nearest to the points' logarithms.
fn slope(points: &[(f64, f64)]) -> f64 {
    let logarithms: Vec<_> = points.iter().map(|(x, y)| (x.ln(), y.max(1e-9).ln())).collect();
    let count = logarithms.len().max(1) as f64;
    let mean_x = logarithms.iter().map(|(x, _)| x).sum::<f64>() / count;
    let mean_y = logarithms.iter().map(|(_, y)| y).sum::<f64>() / count;
    let across: f64 = logarithms.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    across / logarithms.iter().map(|(x, _)| (x - mean_x).powi(2)).sum::<f64>().max(1e-12)
}

/// Runs a frame of one kind.
fn frame(gpu: &Gpu, executor: &mut Executor, kind: Kind, size: [u32; 2], layers: u32) -> Result<Times> {
    let mut graph = Graph::new("bench", gpu.caps());
    let depth = cleared_depth(&mut graph, size);
    let format = match kind {
        Kind::Blend => vk::Format::R16G16B16A16_SFLOAT,
        _ => vk::Format::R32G32B32A32_SFLOAT,
    };
    let color = graph.image("color", ImageShape::new_2d(format, size));
    let color = graph.clear("background", color, vk::ClearColorValue::default());
    let layers = Layers(layers);
    let color = match kind {
        Kind::Nothing => color,
        Kind::Blend => blended(&mut graph, layers, &depth, color),
        Kind::Arrays => composited(&mut graph, Build::Arrays, layers, &depth, color),
        Kind::Lists => composited(&mut graph, Build::Lists(Sizing::Counted), layers, &depth, color),
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
    Ok(Times { whole: executed.running.as_secs_f64(), build: sum(false), sort: sum(true) })
}

fn cleared_depth(graph: &mut Graph, size: [u32; 2]) -> ImageHandle {
    let depth = graph.image("depth", ImageShape::new_2d(vk::Format::D32_SFLOAT, size));
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

fn composited(graph: &mut Graph, build: Build, layers: Layers, depth: &ImageHandle, color: ImageHandle) -> ImageHandle {
    let view = view(depth.size());
    ABuffer { build, ..ABuffer::default() }.record(graph, &view, depth, &layers, color).color
}

/// Only how far layers are depends on it.
fn view(size: [u32; 2]) -> View {
    Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0, NEAR).view(size)
}

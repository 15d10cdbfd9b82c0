//! What the A-buffer costs a fragment, beside blending of the same fragments, beside the other techniques, and beside the
//! bytes that must move at least: layers of one colour.

mod frames;
mod layers;

use shadowgraph::gpu::Gpu;
use shadowgraph::graph::Executor;
use shadowgraph::techniques::transparency::abuffer::{LongSort, sample_counts};

use self::frames::{Kind, OTHERS, Times, execute, medians};
use self::layers::{Layers, Lengths};
use super::{Measurement, median};
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

const KINDS: [Kind; 4] = [Kind::Nothing, Kind::Blend, Kind::Arrays, Kind::Lists];

const COMPARED: [u32; 2] = [8, 32];

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
    SIDES.into_iter().try_for_each(|side| passes(gpu, side, arguments, tell))?;
    for (name, lengths) in LENGTHS {
        measure(gpu, Layers { size: [256, 256], lengths }, &format!("256x256, {name}"), arguments, tell)?;
    }
    sample_counts(gpu.caps()).into_iter().try_for_each(|count| samples(gpu, count, arguments, tell))?;
    LONG.into_iter().try_for_each(|length| sorts(gpu, length, arguments, tell))
}

/// Tells the time of each pass of arrays, and of blending, at eight layers.
fn passes(
    gpu: &Gpu,
    side: u32,
    arguments: &BenchArguments,
    tell: &mut impl FnMut(Measurement) -> Result<()>,
) -> Result<()> {
    let case = format!("passes {side}x{side}x8");
    if !arguments.wants(&case) {
        return Ok(());
    }
    let layers = Layers::constant([side, side], 8);
    let mut executor = Executor::new(gpu);
    let mut passes: Vec<(String, Vec<f64>)> = Vec::new();
    for _ in 0..=arguments.runs {
        for kind in [Kind::Blend, Kind::Arrays] {
            for pass in execute(gpu, &mut executor, kind, layers)?.passes {
                match passes.iter_mut().find(|(name, _)| *name == pass.name) {
                    Some((_, seconds)) => seconds.push(pass.seconds),
                    None => passes.push((pass.name, vec![pass.seconds])),
                }
            }
        }
    }
    let tell = |(name, seconds): (String, _)| tell(figure(case.clone(), &name, median(seconds) * 1e6, "µs"));
    passes.into_iter().try_for_each(tell)
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
    let [nothing, single, several] = medians(gpu, kinds, layers, arguments.runs)?;
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
    let times = medians(gpu, LONG_SORTS.map(|(_, sort)| Kind::Sorted(sort)), layers, arguments.runs)?;
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
    let [nothing, blend, arrays, lists, subgroup_lists, filled] = medians(gpu, kinds, layers, arguments.runs)?;
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
        let whole = medians(gpu, kinds, Layers::constant(size, layers), arguments.runs)?.map(|times| times.whole);
        let [arrays, other] = [whole[1], whole[2]].map(|seconds| (seconds - whole[0]).max(1e-9));
        tell(figure(case.clone(), "whole", other * 1e9 / fragments, "ns/fragment"))?;
        tell(figure(case, "arrays to it", arrays / other, "times"))?;
    }
    Ok(())
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

//! What the A-buffer costs a fragment, beside blending of the same fragments: full-screen layers of one colour.

use ash::vk;
use glam::Vec3;
use shadowgraph::gpu::{Gpu, blend};
use shadowgraph::graph::{Executed, Executor, Graph, ImageHandle, ImageShape, Load, RasterPass};
use shadowgraph::scene::{Camera, View, depth};
use shadowgraph::shader::Program;
use shadowgraph::shader::generated::bench::{layers_array_frag, layers_blend_frag, layers_list_frag, layers_vert};
use shadowgraph::shader::generated::transparency::abuffer::count_frag;
use shadowgraph::techniques::transparency::abuffer::{ABuffer, Build, Draw, Fragments, Sizing, Step};

use super::Measurement;
use crate::cli::{BenchArguments, DeviceArguments};
use crate::failure::Result;
use crate::session;

const LAYERS: [u32; 2] = [8, 32];

/// Layers over the whole picture.
#[derive(Clone, Copy)]
struct Layers(u32);

impl<'f> Fragments<'f> for Layers {
    fn programs(&self, step: Step) -> Vec<Program> {
        let fragment = match step {
            Step::Samples => None,
            Step::Count => Some(&count_frag::SHADER),
            Step::Arrays => Some(&layers_array_frag::SHADER),
            Step::Lists => Some(&layers_list_frag::SHADER),
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
}

/// A frame of one kind, and its passes' times.
pub fn run(arguments: &BenchArguments, tell: &mut impl FnMut(Measurement) -> Result<()>) -> Result<()> {
    let gpu = session::open(&DeviceArguments::default())?;
    let measured = LAYERS.iter().try_for_each(|&layers| measure(&gpu, layers, arguments, tell));
    let closed = session::close(gpu);
    measured.and(closed)
}

fn measure(
    gpu: &Gpu,
    layers: u32,
    arguments: &BenchArguments,
    tell: &mut impl FnMut(Measurement) -> Result<()>,
) -> Result<()> {
    let size = [512, 512];
    let fragments = f64::from(size[0]) * f64::from(size[1]) * f64::from(layers);
    let mut executor = Executor::new(gpu);
    type Record = fn(&mut Graph<'_>, Layers, &ImageHandle, ImageHandle) -> ImageHandle;
    let kinds: [(&str, Record); 3] = [("blend", blended), ("arrays", arrays), ("lists", lists)];
    for (kind, record) in kinds {
        let mut best: Vec<(String, f64)> = Vec::new();
        for _ in 0..=arguments.runs {
            let mut graph = Graph::new("bench", gpu.caps());
            let depth = cleared_depth(&mut graph, size);
            let format =
                if kind == "blend" { vk::Format::R16G16B16A16_SFLOAT } else { vk::Format::R32G32B32A32_SFLOAT };
            let color = graph.image("color", ImageShape::new_2d(format, size));
            let color = graph.clear("background", color, vk::ClearColorValue::default());
            let color = record(&mut graph, Layers(layers), &depth, color);
            graph.keep("color", &color);
            let plan = graph.compile(gpu).map_err(shadowgraph::Error::from)?;
            let executed: Executed = executor.execute(&plan, graph)?;
            for pass in &executed.passes {
                match best.iter_mut().find(|(name, _)| *name == pass.name) {
                    Some((_, time)) => *time = (*time).min(pass.seconds),
                    None => best.push((pass.name.clone(), pass.seconds)),
                }
            }
        }
        for (pass, time) in best {
            let value = time * 1e9 / fragments;
            let case = format!("{kind} {layers}");
            tell(Measurement { bench: "abuffer", case, metric: pass, value, unit: "ns/fragment" })?;
        }
    }
    Ok(())
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

fn arrays(graph: &mut Graph, layers: Layers, depth: &ImageHandle, color: ImageHandle) -> ImageHandle {
    ABuffer::default().record(graph, &view(depth.size()), depth, &layers, color).color
}

fn lists(graph: &mut Graph, layers: Layers, depth: &ImageHandle, color: ImageHandle) -> ImageHandle {
    let build = Build::Lists(Sizing::Counted);
    ABuffer { build, ..ABuffer::default() }.record(graph, &view(depth.size()), depth, &layers, color).color
}

/// Only how far layers are depends on it.
fn view(size: [u32; 2]) -> View {
    Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0, 0.1).view(size)
}

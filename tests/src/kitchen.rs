//! What techniques of transparency make of soups, on the device.

use glam::Vec3;
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executed, Executor, Graph, ImageHandle, ImageShape, RasterPass};
use shadowgraph::scene::{Draw, DrawList, GpuScene, View, light_block};
use shadowgraph::shader::Program;
use shadowgraph::shader::generated::blocks;
use shadowgraph::techniques::shadow::map_sampler;
use shadowgraph::techniques::surface::depth::DepthPrepass;
use shadowgraph::techniques::transparency::OrderIndependent;
use shadowgraph::techniques::transparency::abuffer::{ABuffer, Composited, Node};
use shadowgraph::techniques::transparency::forward::ForwardLights;
use shadowgraph::techniques::transparency::fragments::{self, Blended, Fragments, Step};

use crate::device::shared;
use crate::figures::Picture;
use crate::soup::{BACKGROUND, Random, Soup};

/// What the A-buffer found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Bytes of the picture.
    pub color: Vec<[f32; 4]>,
    /// Layers of each pixel.
    pub count: Vec<f32>,
    /// Distance of the nearest layer.
    pub front: Vec<f32>,
    /// Of each of the nearest layers: colours, distances.
    pub layers: Vec<(Vec<[f32; 4]>, Vec<f32>)>,
    /// Pixels whose nodes are not as many as were counted; pixels with a clamped colour; nodes that are in no list.
    pub report: [u32; 3],
    /// Nodes in all.
    pub nodes: u32,
    /// Most of a pixel.
    pub longest: u32,
    /// Counter of linked lists.
    pub counter: Option<u32>,
    /// Samples that an occlusion query counted.
    pub samples: Option<u64>,
}

/// A soup on the device.
pub struct Kitchen<'g> {
    executor: Executor<'g>,
    gpu: &'g Gpu,
    /// The scene.
    pub scene: GpuScene,
    view: View,
    /// The step in which everything is drawn twice: a mistake that is to be found.
    pub twice: Option<Step>,
    /// Bytes of transient memory of the last run of the A-buffer: the most of a segment.
    pub memory: u64,
}

impl<'g> Kitchen<'g> {
    /// Uploads a soup.
    pub fn new(gpu: &'g Gpu, soup: &Soup) -> Self {
        let scene = soup.scene().upload(gpu).unwrap_or_else(|error| panic!("{}: {error}", soup.name));
        Self { executor: Executor::new(gpu), gpu, scene, view: soup.view(), twice: None, memory: 0 }
    }

    /// Changes the order of the draws.
    pub fn reorder(&mut self, change: impl FnOnce(&mut Vec<Draw>)) {
        let mut draws = self.scene.draws.draws().to_vec();
        change(&mut draws);
        self.scene.draws = DrawList::new(draws, Vec::new());
    }

    /// Draws in any order, the opaque ones first.
    pub fn shuffle(&mut self, random: &mut Random) {
        self.reorder(|draws| {
            random.shuffle(draws);
            draws.sort_by_key(|draw| draw.class);
        });
    }

    /// Runs the A-buffer over it.
    pub fn run(&mut self, abuffer: ABuffer, pull_vertices: bool) -> shadowgraph::Result<Found> {
        let mut graph = Graph::new("soup", self.gpu.caps());
        let (view, twice) = (self.view, self.twice);
        let Composited { color, count, front, layers, report, known, counter, .. } =
            record(&mut graph, (&self.scene, view, abuffer.samples), pull_vertices, |graph, depth, blended, color| {
                abuffer.record(graph, &view, depth, &Twice { blended, step: twice }, color)
            });
        graph.capture("color", &color);
        graph.capture("count", &count);
        graph.capture("front", &front);
        graph.capture("report", &report);
        for (index, layer) in layers.iter().enumerate() {
            graph.capture(format!("layer.{index}"), &layer.color);
            graph.capture(format!("layer.{index}.Z"), &layer.distance);
        }
        let plan = graph.compile(self.gpu).map_err(shadowgraph::Error::from)?;
        let executed = self.executor.execute(&plan, graph)?;
        let heaps = executed.later.iter().map(|segment| segment.plan.statistics.heap_bytes);
        self.memory = heaps.max().unwrap_or(0);
        let (nodes, longest) = known.layers()?;
        Ok(Found {
            color: texels(&executed, "color")?,
            count: texels(&executed, "count")?,
            front: texels(&executed, "front")?,
            layers: (0..layers.len())
                .map(|i| Ok((texels(&executed, &format!("layer.{i}"))?, texels(&executed, &format!("layer.{i}.Z"))?)))
                .collect::<shadowgraph::Result<_>>()?,
            report: texels::<u32>(&executed, "report")?.try_into().unwrap_or([u32::MAX; 3]),
            nodes: nodes as u32,
            longest,
            counter: counter.map(|counter| counter.values().map(|values| values[0])).transpose()?,
            samples: executed.samples("abuffer.samples").ok(),
        })
    }

    /// The nodes that arrays keep of each pixel, in any order.
    pub fn nodes(&mut self, abuffer: ABuffer, pull_vertices: bool) -> shadowgraph::Result<Vec<Vec<Node>>> {
        let mut graph = Graph::new("soup", self.gpu.caps());
        let view = self.view;
        let Composited { count, nodes, .. } =
            record(&mut graph, (&self.scene, view, abuffer.samples), pull_vertices, |graph, depth, blended, color| {
                abuffer.record(graph, &view, depth, blended, color)
            });
        graph.capture("count", &count);
        graph.capture("nodes", nodes.as_ref().unwrap_or_else(|| panic!("{abuffer:?} has no arrays")));
        let plan = graph.compile(self.gpu).map_err(shadowgraph::Error::from)?;
        let executed = self.executor.execute(&plan, graph)?;
        let mut nodes = abuffer.unpack(&texels::<[u32; 4]>(&executed, "nodes")?)?.into_iter();
        let count: Vec<f32> = texels(&executed, "count")?;
        Ok(count.into_iter().map(|count| nodes.by_ref().take(count as usize).collect()).collect())
    }

    /// The picture that a technique makes beside another one, for the pages.
    pub fn side_by_side(&mut self, how: &dyn OrderIndependent, other: &[[f32; 4]], caption: &str) -> Picture {
        let found = self.composite(how, false).unwrap_or_else(|error| panic!("{error}"));
        let [width, height] = self.view.size.map(|side| side as usize);
        let row = |y: usize| found[y * width..][..width].iter().chain(&other[y * width..][..width]);
        let pixels = (0..height).flat_map(row).map(|&[r, g, b, _]| [r, g, b]).collect();
        Picture { size: [2 * width as u32, height as u32], pixels, exposure: 0.9, caption: caption.into() }
    }

    /// Runs any technique over it: the picture.
    pub fn composite(&mut self, how: &dyn OrderIndependent, pull: bool) -> shadowgraph::Result<Vec<[f32; 4]>> {
        let mut graph = Graph::new("soup", self.gpu.caps());
        let view = self.view;
        let color = record(&mut graph, (&self.scene, view, 1), pull, |graph, depth, blended, color| {
            how.composite(graph, &view, depth, blended, color)
        });
        graph.capture("color", &color);
        let plan = graph.compile(self.gpu).map_err(shadowgraph::Error::from)?;
        texels(&self.executor.execute(&plan, graph)?, "color")
    }
}

/// Blended surfaces, drawn twice in one of the steps.
struct Twice<'b, 's, 'f> {
    blended: &'b Blended<'s, 'f>,
    step: Option<Step>,
}

impl<'f> Fragments<'f> for Twice<'_, '_, 'f> {
    fn programs(&self, step: Step) -> Vec<Program> {
        self.blended.programs(step)
    }

    fn bind(&self, pass: &mut RasterPass<'_, 'f>, step: Step) {
        self.blended.bind(pass, step);
    }

    fn draw(&self, step: Step) -> fragments::Draw<'f> {
        let mut draw = self.blended.draw(step);
        let times = if self.step == Some(step) { 2 } else { 1 };
        Box::new(move |recorder| (0..times).try_for_each(|_| draw(recorder)))
    }

    fn tints(&self) -> bool {
        self.blended.tints()
    }

    fn distances(&self) -> [f32; 2] {
        self.blended.distances()
    }
}

/// Opaque depth, the background, and what `composite` makes of the fragments.
fn record<'f, T>(
    graph: &mut Graph<'f>,
    (scene, view, samples): (&'f GpuScene, View, u32),
    pull_vertices: bool,
    composite: impl FnOnce(&mut Graph<'f>, &ImageHandle, &Blended<'_, 'f>, ImageHandle) -> T,
) -> T {
    let lights: blocks::Lights = light_block(&[], &[]);
    let lights = ForwardLights {
        lights: &lights,
        cascades: None,
        spots: None,
        deep: None,
        sampler: map_sampler(),
        environment: Vec3::ZERO,
    };
    let depth = DepthPrepass.record_samples(graph, scene, &view, samples);
    let color = graph.image("color", ImageShape::new_2d(ash::vk::Format::R32G32B32A32_SFLOAT, view.size));
    let color = graph.clear("background", color, ash::vk::ClearColorValue { float32: BACKGROUND });
    let mut blended = Blended::new(graph, scene, view, &lights);
    blended.pull_vertices |= pull_vertices;
    composite(graph, &depth, &blended, color)
}

/// For the pages: what a technique makes of triangles, and beside it the exact picture.
pub fn beside_exact(how: &dyn OrderIndependent, caption: &str) -> Picture {
    let mut kitchen = Kitchen::new(shared(), &Soup::shown());
    let exact = kitchen.composite(&ABuffer::default(), false).unwrap_or_else(|error| panic!("{error}"));
    kitchen.side_by_side(how, &exact, caption)
}

fn texels<T: bytemuck::Pod>(executed: &Executed, name: &str) -> shadowgraph::Result<Vec<T>> {
    executed.capture(name)?.texels()
}

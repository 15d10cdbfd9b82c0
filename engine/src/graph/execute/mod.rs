//! Running a planned frame on a device.

mod capture;
mod histories;
mod queries;
mod resources;
mod run;
mod segments;
mod timer;

use std::time::{Duration, Instant};

use ash::vk;

pub use capture::Capture;
pub(super) use queries::Asked;
pub use queries::{Counts, PassCount};
pub use timer::PassTime;

use self::histories::Histories;
use self::queries::Queries;
use self::resources::{Resources, image_info};
use self::timer::Timer;
use super::builder::{External, Graph};
use super::description::{Description, Origin, PassId, Range, Shape};
use super::pass::{Bound, What, Work};
use super::plan::{Plan, Segment, Usage, Work as Step};
use super::record::{self, Ready};
use crate::gpu::{
    Buffer, BufferInfo, Descriptor, DescriptorArena, Gpu, Heap, Image, Memory, Requirements, SamplerInfo, ViewInfo,
};
use crate::shader::{Binding, BindingKind, Pipelines};
use crate::{Error, Result};

/// Runs frames on a device, and keeps from frame to frame what they can share: pipelines, descriptor pools, memory.
///
/// `Send`; one thread uses it at a time. It keeps its device alive.
pub struct Executor<'g> {
    gpu: &'g Gpu,
    pipelines: Pipelines,
    descriptors: DescriptorArena,
    heaps: Vec<(Requirements, Heap)>,
    histories: Histories,
    serialize: bool,
}

/// A frame that has run.
#[derive(Default)]
pub struct Executed {
    /// Captured contents, in the order they were captured.
    pub captures: Vec<Capture>,
    /// Time of each pass on the device, in the order of the plan; empty where the device has no timestamps.
    pub passes: Vec<PassTime>,
    /// Time from the start of the call to submission, on the host. Over all segments.
    pub recording: Duration,
    /// Time from submission until the device was done. Over all segments.
    pub running: Duration,
    /// What passes asked the device to count.
    pub counts: Vec<PassCount>,
    /// Segments after the first checkpoint, as they were planned.
    pub later: Vec<Segment>,
}

/// What segments of a frame hand on.
struct Frame<'f> {
    /// Of passes that have not run, in recorded order.
    work: std::vec::IntoIter<Work<'f>>,
    memory: Resources,
    arena: Option<Buffer>,
    queries: Vec<Asked>,
    /// How many passes the segments before had.
    first_pass: u32,
}

/// A segment that has run.
struct Ran {
    /// By root.
    captures: Vec<Option<Capture>>,
    passes: Vec<PassTime>,
    counts: Vec<PassCount>,
    recording: Duration,
    running: Duration,
}

impl Executed {
    /// A capture by name.
    ///
    /// # Errors
    /// [`Error::Invalid`] listing what was captured.
    pub fn capture(&self, name: &str) -> Result<&Capture> {
        self.captures.iter().find(|capture| capture.name == name).ok_or_else(|| {
            let known: Vec<_> = self.captures.iter().map(|capture| capture.name.as_str()).collect();
            Error::invalid(format!("capture `{name}`"), format!("was not made; there are {}", known.join(", ")))
        })
    }
}

impl<'g> Executor<'g> {
    /// An executor without anything kept yet.
    pub fn new(gpu: &'g Gpu) -> Self {
        let descriptors = gpu.descriptor_arena("passes");
        Self {
            gpu,
            pipelines: Pipelines::default(),
            descriptors,
            heaps: Vec::new(),
            histories: Histories::default(),
            serialize: false,
        }
    }

    /// An empty frame that knows what the last one left ([`Graph::history_image`]).
    pub fn graph(&self, name: &str) -> Graph<'g> {
        let mut graph = Graph::new(name, self.gpu.caps());
        graph.kept = self.histories.kept.clone();
        graph
    }

    /// Puts a full barrier before every pass: where that changes a picture, a barrier is missing; where it does not, a
    /// shader is wrong.
    pub fn serialize(&mut self, on: bool) {
        self.serialize = on;
    }

    /// Frees a history; the next frame that declares it is its first. Says whether there was one.
    pub fn forget_history(&mut self, key: &str) -> bool {
        self.histories.forget(key)
    }

    /// Runs a frame and waits until the device is done. Histories of a frame that fails begin anew.
    ///
    /// # Errors
    /// [`Error::Missing`] where a shader asks for what the device lacks; [`Error::OutOfMemory`] naming the heap;
    /// [`Error::DeviceLost`] naming the last pass that began; what a pass's closure returns.
    pub fn execute(&mut self, plan: &Plan, graph: Graph) -> Result<Executed> {
        let Graph { description, work, mut external, arena, histories, later, queries, .. } = graph;
        self.histories.take(self.gpu, &histories, &mut external)?;
        let arena = self.arena(&arena.bytes)?;
        let mut frame = Frame { work: work.into_iter(), memory: Resources(external), arena, queries, first_pass: 0 };
        if description.checkpoints.is_empty() {
            let Ran { captures, passes, counts, recording, running } = self.run(&description, plan, &mut frame)?;
            self.histories.keep(histories, plan, &frame.memory.0);
            let captures = captures.into_iter().flatten().collect();
            return Ok(Executed { captures, passes, counts, recording, running, later: Vec::new() });
        }
        self.execute_segments(description, plan, &mut frame, later, histories)
    }

    /// Runs a frame, or a segment of one, and waits until the device is done.
    fn run(&mut self, description: &Description, plan: &Plan, frame: &mut Frame) -> Result<Ran> {
        let start = Instant::now();
        let mut work: Vec<Option<Work>> = frame.work.by_ref().take(description.passes.len()).map(Some).collect();

        // 1. Memory: what the plan placed, what the host reads back.
        self.memory(plan, description, &mut frame.memory)?;
        let (memory, arena) = (&frame.memory, frame.arena.as_ref());
        let captures = self.capture_buffers(description)?;

        // 2. Pipelines and descriptor sets.
        self.descriptors.reset();
        let mut ready = Vec::with_capacity(work.len());
        for step in &plan.steps {
            if let Step::Pass(PassId(pass)) = step.work {
                let name = &description.passes[pass as usize].name;
                if let Some(work) = &work[pass as usize] {
                    ready.push((pass, self.prepare(name, work, memory, arena)?));
                }
            }
        }

        // 3. Commands, in the order of the plan.
        let device = self.gpu.raw();
        let mut commands = self.gpu.commands(&description.name)?;
        let timer = Timer::new(self.gpu, plan.steps.len())?;
        let queries = self.queries(plan, description, frame)?;
        let first_pass = frame.first_pass;
        frame.first_pass += description.passes.len() as u32;
        let mut ready = ready.into_iter();
        let mut names = Vec::with_capacity(plan.steps.len());
        for (index, step) in plan.steps.iter().enumerate() {
            run::batch(&step.barriers, memory).record(device, &commands);
            if self.serialize {
                record::full_barrier(device, &commands);
            }
            timer.mark(device, &commands, 2 * index);
            match step.work {
                Step::Pass(PassId(pass)) => {
                    let name = &description.passes[pass as usize].name;
                    commands.begin_pass(name);
                    if let (Some(work), Some((_, programs))) = (work[pass as usize].take(), ready.next()) {
                        let whole = PassId(first_pass + pass);
                        queries.begin(device, &commands, whole);
                        run::run(device, &commands, work, &programs, memory)?;
                        queries.end(device, &commands, whole);
                    }
                    commands.end_pass();
                    names.push(name.clone());
                }
                Step::ReadBack(root) => {
                    let name = &description.roots[root].name;
                    commands.begin_pass(&format!("read back {name}"));
                    capture::read_back(device, &commands, description, root, memory, captures[root].as_ref());
                    commands.end_pass();
                    names.push(format!("read back {name}"));
                }
            }
            timer.mark(device, &commands, 2 * index + 1);
        }
        run::batch(&plan.finally, memory).record(device, &commands);

        // 4. Run, and wait.
        let recording = start.elapsed();
        let submitted = Instant::now();
        let token = self.gpu.submit(commands)?;
        self.gpu.wait(token)?;
        let running = submitted.elapsed();
        let passes = timer.times(names)?;
        Ok(Ran { captures, passes, counts: queries.counts()?, recording, running })
    }

    /// Queries of the passes that run.
    fn queries(&self, plan: &Plan, description: &Description, frame: &Frame) -> Result<Queries> {
        if frame.queries.is_empty() {
            return Ok(Queries::default());
        }
        Queries::new(self.gpu, &frame.queries, |PassId(pass)| {
            let here = pass.checked_sub(frame.first_pass)?;
            let runs = plan.steps.iter().any(|step| step.work == Step::Pass(PassId(here)));
            runs.then(|| description.passes[here as usize].name.clone())
        })
    }

    /// Makes what is not there yet: transients where the plan placed them, and what is alive over a checkpoint.
    fn memory(&mut self, plan: &Plan, description: &Description, resources: &mut Resources) -> Result<()> {
        let mut heaps = Vec::with_capacity(plan.heaps.len());
        for (index, heap) in plan.heaps.iter().enumerate() {
            let wanted = Requirements { size: heap.size, alignment: heap.alignment, type_bits: heap.type_bits };
            heaps.push(self.heap(index, wanted)?);
        }
        for (index, resource) in description.resources.iter().enumerate() {
            if let (Origin::Kept { .. }, None, Some(usage)) =
                (&resource.origin, &resources.0[index], plan.usages[index])
            {
                resources.0[index] = Some(resources::alone(self.gpu, resource, usage)?);
            }
        }
        for placement in &plan.placements {
            let resource = &description.resources[placement.resource.0 as usize];
            let heap = &heaps[placement.heap];
            let made = match (&resource.shape, plan.usages[placement.resource.0 as usize]) {
                (Shape::Image(shape), Some(Usage::Image(usage))) => {
                    let info = image_info(&resource.name, shape, usage);
                    External::Image(self.gpu.place_image(heap, placement.offset, &info)?)
                }
                (&Shape::Buffer { size }, Some(Usage::Buffer(usage))) => {
                    let info = BufferInfo { name: &resource.name, size, usage, memory: Memory::Device };
                    External::Buffer(self.gpu.place_buffer(heap, placement.offset, &info)?)
                }
                _ => continue,
            };
            resources.0[placement.resource.0 as usize] = Some(made);
        }
        Ok(())
    }

    /// The heap kept for this place where it fits, else a new one.
    fn heap(&mut self, index: usize, wanted: Requirements) -> Result<Heap> {
        let fits = |kept: &Requirements| {
            kept.size >= wanted.size && kept.alignment >= wanted.alignment && kept.type_bits == wanted.type_bits
        };
        if let Some((_, heap)) = self.heaps.get(index).filter(|(kept, _)| fits(kept)) {
            return Ok(heap.clone());
        }
        self.heaps.truncate(index);
        let heap = self.gpu.create_heap(&format!("transients {index}"), wanted, Memory::Device)?;
        self.heaps.push((wanted, heap.clone()));
        Ok(heap)
    }

    fn arena(&self, bytes: &[u8]) -> Result<Option<Buffer>> {
        if bytes.is_empty() {
            return Ok(None);
        }
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::STORAGE_BUFFER;
        let size = bytes.len() as u64;
        let buffer = self.gpu.create_buffer(&BufferInfo { name: "frame data", size, usage, memory: Memory::Upload })?;
        buffer.write(0, bytes)?;
        Ok(Some(buffer))
    }

    /// A host buffer for each root that is read back.
    fn capture_buffers(&self, description: &Description) -> Result<Vec<Option<Capture>>> {
        let capture = |root| Capture::new(self.gpu, description, root);
        description.roots.iter().map(|root| root.read_back.then(|| capture(root)).transpose()).collect()
    }

    /// Pipelines of a pass's programs, each with its set 0.
    fn prepare(&mut self, pass: &str, work: &Work, memory: &Resources, arena: Option<&Buffer>) -> Result<Vec<Ready>> {
        let (pipelines, bound) = match work {
            Work::Compute { shader, constants, bound, .. } => {
                (vec![self.pipelines.compute(self.gpu, shader, constants)?], bound)
            }
            Work::Raster { programs, targets, bound, .. } => {
                let make = |program| self.pipelines.graphics(self.gpu, program, targets);
                (programs.iter().map(make).collect::<Result<Vec<_>>>()?, bound)
            }
            Work::Fill { .. } | Work::Clear { .. } | Work::ClearDepth { .. } | Work::Zero(_) => {
                return Ok(Vec::new());
            }
        };
        let mut ready = Vec::with_capacity(pipelines.len());
        for pipeline in pipelines {
            let mut descriptors = Vec::new();
            for wanted in pipeline.bindings().iter().filter(|wanted| wanted.binding.set == 0) {
                let number = wanted.binding.binding;
                let Some(found) = bound.iter().find(|b| b.binding.binding == number) else { continue };
                descriptors.push((number, self.descriptor(pass, found, &wanted.binding, memory, arena)?));
            }
            let set = match descriptors.is_empty() {
                true => vk::DescriptorSet::null(),
                false => self.descriptors.set(&pipeline, 0, &descriptors)?,
            };
            ready.push(Ready { pipeline, set });
        }
        Ok(ready)
    }

    fn descriptor(
        &self,
        pass: &str,
        bound: &Bound,
        binding: &Binding,
        memory: &Resources,
        arena: Option<&Buffer>,
    ) -> Result<Descriptor> {
        let missing = || Error::invalid(format!("`{}` of pass `{pass}`", binding.name), "has no memory behind it");
        let kind = binding.image.map_or(vk::ImageViewType::TYPE_2D, |image| image.view);
        match &bound.what {
            What::Data(data) => {
                let buffer = arena.ok_or_else(missing)?.clone();
                Ok(Descriptor::Buffer { buffer, offset: data.offset, size: data.size })
            }
            What::Buffer(buffer) => Ok(Descriptor::buffer(buffer)),
            What::Image(image, sampler) => {
                let view = image.whole().kind(kind);
                let layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
                self.image_descriptor(binding, image.clone(), view, layout, sampler)
            }
            What::Resource { resource, range, layout, sampler } => {
                match (memory.0[resource.0 as usize].as_ref().ok_or_else(missing)?, *range) {
                    (External::Image(image), Range::Image { aspects, mips, layers }) => {
                        // A sampled depth-stencil image shows its depth.
                        let depth = vk::ImageAspectFlags::DEPTH;
                        let aspects = if aspects.contains(depth) { depth } else { aspects };
                        let view = ViewInfo { kind, mips, layers, aspects, ..image.whole() };
                        self.image_descriptor(binding, image.clone(), view, *layout, sampler)
                    }
                    (External::Buffer(buffer), Range::Buffer([first, end])) => {
                        // A size that a checkpoint told may be less than the description's.
                        let size = end.min(buffer.size()).saturating_sub(first);
                        Ok(Descriptor::Buffer { buffer: buffer.clone(), offset: first, size })
                    }
                    _ => Err(missing()),
                }
            }
        }
    }

    fn image_descriptor(
        &self,
        binding: &Binding,
        image: Image,
        view: ViewInfo,
        layout: vk::ImageLayout,
        sampler: &SamplerInfo,
    ) -> Result<Descriptor> {
        Ok(match binding.kind {
            BindingKind::CombinedImageSampler => {
                Descriptor::Sampled { image, view, layout, sampler: self.gpu.sampler(sampler)? }
            }
            _ => Descriptor::Image { image, view, layout },
        })
    }
}

//! Running a planned frame on a device.

mod capture;
mod histories;
mod queries;
mod resources;
mod run;
mod segments;
mod timer;
mod transients;

use std::time::{Duration, Instant};

use ash::vk;

pub use capture::Capture;
pub(super) use queries::Asked;
pub use queries::{Counts, PassCount};
pub use timer::PassTime;

use self::histories::Histories;
use self::queries::Queries;
use self::resources::Resources;
use self::timer::Timer;
use self::transients::Transients;
use super::builder::{External, Graph};
use super::description::{Description, PassId, Range};
use super::pass::{Bound, What, Work};
use super::plan::{Plan, Segment, Work as Step};
use super::record::{self, Batch, BoundCompute, Ready};
use crate::gpu::{
    Buffer, BufferInfo, Descriptor, DescriptorArena, Gpu, Image, Memory, Pipeline, SamplerInfo, ViewInfo,
};
use crate::shader::{Binding, BindingKind, Pipelines, Wanted};
use crate::{Error, Result};

/// Runs frames on a device, and keeps from frame to frame what they can share: pipelines, descriptor pools, memory.
///
/// `Send`; one thread uses it at a time. It keeps its device alive.
pub struct Executor<'g> {
    gpu: &'g Gpu,
    pipelines: Pipelines,
    /// Not in use by a frame: one that fails takes it away.
    descriptors: Option<DescriptorArena>,
    transients: Transients,
    histories: Histories,
    serialize: bool,
    instruments: bool,
}

/// A frame made ready to be run any number of times: see [`Executor::prepare`].
///
/// Frames of one executor share memory: none keeps anything from run to run but what it imports.
pub struct Prepared<'f> {
    description: Description,
    steps: Vec<ReadyStep<'f>>,
    finally: Batch,
    memory: Resources,
    descriptors: DescriptorArena,
    timer: Timer,
    queries: Queries,
    /// Number of its first pass in the whole frame.
    first_pass: u32,
    /// Descriptor sets point into it.
    _arena: Option<Buffer>,
}

/// One step with all that recording needs.
struct ReadyStep<'f> {
    barriers: Batch,
    task: Task<'f>,
}

// Nearly all are passes: a box would only add a way to go.
#[allow(clippy::large_enum_variant)]
enum Task<'f> {
    Pass { pass: u32, work: Work<'f>, programs: Vec<Ready> },
    ReadBack(usize),
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

impl From<Ran> for Executed {
    /// Of a frame of one segment.
    fn from(ran: Ran) -> Self {
        let Ran { captures, passes, counts, recording, running } = ran;
        let captures = captures.into_iter().flatten().collect();
        Self { captures, passes, counts, recording, running, later: Vec::new() }
    }
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
        Self {
            gpu,
            pipelines: Pipelines::default(),
            descriptors: None,
            transients: Transients::default(),
            histories: Histories::default(),
            serialize: false,
            instruments: true,
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

    /// Whether passes get timestamps, debug labels, and the marks that name the last one should the device be lost, and
    /// each transient an object and a debug name of its own. On at the start; off, frames of many small passes are made
    /// ready and recorded faster.
    pub fn instruments(&mut self, on: bool) {
        self.instruments = on;
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
            let ran = self.run_once(description, plan, &mut frame)?;
            self.histories.keep(histories, plan, &frame.memory.0);
            return Ok(ran.into());
        }
        self.execute_segments(description, plan, &mut frame, later, histories)
    }

    /// Makes a frame ready to be run any number of times: pipelines, descriptor sets, memory and barriers are there
    /// once, and [`Executor::run`] records. What changes from run to run comes from [`super::ComputePass::push_with`],
    /// from the closures of raster passes, and from buffers and images that the frame imports.
    ///
    /// # Errors
    /// As [`Executor::execute`]; [`Error::Invalid`] where the frame has histories or checkpoints: what follows from the
    /// last frame, or from what the host reads, is not known before.
    pub fn prepare<'f>(&mut self, plan: &Plan, graph: Graph<'f>) -> Result<Prepared<'f>> {
        let Graph { description, work, external, arena, histories, queries, .. } = graph;
        if !histories.is_empty() || !description.checkpoints.is_empty() {
            let why = "has histories or checkpoints, which change from run to run; execute it anew each time";
            return Err(Error::invalid(format!("graph `{}`", description.name), why));
        }
        let arena = self.arena(&arena.bytes)?;
        let mut frame = Frame { work: work.into_iter(), memory: Resources(external), arena, queries, first_pass: 0 };
        let descriptors = self.gpu.descriptor_arena(&description.name);
        self.ready(description, plan, &mut frame, descriptors)
    }

    /// Records a frame that was prepared, runs it, and waits until the device is done.
    ///
    /// # Errors
    /// As [`Executor::execute`].
    pub fn run(&mut self, prepared: &mut Prepared) -> Result<Executed> {
        Ok(self.record_and_wait(prepared)?.into())
    }

    /// Runs a frame, or a segment of one, once.
    fn run_once(&mut self, description: Description, plan: &Plan, frame: &mut Frame) -> Result<Ran> {
        let start = Instant::now();
        let mut descriptors = self.descriptors.take().unwrap_or_else(|| self.gpu.descriptor_arena("passes"));
        descriptors.reset();
        let mut prepared = self.ready(description, plan, frame, descriptors)?;
        let readying = start.elapsed();
        let ran = self.record_and_wait(&mut prepared)?;
        (self.descriptors, frame.memory) = (Some(prepared.descriptors), prepared.memory);
        Ok(Ran { recording: ran.recording + readying, ..ran })
    }

    /// Everything but recording.
    fn ready<'f>(
        &mut self,
        description: Description,
        plan: &Plan,
        frame: &mut Frame<'f>,
        mut descriptors: DescriptorArena,
    ) -> Result<Prepared<'f>> {
        let mut work: Vec<Option<Work>> = frame.work.by_ref().take(description.passes.len()).map(Some).collect();

        // 1. Memory that the plan placed.
        self.transients.make(self.gpu, plan, &description, self.instruments, &mut frame.memory)?;
        let (memory, arena) = (std::mem::take(&mut frame.memory), frame.arena.as_ref());

        // 2. Pipelines, in the order of the plan.
        let planned = plan.steps.iter().filter_map(|step| match step.work {
            Step::Pass(PassId(pass)) => work[pass as usize].as_ref(),
            Step::ReadBack(_) => None,
        });
        let wanted: Vec<Wanted> = planned.flat_map(Work::pipelines).collect();
        let mut pipelines = self.pipelines.all(self.gpu, &wanted)?.into_iter();

        // 3. Descriptor sets and barriers.
        let mut steps = Vec::with_capacity(plan.steps.len());
        for step in &plan.steps {
            let task = match step.work {
                Step::Pass(PassId(pass)) => {
                    let Some(work) = work[pass as usize].take() else { continue };
                    let name = &description.passes[pass as usize].name;
                    let programs = self.prepare_pass(name, &work, &mut pipelines, &memory, arena, &mut descriptors)?;
                    Task::Pass { pass, work, programs }
                }
                Step::ReadBack(root) => Task::ReadBack(root),
            };
            steps.push(ReadyStep { barriers: run::batch(&step.barriers, &memory), task });
        }
        let timer = if self.instruments { Timer::new(self.gpu, steps.len())? } else { Timer::default() };
        let queries = self.queries(plan, &description, frame)?;
        let first_pass = frame.first_pass;
        frame.first_pass += description.passes.len() as u32;
        let finally = run::batch(&plan.finally, &memory);
        let arena = frame.arena.clone();
        Ok(Prepared { description, steps, finally, memory, descriptors, timer, queries, first_pass, _arena: arena })
    }

    fn record_and_wait(&mut self, prepared: &mut Prepared) -> Result<Ran> {
        // 1. Host buffers for what is read back; queries begin anew.
        let start = Instant::now();
        let Prepared { description, steps, finally, memory, timer, queries, first_pass, .. } = prepared;
        let captures = self.capture_buffers(description)?;
        timer.reset();
        queries.reset();

        // 2. Commands.
        let device = self.gpu.raw();
        let mut commands = self.gpu.commands(&description.name)?;
        let mut bound = BoundCompute::default();
        for (index, step) in steps.iter_mut().enumerate() {
            step.barriers.record(device, &commands);
            if self.serialize {
                record::full_barrier(device, &commands);
            }
            timer.mark(device, &commands, 2 * index);
            match &mut step.task {
                Task::Pass { pass, work, programs } => {
                    if self.instruments {
                        commands.begin_pass(&description.passes[*pass as usize].name);
                    }
                    let whole = PassId(*first_pass + *pass);
                    queries.begin(device, &commands, whole);
                    run::run(device, &commands, work, (programs, &mut bound), memory)?;
                    queries.end(device, &commands, whole);
                }
                Task::ReadBack(root) => {
                    if self.instruments {
                        commands.begin_pass(&format!("read back {}", description.roots[*root].name));
                    }
                    capture::read_back(device, &commands, description, *root, memory, captures[*root].as_ref());
                }
            }
            if self.instruments {
                commands.end_pass();
            }
            timer.mark(device, &commands, 2 * index + 1);
        }
        finally.record(device, &commands);

        // 3. Run, and wait.
        let recording = start.elapsed();
        let submitted = Instant::now();
        let token = self.gpu.submit(commands)?;
        captures.iter().flatten().for_each(Capture::prefault);
        self.gpu.wait(token)?;
        let running = submitted.elapsed();
        let name = |step: &ReadyStep| match step.task {
            Task::Pass { pass, .. } => description.passes[pass as usize].name.clone(),
            Task::ReadBack(root) => format!("read back {}", description.roots[root].name),
        };
        let passes = timer.times(|index| steps.get(index).map(name).unwrap_or_default())?;
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

    /// The next pipelines, a pass's, each with its set 0.
    fn prepare_pass(
        &self,
        pass: &str,
        work: &Work,
        pipelines: &mut impl Iterator<Item = Pipeline>,
        memory: &Resources,
        arena: Option<&Buffer>,
        sets: &mut DescriptorArena,
    ) -> Result<Vec<Ready>> {
        let (count, bound) = match work {
            Work::Compute { bound, .. } => (1, bound),
            Work::Raster { programs, bound, .. } => (programs.len(), bound),
            Work::Fill { .. } | Work::Clear { .. } | Work::ClearDepth { .. } | Work::Zero(_) => {
                return Ok(Vec::new());
            }
        };
        let mut ready = Vec::with_capacity(count);
        for pipeline in pipelines.take(count) {
            let mut descriptors = Vec::new();
            for wanted in pipeline.bindings().iter().filter(|wanted| wanted.binding.set == 0) {
                let number = wanted.binding.binding;
                let Some(found) = bound.iter().find(|b| b.binding.binding == number) else { continue };
                descriptors.push((number, self.descriptor(pass, found, &wanted.binding, memory, arena)?));
            }
            let set = match descriptors.is_empty() {
                true => vk::DescriptorSet::null(),
                false => sets.set(&pipeline, 0, &descriptors)?,
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

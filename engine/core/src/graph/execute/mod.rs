//! Running a planned frame on a device.

mod capture;
mod histories;
mod plans;
mod queries;
mod ready;
mod resources;
mod run;
mod segments;
mod sets;
mod timer;
mod transients;

use std::sync::Arc;
use std::time::{Duration, Instant};

use ash::vk;

pub use capture::Capture;
pub(super) use queries::Asked;
pub use queries::{Counts, PassCount};
pub use ready::Prepared;
pub use timer::PassTime;

use self::capture::HostBuffers;
use self::histories::{Histories, Turns};
use self::plans::Plans;
use self::ready::{Phase, Task};
use self::resources::Resources;
use self::transients::Transients;
use super::builder::Graph;
use super::description::{Description, PassId, VersionId};
use super::pass::{Bound, Work};
use super::plan::{Plan, Segment};
use super::record::{self, BoundCompute};
use crate::gpu::{Buffer, BufferInfo, DescriptorCache, Gpu, Memory};
use crate::shader::Pipelines;
use crate::{Error, Result};

/// Runs frames on a device, and keeps from frame to frame what they can share: pipelines, descriptor pools, memory.
///
/// `Send`; one thread uses it at a time. It keeps its device alive.
pub struct Executor<'g> {
    gpu: &'g Gpu,
    pipelines: Pipelines,
    /// Not in use by a frame: one that fails takes it away.
    descriptors: Option<DescriptorCache>,
    /// What the host gave the last frame's shaders: the next one's bytes go there, and sets that point at it stay.
    arena: Option<Buffer>,
    transients: Transients,
    host_buffers: HostBuffers,
    histories: Histories,
    plans: Plans,
    serialize: bool,
    instruments: bool,
}

/// A frame that has run.
#[derive(Default)]
pub struct Executed {
    /// Captured contents, in the order they were captured.
    pub captures: Vec<Capture>,
    /// Time of each pass on the device, the barriers before it included, in the order of the plan; empty where the device
    /// has no timestamps.
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
    /// Behind the bindings of all passes.
    bound: Arc<Vec<Bound>>,
    memory: Resources,
    arena: Option<Buffer>,
    queries: Vec<Asked>,
    /// How many passes the segments before had.
    first_pass: u32,
    /// By pass of the whole frame, whether it runs. Nothing for a frame of one segment.
    live: Vec<bool>,
    /// What the host reads at checkpoints.
    awaited: Vec<VersionId>,
}

impl<'f> Frame<'f> {
    /// Before its first segment.
    fn new(
        (work, bound): (Vec<Work<'f>>, Vec<Bound>),
        memory: Resources,
        arena: Option<Buffer>,
        queries: Vec<Asked>,
    ) -> Self {
        let (work, bound) = (work.into_iter(), Arc::new(bound));
        Self { work, bound, memory, arena, queries, first_pass: 0, live: Vec::new(), awaited: Vec::new() }
    }
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
            arena: None,
            transients: Transients::default(),
            host_buffers: HostBuffers::default(),
            histories: Histories::default(),
            plans: Plans::default(),
            serialize: false,
            instruments: true,
        }
    }

    /// An empty frame that knows what the last one left ([`Graph::history_image`]).
    pub fn graph(&self, name: &str) -> Graph<'g> {
        let mut graph = Graph::new("", self.gpu.caps());
        self.plans.begin(&mut graph, name);
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
    /// [`Error::DeviceLost`] naming the last pass that began; what a pass's closure returns; [`Error::Invalid`] for the
    /// plan of another graph, and for imports that were not made for what passes do to them.
    pub fn execute(&mut self, plan: &Plan, graph: Graph) -> Result<Executed> {
        self.execute_with(plan, graph, &mut |_| {})
    }

    /// As [`Executor::execute`]. `left` sees what each segment of the frame but the last has left, as soon as the host has it:
    /// the next one waits until it returns, and runs while threads that it starts go on.
    ///
    /// # Errors
    /// As [`Executor::execute`].
    pub fn execute_with(&mut self, plan: &Plan, graph: Graph, left: &mut dyn FnMut(&[Capture])) -> Result<Executed> {
        check(self.gpu, plan, &graph)?;
        self.transients.begin_frame();
        self.descriptors.iter_mut().for_each(DescriptorCache::begin_frame);
        let Graph { description, work, bound, mut external, arena, histories, later, queries, .. } = graph;
        self.histories.take(self.gpu, &histories, &mut external)?;
        let arena = self.arena_of_this_frame(&arena.bytes)?;
        let mut frame = Frame::new((work, bound), Resources(external), arena, queries);
        if description.checkpoints.is_empty() {
            let (ran, description) = self.run_once(description, plan, &mut frame)?;
            self.histories.keep(histories, plan, &frame.memory.0);
            self.plans.executed(plan, description, frame.bound.len());
            self.arena = frame.arena;
            return Ok(ran.into());
        }
        let executed = self.execute_segments(description, plan, &mut frame, (later, histories), left)?;
        self.arena = frame.arena;
        Ok(executed)
    }

    /// Makes a frame ready to be run any number of times: pipelines, descriptor sets, memory and barriers are there
    /// once, and [`Executor::run`] records. What changes from run to run comes from [`super::ComputePass::push_with`],
    /// from the closures of raster passes, and from buffers and images that the frame imports.
    ///
    /// Histories go on from run to run: the two resources of each take turns, with descriptor sets and barriers for both.
    /// A frame like it has to run by [`Executor::execute`] first, mostly once: then the history has begun, and is found
    /// as each run leaves it.
    ///
    /// # Errors
    /// As [`Executor::execute`]; [`Error::Invalid`] where the frame has checkpoints: sizes follow from what the host
    /// reads there, and from sizes the memory, its barriers and the descriptor sets; where it is the first one of a
    /// history, or would leave one in another state than it finds it in; or where it leaves an imported image in
    /// another layout than it arrives in, for each run finds it as the last one left it.
    pub fn prepare<'f>(&mut self, plan: &Plan, graph: Graph<'f>) -> Result<Prepared<'f>> {
        check(self.gpu, plan, &graph)?;
        self.transients.begin_frame();
        let Graph { description, work, bound, mut external, arena, histories, queries, .. } = graph;
        if !description.checkpoints.is_empty() {
            let why = "has checkpoints: sizes follow from what the host reads; execute it anew each time";
            return Err(Error::invalid(format!("graph `{}`", description.name), why));
        }
        resources::check_turns(plan, &description)?;
        let turns = self.histories.share(histories, plan, &mut external)?;
        let arena = self.arena(&arena.bytes)?;
        let mut frame = Frame::new((work, bound), Resources(external), arena, queries);
        let descriptors = self.gpu.descriptor_cache(&description.name);
        self.ready(description, plan, &mut frame, (descriptors, turns))
    }

    /// Records a frame that was prepared, runs it, and waits until the device is done. Histories of a run that fails
    /// begin anew.
    ///
    /// # Errors
    /// As [`Executor::execute`]; [`Error::Invalid`] for a frame of another device, and where another frame has gone on with
    /// one of its histories, or it was forgotten.
    pub fn run(&mut self, prepared: &mut Prepared) -> Result<Executed> {
        if !prepared.descriptors.is_from(self.gpu) {
            let why = "was prepared for another device; prepare it by the executor that runs it";
            return Err(Error::invalid(format!("graph `{}`", prepared.description.name), why));
        }
        let phase = self.histories.phase(&prepared.turns)?;
        let ran = self.record_and_wait(prepared, phase, []);
        self.histories.turn(&mut prepared.turns, ran.is_ok());
        Ok(ran?.into())
    }

    /// Runs a frame, or a segment of one, once; gives the description back.
    fn run_once(&mut self, description: Description, plan: &Plan, frame: &mut Frame) -> Result<(Ran, Description)> {
        let start = Instant::now();
        let descriptors = self.descriptors.take().unwrap_or_else(|| self.gpu.descriptor_cache("passes"));
        let mut prepared = self.ready(description, plan, frame, (descriptors, Turns::default()))?;
        let readying = start.elapsed();
        let later = frame.work.as_slice().iter().zip(frame.live.iter().skip(frame.first_pass as usize));
        let later = later.filter(|(work, live)| **live && !work.waits_for(&frame.awaited)).map(|(work, _)| work);
        let ran = self.record_and_wait(&mut prepared, 0, later)?;
        let memory = prepared.phases.pop().map(|phase| phase.memory).unwrap_or_default();
        (self.descriptors, frame.memory) = (Some(prepared.descriptors), memory);
        Ok((Ran { recording: ran.recording + readying, ..ran }, prepared.description))
    }

    /// `later`: what segments after this one do, whatever the host reads. Their pipelines are made while the device is busy.
    fn record_and_wait<'w, 'f: 'w>(
        &mut self,
        prepared: &mut Prepared,
        phase: usize,
        later: impl IntoIterator<Item = &'w Work<'f>>,
    ) -> Result<Ran> {
        // 1. Host buffers for what is read back; queries begin anew.
        let start = Instant::now();
        let Prepared { description, steps, work, phases, timer, queries, first_pass, .. } = prepared;
        let Phase { barriers, programs, memory } = &phases[phase];
        let captures = self.capture_buffers(description)?;
        timer.reset();
        queries.reset();

        // 2. Commands.
        let device = self.gpu.raw();
        let mut commands = self.gpu.commands(&description.name)?;
        let (mut bound, mut asked) = (BoundCompute::default(), Vec::new());
        for (index, step) in steps.iter().enumerate() {
            timer.mark(device, &commands, index);
            barriers.record(device, &commands, index);
            if self.serialize {
                record::full_barrier(device, &commands);
            }
            match step {
                Task::Pass { pass, programs: mine } => {
                    if self.instruments {
                        commands.begin_pass(&description.passes[*pass as usize].name);
                    }
                    let whole = PassId(*first_pass + *pass);
                    queries.begin(device, &commands, whole);
                    let programs = &programs[mine.clone()];
                    let work = &mut work[*pass as usize];
                    run::run(device, &commands, work, (programs, &mut bound), memory, &mut asked)?;
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
        }
        timer.mark(device, &commands, steps.len());
        barriers.record(device, &commands, steps.len());

        // 3. Run, and wait.
        let recording = start.elapsed();
        let submitted = Instant::now();
        let token = self.gpu.submit(commands)?;
        let mut wanted = Vec::new();
        later.into_iter().for_each(|work| work.pipelines(&mut wanted));
        let made = self.pipelines.all(self.gpu, &wanted);
        // What is read back is written last.
        captures.iter().flatten().for_each(Capture::populate);
        self.gpu.wait(token)?;
        made?;
        let running = submitted.elapsed();
        let name = |step: &Task| match step {
            Task::Pass { pass, .. } => description.passes[*pass as usize].name.to_string(),
            Task::ReadBack(root) => format!("read back {}", description.roots[*root].name),
        };
        let passes = timer.times(|index| steps.get(index).map(name).unwrap_or_default())?;
        Ok(Ran { captures, passes, counts: queries.counts()?, recording, running })
    }

    /// The last frame's buffer where the bytes fit, else a new one.
    fn arena_of_this_frame(&mut self, bytes: &[u8]) -> Result<Option<Buffer>> {
        match self.arena.take().filter(|buffer| !bytes.is_empty() && buffer.size() >= bytes.len() as u64) {
            Some(buffer) => {
                buffer.write(0, bytes)?;
                Ok(Some(buffer))
            }
            None => self.arena(bytes),
        }
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
    fn capture_buffers(&mut self, description: &Description) -> Result<Vec<Option<Capture>>> {
        self.host_buffers.begin();
        let mut capture = |root| Capture::new(self.gpu, &mut self.host_buffers, description, root);
        description.roots.iter().map(|root| root.read_back.then(|| capture(root)).transpose()).collect()
    }
}

/// Whether a plan can be executed for a graph.
fn check(gpu: &Gpu, plan: &Plan, graph: &Graph) -> Result<()> {
    if plan.fingerprint != graph.fingerprint() {
        let why = "was compiled from another graph: compile the one that is executed, after its last pass is recorded";
        return Err(Error::invalid(format!("the plan for graph `{}`", graph.description.name), why));
    }
    resources::check_imports(gpu, plan, graph)
}

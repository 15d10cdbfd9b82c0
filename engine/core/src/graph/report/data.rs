//! A plan with all of its names, to be serialised.

use serde::Serialize;

use super::path::DependencyReport;
use super::resource::ResourceReport;
use crate::graph::plan::Statistics;

/// Name of the form of [`Report`], with its version.
pub const SCHEMA: &str = "shadowgraph.graph/1.3";

/// A description and its plan.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// Name of the graph.
    pub graph: String,
    /// Passes and read-backs that run, in order.
    pub steps: Vec<StepReport>,
    /// Submissions, in order.
    pub batches: Vec<BatchReport>,
    /// The longest chain of steps that wait for one another's results, by index into `steps`.
    pub critical_path: Vec<usize>,
    /// Barriers after the last step.
    pub finally: Vec<BarrierReport>,
    /// Passes that do not run.
    pub culled: Vec<CulledReport>,
    /// Resources that a step uses.
    pub resources: Vec<ResourceReport>,
    /// Memory of transients.
    pub memory: MemoryReport,
    /// Figures.
    pub statistics: Statistics,
    /// Of a segment that follows another one: the checkpoint before it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
    /// Segments after the frame's first checkpoint, where it ran: their sizes follow from what the host read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub later: Vec<Report>,
}

/// A pass or a read-back.
#[derive(Clone, Debug, Serialize)]
pub struct StepReport {
    /// Name of the pass, or of the root.
    pub name: String,
    /// `pass` or `read-back`.
    pub kind: &'static str,
    /// Queue it runs on.
    pub queue: String,
    /// Index of its submission.
    pub batch: usize,
    /// Barriers before it.
    pub barriers: Vec<BarrierReport>,
    /// What it reads.
    pub reads: Vec<UseReport>,
    /// What it writes.
    pub writes: Vec<UseReport>,
    /// Earlier steps whose results it uses.
    pub depends: Vec<DependencyReport>,
    /// Why it runs although nobody reads what it writes.
    pub side_effect: Option<String>,
    /// Time on the device, where the frame ran and the device tells.
    pub milliseconds: Option<f64>,
}

/// A submission.
#[derive(Clone, Debug, Serialize)]
pub struct BatchReport {
    /// Queue it is submitted to.
    pub queue: String,
    /// Value that its queue's timeline semaphore is set to when it is done.
    pub signal: u64,
    /// What it waits for.
    pub waits: Vec<WaitReport>,
    /// Barriers after its steps: resources given to other queues' families.
    pub release: Vec<BarrierReport>,
}

/// A wait for another queue's timeline semaphore.
#[derive(Clone, Debug, Serialize)]
pub struct WaitReport {
    /// The other queue.
    pub queue: String,
    /// Value waited for.
    pub value: u64,
    /// Pipeline stages that wait.
    pub stages: String,
}

/// A use of a resource.
#[derive(Clone, Debug, Serialize)]
pub struct UseReport {
    /// What the pass calls it.
    pub slot: String,
    /// Name of the resource.
    pub resource: String,
    /// Which part of it, in words; empty where it is all.
    pub part: String,
    /// Version that is read, or written over.
    pub version: u32,
    /// Version that is made.
    pub makes: Option<u32>,
    /// Pipeline stages.
    pub stages: String,
    /// Memory accesses.
    pub access: String,
    /// Image layout.
    pub layout: Option<String>,
}

/// A barrier.
#[derive(Clone, Debug, Serialize)]
pub struct BarrierReport {
    /// `image`, `buffer` or `memory`.
    pub kind: &'static str,
    /// Name of the resource.
    pub resource: Option<String>,
    /// Which part of it, in words; empty where it is all.
    pub part: String,
    /// First stages and accesses.
    pub from: [String; 2],
    /// Second stages and accesses.
    pub to: [String; 2],
    /// Layouts before and after, of an image.
    pub layouts: Option<[String; 2]>,
    /// Queue families that it is handed over from and to.
    pub families: Option<[u32; 2]>,
    /// Why it stands.
    pub reason: String,
}

/// A pass that does not run.
#[derive(Clone, Debug, Serialize)]
pub struct CulledReport {
    /// Name of the pass.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// Memory of transients.
#[derive(Clone, Debug, Serialize)]
pub struct MemoryReport {
    /// Heaps.
    pub heaps: Vec<HeapReport>,
    /// Bytes of all heaps.
    pub bytes: u64,
    /// Bytes if no two transients shared memory.
    pub unaliased_bytes: u64,
    /// Bytes that sharing saves.
    pub saved_bytes: u64,
    /// The most bytes alive at once in this order.
    pub lower_bound_bytes: u64,
    /// Heaps over lower bound; 1 is perfect.
    pub over_lower_bound: f64,
    /// Share of the bytes without sharing that sharing saves.
    pub saved_share: f64,
    /// Why resources do not share memory, two by two, of the largest of each heap.
    pub apart: Vec<ApartReport>,
}

/// Why two resources do not share memory.
#[derive(Clone, Debug, Serialize)]
pub struct ApartReport {
    /// Names of both.
    pub resources: [String; 2],
    /// Why.
    pub reason: String,
}

/// A heap and who lies in it.
#[derive(Clone, Debug, Serialize)]
pub struct HeapReport {
    /// Bytes.
    pub bytes: u64,
    /// Memory types that will do.
    pub type_bits: u32,
    /// By offset, then by time.
    pub placements: Vec<PlacementReport>,
}

/// Where a transient lies.
#[derive(Clone, Debug, Serialize)]
pub struct PlacementReport {
    /// Name of the resource.
    pub resource: String,
    /// Bytes from the heap's start.
    pub offset: u64,
    /// Bytes.
    pub bytes: u64,
    /// First and last step that use it.
    pub steps: [usize; 2],
}

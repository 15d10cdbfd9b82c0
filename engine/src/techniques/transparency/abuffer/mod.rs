//! A-buffer: every fragment of blended surfaces is kept, sorted by depth in its pixel, and composited exactly.
//!
//! Sources: Carpenter 1984, "The A-buffer, an antialiased hidden surface method"; Yang, Hensley, Grün and Thibieroz
//! 2010, "Real-time concurrent linked list construction on the GPU" (lists); Maule, Comba, Torchelsen and Bastos 2014,
//! "Memory-optimized order-independent transparency with dynamic fragment buffer" (counting, prefix sum, arrays).

mod arrays;
mod bands;
mod lists;
mod nearest;
mod node;
mod resolve;
mod samples;
mod scan;
mod sorted;
mod told;

use ash::vk;

pub use nearest::NearestLayer;
pub use node::{COMPACT_TRIANGLES, Node, NodeFormat};
pub use resolve::{IN_PLACE_MOST, MOST_LAYERS};
pub use samples::sample_counts;
pub use sorted::{MOST_SORTED, SortedLists};

use self::node::TEXEL;
use self::resolve::SHORT;
use self::scan::Scanned;
use crate::Result;
use crate::graph::{BufferHandle, Checkpoint, ComputePass, Data, Graph, ImageHandle};
use crate::scene::View;
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::abuffer::sort_comp;
use crate::techniques::transparency::OrderIndependent;
use crate::techniques::transparency::fragments::{Fragments, Step};

const NAME: &str = "abuffer";

/// Of images of nodes, and of what is beside them.
const NODES: vk::Format = vk::Format::R32G32B32A32_UINT;
const BESIDE: vk::Format = vk::Format::R32_UINT;

/// A-buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ABuffer {
    /// How fragments come to their pixels.
    pub build: Build,
    /// How nodes are stored.
    pub format: NodeFormat,
    /// Colours are stored as multiples of two to this power: it moves the range that the format can hold. From -64 to
    /// 64.
    pub exponent: i32,
    /// Most bytes that nodes and the images that long lists are sorted in may take at once. The device's largest
    /// allocation is a limit anyway.
    pub memory: u64,
    /// Bands of rows that arrays may be built in, one after the other, where the whole picture does not fit into `memory`.
    /// Each is some twenty passes, which do nothing where it is not needed. With 1 the picture is built at once.
    pub bands: u32,
    /// How many of the nearest layers of each pixel are images of their own ([`Composited::layers`]), each a pass over
    /// all nodes.
    pub layers: u32,
    /// How pixels of more than 16 layers are sorted.
    pub long_sort: LongSort,
    /// Samples a pixel, 1, 2, 4 or 8, of which the opaque depth has as many: edges of layers are anti-aliased, and so is
    /// what they hide behind. A fragment is shaded once a pixel and kept with the samples that it is seen at. Needs
    /// [`crate::gpu::Feature::PostDepthCoverage`].
    pub samples: u32,
}

impl Default for ABuffer {
    /// Counted arrays of compact nodes, as many as the device has room for.
    fn default() -> Self {
        Self {
            build: Build::default(),
            format: NodeFormat::default(),
            exponent: 0,
            memory: u64::MAX,
            bands: 1,
            layers: 0,
            long_sort: LongSort::default(),
            samples: 1,
        }
    }
}

/// How fragments come to their pixels. The picture is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Build {
    /// A pass counts, prefix sums place an array for each pixel, a second pass fills them.
    #[default]
    Arrays,
    /// Linked lists, nodes allocated by one counter: the reference that the arrays are measured against.
    Lists(Sizing),
    /// The same, with one addition to the counter for all fragments of a subgroup, where pixels have one sample. Needs
    /// [`crate::gpu::Feature::FragmentBallot`].
    SubgroupLists(Sizing),
}

/// How pixels of more layers than fit into registers are sorted. The picture is the same. In place, an invocation sorts a
/// pixel of up to [`IN_PLACE_MOST`] layers in memory; more are sorted in blocks anyway.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LongSort {
    /// Blocks of 16 in registers by a network, an invocation a block, then merged two to one (after Knowles, Leach and
    /// Zambetta 2014, "Fast sorting for exact OIT of complex scenes").
    #[default]
    Blocks,
    /// In place, by Shell's method.
    Shell,
    /// In place, by a heap.
    Heap,
    /// In place, by Batcher's bitonic network.
    Bitonic,
}

impl LongSort {
    /// As `totals.glsl` has it.
    fn number(self) -> u32 {
        match self {
            Self::Blocks => 0,
            Self::Shell => 1,
            Self::Heap => 2,
            Self::Bitonic => 3,
        }
    }
}

/// How many nodes linked lists have room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sizing {
    /// As many as a precise occlusion query counts before. Needs `occlusionQueryPrecise`. Of several samples a pixel a query
    /// counts each, so the lists' counter counts instead, in a pass that keeps nothing.
    Counted,
    /// So many: mostly of [`Sizing::after`]. Where that is too few, the lists are built again in the same frame, with as many
    /// as there are.
    Guessed(u32),
}

impl Sizing {
    /// What the last frame's [`Composited::counter`] told, and an eighth more.
    pub fn after(counted: u32) -> Self {
        Self::Guessed(counted.saturating_add(counted / 8))
    }
}

/// What an A-buffer gives.
pub struct Composited {
    /// The colour, with all layers over it.
    pub color: ImageHandle,
    /// Layers of each pixel, R32 float.
    pub count: ImageHandle,
    /// Distance of the nearest layer along the view axis, metres, R32 float; infinite where there is none.
    pub front: ImageHandle,
    /// The nearest layers, as many as [`ABuffer::layers`] asks for.
    pub layers: Vec<NearestLayer>,
    /// Nodes of [`Build::Arrays`], R32G32B32A32 uint texels row by row, for [`ABuffer::unpack`]: those of the first pixel,
    /// then those of the next in its row, each pixel's in any order. `None` where there may be several bands, or nodes are
    /// [`NodeFormat::HalfTinted`].
    pub nodes: Option<ImageHandle>,
    /// One [`blocks::ABufferReport`].
    pub report: BufferHandle,
    /// Sums over all pixels; once the frame has run.
    pub known: Known,
    /// The counter of linked lists: fragments that asked for a node, of the first attempt.
    pub counter: Option<Checkpoint<u32>>,
}

/// What the host reads of a picture's layers.
#[derive(Clone)]
pub enum Known {
    /// Of the whole picture.
    Totals(Checkpoint<blocks::Totals>),
    /// Of each row.
    Rows(Checkpoint<blocks::Row>),
}

impl Known {
    /// Nodes of all pixels, and most of a pixel.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] before the frame has run.
    pub fn layers(&self) -> Result<(u64, u32)> {
        match self {
            Self::Totals(totals) => {
                let total = &totals.values()?[0].total;
                Ok((u64::from(total.nodes), total.longest))
            }
            Self::Rows(rows) => {
                let rows = rows.values()?;
                let nodes = rows.iter().map(|row| u64::from(row.nodes)).sum();
                Ok((nodes, rows.iter().map(|row| row.longest).max().unwrap_or(0)))
            }
        }
    }
}

/// Nodes of a picture or a band, before they are sorted.
struct Built {
    /// Before the names of passes.
    name: String,
    nodes: ImageHandle,
    linked: bool,
    scanned: Scanned,
    /// Words of nodes that do not fit into their texels.
    beside: ImageHandle,
    /// By pixel: of arrays, their ends; of lists, their heads.
    ends: ImageHandle,
    /// Of lists, how many nodes fragments asked for.
    counter: Option<BufferHandle>,
    /// Pixels that have nodes, class by class.
    work: BufferHandle,
    /// `frame.glsl`'s block.
    frame: Data,
}

impl Built {
    /// What a pass over nodes of pixels reads: `nodes_read.glsl` and `work.glsl`.
    fn bind(&self, pass: &mut ComputePass, of: &ABuffer) {
        pass.read(sort_comp::NODES, &self.nodes)
            .read(sort_comp::BESIDE, &self.beside)
            .read(sort_comp::TOTALS, &self.scanned.totals)
            .read(sort_comp::WORK, &self.work)
            .specialize(sort_comp::NODE_FORMAT, of.format.number())
            .specialize(sort_comp::SAMPLES, of.samples)
            .specialize(sort_comp::LINKED, self.linked);
    }
}

impl ABuffer {
    /// Composites all fragments before the opaque `depth` over `color` (R32G32B32A32 float, premultiplied).
    ///
    /// Running the frame fails with [`crate::Error::Invalid`], and says what would be needed, where there is no
    /// room for all fragments, in as many bands as there may be, or a pixel has more than [`MOST_LAYERS`]. Compiling it
    /// fails where the device cannot rasterise as many samples a pixel as are asked for, or `depth` has others.
    pub fn record<'f>(
        &self,
        graph: &mut Graph<'f>,
        view: &View,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        color: ImageHandle,
    ) -> Composited {
        samples::check(graph, self.samples, depth);
        let linked = match self.build {
            Build::Arrays => return self.by_arrays(graph, view, depth, fragments, color),
            Build::Lists(sizing) | Build::SubgroupLists(sizing) if self.samples > 1 => {
                (Step::ListsMultisampled, sizing)
            }
            Build::Lists(sizing) => (Step::Lists, sizing),
            Build::SubgroupLists(sizing) => (Step::SubgroupLists, sizing),
        };
        self.by_lists(linked, graph, view, depth, fragments, color)
    }
}

impl OrderIndependent for ABuffer {
    fn composite<'f>(
        &self,
        graph: &mut Graph<'f>,
        view: &View,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        color: ImageHandle,
    ) -> ImageHandle {
        self.record(graph, view, depth, fragments, color).color
    }
}

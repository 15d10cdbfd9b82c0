//! Resources of the last frame, by key: describing them.
//!
//! Two resources of one shape take turns. A frame reads the one that the last frame wrote, and writes the other one for
//! the next frame, so nothing ever waits for itself over a frame: no circle goes through a history. The executor keeps
//! both, with the state that each part of them was left in, so the first barriers of a frame are exact.

use std::collections::HashMap;

use ash::vk;

use super::builder::Graph;
use super::description::{Access, ImageShape, Origin, Queue, Range, ResourceId, Shape, State};
use super::errors::{ErrorKind, GraphError};
use super::handle::{BufferHandle, Handle, ImageHandle};
use super::pass::Work;
use super::plan::{Plan, held_at_the_end, states};

/// What the last frame left, and what this one leaves for the next one.
#[derive(Debug)]
#[must_use = "a history that nobody reads or writes does nothing"]
pub struct History<H> {
    /// What the last frame left, to be read. Where there is none, what [`First`] says.
    pub previous: H,
    /// What this frame leaves. Undefined until it is written; whoever writes it runs. It is written whole or not at
    /// all: where no pass writes it, the next frame finds this frame's `previous` again.
    pub next: H,
    /// Whether there is no last frame: the key is new, the shape is another one, or the view was cut
    /// ([`Graph::cut`]).
    pub is_first: bool,
}

/// What `previous` holds where there is no last frame.
#[derive(Clone, Copy)]
pub enum First {
    /// Nothing: reading it is an error. The technique looks at [`History::is_first`] and goes another way.
    Nothing,
    /// This colour, in the components that the format has.
    Color(vk::ClearColorValue),
    /// This depth.
    Depth(f32),
    /// This 32-bit value all over a buffer.
    Fill(u32),
}

/// What an executor keeps of a history, besides its memory.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    pub(super) shape: Shape,
    /// States that parts of the previous and of the next one are in.
    pub(super) states: [Vec<State>; 2],
    /// How many frames there were.
    pub(super) turn: u64,
}

/// By key.
pub(super) type KeptHistories = HashMap<String, Kept>;

/// A history of a graph.
pub(super) struct Declared {
    pub(super) key: String,
    pub(super) shape: Shape,
    /// The previous and the next one.
    pub(super) resources: [ResourceId; 2],
    /// The turn whose memory it goes on with; `None`: it takes new memory.
    pub(super) found: Option<u64>,
    /// Whether it begins anew.
    pub(super) is_first: bool,
}

impl Graph<'_> {
    /// From here on the frame has nothing to do with the last one (another camera, another scene): histories begin
    /// anew.
    pub fn cut(&mut self) {
        self.cut = true;
    }

    /// An image that the last frame left, and the one that this frame leaves, by key. Needs a graph that
    /// [`super::Executor::graph`] began; with any other it is always the first frame.
    ///
    /// # Errors
    /// [`Graph::compile`] says where the key is declared twice in a frame, where `previous` is written, where `next` is
    /// written in part, and where `first` does not fit the format.
    pub fn history_image(&mut self, key: &str, shape: ImageShape, first: First) -> History<ImageHandle> {
        let (origins, is_first) = self.history(key, Shape::Image(shape));
        let [previous, next] = origins;
        let mut previous = self.new_image(previous_name(key).into(), shape, previous, None);
        let next = self.new_image(key.into(), shape, next, None);
        self.declare(key, Shape::Image(shape), [previous.resource, next.resource], is_first);
        if is_first {
            let color = shape.aspects() == vk::ImageAspectFlags::COLOR;
            let depth = shape.aspects() == vk::ImageAspectFlags::DEPTH;
            let (resource, range) = (previous.resource, previous.range);
            previous = match first {
                First::Nothing => previous,
                First::Color(value) if color => self.begin(key, previous, Work::Clear { resource, range, value }),
                First::Depth(value) if depth => self.begin(key, previous, Work::ClearDepth { resource, range, value }),
                _ => {
                    let wrong = format!("begins with a value that format {:?} does not take", shape.format);
                    self.history_mistake(key, wrong, "Color for colours, Depth for depth, Nothing for all");
                    previous
                }
            };
        }
        History { previous, next, is_first }
    }

    /// A buffer that the last frame left, and the one that this frame leaves; as [`Graph::history_image`].
    ///
    /// # Errors
    /// As [`Graph::history_image`].
    pub fn history_buffer(&mut self, key: &str, size: u64, first: First) -> History<BufferHandle> {
        let (origins, is_first) = self.history(key, Shape::Buffer { size });
        let [previous, next] = origins;
        let mut previous = self.new_buffer(previous_name(key).into(), size, previous, None);
        let next = self.new_buffer(key.into(), size, next, None);
        self.declare(key, Shape::Buffer { size }, [previous.resource, next.resource], is_first);
        if is_first {
            let (resource, range) = (previous.resource, previous.range);
            previous = match first {
                First::Nothing => previous,
                First::Fill(value) => self.begin(key, previous, Work::Fill { resource, range, value }),
                _ => {
                    self.history_mistake(key, "begins with a value that no buffer takes".into(), "Fill or Nothing");
                    previous
                }
            };
        }
        History { previous, next, is_first }
    }

    /// Where both resources of a history come from, and whether there is no last frame.
    fn history(&self, key: &str, shape: Shape) -> ([Origin; 2], bool) {
        let kept = self.kept.get(key).filter(|kept| kept.shape == shape);
        let is_first = self.cut || !kept.is_some_and(|kept| all_held(&shape, &kept.states[0]));
        let [previous, next] = kept.map_or([Vec::new(), Vec::new()], |kept| kept.states.clone());
        let forget = |states: Vec<State>| states.into_iter().map(|state| State { holds: false, ..state }).collect();
        let previous = if is_first { forget(previous) } else { previous };
        let origin = |before, needed| Origin::Kept { before, after: None, needed };
        ([origin(previous, false), origin(forget(next), true)], is_first)
    }

    fn declare(&mut self, key: &str, shape: Shape, resources: [ResourceId; 2], is_first: bool) {
        if let Some(known) = self.histories.iter().find(|known| known.key == key) {
            let [known, other] = [&known.shape, &shape].map(describe);
            let wrong = format!("is declared twice in a frame, as {known} and as {other}");
            self.history_mistake(key, wrong, "once: hand the handles on");
        }
        let kept = self.kept.get(key).filter(|kept| kept.shape == shape);
        debug_assert!(kept.is_some() || is_first);
        let found = kept.map(|kept| kept.turn);
        self.histories.push(Declared { key: key.into(), shape, resources, found, is_first });
    }

    /// The pass that gives the first frame something to read.
    fn begin<H: Handle>(&mut self, key: &str, previous: H, work: Work<'static>) -> H {
        let pass = self.begin_pass();
        let next = self.replaced(pass, "destination", previous, false, Access::transfer_write());
        let queue = if matches!(work, Work::Fill { .. }) { Queue::Transfer } else { Queue::Graphics };
        self.push_pass(format!("begin {key}").into(), queue, work);
        next
    }

    /// Nobody writes what the last frame left: the next frame would not know.
    pub(super) fn check_previous(&mut self, slot: &str, handle: &impl Handle) {
        let declared = self.histories.iter().find(|declared| declared.resources[0] == handle.resource());
        if let Some(key) = declared.map(|declared| declared.key.clone()) {
            let wrong = format!("slot `{slot}` writes what the last frame left");
            self.history_mistake(&key, wrong, "write `next`; `previous` is read");
        }
    }

    /// Histories that the plan would leave written in part.
    pub(super) fn written_in_part(&self, plan: &Plan) -> Vec<GraphError> {
        let partly = self.histories.iter().filter(|declared| {
            // A plan knows of its segment alone.
            let held = match self.description.checkpoints.is_empty() {
                true => amount_held(&states(&plan.ends, declared.resources[1])),
                false => held_at_the_end(&self.description, declared.resources[1]),
            };
            0 < held && held < declared.shape.whole().amount()
        });
        let wrong = |declared: &Declared| {
            let wrong = "is written in part: the next frame would find a gap".into();
            mistake(&declared.key, wrong, "write all of `next`, or nothing")
        };
        partly.map(wrong).collect()
    }

    fn history_mistake(&mut self, key: &str, wrong: String, allowed: &str) {
        self.mistakes.push(mistake(key, wrong, allowed));
    }
}

impl Declared {
    /// What the next frame goes on with: whether both take turns, and the states.
    pub(super) fn after(&self, plan: &Plan) -> (bool, Kept) {
        let [last, new] = self.resources.map(|resource| states(&plan.ends, resource));
        let turned = all_held(&self.shape, &new);
        let states = if turned { [new, last] } else { [last, new] };
        (turned, Kept { shape: self.shape.clone(), states, turn: self.found.map_or(0, |turn| turn + 1) })
    }
}

fn mistake(key: &str, wrong: String, allowed: &str) -> GraphError {
    let (pass, slot, resource, allowed) = (None, None, Some(key.into()), allowed.into());
    GraphError { kind: ErrorKind::History, pass, slot, resource, wrong, allowed }
}

fn previous_name(key: &str) -> String {
    format!("{key} of the last frame")
}

fn all_held(shape: &Shape, states: &[State]) -> bool {
    amount_held(states) == shape.whole().amount()
}

fn amount_held(states: &[State]) -> u64 {
    states.iter().filter(|state| state.holds).map(|state| Range::amount(&state.range)).sum()
}

fn describe(shape: &Shape) -> String {
    match shape {
        Shape::Buffer { size } => format!("{size} bytes"),
        Shape::Image(ImageShape { format, extent: [width, height, depth], mips, layers, .. }) => {
            format!("{width}x{height}x{depth} texels of {format:?}, {mips} mips, {layers} layers")
        }
    }
}

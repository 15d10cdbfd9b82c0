//! A checker of plans, written from Vulkan's rules of synchronisation, memory aliasing and queue family ownership, and
//! from what a description means. It shares no code with the planner.
//!
//! [`check`] replays a plan on a made-up device. Every access leaves a record: where it ran, what it is ordered
//! before, and (of a write) whether it is available and to whom it is visible. Barriers and semaphores move records
//! along, as the chapter on synchronisation says; each access is then held against the records of its memory:
//!
//! - a read is ordered behind every write of the memory, and the write is visible to its stage and access;
//! - a write is ordered behind every read and write of the memory, and the writes are available;
//! - a layout transition is both, and must find everything in the first scopes of its own barrier (writes to memory
//!   that another resource aliases are made available by any barrier of the same call);
//! - the image is in the layout that the access says, and the resource belongs to the queue's family;
//! - what is read is what the version asked for holds: the writes of those passes and no others.
//!
//! [`check_frames`] does so for frames in a row, [`check_segments`] for a frame with checkpoints.
//!
//! Why an execution dependency is enough for a write after a read, although the write before the read is not made
//! visible to the second write: it is available and ordered, and visibility matters to reads alone. That is the view
//! of synchronisation validation, and of the examples of the specification's authors.

mod atoms;
mod choices;
mod contents;
mod device;
mod draft;
mod ends;
mod frames;
mod generate;
mod greedy;
mod histories;
mod memory;
mod part;
mod record;
mod replay;
mod rules;

pub use device::MadeUpDevice;
pub use draft::{Draft, PassDraft};
pub use frames::{Frame, check_frames, check_segments};
pub use generate::{Recipe, recipes};
pub use greedy::greedy_calls;
pub use replay::check;

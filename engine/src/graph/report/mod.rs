//! Reports of a description and its plan: as text, as a DOT graph, as JSON.
//!
//! [`Report`] is the data behind JSON, and behind any page made from it. Its `schema` names the form; what is added
//! later keeps the names that are there, and raises the number after the dot.

mod data;
mod dot;
mod path;
mod text;

pub use data::{
    ApartReport, BarrierReport, BatchReport, CulledReport, HeapReport, MemoryReport, PlacementReport, Report, SCHEMA,
    StepReport, UseReport, WaitReport,
};
pub use dot::dot;
pub use path::critical_path;
pub use text::text;

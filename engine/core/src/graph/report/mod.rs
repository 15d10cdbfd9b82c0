//! Reports of a description and its plan: as text, as a DOT graph, as JSON, as an HTML page.
//!
//! [`Report`] is the data behind JSON, and behind any page made from it. Its `schema` names the form; what is added
//! later keeps the names that are there, and raises the number after the dot.

mod build;
mod data;
mod dot;
mod page;
mod path;
mod resource;
mod text;

pub use data::{
    ApartReport, BarrierReport, BatchReport, CulledReport, HeapReport, MemoryReport, PlacementReport, Report, SCHEMA,
    StepReport, UseReport, WaitReport,
};
pub use dot::dot;
pub use page::html;
pub use path::{DependencyReport, critical_path};
pub use resource::ResourceReport;
pub use text::text;

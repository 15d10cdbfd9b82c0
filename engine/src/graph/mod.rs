//! The render graph: describe, plan, execute, report.
pub mod description;

/// All that is wrong with a graph.
#[derive(Debug, thiserror::Error)]
#[error("placeholder")]
pub struct GraphErrors;

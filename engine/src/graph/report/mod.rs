//! Reports of a description and its plan: as text, as a DOT graph, as JSON.
//!
//! All three are made from [`Report`], plain data that can be serialised; its `schema` names the form.

mod text;

pub use text::text;

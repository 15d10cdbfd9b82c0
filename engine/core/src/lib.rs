//! The lower floors of [shadowgraph](https://github.com/shadowgraph/shadowgraph): what renders without knowing scenes
//! or techniques. Applications use the `shadowgraph` crate, which has all of this and the floors above.
//!
//! | module | what it holds |
//! |---|---|
//! | [`graph`] | passes and resources, plan, execution, report |
//! | [`shader`] | bindings, programs |
//! | [`gpu`] | instance, device, memory, commands, validation messages |
//! | [`geometry`] | boxes and frusta on the host |
//! | [`error`] | one error type |
#![deny(unsafe_code)]

pub mod error;
pub mod geometry;
pub mod gpu;
pub mod graph;
#[doc(hidden)]
pub mod parallel;
pub mod shader;

pub use error::{Error, Result};

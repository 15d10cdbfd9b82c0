//! From surfaces and lights to radiance.

pub mod lighting;

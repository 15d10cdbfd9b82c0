//! Surfaces that let light through.

pub mod sorted;

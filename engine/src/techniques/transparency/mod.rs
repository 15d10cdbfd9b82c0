//! Surfaces that let light through.

pub mod abuffer;
pub mod forward;
pub mod sorted;

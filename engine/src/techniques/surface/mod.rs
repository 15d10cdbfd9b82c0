//! The first opaque surface seen from a camera.

pub mod depth;
pub mod gbuffer;
pub mod position;

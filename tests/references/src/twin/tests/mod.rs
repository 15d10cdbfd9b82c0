//! The twins against what can be worked out by hand, by a formula, or by a slower way.

mod cascades;
mod geometry;
mod materials;
mod shading;
mod shadow;

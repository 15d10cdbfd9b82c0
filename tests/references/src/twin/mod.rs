//! The twins: slow, plain, double precision, one definition each.
//!
//! None of them looks at a shader. Where a definition leaves something open, the twin's module says what it chose.

pub mod approximate;
pub mod atlas;
pub mod attributes;
pub mod brdf;
pub mod bvh;
pub mod camera;
pub mod cascades;
pub mod frustum;
pub mod layers;
pub mod lighting;
pub mod scene;
pub mod shadow;
pub mod surface;
pub mod texture;
pub mod transmittance;
pub mod vote;
pub mod voxel;
pub mod walk;

#[cfg(test)]
mod tests;

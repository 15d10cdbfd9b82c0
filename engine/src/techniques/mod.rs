//! The techniques, a folder each, grouped in families. A technique takes handles and settings in and gives handles
//! out; it never imports another one. [`crate::frame`] connects them.

pub mod registry;
pub mod shading;
pub mod shadow;
pub mod surface;
pub mod transparency;
pub mod voxel;

//! Pure geometry on the host: no device, no files.

mod bounds;

pub use bounds::Aabb;

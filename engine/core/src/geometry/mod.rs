//! Pure geometry on the host: no device, no files.

mod bounds;
mod frustum;

pub use bounds::Aabb;
pub use frustum::Frustum;

//! Geometry on the host: bounds and frusta.

mod bounds;
mod frustum;

pub use bounds::Aabb;
pub use frustum::Frustum;

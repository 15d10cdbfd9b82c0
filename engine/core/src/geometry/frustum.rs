//! View frusta.

use glam::{Mat4, Vec3, Vec4};

use super::Aabb;

/// The planes of a clip volume in world space, normals inwards.
#[derive(Clone, Copy, Debug)]
pub struct Frustum {
    planes: [Vec4; 6],
}

impl Frustum {
    /// From a matrix into Vulkan's clip space (Gribb and Hartmann 2001, "Fast extraction of viewing frustum planes").
    pub fn new(clip_from_world: &Mat4) -> Self {
        let m = clip_from_world.transpose();
        let (x, y, z, w) = (m.x_axis, m.y_axis, m.z_axis, m.w_axis);
        Self { planes: [w + x, w - x, w + y, w - y, z, w - z] }
    }

    /// Whether a box may touch it. Conservative: never false for a box that does.
    pub fn touches(&self, bounds: &Aabb) -> bool {
        self.planes.iter().all(|plane| {
            let normal = plane.truncate();
            let corner = Vec3::select(normal.cmpge(Vec3::ZERO), bounds.max, bounds.min);
            // Room for the rounding of a long sum.
            let slack = 1e-5 * (normal.abs().dot(corner.abs()) + plane.w.abs());
            normal.dot(corner) + plane.w >= -slack
        })
    }
}

//! Cameras and views, and the one place that knows which way depth runs.

use glam::{Mat4, Vec3, Vec4};

use crate::geometry::Aabb;

/// Depth convention: reversed. 1 on the near plane, 0 at infinity.
pub mod depth {
    use ash::vk;

    /// Farthest.
    pub const CLEAR: f32 = 0.0;
    /// Nearer passes.
    pub const CLOSER: vk::CompareOp = vk::CompareOp::GREATER;
    /// Nearer or equal passes.
    pub const CLOSER_OR_EQUAL: vk::CompareOp = vk::CompareOp::GREATER_OR_EQUAL;
}

/// A camera of a scene.
#[derive(Clone, Debug)]
pub struct Camera {
    /// Name made unique in the scene.
    pub name: String,
    /// Rigid: looks along −z, y up.
    pub world_from_view: Mat4,
    /// Lens.
    pub projection: Projection,
}

/// Lens of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Perspective.
    Perspective {
        /// Vertical field of view, radians.
        fov_y: f32,
        /// Metres.
        near: f32,
        /// Metres; `None` is infinite.
        far: Option<f32>,
    },
    /// Orthographic.
    Orthographic {
        /// Half the height, metres.
        half_height: f32,
        /// Metres.
        near: f32,
        /// Metres.
        far: f32,
    },
}

impl Camera {
    /// A perspective camera at `eye` that looks at `target`. Where `up` is parallel to the line of sight, another
    /// axis stands in.
    pub fn look_at(eye: Vec3, target: Vec3, up: Vec3, fov_y: f32, near: f32) -> Self {
        let forward = (target - eye).try_normalize().unwrap_or(Vec3::NEG_Z);
        let up = up.try_normalize().unwrap_or(Vec3::Y);
        let up = if forward.cross(up).length_squared() > 1e-12 { up } else { forward.any_orthonormal_vector() };
        let right = forward.cross(up).normalize();
        let world_from_view = Mat4::from_cols(
            right.extend(0.0),
            right.cross(forward).extend(0.0),
            (-forward).extend(0.0),
            eye.extend(1.0),
        );
        Self { name: "camera".into(), world_from_view, projection: Projection::Perspective { fov_y, near, far: None } }
    }

    /// A camera for a scene without one: it sees all of `bounds` from a corner, a little from above, through a lens of
    /// `fov_y` (vertical, radians) in a picture of `aspect` (width over height).
    ///
    /// The near plane follows the size of the scene, as units run from millimetres to thousands.
    pub fn framing(bounds: Aabb, fov_y: f32, aspect: f32) -> Self {
        // Room around the scene, as a factor on its distance.
        const MARGIN: f32 = 1.04;
        let scale = bounds.min.abs().max(bounds.max.abs()).max_element();
        let radius = bounds.radius().max(scale * 1e-3).max(1e-5);
        let back = Vec3::new(0.62, 0.42, 1.0).normalize();
        let mut camera = Self::look_at(bounds.center() + back, bounds.center(), Vec3::Y, fov_y, 1.0);

        // Every corner has to be within the pyramid of sight: it tells how far back the eye must be at least.
        let axes = camera.world_from_view;
        let tan_y = (fov_y * 0.5).tan();
        let tan_x = tan_y * if aspect.is_finite() && aspect > 0.0 { aspect } else { 1.0 };
        let needed = bounds.corners().map(|corner| {
            let from_center = corner - bounds.center();
            let x = from_center.dot(axes.x_axis.truncate()).abs();
            let y = from_center.dot(axes.y_axis.truncate()).abs();
            from_center.dot(back) + (x / tan_x).max(y / tan_y)
        });
        let distance = needed.into_iter().fold(radius * 0.5, f32::max) * MARGIN;
        let eye = bounds.center() + back * distance;
        camera.world_from_view.w_axis = eye.extend(1.0);
        let near = Self::near_for(bounds, eye);
        camera.projection = Projection::Perspective { fov_y, near, far: None };
        camera
    }

    /// A near plane for a scene of these bounds, seen from `eye`: as far as it can be without cutting into the box,
    /// and from within, a small part of its size.
    pub fn near_for(bounds: Aabb, eye: Vec3) -> f32 {
        let distance = (eye.clamp(bounds.min, bounds.max) - eye).length();
        (distance * 0.5).max(bounds.radius() * 1e-3).max(1e-6)
    }

    /// What a picture of `size` pixels sees. The vertical extent of the lens is kept, the horizontal one follows.
    pub fn view(&self, size: [u32; 2]) -> View {
        let aspect = size[0] as f32 / size[1] as f32;
        View {
            size,
            world_from_view: self.world_from_view,
            view_from_world: self.world_from_view.inverse(),
            clip_from_view: self.projection.clip_from_view(aspect),
        }
    }
}

impl Projection {
    /// Vulkan clip space from view space: y down, depth reversed as in [`depth`]. `aspect` is width over height.
    pub fn clip_from_view(&self, aspect: f32) -> Mat4 {
        match *self {
            Self::Perspective { fov_y, near, far } => {
                let f = 1.0 / (fov_y * 0.5).tan();
                // z_clip = a z + b, w = −z: 1 at −near, 0 at −far.
                let (a, b) = match far {
                    Some(far) => (near / (far - near), near * far / (far - near)),
                    None => (0.0, near),
                };
                Mat4::from_cols(
                    Vec4::new(f / aspect, 0.0, 0.0, 0.0),
                    Vec4::new(0.0, -f, 0.0, 0.0),
                    Vec4::new(0.0, 0.0, a, -1.0),
                    Vec4::new(0.0, 0.0, b, 0.0),
                )
            }
            Self::Orthographic { half_height, near, far } => Mat4::from_cols(
                Vec4::new(1.0 / (half_height * aspect), 0.0, 0.0, 0.0),
                Vec4::new(0.0, -1.0 / half_height, 0.0, 0.0),
                Vec4::new(0.0, 0.0, 1.0 / (far - near), 0.0),
                Vec4::new(0.0, 0.0, far / (far - near), 1.0),
            ),
        }
    }
}

/// A camera with a picture size: what a camera pass needs.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Rigid.
    pub world_from_view: Mat4,
    /// Its inverse.
    pub view_from_world: Mat4,
    /// Vulkan clip space: y down, depth reversed.
    pub clip_from_view: Mat4,
}

impl View {
    /// Vulkan clip space from world space.
    pub fn clip_from_world(&self) -> Mat4 {
        self.clip_from_view * self.view_from_world
    }

    /// How the distance along the view axis follows from a depth d of the depth buffer: (a d + b) / (c d + e), metres.
    pub fn distance_row(&self) -> [f32; 4] {
        let inverse = self.clip_from_view.inverse();
        // The view looks along -z.
        [-inverse.z_axis.z, -inverse.w_axis.z, inverse.z_axis.w, inverse.w_axis.w]
    }

    /// Distance along the view axis of a depth, metres.
    pub fn distance(&self, depth: f32) -> f32 {
        let [a, b, c, e] = self.distance_row();
        (a * depth + b) / (c * depth + e)
    }

    /// World-space position of the eye.
    pub fn eye(&self) -> Vec3 {
        self.world_from_view.w_axis.truncate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn framing_sees_every_corner_at_any_scale() {
        for scale in [1e-3, 1.0, 5e3] {
            for size in [Vec3::ONE, Vec3::new(10.0, 0.1, 3.0), Vec3::new(0.0, 4.0, 0.0), Vec3::ZERO] {
                for picture in [[1280, 720], [300, 900], [64, 64]] {
                    let min = Vec3::new(3.0, -2.0, 7.0) * scale;
                    let bounds = Aabb { min, max: min + size * scale };
                    let camera = Camera::framing(bounds, 0.7, picture[0] as f32 / picture[1] as f32);
                    let clip = camera.view(picture).clip_from_world();
                    for corner in bounds.corners() {
                        let p = clip * corner.extend(1.0);
                        let inside = p.x.abs() < p.w && p.y.abs() < p.w && p.z > 0.0 && p.z < p.w;
                        assert!(inside, "{corner} at {p} of {bounds:?} in {picture:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn from_within_the_near_plane_is_a_part_of_the_size() {
        let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE };
        assert!((Camera::near_for(bounds, Vec3::ZERO) - bounds.radius() * 1e-3).abs() < 1e-9);
        assert_eq!(Camera::near_for(bounds, Vec3::new(5.0, 0.0, 0.0)), 2.0);
    }
}

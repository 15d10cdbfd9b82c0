//! Cameras and views, and the one place that knows which way depth runs.

use glam::{Mat4, Vec3, Vec4};

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

    /// World-space position of the eye.
    pub fn eye(&self) -> Vec3 {
        self.world_from_view.w_axis.truncate()
    }
}

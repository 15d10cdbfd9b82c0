//! Punctual lights in the units of `KHR_lights_punctual`.

use glam::Vec3;

/// A light.
#[derive(Clone, Debug)]
pub struct Light {
    /// Name made unique in the scene and free of dots: it becomes part of layer names.
    pub name: String,
    /// Linear Rec. 709, multiplied into the intensity.
    pub color: Vec3,
    /// Kind, with intensity and geometry.
    pub kind: LightKind,
}

/// Kind of a light. Positions and directions are in world space; directions have unit length and point the way the
/// light travels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light from infinitely far.
    Directional {
        /// Way the light travels.
        direction: Vec3,
        /// Lux (lm/m²) on a plane facing the light.
        illuminance: f32,
    },
    /// All around.
    Point {
        /// World space.
        position: Vec3,
        /// Candela (lm/sr).
        intensity: f32,
        /// Metres beyond which it does nothing; infinite where the file gives none.
        range: f32,
    },
    /// A cone.
    Spot {
        /// World space.
        position: Vec3,
        /// Axis of the cone.
        direction: Vec3,
        /// Candela (lm/sr) on the axis.
        intensity: f32,
        /// Metres beyond which it does nothing; infinite where the file gives none.
        range: f32,
        /// Half-angle up to which it is at full intensity, radians.
        inner: f32,
        /// Half-angle at which it ends, radians.
        outer: f32,
    },
}

impl Light {
    /// The sun that a scene without lights gets: 100,000 lux from above, behind the left shoulder of
    /// [`Camera::framing`](crate::scene::Camera::framing).
    pub fn default_sun() -> Self {
        let direction = Vec3::new(0.35, -0.8, -0.5).normalize();
        Self {
            name: "sun".into(),
            color: Vec3::ONE,
            kind: LightKind::Directional { direction, illuminance: 100_000.0 },
        }
    }
}

impl super::Scene {
    /// The way the first directional light travels, world space; `None` where there is none.
    pub fn sun(&self) -> Option<Vec3> {
        self.lights.iter().find_map(|light| match light.kind {
            LightKind::Directional { direction, .. } => Some(direction),
            LightKind::Point { .. } | LightKind::Spot { .. } => None,
        })
    }
}

//! Lights as shaders read them (`common/lights.glsl`).

use glam::Vec3;

use super::{Light, LightKind};
use crate::shader::generated::blocks;

/// Where a light's shadow is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightShadow {
    /// Layer of the shadow masks.
    pub mask: u32,
    /// Its number among the lights that its shadow technique serves, where that one has a function for any point.
    pub index: Option<u32>,
    /// Its number among the lights with a deep shadow map.
    pub deep: Option<u32>,
}

/// Most lights of a frame; `MAX_LIGHTS` in `common/lights.glsl`.
pub const MAX_LIGHTS: usize = 256;

/// The first [`MAX_LIGHTS`] lights as shaders read them. `shadows` has an entry a light; `None` lights through
/// everything.
pub fn light_block(lights: &[Light], shadows: &[Option<LightShadow>]) -> blocks::Lights {
    let mut block: blocks::Lights = bytemuck::Zeroable::zeroed();
    for (i, (place, light)) in block.lights.iter_mut().zip(lights).enumerate() {
        *place = record(light, shadows.get(i).copied().flatten());
        block.light_count += 1;
    }
    block
}

fn record(light: &Light, shadow: Option<LightShadow>) -> blocks::Light {
    // KHR_lights_punctual: 1 / max(0.001, cos(inner) − cos(outer)), and its offset.
    let cone = |inner: f32, outer: f32| {
        let scale = 1.0 / (inner.cos() - outer.cos()).max(0.001);
        (scale, -outer.cos() * scale)
    };
    let inverse = |range: f32| if range.is_finite() && range > 0.0 { 1.0 / range } else { 0.0 };
    let (kind, intensity, position, range, direction, (cone_scale, cone_offset)) = match light.kind {
        LightKind::Directional { direction, illuminance } => (0, illuminance, Vec3::ZERO, 0.0, direction, (0.0, 1.0)),
        LightKind::Point { position, intensity, range } => {
            (1, intensity, position, inverse(range), Vec3::ZERO, (0.0, 1.0))
        }
        LightKind::Spot { position, direction, intensity, range, inner, outer } => {
            (2, intensity, position, inverse(range), direction, cone(inner, outer))
        }
    };
    blocks::Light {
        color: light.color * intensity,
        kind,
        position,
        inverse_range: range,
        direction,
        cone_scale,
        cone_offset,
        mask: shadow.map_or(-1, |shadow| shadow.mask as i32),
        shadow: shadow.and_then(|shadow| shadow.index).map_or(-1, |index| index as i32),
        deep: shadow.and_then(|shadow| shadow.deep).map_or(-1, |deep| deep as i32),
    }
}

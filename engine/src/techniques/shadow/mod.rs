//! Which points does a light reach? Every technique of this family turns a light and the surfaces a camera sees into
//! a screen mask, and has a GLSL function for points that are not on the screen's first surface.

pub mod cascaded;
pub mod deep;
pub mod marched;
pub mod spot;

use ash::vk;

use crate::gpu::SamplerInfo;
use crate::graph::ImageHandle;
use crate::scene::{Light, LightKind, Projection, View, depth};

/// The surfaces that receive shadows.
pub struct Receivers<'h> {
    /// The camera.
    pub view: &'h View,
    /// Depth of the first opaque surface.
    pub depth: &'h ImageHandle,
    /// Ids, with the triangle's normal in A: see `surface::gbuffer`.
    pub ids: &'h ImageHandle,
}

/// Widest cone that one map of a spot covers, half-angle in radians. Beyond it a light has no shadow.
pub const MAX_HALF_ANGLE: f32 = 80.0 * std::f32::consts::PI / 180.0;

/// A spot light's own view of a scene of this size (metres): `None` for a light that is no spot.
pub(crate) fn spot_view(light: &Light, scene_size: f32, resolution: u32) -> Option<View> {
    let LightKind::Spot { position, direction, range, outer, .. } = light.kind else { return None };
    let near = 1e-3 * scene_size.min(range).max(1e-6);
    let fov_y = 2.0 * outer.clamp(1e-3, MAX_HALF_ANGLE);
    let projection = Projection::Perspective { fov_y, near, far: None };
    Some(View::along(position, direction, projection, [resolution; 2]))
}

/// Percentage-closer filter (Reeves, Salesin and Cook 1987).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The hardware's bilinear comparison of 2×2 texels.
    Bilinear,
    /// So many bilinear taps a side, one texel apart.
    Grid(u32),
}

impl Filter {
    /// Bilinear taps a side.
    pub fn taps(self) -> u32 {
        match self {
            Self::Bilinear => 1,
            Self::Grid(taps) => taps.clamp(1, 15),
        }
    }
}

/// How shadow maps are sampled: lit where the receiver is at least as close as the stored depth, and beyond the edge.
pub fn map_sampler() -> SamplerInfo {
    SamplerInfo {
        mip: vk::SamplerMipmapMode::NEAREST,
        wrap: [vk::SamplerAddressMode::CLAMP_TO_BORDER; 3],
        compare: Some(depth::CLOSER_OR_EQUAL),
        border: vk::BorderColor::FLOAT_TRANSPARENT_BLACK,
        ..SamplerInfo::default()
    }
}

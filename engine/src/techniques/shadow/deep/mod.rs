//! Deep shadow maps: how much of a light's red, green and blue comes through the blended surfaces before a point.
//!
//! Source: Lokovic and Veach 2000, "Deep shadow maps". Each texel has a transmittance as a function of depth: a step at
//! every surface, channel by channel. The steps are the fragments of an A-buffer seen from the light, all of them: nothing
//! is compressed. What is opaque is not in it: an ordinary shadow map is multiplied in.

use ash::vk;
use glam::Vec3;

use super::{Receivers, spot_view};
use crate::geometry::Aabb;
use crate::graph::{Graph, ImageHandle, ImageShape};
use crate::scene::{Light, LightKind, View, ViewSet};
use crate::shader::generated::blocks;
use crate::shader::generated::shadow::deep::{accumulate_comp, mask_comp};

/// Most lights; `MAX_DEEP_MAPS` in `visibility.glsl`.
pub const MAX_LIGHTS: usize = 8;

/// Deep shadow maps of directional and spot lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeepShadow {
    /// Width and height of each map in texels, from 1 to 2048.
    pub resolution: u32,
}

impl Default for DeepShadow {
    fn default() -> Self {
        Self { resolution: 1024 }
    }
}

/// The blended surfaces before lights, sorted: see `transparency::abuffer`. The maps stand side by side in one picture.
pub struct SortedCasters {
    /// R32G32B32A32 uint texels row by row, a node each, nearest first: depth, key, and what is let through, 21 bits a
    /// channel.
    pub nodes: ImageHandle,
    /// By texel, R32G32B32A32 float: number of its first node, how many it has, depth of the nearest and the farthest.
    pub spans: ImageHandle,
}

/// What the technique gives.
pub struct DeepShadows {
    /// What comes through of each light at each pixel, R32G32B32A32 float; a layer a light, in the order of the views.
    pub masks: ImageHandle,
    /// By node its depth, and the transmittance behind it: bits of floats, R32G32B32A32 uint, row by row.
    pub steps: ImageHandle,
    /// By texel, as in [`SortedCasters::spans`].
    pub spans: ImageHandle,
    /// Parameters for `visibility.glsl`.
    pub parameters: blocks::DeepMaps,
}

impl DeepShadow {
    /// A light's view of what is blended, whose bounds are `casters`: as tight as can be around them for directional
    /// lights, the whole cone of spots. `None` for point lights. `scene_size`: metres.
    pub fn view(&self, light: &Light, casters: &Aabb, scene_size: f32) -> Option<View> {
        let resolution = self.side();
        let LightKind::Directional { direction, .. } = light.kind else {
            return spot_view(light, scene_size, resolution);
        };
        let turned = View::parallel(Vec3::ZERO, direction, 1.0, 1.0, 1.0, [1; 2]).view_from_world;
        let in_light = casters.transformed(turned);
        let size = in_light.max - in_light.min;
        // A texel of room on each side for bilinear filtering.
        let room = 1.0 + 4.0 / resolution as f32;
        let width = (size.x.max(size.y) * room).max(1e-6 * scene_size.max(1e-6));
        let half_depth = (0.5 * size.z).max(0.5 * width) * 1.01;
        Some(View::parallel(casters.center(), direction, width, half_depth, half_depth, [resolution; 2]))
    }

    /// Texels a side.
    pub fn side(&self) -> u32 {
        self.resolution.clamp(1, 2048)
    }

    /// Turns sorted casters into transmittance functions, and writes the masks of the lights that have these views; at
    /// most [`MAX_LIGHTS`].
    pub fn record(
        &self,
        graph: &mut Graph,
        receivers: &Receivers,
        views: &[View],
        casters: SortedCasters,
    ) -> DeepShadows {
        // 1. Transmittance after each surface.
        let SortedCasters { nodes, spans } = casters;
        let mut pass = graph.compute("shadow.deep.accumulate", &accumulate_comp::SHADER);
        pass.read(accumulate_comp::SPANS, &spans);
        let steps = pass.write(accumulate_comp::STEPS, nodes);
        pass.dispatch([spans.size()[0], spans.size()[1], 1]);

        // 2. What comes through at each pixel.
        let parameters = self.parameters(views);
        let size = receivers.view.size;
        let shape = ImageShape::new_2d(vk::Format::R32G32B32A32_SFLOAT, size).layers(parameters.deep_count.max(1));
        let masks = graph.image("shadow.deep.masks", shape);
        let mut pass = graph.compute("shadow.deep.mask", &mask_comp::SHADER);
        pass.uniform(mask_comp::VIEWS, &ViewSet::from(*receivers.view).block())
            .uniform(mask_comp::DEEP_MAPS, &parameters)
            .read(mask_comp::DEPTH, receivers.depth)
            .read(mask_comp::IDS, receivers.ids)
            .sample(mask_comp::DEEP_SPANS, &spans, sampler())
            .sample(mask_comp::DEEP_STEPS, &steps, sampler());
        let masks = pass.write(mask_comp::MASKS, masks);
        pass.dispatch([size[0], size[1], 1]);
        DeepShadows { masks, steps, spans, parameters }
    }

    fn parameters(&self, views: &[View]) -> blocks::DeepMaps {
        let mut parameters: blocks::DeepMaps = bytemuck::Zeroable::zeroed();
        parameters.deep_resolution = self.side();
        for (place, view) in parameters.deep_maps.iter_mut().zip(views) {
            let axis = -view.world_from_view.z_axis.truncate();
            let orthographic = view.is_orthographic();
            let eye = if orthographic { (-axis).extend(0.0) } else { view.eye().extend(1.0) };
            *place = blocks::DeepMap {
                clip_from_world: view.clip_from_world().to_cols_array_2d(),
                eye: eye.to_array(),
                axis,
                // 1 / P[0][0] is half the width: of the map, or a metre before a spot.
                texel: 2.0 / (view.clip_from_view.x_axis.x * self.side() as f32),
            };
            parameters.deep_count += 1;
        }
        parameters
    }
}

/// The functions are fetched, not filtered.
pub(crate) fn sampler() -> crate::gpu::SamplerInfo {
    crate::gpu::SamplerInfo::nearest()
}

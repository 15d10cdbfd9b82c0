//! A shadow map for each spot light (Williams 1978, "Casting curved shadows on curved surfaces"), all in one array.

use ash::vk;
use glam::Vec3;

pub use super::MAX_HALF_ANGLE;
use super::{Filter, Receivers, map_sampler, spot_view};
use crate::graph::{Graph, ImageHandle, ImageShape};
use crate::scene::{Faces, GpuScene, Light, LightKind, View, ViewSet};
use crate::shader::generated::blocks;
use crate::shader::generated::shadow::spot::mask_comp as shader;

/// Most spot lights with a shadow; `MAX_SPOTS` in `visibility.glsl`.
pub const MAX_SPOTS: usize = 64;

/// Shadow maps of spot lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Width and height of each map in texels.
    pub resolution: u32,
    /// Filter of the masks.
    pub filter: Filter,
}

impl Default for Spot {
    fn default() -> Self {
        Self { resolution: 1024, filter: Filter::Bilinear }
    }
}

/// What the technique gives.
pub struct SpotShadows {
    /// Visibility of the lights at each pixel, 1 is lit; a layer a light, in the order asked for.
    pub masks: ImageHandle,
    /// Depth maps, a layer a light.
    pub maps: ImageHandle,
    /// Parameters for `visibility.glsl`.
    pub parameters: blocks::SpotMaps,
    /// Its constant `SPOT_TAPS`.
    pub taps: u32,
}

impl Spot {
    /// Whether this technique serves a light.
    pub fn serves(light: &Light) -> bool {
        matches!(light.kind, LightKind::Spot { .. })
    }

    /// The light's own view of the scene: `None` for a light that is no spot.
    pub fn view(&self, light: &Light, scene_size: f32) -> Option<View> {
        spot_view(light, scene_size, self.resolution)
    }

    /// Renders a map for each of `lights` (spots all) and writes their masks, a layer each; nothing where there are
    /// none.
    pub fn record<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        receivers: &Receivers,
        lights: &[&Light],
        masks: ImageHandle,
    ) -> Option<SpotShadows> {
        let views: Vec<_> = lights.iter().filter_map(|light| self.view(light, 2.0 * scene.bounds.radius())).collect();
        if views.is_empty() {
            return None;
        }
        let records: Vec<_> = lights.iter().zip(&views).map(|(light, view)| self.map_record(light, view)).collect();
        let count = views.len() as u32;
        let shape = ImageShape::new_2d(vk::Format::D32_SFLOAT, [self.resolution; 2]).layers(count);
        let target = graph.image("shadow.spot.map", shape);
        // Spots look different ways: a pass each culls better than one for all.
        let layers = graph.split_layers(target).into_iter().zip(views).enumerate();
        let drawn: Vec<_> = layers
            .map(|(i, (layer, view))| {
                let name = format!("shadow.spot.map.{i}");
                scene.record_depth(graph, &name, &view.into(), layer, Faces::Both)
            })
            .collect();
        let maps = graph.join(drawn)?;

        let mut parameters: blocks::SpotMaps = bytemuck::Zeroable::zeroed();
        parameters.spot_count = count;
        parameters.spot_map_texel = 1.0 / self.resolution as f32;
        for (place, record) in parameters.spots.iter_mut().zip(records) {
            *place = record;
        }
        let taps = self.filter.taps();
        let mut pass = graph.compute("shadow.spot.mask", &shader::SHADER);
        pass.uniform(shader::VIEWS, &ViewSet::from(*receivers.view).block())
            .uniform(shader::SPOT_MAPS, &parameters)
            .read(shader::DEPTH, receivers.depth)
            .read(shader::IDS, receivers.ids)
            .sample(shader::SPOT_MAP, &maps, map_sampler())
            .specialize(shader::SPOT_TAPS, taps);
        let masks = pass.write(shader::MASKS, masks);
        pass.dispatch([receivers.view.size[0], receivers.view.size[1], 1]);
        Some(SpotShadows { masks, maps, parameters, taps })
    }

    fn map_record(&self, light: &Light, view: &View) -> blocks::SpotMap {
        let direction = match light.kind {
            LightKind::Spot { direction, .. } => direction,
            LightKind::Directional { .. } | LightKind::Point { .. } => Vec3::NEG_Y,
        };
        // 1 / P[0][0] is the tangent of the half-angle.
        let texel = 2.0 / (view.clip_from_view.x_axis.x * self.resolution as f32);
        let clip_from_world = view.clip_from_world().to_cols_array_2d();
        blocks::SpotMap { clip_from_world, position: view.eye(), texel, direction }
    }
}

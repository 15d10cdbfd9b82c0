//! Which lights cast shadows in a frame, and how.

use ash::vk;

use super::FrameSettings;
use super::voxels::Marching;
use crate::Result;
use crate::geometry::Aabb;
use crate::graph::{Graph, ImageHandle, ImageShape, Load};
use crate::scene::{DrawClass, GpuScene, Light, LightKind, LightShadow, MAX_LIGHTS, View, depth};
use crate::shader::generated::blocks;
use crate::techniques::shadow::Receivers;
use crate::techniques::shadow::cascaded::CascadedShadow;
use crate::techniques::shadow::deep::{self, DeepShadow, DeepShadows, SortedCasters};
use crate::techniques::shadow::marched;
use crate::techniques::shadow::spot::{MAX_SPOTS, Spot, SpotShadows};
use crate::techniques::transparency::abuffer::{ABuffer, MOST_LAYERS, NodeFormat, SortedLists};
use crate::techniques::transparency::casters::Casters;

impl FrameSettings {
    /// Shadow maps of the first directional light and of the spots, rays to point lights where there are voxels, and one
    /// image with a mask a layer.
    pub(super) fn shadows<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        receivers: &Receivers,
        marching: Option<&Marching>,
    ) -> Result<Shadows> {
        let lights = &scene.lights;
        let sun = lights.iter().enumerate().find_map(|(i, light)| match light.kind {
            LightKind::Directional { direction, .. } => Some((i, direction)),
            LightKind::Point { .. } | LightKind::Spot { .. } => None,
        });
        let spots: Vec<usize> = (0..lights.len()).filter(|&i| Spot::serves(&lights[i])).take(MAX_SPOTS).collect();
        let is_point = |&i: &usize| marching.is_some() && matches!(lights[i].kind, LightKind::Point { .. });
        let points: Vec<usize> = (0..lights.len()).filter(is_point).take(marched::MAX_LIGHTS).collect();
        let blocks = [u32::from(sun.is_some()), spots.len() as u32, points.len() as u32];
        let count = blocks.iter().sum();

        // Masks: the sun's first, then the spots', then the points'.
        let mut shadows = Shadows::new(lights);
        let shadow_of = |mask, index| Some(LightShadow { mask, index, deep: None });
        let mut masks = 0..;
        if let Some((sun, _)) = sun
            && let Some(mask) = masks.next()
        {
            shadows.of_lights[sun] = shadow_of(mask, Some(0));
        }
        for ((index, &spot), mask) in (0..).zip(&spots).zip(&mut masks) {
            shadows.of_lights[spot] = shadow_of(mask, Some(index));
        }
        for (&point, mask) in points.iter().zip(masks) {
            shadows.of_lights[point] = shadow_of(mask, None);
        }
        shadows.warn(lights);
        if count == 0 {
            return Ok(shadows);
        }
        let shape = ImageShape::new_2d(vk::Format::R32_SFLOAT, self.view.size).layers(count);
        let masks = graph.image("shadow.masks", shape);
        let blocks: Vec<u32> = blocks.into_iter().filter(|&layers| layers > 0).collect();
        let mut masks = graph.split_layer_blocks(masks, &blocks).into_iter();
        let mut written = Vec::with_capacity(blocks.len());
        if let Some((_, direction)) = sun
            && let Some(mask) = masks.next()
        {
            let cascaded = self.cascaded.record(graph, scene, receivers, direction, mask)?;
            let CascadedShadow { mask, index, map, parameters, taps } = cascaded;
            written.push(mask);
            shadows.sun = Some(SunShadow { index, map, parameters, taps });
        }
        let spot_lights: Vec<&Light> = spots.iter().map(|&i| &lights[i]).collect();
        if !spot_lights.is_empty()
            && let Some(masks) = masks.next()
            && let Some(spots) = self.spot.record(graph, scene, receivers, &spot_lights, masks)
        {
            let SpotShadows { masks, maps, parameters, taps } = spots;
            written.push(masks);
            shadows.spots = Some(SpotMaps { maps, parameters, taps });
        }
        if let Some(Marching { technique, occluders, position }) = marching
            && let Some(masks) = masks.next()
        {
            let lights: Vec<&Light> = points.iter().map(|&i| &lights[i]).collect();
            written.push(technique.record(graph, occluders, [position, receivers.ids], &lights, masks));
        }
        shadows.masks = graph.join(written);
        if let Some(technique) = self.deep_shadow {
            self.deep_shadows(technique, graph, scene, receivers, &mut shadows)?;
        }
        Ok(shadows)
    }

    /// Deep shadow maps of the lights that have shadows, where blended surfaces stand before them.
    fn deep_shadows<'f>(
        &self,
        technique: DeepShadow,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        receivers: &Receivers,
        shadows: &mut Shadows,
    ) -> Result<()> {
        // 1. The lights and their views.
        let blended = scene.draws.draws().iter().filter(|draw| draw.class == DrawClass::Blend);
        let Some(casters) = blended.map(|draw| draw.bounds).reduce(Aabb::union) else { return Ok(()) };
        let mut views: Vec<View> = Vec::new();
        // The maps stand side by side in one image.
        let in_a_row = graph.caps().limits.max_image_dimension_2d / technique.side();
        let most = deep::MAX_LIGHTS.min(in_a_row as usize);
        for (index, light) in scene.lights.iter().enumerate() {
            let Some(shadow) = &mut shadows.of_lights[index] else { continue };
            let Some(view) = technique.view(light, &casters, 2.0 * scene.bounds.radius()) else { continue };
            if views.len() == most {
                shadows.warnings.push(format!("light `{}` shines through blended surfaces undimmed", light.name));
                continue;
            }
            shadow.deep = Some(views.len() as u32);
            shadows.deep_lights.push(index);
            views.push(view);
        }
        if views.is_empty() {
            return Ok(());
        }

        // 2. What they see of blended surfaces, sorted. What is opaque has maps of its own.
        let side = technique.side();
        let shape = ImageShape::new_2d(vk::Format::D32_SFLOAT, [side * views.len() as u32, side]);
        let nothing = graph.image("shadow.deep.nothing", shape);
        let mut pass = graph.raster("shadow.deep.nothing", Vec::new());
        let nothing = pass.depth(nothing, Load::Clear(depth::CLEAR));
        pass.draw(|_| Ok(()));
        let seen = Casters::new(graph, scene, views.clone())?;
        let abuffer = ABuffer { format: NodeFormat::Transmittance, memory: self.layer_memory, ..ABuffer::default() };
        let SortedLists { nodes, spans } = abuffer.sort(graph, "shadow.deep", &nothing, &seen, MOST_LAYERS);

        // 3. Functions and masks.
        shadows.deep = Some(technique.record(graph, receivers, &views, SortedCasters { nodes, spans }));
        Ok(())
    }
}

/// Shadows of a frame.
pub(super) struct Shadows {
    /// By light.
    pub(super) of_lights: Vec<Option<LightShadow>>,
    pub(super) masks: Option<ImageHandle>,
    pub(super) sun: Option<SunShadow>,
    pub(super) spots: Option<SpotMaps>,
    /// What comes through blended surfaces; the lights it is of.
    pub(super) deep: Option<DeepShadows>,
    pub(super) deep_lights: Vec<usize>,
    pub(super) warnings: Vec<String>,
}

pub(super) struct SunShadow {
    pub(super) index: ImageHandle,
    pub(super) map: ImageHandle,
    pub(super) parameters: blocks::Cascades,
    pub(super) taps: u32,
}

pub(super) struct SpotMaps {
    pub(super) maps: ImageHandle,
    pub(super) parameters: blocks::SpotMaps,
    pub(super) taps: u32,
}

impl Shadows {
    pub(super) fn new(lights: &[Light]) -> Self {
        Self {
            of_lights: vec![None; lights.len()],
            masks: None,
            sun: None,
            spots: None,
            deep: None,
            deep_lights: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// Says which lights the frame does not show as the scene asks.
    fn warn(&mut self, lights: &[Light]) {
        let without = lights.iter().zip(&self.of_lights).take(MAX_LIGHTS).filter(|(_, shadow)| shadow.is_none());
        let why = |light: &Light| match light.kind {
            LightKind::Point { .. } => "a point light has one through voxels alone (`FrameSettings::voxels`, --voxels)",
            LightKind::Directional { .. } => "only the first directional light has one",
            LightKind::Spot { .. } => "only so many spots have one",
        };
        self.warnings
            .extend(without.map(|(light, _)| format!("light `{}` casts no shadow: {}", light.name, why(light))));
        if lights.len() > MAX_LIGHTS {
            let dark = lights.len() - MAX_LIGHTS;
            self.warnings.push(format!("{dark} lights after the first {MAX_LIGHTS} do not shine"));
        }
    }
}

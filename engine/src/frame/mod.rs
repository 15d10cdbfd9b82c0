//! The assembled frame: which light, cascade and camera passes run, from one settings value, and which layers they
//! leave.

mod layers;
mod voxels;

use ash::vk;
use glam::Vec3;

pub use layers::{ABUFFER_REPORT, Deep, Layer, Samples, Selection, Source};
pub use voxels::VoxelVisibility;

use crate::graph::{BufferHandle, Graph, ImageHandle, ImageShape};
use crate::scene::{DrawClass, GpuScene, Light, LightKind, LightShadow, MAX_LIGHTS, View, light_block};
use crate::shader::generated::blocks;
use crate::techniques::shading::lighting::{Lighting, LightingInput};
use crate::techniques::shadow::cascaded::{Cascaded, CascadedShadow};
use crate::techniques::shadow::marched;
use crate::techniques::shadow::spot::{MAX_SPOTS, Spot, SpotShadows};
use crate::techniques::shadow::{Receivers, map_sampler};
use crate::techniques::surface::depth::DepthPrepass;
use crate::techniques::surface::gbuffer::{GBuffer, Precision, Surfaces};
use crate::techniques::surface::position::Position;
use crate::techniques::transparency::OrderIndependent;
use crate::techniques::transparency::abuffer::{ABuffer, COMPACT_TRIANGLES, Composited, NodeFormat};
use crate::techniques::transparency::depth_peeling::DepthPeeling;
use crate::techniques::transparency::dual_depth_peeling::DualDepthPeeling;
use crate::techniques::transparency::forward::{ForwardLights, ForwardShadow};
use crate::techniques::transparency::fragments::Blended;
use crate::techniques::transparency::kbuffer::KBuffer;
use crate::techniques::transparency::moments::Moments;
use crate::techniques::transparency::sorted::Sorted;
use crate::techniques::transparency::stochastic::Stochastic;
use crate::techniques::transparency::weighted::Weighted;
use crate::techniques::voxel::Occluders;

/// How blended surfaces are composited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Transparency {
    /// Object by object, far ones first: objects that interlock come out wrong.
    #[default]
    Sorted,
    /// Every layer of every pixel, by depth.
    ABuffer,
    /// The same, layer by layer from the front: much slower where there are many.
    DepthPeeling(DepthPeeling),
    /// The same, from both ends.
    DualDepthPeeling(DualDepthPeeling),
    /// An average of all layers, the nearer ones with more weight.
    Weighted(Weighted),
    /// The nearest layers exactly, behind them an average.
    KBuffer(KBuffer),
    /// All layers, as visible as four moments of what hides them tell.
    Moments(Moments),
    /// All layers, as visible as random samples tell.
    Stochastic(Stochastic),
}

impl Transparency {
    /// Its name in the registry of techniques.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sorted => "sorted",
            Self::ABuffer => "abuffer",
            Self::DepthPeeling(_) => "depth_peeling",
            Self::DualDepthPeeling(_) => "dual_depth_peeling",
            Self::Weighted(_) => "weighted",
            Self::KBuffer(_) => "kbuffer",
            Self::Moments(_) => "moments",
            Self::Stochastic(_) => "stochastic",
        }
    }
}

/// What a frame is made with.
#[derive(Clone, Debug)]
pub struct FrameSettings {
    /// The camera and the picture's size.
    pub view: View,
    /// Shadows of the first directional light.
    pub cascaded: Cascaded,
    /// Shadows of spot lights.
    pub spot: Spot,
    /// Shadows of point lights, and ambient occlusion, by rays through voxels.
    pub voxels: Option<VoxelVisibility>,
    /// Radiance that comes from everywhere, cd/m².
    pub environment: Vec3,
    /// How finely the G-buffer and the layers of the A-buffer are stored.
    pub precision: Precision,
    /// How blended surfaces are composited.
    pub transparency: Transparency,
    /// Most bytes that the A-buffer's layers may take.
    pub layer_memory: u64,
    /// Whether every layer of every pixel is captured as well, for [`crate::capture::DeepPicture`]. Blended surfaces are
    /// composited by [`Transparency::ABuffer`] then.
    pub deep: bool,
    /// Which layers are captured. What only others need is not rendered.
    pub layers: Selection,
}

impl FrameSettings {
    /// Four cascades, bilinear shadows, no environment, every layer.
    pub fn new(view: View) -> Self {
        Self {
            view,
            cascaded: Cascaded::default(),
            spot: Spot::default(),
            voxels: None,
            environment: Vec3::ZERO,
            precision: Precision::default(),
            transparency: Transparency::default(),
            layer_memory: u64::MAX,
            deep: false,
            layers: Selection::All,
        }
    }

    /// How blended surfaces are composited: what is captured deep are the A-buffer's layers.
    pub fn composited_by(&self) -> Transparency {
        if self.deep { Transparency::ABuffer } else { self.transparency }
    }
}

/// What a recorded frame will leave.
pub struct Frame {
    /// Captured layers.
    pub layers: Vec<Layer>,
    /// What was captured for a deep picture.
    pub deep: Option<Deep>,
    /// What the frame does not show as the scene asks, a sentence each.
    pub warnings: Vec<String>,
}

impl FrameSettings {
    /// Records the passes of a frame and marks its layers to be captured.
    pub fn record<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene) -> Frame {
        let view = &self.view;
        let mut captured = layers::Captured::new(&self.layers);

        // 1. Camera: the first opaque surface of each pixel.
        let depth = DepthPrepass.record(graph, scene, view);
        let surfaces = GBuffer::default().precision(self.precision).record(graph, scene, view, depth);
        let position = Position.record(graph, view, &surfaces.depth);

        // 2. Lights: maps and masks of those that cast shadows.
        let receivers = Receivers { view, depth: &surfaces.depth, ids: &surfaces.ids };
        let occluders = self.voxels.map(|voxels| voxels.occluders(graph, scene)).transpose();
        let (occluders, why_not) = occluders.map_or_else(|error| (None, Some(error)), |occluders| (occluders, None));
        let marched = self.voxels.zip(occluders.as_ref());
        let mut shadows = self.shadows(graph, scene, &receivers, marched.map(|marched| (marched, &position)));
        shadows.warnings.extend(why_not.map(|error| format!("there are no voxels: {error}")));
        let lights = light_block(&scene.lights, &shadows.of_lights);

        // 3. Camera: shading of the opaque surfaces, then blended ones over them.
        let input = LightingInput {
            depth: &surfaces.depth,
            albedo: &surfaces.albedo,
            normal: &surfaces.normal,
            material: &surfaces.material,
            emissive: &surfaces.emissive,
            lights: &lights,
            masks: shadows.masks.as_ref(),
        };
        let lit = Lighting { environment: self.environment }.record(graph, scene, view, &input);
        let forward = ForwardLights {
            lights: &lights,
            cascades: shadows.sun.as_ref().map(|sun| {
                let SunShadow { map: maps, parameters, taps, .. } = sun;
                ForwardShadow { parameters, maps, taps: *taps }
            }),
            spots: shadows.spots.as_ref().map(|spots| {
                let SpotMaps { maps, parameters, taps } = spots;
                ForwardShadow { parameters, maps, taps: *taps }
            }),
            sampler: map_sampler(),
            environment: self.environment,
        };
        if self.deep {
            graph.capture(Deep::OPAQUE, &lit.color);
            graph.capture(Deep::POSITION, &position);
        }
        let (color, layers) = self.transparency(graph, scene, &surfaces.depth, &forward, lit.color);

        // 4. Captures.
        captured.frame(graph, &color, &lit.direct, &position, &surfaces);
        captured.shadows(graph, scene, &shadows);
        if let Some((VoxelVisibility { occlusion, .. }, occluders)) = marched {
            let open = occlusion.record(graph, occluders, &position, &surfaces.ids);
            captured.occlusion(graph, &open);
        }
        if let Some(layers) = &layers {
            captured.abuffer(graph, layers);
        }
        let deep = self.deep.then(|| Deep { abuffer: layers.map(|layers| layers.made_by) });
        Frame { layers: captured.layers, deep, warnings: shadows.warnings }
    }

    /// Blended surfaces over `color`; what the A-buffer knows of them besides.
    fn transparency<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        depth: &ImageHandle,
        lights: &ForwardLights,
        color: ImageHandle,
    ) -> (ImageHandle, Option<TransparentLayers>) {
        let view = &self.view;
        if !scene.draws.draws().iter().any(|draw| draw.class == DrawClass::Blend) {
            return (color, None);
        }
        let blended = Blended::new(graph, scene, *view, lights);
        let transparency = self.composited_by();
        let technique: &dyn OrderIndependent = match &transparency {
            Transparency::Sorted => return (Sorted.record(graph, scene, view, depth, lights, color), None),
            Transparency::ABuffer => {
                let (color, layers) = self.abuffer(graph, &blended, depth, color);
                return (color, Some(layers));
            }
            Transparency::DepthPeeling(technique) => technique,
            Transparency::DualDepthPeeling(technique) => technique,
            Transparency::Weighted(technique) => technique,
            Transparency::KBuffer(technique) => technique,
            Transparency::Moments(technique) => technique,
            Transparency::Stochastic(technique) => technique,
        };
        (technique.composite(graph, view, depth, &blended, color), None)
    }

    fn abuffer<'f>(
        &self,
        graph: &mut Graph<'f>,
        blended: &Blended<'_, 'f>,
        depth: &ImageHandle,
        color: ImageHandle,
    ) -> (ImageHandle, TransparentLayers) {
        let format = match self.precision {
            Precision::Float => NodeFormat::Float,
            Precision::Compact if blended.triangles() > COMPACT_TRIANGLES => NodeFormat::Half,
            Precision::Compact => NodeFormat::Compact,
        };
        // Up to a million cd/m²: highlights of the sun are beyond what nodes hold as they are.
        let abuffer = ABuffer { format, exponent: 4, memory: self.layer_memory, ..ABuffer::default() };
        let Composited { color, count, front, nodes, report, .. } =
            abuffer.record(graph, &self.view, depth, blended, color);
        if let Some(nodes) = nodes.filter(|_| self.deep) {
            graph.capture(Deep::COUNT, &count);
            graph.capture(Deep::NODES, &nodes);
        }
        (color, TransparentLayers { made_by: abuffer, count, front, report })
    }

    /// Shadow maps of the first directional light and of the spots, rays to point lights where there are voxels (with
    /// positions of pixels), and one image with a mask a layer.
    fn shadows<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        receivers: &Receivers,
        marched: Option<((VoxelVisibility, &Occluders), &ImageHandle)>,
    ) -> Shadows {
        let lights = &scene.lights;
        let sun = lights.iter().enumerate().find_map(|(i, light)| match light.kind {
            LightKind::Directional { direction, .. } => Some((i, direction)),
            LightKind::Point { .. } | LightKind::Spot { .. } => None,
        });
        let spots: Vec<usize> = (0..lights.len()).filter(|&i| Spot::serves(&lights[i])).take(MAX_SPOTS).collect();
        let is_point = |&i: &usize| marched.is_some() && matches!(lights[i].kind, LightKind::Point { .. });
        let points: Vec<usize> = (0..lights.len()).filter(is_point).take(marched::MAX_LIGHTS).collect();
        let blocks = [u32::from(sun.is_some()), spots.len() as u32, points.len() as u32];
        let count = blocks.iter().sum();

        // Masks: the sun's first, then the spots', then the points'.
        let mut shadows = Shadows::new(lights);
        let mut masks = 0..;
        if let Some((sun, _)) = sun
            && let Some(mask) = masks.next()
        {
            shadows.of_lights[sun] = Some(LightShadow { mask, index: Some(0) });
        }
        for ((index, &spot), mask) in (0..).zip(&spots).zip(&mut masks) {
            shadows.of_lights[spot] = Some(LightShadow { mask, index: Some(index) });
        }
        for (&point, mask) in points.iter().zip(masks) {
            shadows.of_lights[point] = Some(LightShadow { mask, index: None });
        }
        shadows.warn(lights);
        if count == 0 {
            return shadows;
        }
        let shape = ImageShape::new_2d(vk::Format::R32_SFLOAT, self.view.size).layers(count);
        let masks = graph.image("shadow.masks", shape);
        let blocks: Vec<u32> = blocks.into_iter().filter(|&layers| layers > 0).collect();
        let mut masks = graph.split_layer_blocks(masks, &blocks).into_iter();
        let mut written = Vec::with_capacity(blocks.len());
        if let Some((_, direction)) = sun
            && let Some(mask) = masks.next()
        {
            let cascaded = self.cascaded.record(graph, scene, receivers, direction, mask);
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
        if let Some(((VoxelVisibility { shadows: technique, .. }, occluders), position)) = marched
            && let Some(masks) = masks.next()
        {
            let lights: Vec<&Light> = points.iter().map(|&i| &lights[i]).collect();
            written.push(technique.record(graph, occluders, [position, receivers.ids], &lights, masks));
        }
        shadows.masks = graph.join(written);
        shadows
    }
}

/// What the A-buffer knows besides the colour.
struct TransparentLayers {
    made_by: ABuffer,
    count: ImageHandle,
    front: ImageHandle,
    report: BufferHandle,
}

/// Shadows of a frame.
struct Shadows {
    /// By light.
    of_lights: Vec<Option<LightShadow>>,
    masks: Option<ImageHandle>,
    sun: Option<SunShadow>,
    spots: Option<SpotMaps>,
    warnings: Vec<String>,
}

struct SunShadow {
    index: ImageHandle,
    map: ImageHandle,
    parameters: blocks::Cascades,
    taps: u32,
}

struct SpotMaps {
    maps: ImageHandle,
    parameters: blocks::SpotMaps,
    taps: u32,
}

impl Shadows {
    fn new(lights: &[Light]) -> Self {
        Self { of_lights: vec![None; lights.len()], masks: None, sun: None, spots: None, warnings: Vec::new() }
    }

    /// Says which lights the frame does not show as the scene asks.
    fn warn(&mut self, lights: &[Light]) {
        let without = lights.iter().zip(&self.of_lights).take(MAX_LIGHTS).filter(|(_, shadow)| shadow.is_none());
        self.warnings.extend(without.map(|(light, _)| format!("light `{}` casts no shadow", light.name)));
        if lights.len() > MAX_LIGHTS {
            let dark = lights.len() - MAX_LIGHTS;
            self.warnings.push(format!("{dark} lights after the first {MAX_LIGHTS} do not shine"));
        }
    }
}

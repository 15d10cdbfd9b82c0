//! The assembled frame: which light, cascade and camera passes run, from one settings value, and which layers they
//! leave.

mod adaptive;
mod layers;
mod shadows;
mod voxels;

use glam::Vec3;

pub use adaptive::AdaptiveLists;
pub use layers::{ABUFFER_REPORT, Deep, Layer, MOST_NUMBERED, Samples, Selection, Source};
pub use voxels::VoxelVisibility;

use self::shadows::{Shadows, SpotMaps, SunShadow};
use self::voxels::Marching;
use crate::graph::{BufferHandle, Graph, ImageHandle};
use crate::scene::{AlphaMode, DrawClass, GpuScene, View, light_block};
use crate::techniques::shading::lighting::{Lighting, LightingInput};
use crate::techniques::shadow::cascaded::Cascaded;
use crate::techniques::shadow::deep::DeepShadow;
use crate::techniques::shadow::spot::Spot;
use crate::techniques::shadow::{Receivers, map_sampler};
use crate::techniques::surface::depth::DepthPrepass;
use crate::techniques::surface::gbuffer::{GBuffer, Precision, Surfaces};
use crate::techniques::surface::position::Position;
use crate::techniques::transparency::OrderIndependent;
use crate::techniques::transparency::abuffer::{ABuffer, COMPACT_TRIANGLES, Composited, NearestLayer, NodeFormat};
use crate::techniques::transparency::adaptive::Adaptive;
use crate::techniques::transparency::depth_peeling::DepthPeeling;
use crate::techniques::transparency::dual_depth_peeling::DualDepthPeeling;
use crate::techniques::transparency::forward::{ForwardDeep, ForwardLights, ForwardShadow};
use crate::techniques::transparency::fragments::Blended;
use crate::techniques::transparency::kbuffer::KBuffer;
use crate::techniques::transparency::moments::Moments;
use crate::techniques::transparency::sorted::Sorted;
use crate::techniques::transparency::stochastic::Stochastic;
use crate::techniques::transparency::weighted::Weighted;

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
    /// All layers, as visible as a step function of few nodes tells.
    Adaptive(Adaptive),
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
            Self::Adaptive(_) => "adaptive",
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
    /// What comes through blended surfaces of the light of those that have shadows; else they throw none.
    pub deep_shadow: Option<DeepShadow>,
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
    /// Bands of rows that the A-buffer may be built in where that is too little: see [`ABuffer::bands`]. Deep pictures are
    /// built at once.
    pub layer_bands: u32,
    /// Samples a pixel of the A-buffer's layers: see [`ABuffer::samples`]. What is opaque keeps one colour a pixel, and deep
    /// pictures have one sample.
    pub abuffer_samples: u32,
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
            deep_shadow: None,
            voxels: None,
            environment: Vec3::ZERO,
            precision: Precision::default(),
            transparency: Transparency::default(),
            layer_memory: u64::MAX,
            layer_bands: 1,
            abuffer_samples: 1,
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
        let mut warnings = Vec::new();
        let seen_through = self.voxels.and_then(|voxels| match voxels.occluders(graph, scene) {
            Ok(occluders) => Some((voxels, occluders)),
            Err(error) => {
                warnings.push(format!("there are no voxels: {error}"));
                None
            }
        });
        let marching = seen_through.as_ref().map(|(voxels, occluders)| Marching {
            technique: voxels.shadows,
            occluders,
            position: &position,
        });
        let shadows = self.shadows(graph, scene, &receivers, marching.as_ref()).unwrap_or_else(|error| {
            warnings.push(format!("no light casts a shadow: {error}"));
            Shadows::new(&scene.lights)
        });
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
            deep_masks: shadows.deep.as_ref().map(|deep| &deep.masks),
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
            deep: shadows.deep.as_ref().map(|deep| ForwardDeep {
                parameters: &deep.parameters,
                spans: &deep.spans,
                steps: &deep.steps,
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
        if let Some((voxels, occluders)) = &seen_through {
            let open = voxels.occlusion.record(graph, occluders, &position, &surfaces.ids);
            captured.occlusion(graph, &open);
        }
        if let Some(layers) = &layers {
            captured.abuffer(graph, layers);
        }
        let deep = self.deep.then(|| Deep { abuffer: layers.map(|layers| layers.made_by) });
        warnings.extend(shadows.warnings);
        if self.deep && self.abuffer_samples != 1 {
            warnings
                .push("deep pictures have one sample a pixel: edges of blended surfaces are not anti-aliased".into());
        }
        warnings.extend(self.unshown(scene));
        Frame { layers: captured.layers, deep, warnings }
    }

    /// What the technique of transparency does not show of the scene's materials.
    fn unshown(&self, scene: &GpuScene) -> Vec<String> {
        let transparency = self.composited_by();
        let mut unshown = Vec::new();
        let tints = matches!(
            transparency,
            Transparency::ABuffer
                | Transparency::Adaptive(_)
                | Transparency::DepthPeeling(_)
                | Transparency::DualDepthPeeling(_)
                | Transparency::KBuffer(_)
        );
        if scene.transmits() && (self.deep || !tints) {
            let how = match self.deep {
                true => "deep pictures have one alpha a sample",
                false => "abuffer, depth-peeling, dual-depth-peeling, kbuffer and adaptive show it",
            };
            unshown.push(format!("light that passes through materials is not tinted by them: {how}"));
        }
        let averages = matches!(
            transparency,
            Transparency::Weighted(_)
                | Transparency::KBuffer(_)
                | Transparency::Moments(_)
                | Transparency::Stochastic(_)
        );
        let adds = scene.draws.draws().iter().any(|draw| scene.materials[draw.material].alpha_mode == AlphaMode::Add);
        if averages && adds {
            let name = transparency.name();
            unshown.push(format!("materials that only add light are not shown right: {name} averages layers by alpha"));
        }
        unshown
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
        let adaptive;
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
            Transparency::Adaptive(technique) => {
                adaptive = AdaptiveLists { adaptive: *technique, exponent: 4, memory: self.layer_memory };
                &adaptive
            }
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
        // Deep pictures have one alpha a sample.
        let tinted = blended.scene.transmits() && !self.deep;
        let format = match self.precision {
            Precision::Float if tinted => NodeFormat::FloatTinted,
            Precision::Float => NodeFormat::Float,
            Precision::Compact if tinted => NodeFormat::CompactTinted,
            Precision::Compact if blended.triangles() > COMPACT_TRIANGLES => NodeFormat::Half,
            Precision::Compact => NodeFormat::Compact,
        };
        // Up to a million cd/m²: highlights of the sun are beyond what nodes hold as they are.
        let bands = if self.deep { 1 } else { self.layer_bands };
        let layers = self.layers.numbered("abuffer");
        let samples = if self.deep { 1 } else { self.abuffer_samples };
        let of_samples = (samples != 1).then(|| DepthPrepass.record_samples(graph, blended.scene, &self.view, samples));
        let depth = of_samples.as_ref().unwrap_or(depth);
        let memory = self.layer_memory;
        let abuffer = ABuffer { format, exponent: 4, memory, bands, layers, samples, ..ABuffer::default() };
        let Composited { color, count, front, layers, nodes, report, .. } =
            abuffer.record(graph, &self.view, depth, blended, color);
        if let Some(nodes) = nodes.filter(|_| self.deep) {
            graph.capture(Deep::COUNT, &count);
            graph.capture(Deep::NODES, &nodes);
        }
        (color, TransparentLayers { made_by: abuffer, count, front, nearest: layers, report })
    }
}

/// What the A-buffer knows besides the colour.
struct TransparentLayers {
    made_by: ABuffer,
    count: ImageHandle,
    front: ImageHandle,
    nearest: Vec<NearestLayer>,
    report: BufferHandle,
}

//! The layers a frame can leave: which channels of which image go under which name.

use super::shadows::Shadows;
use super::{Surfaces, TransparentLayers};
use crate::graph::{Graph, ImageHandle};
use crate::scene::GpuScene;
use crate::techniques::transparency::abuffer::ABuffer;

/// Name of the capture that says what the A-buffer could not hold: a `blocks::ABufferReport`.
pub const ABUFFER_REPORT: &str = "abuffer.report";

/// Captures that [`crate::capture::DeepPicture`] is made of.
#[derive(Clone, Copy, Debug)]
pub struct Deep {
    /// Which A-buffer left the nodes; none where nothing blends.
    pub abuffer: Option<ABuffer>,
}

impl Deep {
    /// Colour of the opaque surfaces, R32G32B32A32 float.
    pub const OPAQUE: &str = "deep.opaque";
    /// Their positions, as [`crate::techniques::surface::position`] has them.
    pub const POSITION: &str = "deep.position";
    /// Blended layers of each pixel, R32 float.
    pub const COUNT: &str = "deep.count";
    /// Their nodes, R32G32B32A32 uint.
    pub const NODES: &str = "deep.nodes";
}

/// Most layers `abuffer.0`, `abuffer.1`, … that a frame leaves.
pub const MOST_NUMBERED: u32 = 256;

/// Which layers are wanted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Selection {
    /// Every layer.
    #[default]
    All,
    /// Layers of these names, or whose names begin with one of these and a dot. The picture itself is `color`.
    Only(Vec<String>),
}

impl Selection {
    /// Whether a layer is wanted.
    pub fn wants(&self, name: &str) -> bool {
        match self {
            Self::All => true,
            Self::Only(names) => names.iter().any(|wanted| {
                name.strip_prefix(wanted.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
            }),
        }
    }

    /// How many of the things that are numbered from 0, `prefix.0`, `prefix.1`, …, a selection by name asks for: as many
    /// as there are up to the greatest number. All layers do not ask for any.
    pub(super) fn numbered(&self, prefix: &str) -> u32 {
        let Self::Only(names) = self else { return 0 };
        let number = |name: &String| {
            let number = name.strip_prefix(prefix)?.strip_prefix('.')?.split('.').next()?;
            number.parse().ok().filter(|&number: &u32| number < MOST_NUMBERED)
        };
        names.iter().filter_map(number).max().map_or(0, |most| most + 1)
    }
}

/// One captured layer: some channels of one layer of one captured image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// `color`, `Z`, `N`, `shadow.sun`, …
    pub name: String,
    /// Full channel names, each with its component (0 to 3) in the image.
    pub channels: Vec<(String, usize)>,
    /// How samples are stored.
    pub samples: Samples,
    /// Where they come from.
    pub source: Source,
    /// Whether it has a size of its own and so is no layer of the picture: a shadow map.
    pub own_part: bool,
}

/// How a layer's samples are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// Half-floats, or 32-bit floats where wanted.
    Color,
    /// Always 32-bit floats: depth, position.
    Float,
    /// 32-bit unsigned integers.
    Uint,
}

/// A captured image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Name given to [`Graph::capture`].
    pub capture: String,
    /// Array layer.
    pub layer: u32,
}

/// Layers marked so far.
pub(super) struct Captured<'s> {
    selection: &'s Selection,
    pub(super) layers: Vec<Layer>,
}

impl<'s> Captured<'s> {
    pub(super) fn new(selection: &'s Selection) -> Self {
        Self { selection, layers: Vec::new() }
    }

    /// Layers of the camera.
    pub(super) fn frame(
        &mut self,
        graph: &mut Graph,
        color: &ImageHandle,
        direct: &ImageHandle,
        position: &ImageHandle,
        surfaces: &Surfaces,
    ) {
        use Samples::{Color, Float, Uint};
        let rgb = ["R", "G", "B"];
        let xyz = ["X", "Y", "Z"];
        let named = |name: &str, suffixes: &[&str]| {
            suffixes.iter().enumerate().map(|(i, suffix)| (format!("{name}.{suffix}"), i)).collect::<Vec<_>>()
        };
        let plain = |names: &[&str]| names.iter().enumerate().map(|(i, n)| (n.to_string(), i)).collect::<Vec<_>>();
        let one = |name: &str, component| vec![(name.to_string(), component)];
        self.image(graph, "color", plain(&["R", "G", "B", "A"]), Color, "color", color);
        self.image(graph, "Z", one("Z", 3), Float, "position", position);
        self.image(graph, "P", named("P", &xyz), Float, "position", position);
        self.image(graph, "N", named("N", &xyz), Color, "normal", &surfaces.normal);
        self.image(graph, "albedo", named("albedo", &rgb), Color, "albedo", &surfaces.albedo);
        self.image(graph, "occlusion", one("occlusion", 3), Color, "albedo", &surfaces.albedo);
        self.image(graph, "roughness", one("roughness", 0), Color, "material", &surfaces.material);
        self.image(graph, "metallic", one("metallic", 1), Color, "material", &surfaces.material);
        self.image(graph, "emissive", named("emissive", &rgb), Color, "emissive", &surfaces.emissive);
        self.image(graph, "direct", named("direct", &rgb), Color, "direct", direct);
        for (component, name) in ["id.object", "id.primitive", "id.material"].into_iter().enumerate() {
            self.image(graph, name, one(name, component), Uint, "ids", &surfaces.ids);
        }
    }

    /// Layers of the A-buffer: of the nearest ones, those that are asked for. Its report goes with the picture.
    pub(super) fn abuffer(&mut self, graph: &mut Graph, layers: &TransparentLayers) {
        let one = |name: &str| vec![(name.to_string(), 0)];
        self.image(graph, "abuffer.count", one("abuffer.count"), Samples::Float, "abuffer.count", &layers.count);
        self.image(graph, "abuffer.front.Z", one("abuffer.front.Z"), Samples::Float, "abuffer.front", &layers.front);
        for (index, nearest) in layers.nearest.iter().enumerate() {
            let name = format!("abuffer.{index}");
            let channels = ["R", "G", "B", "A"].iter().enumerate().map(|(i, c)| (format!("{name}.{c}"), i)).collect();
            self.image(graph, &name, channels, Samples::Color, &name, &nearest.color);
            let name = format!("{name}.Z");
            self.image(graph, &name, one(&name), Samples::Float, &name, &nearest.distance);
        }
        if self.layers.iter().any(|layer| layer.name == "color" || layer.name.starts_with("abuffer.")) {
            graph.capture(ABUFFER_REPORT, &layers.report);
        }
    }

    /// Ambient occlusion.
    pub(super) fn occlusion(&mut self, graph: &mut Graph, open: &ImageHandle) {
        let name = "ambient_occlusion";
        self.image(graph, name, vec![(name.into(), 0)], Samples::Color, name, open);
    }

    /// Layers of the lights.
    pub(super) fn shadows(&mut self, graph: &mut Graph, scene: &GpuScene, shadows: &Shadows) {
        for (light, shadow) in scene.lights.iter().zip(&shadows.of_lights) {
            let (Some(shadow), Some(masks)) = (shadow, &shadows.masks) else { continue };
            let name = format!("shadow.{}", light.name);
            let channels = vec![(name.clone(), 0)];
            self.layer(graph, &name, channels, Samples::Color, ("masks", shadow.mask), masks, false);
        }
        if let Some(deep) = &shadows.deep {
            for (layer, &light) in (0..).zip(&shadows.deep_lights) {
                let name = format!("transmittance.{}", scene.lights[light].name);
                let channels = ["R", "G", "B"].iter().enumerate().map(|(i, c)| (format!("{name}.{c}"), i)).collect();
                self.layer(graph, &name, channels, Samples::Color, ("deep.masks", layer), &deep.masks, false);
            }
        }
        if let Some(sun) = &shadows.sun {
            let channels = vec![("cascade.index".into(), 0)];
            self.image(graph, "cascade.index", channels, Samples::Color, "cascade.index", &sun.index);
            for layer in 0..sun.map.shape().layers {
                let name = format!("map.cascade.{layer}");
                let channels = vec![("Z".into(), 0)];
                self.layer(graph, &name, channels, Samples::Float, ("map.cascade", layer), &sun.map, true);
            }
        }
        if let Some(spots) = &shadows.spots {
            let spot_lights = scene.lights.iter().zip(&shadows.of_lights).filter_map(|(light, shadow)| {
                let shadow = shadow.filter(|_| crate::techniques::shadow::spot::Spot::serves(light))?;
                Some((light, shadow.index?))
            });
            for (light, index) in spot_lights {
                let name = format!("map.{}", light.name);
                let channels = vec![("Z".into(), 0)];
                self.layer(graph, &name, channels, Samples::Float, ("map.spot", index), &spots.maps, true);
            }
        }
    }

    fn image(
        &mut self,
        graph: &mut Graph,
        name: &str,
        channels: Vec<(String, usize)>,
        samples: Samples,
        capture: &str,
        image: &ImageHandle,
    ) {
        self.layer(graph, name, channels, samples, (capture, 0), image, false);
    }

    #[allow(clippy::too_many_arguments)]
    fn layer(
        &mut self,
        graph: &mut Graph,
        name: &str,
        channels: Vec<(String, usize)>,
        samples: Samples,
        (capture, layer): (&str, u32),
        image: &ImageHandle,
        own_part: bool,
    ) {
        if !self.selection.wants(name) {
            return;
        }
        if !self.layers.iter().any(|known| known.source.capture == capture) {
            graph.capture(capture, image);
        }
        let source = Source { capture: capture.into(), layer };
        self.layers.push(Layer { name: name.into(), channels, samples, source, own_part });
    }
}

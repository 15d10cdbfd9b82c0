//! From what a frame left on the device to what goes into files.

use serde::Serialize;

use super::png::BLOCK;
use super::{Capture, Channel, Content, HalfReport, Metadata, Part, SampleKind, Samples, Texels};
use crate::frame::{Frame, Layer, Samples as Stored, Source};
use crate::gpu::Caps;
use crate::graph::{self, Executed};
use crate::parallel;
use crate::scene::{Camera, Scene, View};
use crate::{Error, Result};

/// Layers of radiance: exposure applies to them.
const RADIANCE: [&str; 3] = ["color", "direct", "emissive"];

/// What a captured frame is to say of itself, and how it is stored.
pub struct FrameCapture<'a, S> {
    /// For the names of ids.
    pub scene: &'a Scene,
    /// Whose picture it is.
    pub camera: &'a Camera,
    /// The same with the picture's size.
    pub view: &'a View,
    /// Which device made it.
    pub caps: &'a Caps,
    /// How it was made; becomes the JSON attribute `shadowgraph/settings`.
    pub settings: &'a S,
    /// Whether colours are stored as 32-bit floats; half-floats otherwise.
    pub float: bool,
    /// Factor on radiance, recorded in the header.
    pub exposure: f32,
    /// Whether pass times, which differ from run to run, are left out.
    pub reproducible: bool,
}

/// A captured frame.
pub struct CapturedFrame {
    /// For [`super::write_exr`].
    pub capture: Capture,
    /// Samples that half-floats could not hold, by channel: those that lost some.
    pub lost: Vec<(String, HalfReport)>,
}

impl<S: Serialize + Sync> FrameCapture<'_, S> {
    /// Reads the captured images and sorts them into parts: `frame` with all layers of the picture, and a part for each
    /// layer of another size.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the frame did not leave what it announced; [`Error::Vulkan`] where memory cannot be
    /// read.
    pub fn collect(&self, frame: &Frame, executed: &Executed) -> Result<CapturedFrame> {
        // 1. Take the images apart on all cores, each once, though several layers may lie in one.
        let images = images(frame);
        let fault = |index: usize| Error::invalid(format!("capture `{}`", images[index].0.capture), "cannot be read");
        let image = |index: usize| self.image(&images[index], executed.capture(&images[index].0.capture)?);
        let read = parallel::map(images.len(), image, fault)?;
        let mut parts = vec![Part { name: "frame".into(), size: self.view.size, ..Part::default() }];
        let mut lost = Vec::new();
        for image in read {
            parts[0].channels.extend(image.of_frame);
            parts.extend(image.parts);
            lost.extend(image.lost);
        }
        // 2. A selection of nothing but shadow maps leaves no frame.
        parts.retain(|part| !part.channels.is_empty());
        // 3. Say what it is.
        let metadata = self.metadata(frame, executed, &parts, &lost)?;
        Ok(CapturedFrame { capture: Capture { parts, metadata }, lost })
    }

    /// Parts of their own ([`FrameCapture::collect`]) whose images are among these, which a frame left before its end
    /// ([`crate::graph::Executor::execute_with`]).
    ///
    /// # Errors
    /// As `collect`.
    pub fn parts_of(&self, frame: &Frame, captures: &[graph::Capture]) -> Result<Vec<Part>> {
        let mut parts = Vec::new();
        for image in images(frame).iter().filter(|(_, layers)| layers.iter().all(|layer| layer.own_part)) {
            if let Some(capture) = captures.iter().find(|capture| capture.name == image.0.capture) {
                parts.extend(self.image(image, capture)?.parts);
            }
        }
        Ok(parts)
    }

    /// Layers of one image.
    fn image(&self, (source, layers): &(&Source, Vec<&Layer>), capture: &graph::Capture) -> Result<Image> {
        let mut image = Image::default();
        for layer in layers {
            let mut channels = Vec::with_capacity(layer.channels.len());
            let mut size = self.view.size;
            for (name, component) in &layer.channels {
                let texels = self.stored(layer, name, Texels::new(capture, source.layer, *component)?);
                let report = texels.losses()?;
                if report != HalfReport::default() {
                    image.lost.push((name.clone(), report));
                }
                size = texels.size();
                channels.push(Channel::new(name, Content::Texels(texels)));
            }
            if layer.own_part {
                image.parts.push(Part { name: layer.name.clone(), size, channels, ..Part::default() });
            } else if size == self.view.size {
                image.of_frame.extend(channels);
            } else {
                let why = format!("its size {size:?} is not the picture's");
                return Err(Error::invalid(format!("layer {}", layer.name), why));
            }
        }
        Ok(image)
    }

    /// Texels as the file is to have them.
    fn stored(&self, layer: &Layer, channel: &str, texels: Texels) -> Texels {
        // Alpha is no radiance.
        let exposed = self.exposure != 1.0 && channel != "A" && RADIANCE.contains(&layer.name.as_str());
        let texels = if exposed { texels.scaled(self.exposure) } else { texels };
        match layer.samples {
            Stored::Color if !self.float => texels.float_kind(SampleKind::F16),
            Stored::Color | Stored::Float => texels.float_kind(SampleKind::F32),
            Stored::Uint => texels,
        }
    }

    pub(super) fn metadata(
        &self,
        frame: &Frame,
        executed: &Executed,
        parts: &[Part],
        lost: &[(String, HalfReport)],
    ) -> Result<Metadata> {
        let mut metadata = Metadata::default();
        let driver = format!("{} {}", self.caps.driver, self.caps.driver_info);
        metadata.add_software(&self.caps.device, driver.trim());
        metadata.add_units(self.exposure);
        metadata.add_camera(self.view, &self.camera.projection);
        metadata.add_json("shadowgraph/settings", self.settings)?;
        let has = |name: &str| parts.iter().any(|part| part.channels.iter().any(|channel| channel.name == name));
        if has("id.object") {
            metadata.add_names("id.object", self.scene.objects.iter().map(|object| object.name.as_str()))?;
        }
        if has("id.material") {
            metadata.add_names("id.material", self.scene.materials.iter().map(|material| material.name.as_str()))?;
        }
        metadata.add_half_reports(lost.iter().map(|(name, report)| (name.as_str(), *report)))?;
        if !frame.warnings.is_empty() {
            metadata.add_json("shadowgraph/warnings", &frame.warnings)?;
        }
        if !self.reproducible {
            metadata.add_pass_times(executed.passes.iter().map(|pass| (pass.name.as_str(), pass.seconds * 1e3)))?;
        }
        Ok(metadata)
    }
}

/// Pixels of the captured picture for [`super::write_png`]: linear RGBA, premultiplied.
///
/// # Errors
/// [`Error::Invalid`] where the layer `color` was not captured; [`Error::Vulkan`] where memory cannot be read.
pub fn picture(frame: &Frame, executed: &Executed) -> Result<Vec<[f32; 4]>> {
    let Some(layer) = frame.layers.iter().find(|layer| layer.name == "color") else {
        return Err(Error::invalid("the picture", "the layer `color` was not captured"));
    };
    let capture = executed.capture(&layer.source.capture)?;
    let component = |component| Texels::new(capture, layer.source.layer, component);
    let components = [component(0)?, component(1)?, component(2)?, component(3)?];
    let count = components[0].len();
    let block = |index: usize| {
        let range = index * BLOCK..count.min((index + 1) * BLOCK);
        let plane = |component: usize| components[component].read(range.clone()).map(Samples::into_f32);
        let [red, green, blue, alpha] = [plane(0)?, plane(1)?, plane(2)?, plane(3)?];
        let pixels = red.iter().zip(&green).zip(&blue).zip(&alpha);
        Ok(pixels.map(|(((&red, &green), &blue), &alpha)| [red, green, blue, alpha]).collect::<Vec<_>>())
    };
    let fault = |_| Error::invalid("the picture", "its texels cannot be read");
    Ok(parallel::map(count.div_ceil(BLOCK), block, fault)?.concat())
}

/// What one image gives.
#[derive(Default)]
struct Image {
    of_frame: Vec<Channel>,
    parts: Vec<Part>,
    lost: Vec<(String, HalfReport)>,
}

/// Captured images, each with its layers, in the order of their first layers.
fn images(frame: &Frame) -> Vec<(&Source, Vec<&Layer>)> {
    let mut images: Vec<(&Source, Vec<&Layer>)> = Vec::new();
    for layer in &frame.layers {
        match images.iter_mut().find(|(source, _)| **source == layer.source) {
            Some((_, layers)) => layers.push(layer),
            None => images.push((&layer.source, vec![layer])),
        }
    }
    images
}

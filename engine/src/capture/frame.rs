//! From what a frame left on the device to what goes into files.

use std::collections::HashMap;

use serde::Serialize;

use super::{Capture, Channel, HalfReport, Metadata, Part, Samples, unpack};
use crate::frame::{Frame, Layer, Samples as Stored};
use crate::gpu::Caps;
use crate::graph::Executed;
use crate::graph::description::Shape;
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

impl<S: Serialize> FrameCapture<'_, S> {
    /// Reads the captured images and sorts them into parts: `frame` with all layers of the picture, and a part for each
    /// layer of another size.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the frame did not leave what it announced; [`Error::Vulkan`] where memory cannot be
    /// read.
    pub fn collect(&self, frame: &Frame, executed: &Executed) -> Result<CapturedFrame> {
        // 1. Take the images apart, each once, though several layers may lie in one.
        let mut images = Images { executed, planes: HashMap::new() };
        let mut parts = vec![Part { name: "frame".into(), size: self.view.size, ..Part::default() }];
        let mut lost = Vec::new();
        for layer in &frame.layers {
            let channels = self.channels(layer, images.planes(layer)?, &mut lost)?;
            if layer.own_part {
                parts.push(Part { name: layer.name.clone(), size: images.size(layer)?, channels, ..Part::default() });
            } else {
                parts[0].channels.extend(channels);
            }
        }
        // 2. A selection of nothing but shadow maps leaves no frame.
        parts.retain(|part| !part.channels.is_empty());
        // 3. Say what it is.
        let metadata = self.metadata(frame, executed, &parts, &lost)?;
        Ok(CapturedFrame { capture: Capture { parts, metadata }, lost })
    }

    fn channels(
        &self,
        layer: &Layer,
        planes: &[Samples],
        lost: &mut Vec<(String, HalfReport)>,
    ) -> Result<Vec<Channel>> {
        let narrow = layer.samples == Stored::Color && !self.float;
        let exposed = RADIANCE.contains(&layer.name.as_str()) && self.exposure != 1.0;
        let mut channels = Vec::with_capacity(layer.channels.len());
        for (name, component) in &layer.channels {
            let mut samples = planes.get(*component).cloned().ok_or_else(|| {
                Error::invalid(format!("channel {name}"), format!("its image has only {} components", planes.len()))
            })?;
            // Alpha is no radiance.
            if exposed && name != "A" {
                samples = samples.scaled(self.exposure);
            }
            if narrow {
                let report;
                (samples, report) = samples.into_half();
                if report != HalfReport::default() {
                    lost.push((name.clone(), report));
                }
            } else if layer.samples != Stored::Uint {
                samples = samples.into_float();
            }
            channels.push(Channel::new(name, samples));
        }
        Ok(channels)
    }

    fn metadata(
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
    let mut images = Images { executed, planes: HashMap::new() };
    let planes: Vec<Vec<f32>> = images.planes(layer)?.iter().map(|plane| plane.clone().into_f32()).collect();
    let [red, green, blue, alpha] = &planes[..] else {
        return Err(Error::invalid("the picture", format!("its image has {} components, not 4", planes.len())));
    };
    let pixels = red.iter().zip(green).zip(blue).zip(alpha);
    Ok(pixels.map(|(((&red, &green), &blue), &alpha)| [red, green, blue, alpha]).collect())
}

/// Images of a frame, taken apart on demand.
struct Images<'a> {
    executed: &'a Executed,
    planes: HashMap<(&'a str, u32), Vec<Samples>>,
}

impl<'a> Images<'a> {
    fn planes(&mut self, layer: &'a Layer) -> Result<&[Samples]> {
        let key = (layer.source.capture.as_str(), layer.source.layer);
        if !self.planes.contains_key(&key) {
            let capture = self.executed.capture(key.0)?;
            let Shape::Image(shape) = &capture.shape else {
                return Err(Error::invalid(format!("capture `{}`", key.0), "is a buffer, not an image"));
            };
            let planes = capture.layer(key.1, |texels| unpack(shape.format, texels))??;
            self.planes.insert(key, planes);
        }
        Ok(&self.planes[&key])
    }

    fn size(&self, layer: &Layer) -> Result<[u32; 2]> {
        match &self.executed.capture(&layer.source.capture)?.shape {
            Shape::Image(shape) => Ok([shape.extent[0], shape.extent[1]]),
            Shape::Buffer { .. } => Err(Error::invalid(format!("layer `{}`", layer.name), "is a buffer, not an image")),
        }
    }
}

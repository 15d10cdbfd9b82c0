//! Facts in a file's header. Standard OpenEXR attributes keep their names; our own begin with `shadowgraph/`.

use glam::{Mat4, Vec2, Vec3, Vec4};
use serde::Serialize;

use super::HalfReport;
use crate::scene::{Projection, View};
use crate::{Error, Result};

/// A value of a header attribute.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `string`: UTF-8.
    Text(String),
    /// `int`.
    I32(i32),
    /// `float`.
    F32(f32),
    /// `double`.
    F64(f64),
    /// `v2f`.
    Vec2(Vec2),
    /// `v3f`.
    Vec3(Vec3),
    /// `m44f`. OpenEXR multiplies row vectors from the left and stores rows; `glam` multiplies column vectors from
    /// the right and stores columns: the sixteen numbers are the same in the same order.
    Mat4(Mat4),
    /// `chromaticities`: x and y of red, green, blue and white.
    Chromaticities([Vec2; 4]),
}

/// Attributes in the order they are written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata(pub Vec<(String, Value)>);

impl Metadata {
    /// Adds an attribute. [`super::write_exr`] refuses names that occur twice.
    pub fn add(&mut self, name: impl Into<String>, value: Value) {
        self.0.push((name.into(), value));
    }

    /// Adds a text.
    pub fn add_text(&mut self, name: impl Into<String>, text: impl Into<String>) {
        self.add(name, Value::Text(text.into()));
    }

    /// Adds a value as JSON text.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the value cannot be told in JSON.
    pub fn add_json(&mut self, name: &str, value: &impl Serialize) -> Result<()> {
        let json =
            serde_json::to_string(value).map_err(|e| Error::invalid(format!("attribute {name}"), e.to_string()))?;
        self.add_text(name, json);
        Ok(())
    }

    /// Value of an attribute.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.iter().find(|(n, _)| n == name).map(|(_, value)| value)
    }

    /// What colours and lengths mean: `chromaticities` of Rec. 709 and `shadowgraph/units`. Colours are linear,
    /// premultiplied with alpha, and multiplied with `shadowgraph/exposure`.
    pub fn add_units(&mut self, exposure: f32) {
        // Rec. ITU-R BT.709-6, item 1.3.
        let rec709 = [Vec2::new(0.64, 0.33), Vec2::new(0.30, 0.60), Vec2::new(0.15, 0.06), Vec2::new(0.3127, 0.3290)];
        self.add("chromaticities", Value::Chromaticities(rec709));
        self.add("shadowgraph/exposure", Value::F32(exposure));
        self.add_text("shadowgraph/units", "metres; radians; colours linear Rec. 709, premultiplied, times exposure");
    }

    /// Engine and driver: `software`, `shadowgraph/version`, `shadowgraph/device`, `shadowgraph/driver`.
    pub fn add_software(&mut self, device: &str, driver: &str) {
        let version = env!("CARGO_PKG_VERSION");
        self.add_text("software", format!("Shadowgraph {version}"));
        self.add_text("shadowgraph/version", version);
        self.add_text("shadowgraph/device", device);
        self.add_text("shadowgraph/driver", driver);
    }

    /// The camera. Standard: `worldToCamera` (camera space as OpenEXR has it: x right, y up, z forward) and
    /// `worldToNDC` ((0, 0) upper left, (1, 1) lower right, after division by w). Our own: `shadowgraph/viewFromWorld`
    /// and `shadowgraph/clipFromView` (view space x right, y up, −z forward; Vulkan clip space with y down and depth
    /// 1 at the near plane, 0 at infinity), `shadowgraph/eye`, and the lens.
    pub fn add_camera(&mut self, view: &View, lens: &Projection) {
        let camera_from_view = Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0));
        let ndc_from_clip = Mat4::from_cols(
            Vec4::new(0.5, 0.0, 0.0, 0.0),
            Vec4::new(0.0, 0.5, 0.0, 0.0),
            Vec4::new(0.0, 0.0, 1.0, 0.0),
            Vec4::new(0.5, 0.5, 0.0, 1.0),
        );
        self.add("worldToCamera", Value::Mat4(camera_from_view * view.view_from_world));
        self.add("worldToNDC", Value::Mat4(ndc_from_clip * view.clip_from_world()));
        self.add("shadowgraph/viewFromWorld", Value::Mat4(view.view_from_world));
        self.add("shadowgraph/clipFromView", Value::Mat4(view.clip_from_view));
        self.add("shadowgraph/eye", Value::Vec3(view.eye()));
        match *lens {
            Projection::Perspective { fov_y, near, far } => {
                self.add("shadowgraph/fovY", Value::F32(fov_y));
                self.add("shadowgraph/near", Value::F32(near));
                self.add("shadowgraph/far", Value::F32(far.unwrap_or(f32::INFINITY)));
            }
            Projection::Orthographic { half_height, near, far } => {
                self.add("shadowgraph/halfHeight", Value::F32(half_height));
                self.add("shadowgraph/near", Value::F32(near));
                self.add("shadowgraph/far", Value::F32(far));
            }
        }
    }

    /// Names of ids, as `shadowgraph/names/<channel>`: a JSON array whose element *i* is the name of id *i*; element 0
    /// is `null`, the background.
    ///
    /// # Errors
    /// None in practice: names are valid Unicode.
    pub fn add_names<'a>(&mut self, channel: &str, names: impl IntoIterator<Item = &'a str>) -> Result<()> {
        let table: Vec<Option<&str>> = std::iter::once(None).chain(names.into_iter().map(Some)).collect();
        self.add_json(&format!("shadowgraph/names/{channel}"), &table)
    }

    /// Passes and what they took on the device, as `shadowgraph/passes`: a JSON array of `[name, milliseconds]`. Left
    /// out where a file is to be reproducible: times differ from run to run.
    ///
    /// # Errors
    /// None in practice: a time that is no number becomes `null`.
    pub fn add_pass_times<'a>(&mut self, passes: impl IntoIterator<Item = (&'a str, f64)>) -> Result<()> {
        let passes: Vec<(&str, f64)> = passes.into_iter().collect();
        self.add_json("shadowgraph/passes", &passes)
    }

    /// What narrowing to half-floats changed, as `shadowgraph/clamped`: a JSON object from channel to
    /// `[clamped, not a number]` samples, with the channels that lost something. Always written: an empty object says
    /// that nothing was lost.
    ///
    /// # Errors
    /// None in practice.
    pub fn add_half_reports<'a>(&mut self, reports: impl IntoIterator<Item = (&'a str, HalfReport)>) -> Result<()> {
        let lost: serde_json::Map<_, _> = reports
            .into_iter()
            .filter(|(_, report)| *report != HalfReport::default())
            .map(|(channel, report)| (channel.into(), serde_json::json!([report.clamped, report.not_a_number])))
            .collect();
        self.add_json("shadowgraph/clamped", &lost)
    }
}

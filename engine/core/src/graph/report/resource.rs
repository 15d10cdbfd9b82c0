//! Resources, in words.

use serde::Serialize;

use crate::graph::description::{Description, Origin, Shape};
use crate::graph::plan::Plan;

/// A resource that a step uses.
#[derive(Clone, Debug, Serialize)]
pub struct ResourceReport {
    /// Name.
    pub name: String,
    /// `image` or `buffer`.
    pub kind: &'static str,
    /// Size and format, in words.
    pub shape: String,
    /// `transient`, `imported` or `kept`.
    pub origin: &'static str,
}

/// The resources that the plan's steps use.
pub(super) fn resources(description: &Description, plan: &Plan) -> Vec<ResourceReport> {
    let used = description.resources.iter().zip(&plan.usages).filter(|(_, usage)| usage.is_some());
    let report = |(resource, _): (&crate::graph::description::Resource, _)| {
        let (kind, shape) = shape(&resource.shape);
        let origin = match resource.origin {
            Origin::Transient => "transient",
            Origin::Imported { .. } => "imported",
            Origin::Kept { .. } => "kept",
        };
        ResourceReport { name: resource.name.to_string(), kind, shape, origin }
    };
    used.map(report).collect()
}

fn shape(shape: &Shape) -> (&'static str, String) {
    let image = match shape {
        Shape::Buffer { size } => return ("buffer", format!("{size} bytes")),
        Shape::Image(image) => image,
    };
    let [width, height, depth] = image.extent;
    let mut words = format!("{width} × {height}");
    if depth > 1 {
        words += &format!(" × {depth}");
    }
    words += &format!(", {:?}", image.format);
    for (count, what) in [(image.mips, "mips"), (image.layers, "layers"), (image.samples, "samples")] {
        if count > 1 {
            words += &format!(", {count} {what}");
        }
    }
    ("image", words)
}

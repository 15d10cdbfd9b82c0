//! The nearest layers of each pixel, as images.

use std::mem::offset_of;

use ash::vk;

use super::{ABuffer, Built};
use crate::graph::{Graph, ImageHandle, ImageShape};
use crate::scene::{View, ViewSet};
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::abuffer::layer_comp;

/// One layer of each pixel.
pub struct NearestLayer {
    /// What it adds, premultiplied, and its alpha (of tinted layers the channels' mean), R32G32B32A32 float; 0 where the
    /// pixel has not so many.
    pub color: ImageHandle,
    /// Distance along the view axis, metres, R32 float; infinite where there is none.
    pub distance: ImageHandle,
}

/// The layers, and where each pixel stands.
pub(super) struct Nearest {
    pub(super) layers: Vec<NearestLayer>,
    /// Depth and key of the last layer.
    last: Option<ImageHandle>,
}

impl Nearest {
    /// So many, empty so far.
    pub(super) fn new(graph: &mut Graph, count: u32, size: [u32; 2]) -> Self {
        let mut cleared = |name: String, format, value| {
            let image = graph.image(name.clone(), ImageShape::new_2d(format, size));
            graph.clear(format!("{name}.begin"), image, value)
        };
        let nothing = vk::ClearColorValue::default();
        let far = vk::ClearColorValue { float32: [f32::INFINITY; 4] };
        let layer = |index| NearestLayer {
            color: cleared(format!("abuffer.{index}"), vk::Format::R32G32B32A32_SFLOAT, nothing),
            distance: cleared(format!("abuffer.{index}.Z"), vk::Format::R32_SFLOAT, far),
        };
        let layers = (0..count).map(layer).collect();
        // Before all layers.
        let before = vk::ClearColorValue { uint32: [u32::MAX; 4] };
        let last = (count > 0).then(|| cleared("abuffer.last".into(), vk::Format::R32G32_UINT, before));
        Self { layers, last }
    }
}

impl ABuffer {
    /// Finds the layers of a picture or a band, one after the other: by looking through all nodes each time, which takes
    /// no memory and needs no sorting.
    pub(super) fn nearest(&self, graph: &mut Graph, view: &View, built: &Built, nearest: Nearest) -> Nearest {
        let Nearest { layers, mut last } = nearest;
        let next = |(index, NearestLayer { color, distance })| {
            let mut pass = graph.compute(format!("{}.layer.{index}", built.name), &layer_comp::SHADER);
            built.bind(&mut pass, self);
            pass.uniform(layer_comp::VIEWS, &ViewSet::from(*view).block())
                .specialize(layer_comp::NODE_UNIT, self.unit());
            last = last.take().map(|last| pass.write(layer_comp::LAST, last));
            let color = pass.write(layer_comp::COLOR, color);
            let distance = pass.write(layer_comp::DISTANCE_IMAGE, distance);
            pass.dispatch_indirect(&built.scanned.totals, offset_of!(blocks::Totals, work_groups) as u64);
            NearestLayer { color, distance }
        };
        let layers = layers.into_iter().enumerate().map(next).collect();
        Nearest { layers, last }
    }
}

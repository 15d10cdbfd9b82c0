//! Deep pictures: all layers of each pixel, from the A-buffer and the first opaque surface.

use serde::Serialize;

use super::{FrameCapture, Metadata};
use crate::frame::{Deep, Frame};
use crate::graph::Executed;
use crate::{Error, Result};

/// A picture with any number of samples a pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeepPicture {
    /// Width and height in pixels, neither of them 0.
    pub size: [u32; 2],
    /// Samples of each pixel, rows from the top.
    pub counts: Vec<u32>,
    /// Those of the first pixel, nearest first, then those of the next.
    pub samples: Vec<DeepSample>,
    /// Facts about the frame.
    pub metadata: Metadata,
}

/// A surface that a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeepSample {
    /// Distance along the view axis, metres.
    pub depth: f32,
    /// Linear, premultiplied.
    pub color: [f32; 4],
}

impl<S: Serialize + Sync> FrameCapture<'_, S> {
    /// Reads a frame recorded with [`crate::frame::FrameSettings::deep`]: layers of blended surfaces, then the opaque one
    /// behind them with alpha 1. A pixel that shows nothing has no sample.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the frame was not recorded so; [`Error::Vulkan`] where memory cannot be read.
    pub fn collect_deep(&self, frame: &Frame, executed: &Executed) -> Result<DeepPicture> {
        // 1. What the device left: blended layers pixel by pixel, and the opaque surface.
        let Some(deep) = frame.deep else {
            return Err(Error::invalid("the deep picture", "the frame was recorded without `FrameSettings::deep`"));
        };
        let opaque: Vec<[f32; 4]> = executed.capture(Deep::OPAQUE)?.texels()?;
        let position: Vec<[f32; 4]> = executed.capture(Deep::POSITION)?.texels()?;
        let view = self.view;
        let pixels = view.size[0] as usize * view.size[1] as usize;
        let (counts, mut nodes) = match deep.abuffer {
            Some(abuffer) => {
                let counts: Vec<f32> = executed.capture(Deep::COUNT)?.texels()?;
                let texels = executed.capture(Deep::NODES)?.texels::<[u32; 4]>()?;
                (counts.into_iter().map(|count| count as usize).collect(), abuffer.unpack(&texels)?)
            }
            None => (vec![0; pixels], Vec::new()),
        };
        let blended: usize = counts.iter().sum();
        if [opaque.len(), position.len(), counts.len()] != [pixels; 3] || nodes.len() < blended {
            return Err(Error::invalid("the deep picture", "the frame's layers do not have its size"));
        }
        // 2. Each pixel's samples, by depth; what ties is told apart as on the device.
        let [a, b, c, e] = view.distance_row();
        let distance = |depth: f32| (a * depth + b) / (c * depth + e);
        let metadata = self.metadata(frame, executed, &[], &[])?;
        let mut picture = DeepPicture { size: view.size, metadata, ..DeepPicture::default() };
        picture.counts.reserve(pixels);
        picture.samples.reserve(blended + pixels);
        let mut rest = &mut nodes[..];
        for ((count, opaque), position) in counts.into_iter().zip(opaque).zip(position) {
            let (own, after) = std::mem::take(&mut rest).split_at_mut(count);
            rest = after;
            own.sort_unstable_by(|a, b| b.depth.total_cmp(&a.depth).then(b.key.cmp(&a.key)));
            let sample = |depth: f32, [red, green, blue, alpha]: [f32; 4]| {
                let [red, green, blue] = [red, green, blue].map(|radiance| radiance * self.exposure);
                DeepSample { depth, color: [red, green, blue, alpha] }
            };
            picture.samples.extend(own.iter().map(|node| sample(distance(node.depth), node.color)));
            let [.., depth] = position;
            if depth.is_finite() {
                picture.samples.push(sample(depth, opaque));
            }
            picture.counts.push((count + usize::from(depth.is_finite())) as u32);
        }
        Ok(picture)
    }
}

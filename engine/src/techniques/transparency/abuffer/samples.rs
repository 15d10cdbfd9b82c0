//! Several samples a pixel.

use ash::vk;

use super::NAME;
use crate::gpu::{Caps, Feature};
use crate::graph::{Graph, ImageHandle, ImageShape};
use crate::shader::generated::transparency::abuffer::{count_multisampled_frag, counts_multisampled_comp};
use crate::techniques::transparency::fragments::{Fragments, Step, fragment_pass};

/// Refuses what the device cannot rasterise, and opaque depth of other samples.
pub(super) fn check(graph: &mut Graph, samples: u32, depth: &ImageHandle) {
    let of_depth = depth.shape().samples;
    if of_depth != samples {
        let wrong = format!("has {of_depth} samples a pixel");
        graph.refuse(NAME, "opaque depth", wrong, format!("{samples}, as the layers are to have"));
    }
    let (caps, counts) = (graph.caps(), sample_counts(graph.caps()));
    if samples != 1 && !counts.contains(&samples) {
        let needed = Feature::PostDepthCoverage;
        let allowed = match caps.has(needed) {
            true => format!("1 or one of {counts:?} on {}", caps.title()),
            false => format!("1 on {}, which lacks {}", caps.title(), needed.describe()),
        };
        graph.refuse(NAME, "samples", format!("are {samples} a pixel"), allowed);
    }
}

/// Numbers of samples a pixel, above 1, that an A-buffer can have on a device ([`super::ABuffer::samples`]).
pub fn sample_counts(caps: &Caps) -> Vec<u32> {
    let has = if caps.has(Feature::PostDepthCoverage) { caps.limits.framebuffer_sample_counts } else { 0 };
    [2, 4, 8].into_iter().filter(|samples| has & samples != 0).collect()
}

/// Fragments of each pixel that are seen at any of its samples: R32 float.
pub(super) fn count<'f>(graph: &mut Graph<'f>, depth: &ImageHandle, fragments: &dyn Fragments<'f>) -> ImageHandle {
    // Samples of an attachment would each be counted by blending.
    let counted = graph.image("abuffer.fragments", ImageShape::new_2d(vk::Format::R32_UINT, depth.size()));
    let counted = graph.clear("abuffer.fragments.begin", counted, vk::ClearColorValue::default());
    let step = Step::CountMultisampled;
    let mut pass = fragment_pass(graph, "abuffer.fragments", depth, (fragments, step), |program| program);
    let counted = pass.write(count_multisampled_frag::FRAGMENT_COUNTS, counted);
    pass.draw(fragments.draw(step));

    let count = graph.image("abuffer.count", ImageShape::new_2d(vk::Format::R32_SFLOAT, depth.size()));
    let mut pass = graph.compute("abuffer.count", &counts_multisampled_comp::SHADER);
    pass.read(counts_multisampled_comp::FRAGMENT_COUNTS, &counted);
    let count = pass.write(counts_multisampled_comp::COUNTS, count);
    pass.dispatch([depth.size()[0], depth.size()[1], 1]);
    count
}

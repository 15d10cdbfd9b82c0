//! The descriptor sets of passes.

use ash::vk;

use super::resources::Resources;
use crate::gpu::{Buffer, DescriptorCache, Gpu, Image, Pipeline, Points, SamplerInfo, ViewInfo};
use crate::graph::builder::External;
use crate::graph::description::Range;
use crate::graph::name::Name;
use crate::graph::pass::{Bound, What, Work};
use crate::graph::record::Ready;
use crate::shader::{Binding, BindingKind};
use crate::{Error, Result};

/// What sets are made from.
pub(super) struct Sets<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) memory: &'a Resources,
    /// Behind the bindings of all passes.
    pub(super) bound: &'a [Bound],
    /// Bytes of the frame.
    pub(super) arena: Option<&'a Buffer>,
}

impl<'a> Sets<'a> {
    /// The next pipelines, a pass's, each with its set 0.
    pub(super) fn ready(
        &self,
        pass: &Name,
        work: &Work,
        pipelines: &mut impl Iterator<Item = Pipeline>,
        cache: &mut DescriptorCache,
        ready: &mut Vec<Ready>,
    ) -> Result<()> {
        let (count, bound) = match work {
            Work::Compute { bound, .. } => (1, bound),
            Work::Raster(raster) => (raster.programs.len(), &raster.bound),
            Work::Fill { .. } | Work::Clear { .. } | Work::ClearDepth { .. } | Work::Zero(_) => return Ok(()),
        };
        let bound = &self.bound[bound.clone()];
        for pipeline in pipelines.take(count) {
            let wanted = pipeline.bindings().iter().map(|wanted| &wanted.binding).filter(|binding| binding.set == 0);
            let found = wanted.filter_map(|wanted| {
                let found = bound.iter().find(|bound| bound.binding == wanted.binding)?;
                Some(self.points(pass, found, wanted).map(|points| (wanted.binding, points)))
            });
            let set = cache.set(&pipeline, 0, found)?;
            ready.push(Ready { pipeline, set });
        }
        Ok(())
    }

    /// What lies behind a binding.
    fn points(&self, pass: &Name, bound: &'a Bound, binding: &Binding) -> Result<Points<'a>> {
        let missing = || Error::invalid(format!("`{}` of pass `{pass}`", binding.name), "has no memory behind it");
        let kind = binding.image.map_or(vk::ImageViewType::TYPE_2D, |image| image.view);
        match &bound.what {
            What::Data(data) => {
                let buffer = self.arena.ok_or_else(missing)?;
                Ok(Points::Buffer { buffer, offset: data.offset, size: data.size })
            }
            What::Buffer(buffer) => Ok(Points::buffer(buffer)),
            What::Image(image, sampler) => {
                let layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
                self.image(binding, image, image.whole().kind(kind), layout, sampler)
            }
            What::Resource { resource, range, layout, sampler } => {
                match (self.memory.0[resource.0 as usize].as_ref().ok_or_else(missing)?, *range) {
                    (External::Image(image), Range::Image { aspects, mips, layers }) => {
                        // A sampled depth-stencil image shows its depth.
                        let depth = vk::ImageAspectFlags::DEPTH;
                        let aspects = if aspects.contains(depth) { depth } else { aspects };
                        let view = ViewInfo { kind, mips, layers, aspects, ..image.whole() };
                        let nearest = SamplerInfo::nearest();
                        self.image(binding, image, view, *layout, sampler.as_deref().unwrap_or(&nearest))
                    }
                    (External::Buffer(buffer), Range::Buffer([first, end])) => {
                        // A size that a checkpoint told may be less than the description's.
                        let size = end.min(buffer.size()).saturating_sub(first);
                        Ok(Points::Buffer { buffer, offset: first, size })
                    }
                    _ => Err(missing()),
                }
            }
        }
    }

    fn image(
        &self,
        binding: &Binding,
        image: &'a Image,
        view: ViewInfo,
        layout: vk::ImageLayout,
        sampler: &SamplerInfo,
    ) -> Result<Points<'a>> {
        let sampler = match binding.kind {
            BindingKind::CombinedImageSampler => Some(self.gpu.sampler(sampler)?),
            _ => None,
        };
        Ok(Points::Image { image, view, layout, sampler })
    }
}

//! Taking contents apart, so that the parts can be written in any order, and putting them together again.

use ash::vk;

use super::builder::Graph;
use super::description::{Range, Source};
use super::handle::{BufferHandle, ImageHandle};

impl Graph<'_> {
    /// Takes an image apart into its array layers, which can then be written in any order.
    pub fn split_layers(&mut self, image: ImageHandle) -> Vec<ImageHandle> {
        let [first, end] = image.layers();
        self.split_layer_blocks(image, &vec![1; (end - first) as usize])
    }

    /// Takes the first layers of an image apart into blocks of so many layers, which can then be written in any order.
    pub fn split_layer_blocks(&mut self, image: ImageHandle, counts: &[u32]) -> Vec<ImageHandle> {
        let Range::Image { aspects, mips, layers } = image.range else { return Vec::new() };
        let mut first = layers[0];
        let block = |&count: &u32| {
            let layers = [first, first + count];
            first += count;
            self.split(&image, Range::Image { aspects, mips, layers })
        };
        counts.iter().map(block).collect()
    }

    /// Takes an image apart into its mip levels, which can then be written in any order.
    pub fn split_mips(&mut self, image: ImageHandle) -> Vec<ImageHandle> {
        let Range::Image { aspects, mips, layers } = image.range else { return Vec::new() };
        let parts = mips[0]..mips[1];
        parts.map(|mip| self.split(&image, Range::Image { aspects, mips: [mip, mip + 1], layers })).collect()
    }

    /// Takes an image of depth and stencil apart into one and the other, in this order. Sampled as a whole, it shows its
    /// depth.
    pub fn split_aspects(&mut self, image: ImageHandle) -> Vec<ImageHandle> {
        let Range::Image { aspects, mips, layers } = image.range else { return Vec::new() };
        let all = [vk::ImageAspectFlags::COLOR, vk::ImageAspectFlags::DEPTH, vk::ImageAspectFlags::STENCIL];
        let parts = all.into_iter().filter(|&aspect| aspects.contains(aspect));
        parts.map(|aspects| self.split(&image, Range::Image { aspects, mips, layers })).collect()
    }

    /// Puts parts of one image together again. They cover a block of layers or of mips without a gap, or all aspects.
    pub fn join(&mut self, parts: Vec<ImageHandle>) -> Option<ImageHandle> {
        let range = parts.iter().map(|part| part.range).reduce(Range::hull)?;
        let of = parts.iter().map(|part| part.version).collect();
        let first = parts.into_iter().next()?;
        let version = self.version(first.resource, range, Source::Join { of });
        Some(ImageHandle { version, range, ..first })
    }

    /// Lets `count` passes write atomically to one buffer in any order; [`Graph::join_appended`] ends that.
    pub fn append(&mut self, buffer: BufferHandle, count: usize) -> Vec<BufferHandle> {
        let of = buffer.version;
        let fork = |graph: &mut Self| {
            let version = graph.version(buffer.resource, buffer.range, Source::Fork { of });
            BufferHandle { version, ..buffer }
        };
        (0..count).map(|_| fork(self)).collect()
    }

    /// The buffer after all of its unordered writers.
    pub fn join_appended(&mut self, forks: Vec<BufferHandle>) -> Option<BufferHandle> {
        let of = forks.iter().map(|fork| fork.version).collect();
        let first = forks.into_iter().next()?;
        let version = self.version(first.resource, first.range, Source::Join { of });
        Some(BufferHandle { version, ..first })
    }

    fn split(&mut self, whole: &ImageHandle, range: Range) -> ImageHandle {
        let version = self.version(whole.resource, range, Source::Split { of: whole.version });
        ImageHandle { version, range, ..*whole }
    }
}

//! Typed handles to versions of resources.
//!
//! A handle is neither `Clone` nor `Copy`: a pass that writes takes it and gives the next version back, so a stale
//! version cannot be read by mistake.

use ash::vk;

use super::description::{ImageShape, Range, ResourceId, VersionId};

/// Contents of (a part of) an image at one point of the frame.
#[derive(Debug)]
#[must_use = "a version nobody reads is culled"]
pub struct ImageHandle {
    pub(super) graph: u64,
    pub(super) resource: ResourceId,
    pub(super) version: VersionId,
    pub(super) shape: ImageShape,
    pub(super) range: Range,
}

impl ImageHandle {
    /// Size and format of the whole image.
    pub fn shape(&self) -> &ImageShape {
        &self.shape
    }

    /// Width and height of the first mip level this handle covers.
    pub fn size(&self) -> [u32; 2] {
        let mip = self.mips()[0];
        [0, 1].map(|axis| (self.shape.extent[axis] >> mip).max(1))
    }

    /// Array layers it covers, `[first, end)`.
    pub fn layers(&self) -> [u32; 2] {
        match self.range {
            Range::Image { layers, .. } => layers,
            Range::Buffer(_) => [0, 1],
        }
    }

    /// Aspects it covers.
    pub fn aspects(&self) -> vk::ImageAspectFlags {
        match self.range {
            Range::Image { aspects, .. } => aspects,
            Range::Buffer(_) => vk::ImageAspectFlags::empty(),
        }
    }

    /// Mip levels it covers, `[first, end)`.
    pub fn mips(&self) -> [u32; 2] {
        match self.range {
            Range::Image { mips, .. } => mips,
            Range::Buffer(_) => [0, 1],
        }
    }
}

/// Contents of a buffer at one point of the frame.
#[derive(Debug)]
#[must_use = "a version nobody reads is culled"]
pub struct BufferHandle {
    pub(super) graph: u64,
    pub(super) resource: ResourceId,
    pub(super) version: VersionId,
    pub(super) range: Range,
}

impl BufferHandle {
    /// Bytes it covers.
    pub fn size(&self) -> u64 {
        match self.range {
            Range::Buffer([first, end]) => end - first,
            Range::Image { .. } => 0,
        }
    }
}

impl ImageShape {
    /// A two-dimensional image with one mip level, layer and sample.
    pub fn new_2d(format: vk::Format, size: [u32; 2]) -> Self {
        Self { format, extent: [size[0], size[1], 1], mips: 1, layers: 1, samples: 1 }
    }

    /// With array layers.
    pub fn layers(self, layers: u32) -> Self {
        Self { layers, ..self }
    }

    /// With samples a texel: 1, 2, 4, …
    pub fn samples(self, samples: u32) -> Self {
        Self { samples, ..self }
    }

    /// With mip levels.
    pub fn mips(self, mips: u32) -> Self {
        Self { mips, ..self }
    }
}

/// What both kinds of handle are: a version of a resource of one graph.
pub trait Handle: sealed::Sealed {}

impl Handle for ImageHandle {}
impl Handle for BufferHandle {}

pub(super) mod sealed {
    use super::{BufferHandle, ImageHandle, Range, ResourceId, VersionId};

    /// Parts of a handle.
    pub trait Sealed: Sized {
        fn graph(&self) -> u64;
        fn resource(&self) -> ResourceId;
        fn version(&self) -> VersionId;
        fn range(&self) -> Range;
        fn next(self, version: VersionId) -> Self;
    }

    macro_rules! sealed {
        ($($handle:ident),*) => {$(
            impl Sealed for $handle {
                fn graph(&self) -> u64 {
                    self.graph
                }
                fn resource(&self) -> ResourceId {
                    self.resource
                }
                fn version(&self) -> VersionId {
                    self.version
                }
                fn range(&self) -> Range {
                    self.range
                }
                fn next(self, version: VersionId) -> Self {
                    Self { version, ..self }
                }
            }
        )*};
    }

    sealed!(ImageHandle, BufferHandle);
}

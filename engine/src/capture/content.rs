//! What a channel holds: samples on the host, or texels of a captured image, which are taken apart row by row when
//! they are written, so that no second copy of a frame lies in memory.

use std::borrow::Cow;
use std::fmt;
use std::ops::Range;

use ash::vk;
use half::f16;

use super::texels::{components, is_normalised, unpack_component};
use super::{HalfReport, Samples};
use crate::graph;
use crate::graph::description::Shape;
use crate::{Error, Result};

/// OpenEXR's types of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleKind {
    /// 16-bit float.
    F16,
    /// 32-bit float.
    F32,
    /// 32-bit unsigned integer.
    U32,
}

/// Samples of a channel, or where they are.
#[derive(Clone, Debug)]
pub enum Content {
    /// On the host.
    Samples(Samples),
    /// In a captured image.
    Texels(Texels),
}

impl From<Samples> for Content {
    fn from(samples: Samples) -> Self {
        Self::Samples(samples)
    }
}

/// One component of one layer of a captured image.
#[derive(Clone)]
pub struct Texels {
    capture: graph::Capture,
    layer: u32,
    format: vk::Format,
    component: usize,
    size: [u32; 2],
    kind: SampleKind,
    scale: f32,
}

impl Texels {
    /// As it is in the image: see [`super::unpack`].
    ///
    /// # Errors
    /// [`Error::Invalid`] where the capture is a buffer, or its format has no such component.
    pub fn new(capture: &graph::Capture, layer: u32, component: usize) -> Result<Self> {
        let Shape::Image(shape) = &capture.shape else {
            return Err(Error::invalid(format!("capture `{}`", capture.name), "is a buffer, not an image"));
        };
        let format = shape.format;
        let has = components(format)?;
        if component >= has {
            let why = format!("its image has {has} components, not a component {component}");
            return Err(Error::invalid(format!("capture `{}`", capture.name), why));
        }
        let kind = unpack_component(format, &[], component)?.kind();
        let size = [shape.extent[0], shape.extent[1]];
        Ok(Self { capture: capture.clone(), layer, format, component, size, kind, scale: 1.0 })
    }

    /// Width and height of the image.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Floats as floats of another size. Integers are left alone.
    pub fn float_kind(mut self, kind: SampleKind) -> Self {
        if self.kind != SampleKind::U32 && kind != SampleKind::U32 {
            self.kind = kind;
        }
        self
    }

    /// Times a factor, as floats.
    pub fn scaled(mut self, factor: f32) -> Self {
        self.scale = factor;
        self
    }

    /// All of them.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a layer that was not captured; [`Error::Vulkan`] where memory cannot be read.
    pub fn samples(&self) -> Result<Samples> {
        self.read(0..self.len())
    }

    /// What half-floats lose of them: nothing where they are kept as something else.
    ///
    /// # Errors
    /// As [`Texels::samples`].
    pub fn losses(&self) -> Result<HalfReport> {
        let mut report = HalfReport::default();
        if self.kind == SampleKind::F16 && !(is_normalised(self.format) && self.scale == 1.0) {
            const ROW: usize = 4096;
            for first in (0..self.len()).step_by(ROW) {
                report += self.unpacked(first..self.len().min(first + ROW))?.into_half().1;
            }
        }
        Ok(report)
    }

    pub(super) fn len(&self) -> usize {
        self.size.iter().map(|&size| size as usize).product()
    }

    pub(super) fn read(&self, range: Range<usize>) -> Result<Samples> {
        let samples = self.unpacked(range)?;
        Ok(match self.kind {
            SampleKind::F16 => samples.into_half().0,
            SampleKind::F32 => samples.into_float(),
            SampleKind::U32 => samples,
        })
    }

    fn unpacked(&self, range: Range<usize>) -> Result<Samples> {
        let samples = self.capture.layer(self.layer, |texels| {
            let texel = texels.len() / self.len().max(1);
            unpack_component(self.format, &texels[range.start * texel..range.end * texel], self.component)
        })??;
        Ok(if self.scale == 1.0 { samples } else { samples.scaled(self.scale) })
    }
}

impl fmt::Debug for Texels {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { capture, layer, component, .. } = self;
        write!(f, "component {component} of layer {layer} of `{}`", capture.name)
    }
}

/// Neighbouring samples.
pub(super) enum Row<'a> {
    F16(Cow<'a, [f16]>),
    F32(Cow<'a, [f32]>),
    U32(Cow<'a, [u32]>),
}

impl Content {
    /// Number of samples.
    pub fn len(&self) -> usize {
        match self {
            Self::Samples(samples) => samples.len(),
            Self::Texels(texels) => texels.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Type of the samples.
    pub fn kind(&self) -> SampleKind {
        match self {
            Self::Samples(samples) => samples.kind(),
            Self::Texels(texels) => texels.kind,
        }
    }

    /// The samples, read where they are not on the host yet.
    ///
    /// # Errors
    /// As [`Texels::samples`].
    pub fn into_samples(self) -> Result<Samples> {
        match self {
            Self::Samples(samples) => Ok(samples),
            Self::Texels(texels) => texels.samples(),
        }
    }

    pub(super) fn bytes_per_sample(&self) -> usize {
        match self.kind() {
            SampleKind::F16 => 2,
            SampleKind::F32 | SampleKind::U32 => 4,
        }
    }

    /// Samples of a range; a range that is not there is an error of the caller.
    pub(super) fn row(&self, range: Range<usize>) -> Result<Row<'_>> {
        Ok(match self {
            Self::Samples(Samples::F16(values)) => Row::F16(Cow::Borrowed(&values[range])),
            Self::Samples(Samples::F32(values)) => Row::F32(Cow::Borrowed(&values[range])),
            Self::Samples(Samples::U32(values)) => Row::U32(Cow::Borrowed(&values[range])),
            Self::Texels(texels) => match texels.read(range)? {
                Samples::F16(values) => Row::F16(Cow::Owned(values)),
                Samples::F32(values) => Row::F32(Cow::Owned(values)),
                Samples::U32(values) => Row::U32(Cow::Owned(values)),
            },
        })
    }
}

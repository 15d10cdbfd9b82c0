//! What a capture is made of: parts with named channels.

use half::f16;
use half::slice::HalfFloatSliceExt;

use super::{Content, HalfReport, Metadata, Packed, SampleKind, to_half};

/// Everything one file holds.
#[derive(Clone, Debug, Default)]
pub struct Capture {
    /// Images, each of its own size. The first is the frame; its size is the display window of all of them.
    pub parts: Vec<Part>,
    /// Facts about the frame, written into the header of the first part.
    pub metadata: Metadata,
}

/// An image with named channels.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Unique in the file; not empty where there are several parts.
    pub name: String,
    /// Width and height in pixels, neither of them 0.
    pub size: [u32; 2],
    /// In any order; OpenEXR sorts them by name.
    pub channels: Vec<Channel>,
    /// Facts about this part alone.
    pub metadata: Metadata,
    /// Its pixels as they are, compressed ahead ([`Part::pack`]).
    pub packed: Option<Packed>,
}

/// One value a pixel.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Unique in its part, by OpenEXR's convention `layer.component`: `N.X`, `albedo.R`, `Z`.
    pub name: String,
    /// One a pixel, rows from the top.
    pub content: Content,
}

/// Samples of a channel, in one of OpenEXR's three types.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 16-bit float.
    F16(Vec<f16>),
    /// 32-bit float.
    F32(Vec<f32>),
    /// 32-bit unsigned integer.
    U32(Vec<u32>),
}

impl Samples {
    /// Number of samples.
    pub fn len(&self) -> usize {
        match self {
            Self::F16(values) => values.len(),
            Self::F32(values) => values.len(),
            Self::U32(values) => values.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The same samples with floats as half-floats, and what that changed: see [`to_half`]. Half-floats that are
    /// infinite already count and are clamped likewise. Integers are left alone.
    pub fn into_half(self) -> (Self, HalfReport) {
        match self {
            Self::F32(values) => {
                let (values, report) = to_half(&values);
                (Self::F16(values), report)
            }
            Self::F16(mut values) => {
                let mut report = HalfReport::default();
                for value in &mut values {
                    report.not_a_number += u64::from(value.is_nan());
                    if value.is_infinite() {
                        report.clamped += 1;
                        *value = f16::MAX.copysign(*value);
                    }
                }
                (Self::F16(values), report)
            }
            Self::U32(values) => (Self::U32(values), HalfReport::default()),
        }
    }

    /// The same samples with half-floats as 32-bit floats. Integers are left alone.
    pub fn into_float(self) -> Self {
        match self {
            Self::F16(_) => Self::F32(self.into_f32()),
            other => other,
        }
    }

    /// The values as 32-bit floats; of integers, the nearest.
    pub fn into_f32(self) -> Vec<f32> {
        match self {
            Self::F16(values) => values.to_f32_vec(),
            Self::F32(values) => values,
            Self::U32(values) => values.into_iter().map(|value| value as f32).collect(),
        }
    }

    /// The same samples times a factor, as 32-bit floats.
    pub(super) fn scaled(self, factor: f32) -> Self {
        let mut values = self.into_f32();
        values.iter_mut().for_each(|value| *value *= factor);
        Self::F32(values)
    }

    pub(super) fn kind(&self) -> SampleKind {
        match self {
            Self::F16(_) => SampleKind::F16,
            Self::F32(_) => SampleKind::F32,
            Self::U32(_) => SampleKind::U32,
        }
    }
}

impl Channel {
    /// A channel of a name.
    pub fn new(name: impl Into<String>, content: impl Into<Content>) -> Self {
        Self { name: name.into(), content: content.into() }
    }
}

//! Pictures on disk: multi-part OpenEXR for data, PNG for looking at, NPY for arrays; and voxel grids.
//!
//! The writers work on plain host memory and know no device; [`FrameCapture`] fills them from a frame. A file appears
//! whole or not at all: it is written under a temporary name in its own folder and renamed, and the same input gives the
//! same bytes.

mod atomic;
mod content;
mod deep;
mod exr;
mod frame;
mod half_float;
mod metadata;
mod model;
mod npy;
mod png;
mod texels;
mod voxels;

pub use atomic::write_atomically;
pub use content::{Content, SampleKind, Texels};
pub use deep::{DeepPicture, DeepSample};
pub use exr::{Compression, ExrOptions, Packed, write_deep_exr, write_exr};
pub use frame::{CapturedFrame, FrameCapture, picture};
pub use half_float::{HalfReport, to_half};
pub use metadata::{Metadata, Value};
pub use model::{Capture, Channel, Part, Samples};
pub use npy::{NpyScalar, write_npy};
pub use png::{PngOptions, ToneMap, auto_exposure, write_png};
pub use texels::unpack;
pub use voxels::{VoxelFormat, write_voxel_attributes, write_voxels};

//! What a program that renders usually wants: `use shadowgraph::prelude::*;`.

pub use ash::vk::Format;

pub use crate::capture::{write_exr, write_npy, write_png};
pub use crate::frame::{Frame, FrameSettings, Selection};
pub use crate::gpu::{Gpu, GpuOptions, Validation};
pub use crate::graph::{BufferHandle, Executed, Executor, Graph, ImageHandle, ImageShape, Load};
pub use crate::scene::{Camera, GpuScene, Scene, View};
pub use crate::techniques::shading::lighting::Lighting;
pub use crate::techniques::shadow::cascaded::{Cascaded, Splits};
pub use crate::techniques::shadow::spot::Spot;
pub use crate::techniques::shadow::{Filter, Receivers};
pub use crate::techniques::surface::depth::DepthPrepass;
pub use crate::techniques::surface::gbuffer::GBuffer;
pub use crate::techniques::surface::position::Position;
pub use crate::techniques::transparency::sorted::Sorted;
pub use crate::{Error, Result};

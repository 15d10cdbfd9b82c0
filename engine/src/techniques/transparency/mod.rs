//! Surfaces that let light through.

pub mod abuffer;
pub mod adaptive;
pub mod casters;
pub mod depth_peeling;
pub mod dual_depth_peeling;
pub mod forward;
pub mod fragments;
pub mod kbuffer;
pub mod moments;
mod peeling;
pub mod sorted;
pub mod stochastic;
mod sums;
pub mod weighted;

use self::fragments::Fragments;
use crate::graph::{Graph, ImageHandle};
use crate::scene::View;

/// A way to composite blended surfaces that does not ask for an order of draws.
pub trait OrderIndependent {
    /// Composites all fragments before the opaque `depth` over `color` (R32G32B32A32 float, premultiplied).
    ///
    /// Running the frame fails, and says what would be needed, where layers would be lost that the technique promises
    /// to keep.
    fn composite<'f>(
        &self,
        graph: &mut Graph<'f>,
        view: &View,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        color: ImageHandle,
    ) -> ImageHandle;
}

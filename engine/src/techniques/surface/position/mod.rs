//! World position and distance along the view axis, computed back from depth.

use ash::vk;

use crate::graph::{Graph, ImageHandle, ImageShape};
use crate::scene::{View, ViewSet};
use crate::shader::generated::surface::position::position_comp as shader;

/// Position pass.
#[derive(Clone, Copy, Debug, Default)]
pub struct Position;

impl Position {
    /// World-space position in RGB, distance along the view axis in A (metres, infinite in the background), 32-bit
    /// floats.
    pub fn record(&self, graph: &mut Graph, view: &View, depth: &ImageHandle) -> ImageHandle {
        let target = graph.image("position", ImageShape::new_2d(vk::Format::R32G32B32A32_SFLOAT, view.size));
        let mut pass = graph.compute("position", &shader::SHADER);
        pass.uniform(shader::VIEWS, &ViewSet::from(*view).block()).read(shader::DEPTH, depth);
        let position = pass.write(shader::POSITION, target);
        pass.dispatch([view.size[0], view.size[1], 1]);
        position
    }
}

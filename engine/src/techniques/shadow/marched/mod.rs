//! Shadows without maps: a ray through the voxels of a scene, from each pixel to each light, of any kind.
//!
//! Source: Amanatides and Woo 1987, "A Fast Voxel Traversal Algorithm for Ray Tracing"; Nichols, Penmatsa and Wyman 2010,
//! "Interactive, Multiresolution Image-Space Rendering for Dynamic Area Lighting", for visibility through voxels.

use crate::graph::{Graph, ImageHandle};
use crate::scene::{Light, LightKind};
use crate::shader::generated::blocks;
use crate::shader::generated::shadow::marched::mask_comp as shader;
use crate::techniques::voxel::{CLEAR_OF_SURFACE, Grid, Occluders, VoxelSet};

/// Most lights at once; `MAX_MARCHED_LIGHTS` in `visibility.glsl`.
pub const MAX_LIGHTS: usize = 64;

/// Shadows by rays through voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marched {
    /// How far off its surface a ray begins, in voxels: so far that the voxels of a plane do not shadow it.
    pub offset: f32,
}

impl Default for Marched {
    fn default() -> Self {
        Self { offset: CLEAR_OF_SURFACE }
    }
}

impl Marched {
    /// Writes the masks of `lights` (at most [`MAX_LIGHTS`]; 1 is lit), a layer each. `position` and `ids` as
    /// [`surface::position`](crate::techniques::surface::position) and [`gbuffer`](crate::techniques::surface::gbuffer)
    /// have them.
    pub fn record(
        &self,
        graph: &mut Graph,
        occluders: &Occluders<impl VoxelSet>,
        [position, ids]: [&ImageHandle; 2],
        lights: &[&Light],
        masks: ImageHandle,
    ) -> ImageHandle {
        let [width, height, _] = masks.shape().extent;
        let parameters = self.parameters(occluders.voxels.grid(), lights);
        let mut pass = graph.compute("shadow.marched.mask", &shader::SHADER);
        occluders.bind(&mut pass, u32::MAX);
        pass.read(shader::POSITION, position).read(shader::IDS, ids).uniform(shader::MARCHED_LIGHTS, &parameters);
        let masks = pass.write(shader::MASKS, masks);
        pass.dispatch([width, height, 1]);
        masks
    }

    /// Parameters for `visibility.glsl`.
    pub fn parameters(&self, grid: &Grid, lights: &[&Light]) -> blocks::MarchedLights {
        let edge = grid.edge();
        let mut parameters: blocks::MarchedLights = bytemuck::Zeroable::zeroed();
        parameters.marched_offset = self.offset * edge;
        parameters.marched_reach = glam::Vec3::from(grid.size().map(|n| n as f32)).length() * edge;
        for (record, light) in parameters.marched_lights.iter_mut().zip(lights) {
            *record = match light.kind {
                LightKind::Directional { direction, .. } => blocks::MarchedLight { place: -direction, is_near: 0.0 },
                LightKind::Point { position, .. } | LightKind::Spot { position, .. } => {
                    blocks::MarchedLight { place: position, is_near: 1.0 }
                }
            };
            parameters.marched_count += 1;
        }
        parameters
    }
}

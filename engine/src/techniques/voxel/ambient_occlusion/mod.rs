//! How open is the space around a surface? Rays through voxels over the hemisphere of each pixel.
//!
//! Source: Zhukov, Iones and Kronin 1998, "An Ambient Light Illumination Model"; Landis 2002, "Production-Ready Global
//! Illumination", for rays weighted by the cosine.

use ash::vk;

use super::{CLEAR_OF_SURFACE, Occluders, VoxelSet};
use crate::graph::{Graph, ImageHandle, ImageShape};
use crate::shader::generated::blocks;
use crate::shader::generated::voxel::ambient_occlusion::occlusion_comp as shader;

/// Ambient occlusion of the first opaque surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientOcclusion {
    /// Rays a pixel.
    pub rays: u32,
    /// How far they go, in metres; what is further blocks nothing.
    pub reach: f32,
    /// How far off the surface they begin, in voxels.
    pub offset: f32,
}

impl Default for AmbientOcclusion {
    fn default() -> Self {
        Self { rays: 32, reach: 1.0, offset: CLEAR_OF_SURFACE }
    }
}

impl AmbientOcclusion {
    /// The share of the cosine-weighted hemisphere that is open, R32 float; 1 in the background. `position` and `ids` as
    /// [`surface::position`](crate::techniques::surface::position) and [`gbuffer`](crate::techniques::surface::gbuffer)
    /// have them.
    pub fn record(
        &self,
        graph: &mut Graph,
        occluders: &Occluders<impl VoxelSet>,
        position: &ImageHandle,
        ids: &ImageHandle,
    ) -> ImageHandle {
        let [width, height, _] = position.shape().extent;
        let open = graph.image("ambient_occlusion", ImageShape::new_2d(vk::Format::R32_SFLOAT, [width, height]));
        let push = blocks::OcclusionPush { offset: self.offset * occluders.voxels.grid().edge(), reach: self.reach };
        let mut pass = graph.compute("voxel.ambient_occlusion", &shader::SHADER);
        occluders.bind(&mut pass, u32::MAX);
        pass.read(shader::POSITION, position)
            .read(shader::IDS, ids)
            .specialize(shader::RAYS, self.rays.max(1))
            .push(&push);
        let open = pass.write(shader::OPEN, open);
        pass.dispatch([width, height, 1]);
        open
    }
}

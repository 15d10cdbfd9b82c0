//! What a frame makes of the scene's voxels.

use crate::Result;
use crate::graph::{Graph, ImageHandle};
use crate::scene::GpuScene;
use crate::techniques::shadow::marched::Marched;
use crate::techniques::voxel::ambient_occlusion::AmbientOcclusion;
use crate::techniques::voxel::six_separating::SixSeparating;
use crate::techniques::voxel::{Grid, Occluders, Surfaces};

/// Visibility through voxels: shadows of lights that have no map, and ambient occlusion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelVisibility {
    /// Voxels along each side of a cube around the scene.
    pub resolution: u32,
    /// Shadows of point lights.
    pub shadows: Marched,
    /// Layer `ambient_occlusion`.
    pub occlusion: AmbientOcclusion,
}

/// What rays to lights are marched with.
pub(super) struct Marching<'h> {
    pub(super) technique: Marched,
    pub(super) occluders: &'h Occluders,
    /// World positions of pixels.
    pub(super) position: &'h ImageHandle,
}

impl VoxelVisibility {
    /// With so many voxels along a side; ambient occlusion by 16 rays, over a tenth of the scene's size.
    pub fn new(resolution: u32, scene: &GpuScene) -> Self {
        let occlusion =
            AmbientOcclusion { rays: 16, reach: 0.2 * scene.bounds.radius(), ..AmbientOcclusion::default() };
        Self { resolution, shadows: Marched::default(), occlusion }
    }

    /// Voxels of all surfaces that are not blended.
    pub(super) fn occluders<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene) -> Result<Occluders> {
        let grid = Grid::around(&scene.bounds, self.resolution)?;
        let thin = SixSeparating { surfaces: Surfaces::Unblended, ..SixSeparating::default() };
        let voxels = thin.record(graph, scene, &grid)?;
        Ok(Occluders::record(graph, voxels))
    }
}

//! Voxels of surfaces: a triangle an invocation, and large ones dealt out over many.

use super::{Axis, Grid, VoxelBits};
use crate::Result;
use crate::geometry::Aabb;
use crate::graph::{ComputePass, Graph};
use crate::scene::{DrawClass, GpuScene};
use crate::shader::Shader;
use crate::shader::generated::blocks;
use crate::shader::generated::voxel::conservative::{large_comp, small_comp};

/// Smallest ε, in voxels.
const LEAST_MARGIN: f32 = 1e-4;

/// Sets the voxels that make up triangles. `shaders`: for small and for large triangles, with the bindings of
/// `common/surface_voxels_small.glsl` and `common/surface_voxels_large.glsl`.
pub(super) fn record<'f>(
    graph: &mut Graph<'f>,
    scene: &'f GpuScene,
    grid: &Grid,
    axis: Axis,
    surfaces: Surfaces,
    [small, large]: [&'static Shader; 2],
) -> Result<VoxelBits> {
    let VoxelBits { bits, grid, axis } = VoxelBits::new(graph, "voxel.bits", grid, axis)?;
    let bits = graph.fill("voxel.clear", bits, 0);

    // 1. All triangles are numbered, instance by instance.
    let starts = triangle_starts(scene, surfaces);
    let touch = touch(scene, &grid, &starts);
    let triangle_count = touch.triangle_count;
    if triangle_count == 0 {
        return Ok(VoxelBits { bits, grid, axis });
    }
    let starts = graph.data(&starts);

    let bind = |pass: &mut ComputePass| {
        pass.uniform(small_comp::VOXEL_GRID, &grid.block(axis))
            .uniform(small_comp::TOUCH, &touch)
            .constant(small_comp::INSTANCES, &scene.instances)
            .constant(small_comp::TRIANGLE_STARTS, starts)
            .constant(small_comp::INDICES, &scene.indices)
            .constant(small_comp::POSITIONS, &scene.positions);
    };

    // 2. A triangle an invocation; large ones are put on a list.
    let groups = graph.buffer("voxel.large.groups", 16);
    let groups = graph.fill("voxel.large.clear", groups, 0);
    let list = graph.buffer("voxel.large", 8 * u64::from(triangle_count));
    let mut pass = graph.compute("voxel.surface", small);
    bind(&mut pass);
    let bits = pass.write(small_comp::BITS, bits);
    let groups = pass.write(small_comp::LARGE_GROUPS, groups);
    let list = pass.write(small_comp::LARGE_TRIANGLES, list);
    pass.dispatch([triangle_count, 1, 1]);

    // 3. Large triangles, a row of workgroups each.
    let mut pass = graph.compute("voxel.surface.large", large);
    bind(&mut pass);
    pass.read(large_comp::LARGE_GROUPS, &groups).read(large_comp::LARGE_TRIANGLES, &list);
    let bits = pass.write(large_comp::BITS, bits);
    pass.dispatch_indirect(&groups, 0);
    Ok(VoxelBits { bits, grid, axis })
}

/// Which surfaces become voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Surfaces {
    /// All.
    #[default]
    All,
    /// All but those of blended materials.
    Unblended,
}

/// By instance how many triangles come before; then the number of all. An instance that does not count has none.
pub(super) fn triangle_starts(scene: &GpuScene, surfaces: Surfaces) -> Vec<u32> {
    let mut starts = vec![0_u32];
    for draw in scene.draws.draws() {
        let counts = surfaces == Surfaces::All || draw.class != DrawClass::Blend;
        let triangles = if counts { draw.indices.len() as u32 / 3 } else { 0 };
        for _ in draw.instances.clone() {
            starts.push(starts[starts.len() - 1] + triangles);
        }
    }
    starts
}

/// The uniform block `Touch`.
pub(super) fn touch(scene: &GpuScene, grid: &Grid, starts: &[u32]) -> blocks::Touch {
    let (instance_count, triangle_count) = (starts.len() as u32 - 1, starts[starts.len() - 1]);
    blocks::Touch { instance_count, triangle_count, reach: 0.5 + margin(grid, &scene.bounds) }
}

/// ε in voxels: what rounding of coordinates may take away, four units in the last place of the largest one.
pub(super) fn margin(grid: &Grid, scene: &Aabb) -> f32 {
    let far = |corner: glam::Vec3| corner.abs().max_element() / grid.edge();
    let span = grid.size().into_iter().max().unwrap_or(1) as f32;
    let largest = far(grid.min()).max(far(scene.min)).max(far(scene.max)).max(span);
    LEAST_MARGIN.max(4.0 * f32::EPSILON * largest)
}

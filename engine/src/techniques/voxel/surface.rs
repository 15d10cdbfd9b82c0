//! Voxels of surfaces: a triangle an invocation, and large ones dealt out over many.

use super::{Axis, Grid, VoxelBits};
use crate::geometry::Aabb;
use crate::graph::{ComputePass, Graph};
use crate::scene::{Draw, DrawClass, GpuScene};
use crate::shader::Shader;
use crate::shader::generated::blocks;
use crate::shader::generated::voxel::conservative::{large_comp, small_comp};
use crate::{Error, Result};

/// Smallest ε, in voxels.
const LEAST_MARGIN: f32 = 1e-4;

/// Triangles in a row of invocations.
const ROW: u32 = 1 << 20;

/// Sets the voxels that make up triangles. `shaders`: as of [`Visit`].
pub(super) fn record<'f>(
    graph: &mut Graph<'f>,
    scene: &'f GpuScene,
    grid: &Grid,
    axis: Axis,
    surfaces: Surfaces,
    shaders: [&'static Shader; 2],
) -> Result<VoxelBits> {
    let VoxelBits { bits, grid, axis } = VoxelBits::new(graph, "voxel.bits", grid, axis)?;
    let bits = graph.fill("voxel.clear", bits, 0);
    let visit = Visit { name: "voxel", grid, axis, surfaces, shaders };
    let bits = visit.record(graph, scene, bits, |pass, bits| pass.write(small_comp::BITS, bits))?;
    Ok(VoxelBits { bits, grid, axis })
}

/// Passes that are told of the voxels that make up each triangle.
pub(super) struct Visit {
    /// First part of the passes' names.
    pub(super) name: &'static str,
    pub(super) grid: Grid,
    pub(super) axis: Axis,
    pub(super) surfaces: Surfaces,
    /// For small and for large triangles, with `common/surface_voxels_small.glsl` and `common/surface_voxels_large.glsl`.
    pub(super) shaders: [&'static Shader; 2],
}

impl Visit {
    /// `bind` gives each pass what it reads and writes besides, and the latter's next version.
    pub(super) fn record<'f, T>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        state: T,
        bind: impl Fn(&mut ComputePass, T) -> T,
    ) -> Result<T> {
        let Self { name, grid, axis, surfaces, shaders: [small, large] } = self;
        // 1. All triangles are numbered, instance by instance.
        let touch = touch(scene, grid, *surfaces)?;
        let triangle_count = touch.triangle_count;
        if triangle_count == 0 {
            return Ok(state);
        }
        let starts = graph.data(&triangle_starts(scene, *surfaces)?);
        let bind_scene = |pass: &mut ComputePass| {
            pass.uniform(small_comp::VOXEL_GRID, &grid.block(*axis))
                .uniform(small_comp::TOUCH, &touch)
                .constant(small_comp::INSTANCES, &scene.instances)
                .constant(small_comp::TRIANGLE_STARTS, starts)
                .constant(small_comp::INDICES, &scene.indices)
                .constant(small_comp::POSITIONS, &scene.positions);
        };

        // 2. A triangle an invocation; large ones are put on a list.
        let groups = graph.buffer(format!("{name}.large.groups"), 16);
        let groups = graph.fill(format!("{name}.large.clear"), groups, 0);
        let list = graph.buffer(format!("{name}.large"), 8 * u64::from(triangle_count));
        let mut pass = graph.compute(format!("{name}.surface"), small);
        bind_scene(&mut pass);
        let state = bind(&mut pass, state);
        let groups = pass.write(small_comp::LARGE_GROUPS, groups);
        let list = pass.write(small_comp::LARGE_TRIANGLES, list);
        pass.dispatch([triangle_count.min(ROW), triangle_count.div_ceil(ROW), 1]);

        // 3. Large triangles, a row of workgroups each.
        let mut pass = graph.compute(format!("{name}.surface.large"), large);
        bind_scene(&mut pass);
        pass.read(large_comp::LARGE_GROUPS, &groups).read(large_comp::LARGE_TRIANGLES, &list);
        let state = bind(&mut pass, state);
        pass.dispatch_indirect(&groups, 0);
        Ok(state)
    }
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
///
/// # Errors
/// [`Error::Invalid`] for more than 2³² triangles.
pub(super) fn triangle_starts(scene: &GpuScene, surfaces: Surfaces) -> Result<Vec<u32>> {
    let mut starts = vec![0_u32];
    for draw in scene.draws.draws() {
        for _ in draw.instances.clone() {
            let next = starts[starts.len() - 1].checked_add(triangles(draw, surfaces));
            starts.push(next.ok_or_else(|| too_many(scene))?);
        }
    }
    Ok(starts)
}

/// Triangles of all instances.
///
/// # Errors
/// As [`triangle_starts`].
pub(super) fn triangle_count(scene: &GpuScene, surfaces: Surfaces) -> Result<u32> {
    let of = |draw: &Draw| triangles(draw, surfaces).checked_mul(draw.instances.len() as u32);
    let sum = scene.draws.draws().iter().try_fold(0, |sum: u32, draw| sum.checked_add(of(draw)?));
    sum.ok_or_else(|| too_many(scene))
}

/// Triangles of a draw's mesh; none where they do not count.
fn triangles(draw: &Draw, surfaces: Surfaces) -> u32 {
    let counts = surfaces == Surfaces::All || draw.class != DrawClass::Blend;
    if counts { draw.indices.len() as u32 / 3 } else { 0 }
}

fn too_many(scene: &GpuScene) -> Error {
    let why = "has more than 4294967295 triangles, those of a mesh counted for each of its instances";
    Error::invalid(format!("scene `{}`", scene.name), why)
}

/// The uniform block `Touch`.
///
/// # Errors
/// As [`triangle_starts`].
pub(super) fn touch(scene: &GpuScene, grid: &Grid, surfaces: Surfaces) -> Result<blocks::Touch> {
    let instance_count = scene.draws.draws().iter().map(|draw| draw.instances.len() as u32).sum();
    let triangle_count = triangle_count(scene, surfaces)?;
    Ok(blocks::Touch { instance_count, triangle_count, reach: 0.5 + margin(grid, &scene.bounds) })
}

/// ε in voxels: what rounding of coordinates may take away, four units in the last place of the largest one.
pub(super) fn margin(grid: &Grid, scene: &Aabb) -> f32 {
    let far = |corner: glam::Vec3| corner.abs().max_element() / grid.edge();
    let span = grid.size().into_iter().max().unwrap_or(1) as f32;
    let largest = far(grid.min()).max(far(scene.min)).max(far(scene.max)).max(span);
    LEAST_MARGIN.max(4.0 * f32::EPSILON * largest)
}

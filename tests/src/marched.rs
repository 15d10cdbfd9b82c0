//! What a camera sees of a scene that is voxels besides, for rays that begin there.

use glam::{Vec3, Vec4};
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Graph, ImageHandle};
use shadowgraph::techniques::surface::depth::DepthPrepass;
use shadowgraph::techniques::surface::gbuffer::{GBuffer, Precision};
use shadowgraph::techniques::surface::position::Position;
use shadowgraph::techniques::voxel::six_separating::SixSeparating;
use shadowgraph::techniques::voxel::{Grid, Occluders, Surfaces, Voxels};

use crate::parallel;
use crate::render::Subject;
use crate::twin::walk;

/// What was captured.
pub struct Marched {
    /// Width and height.
    pub size: [u32; 2],
    /// The voxels that rays were marched through.
    pub voxels: Voxels,
    /// World positions; w is infinite in the background.
    pub positions: Vec<Vec4>,
    /// Unit normals of triangles.
    pub normals: Vec<Vec3>,
    /// What the technique wrote, layer by layer.
    pub found: Vec<f32>,
}

impl Marched {
    /// Renders with thin voxels, `resolution` along a side. `record` gets what blocks, positions and ids.
    pub fn capture(
        gpu: &Gpu,
        subject: &Subject,
        resolution: u32,
        record: impl FnOnce(&mut Graph, &Occluders, [&ImageHandle; 2]) -> ImageHandle,
    ) -> Self {
        let view = subject.view();
        let mut grid = None;
        let executed = subject.execute(gpu, |graph, scene| {
            let around = Grid::around(&scene.bounds, resolution).unwrap_or_else(|error| panic!("{error}"));
            let thin = SixSeparating { surfaces: Surfaces::Unblended, ..SixSeparating::default() };
            let voxels = thin.record(graph, scene, &around).unwrap_or_else(|error| panic!("{error}"));
            grid = Some((around, voxels.axis));
            graph.capture("bits", &voxels.bits);
            let occluders = Occluders::record(graph, voxels);
            let depth = DepthPrepass.record(graph, scene, &view);
            let surfaces = GBuffer::default().precision(Precision::Float).record(graph, scene, &view, depth);
            let position = Position.record(graph, &view, &surfaces.depth);
            let found = record(graph, &occluders, [&position, &surfaces.ids]);
            graph.capture("position", &position);
            graph.capture("ids", &surfaces.ids);
            graph.capture("found", &found);
        });
        let capture = |name: &str| executed.capture(name).unwrap_or_else(|error| panic!("{error}"));
        let (grid, axis) = grid.unwrap_or_else(|| panic!("nothing was recorded"));
        let read = |error: shadowgraph::Error| -> ! { panic!("{error}") };
        let ids: Vec<[u32; 4]> = capture("ids").texels().unwrap_or_else(|error| read(error));
        Self {
            size: subject.size,
            voxels: Voxels::read(capture("bits"), &grid, axis).unwrap_or_else(|error| read(error)),
            positions: capture("position").texels().unwrap_or_else(|error| read(error)),
            normals: ids.into_iter().map(|id| unpacked(id[3])).collect(),
            found: capture("found").texels().unwrap_or_else(|error| read(error)),
        }
    }

    /// `value` of each pixel, by its coordinates, position and normal; `background` where there is no surface.
    pub fn expected(&self, background: f32, value: impl Fn([u32; 2], Vec3, Vec3) -> f32 + Sync) -> Vec<f32> {
        let width = self.size[0] as usize;
        parallel::rows(self.size[1] as usize, |y| {
            let pixel = |x: usize| match self.positions[y * width + x] {
                place if place.w.is_infinite() => background,
                place => value([x as u32, y as u32], place.truncate(), self.normals[y * width + x]),
            };
            (0..width).map(pixel).collect()
        })
    }

    /// Whether a set voxel lies between two points, by the twin.
    pub fn is_blocked(&self, origin: Vec3, end: Vec3) -> bool {
        walk::is_blocked(self.voxels.grid(), |voxel| self.voxels.get(voxel), [origin, end])
    }
}

/// A unit vector from its octahedral 2×16 bits (Cigolle et al. 2014).
fn unpacked(packed: u32) -> Vec3 {
    let half = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).clamp(-1.0, 1.0);
    let [x, y] = [half(packed), half(packed >> 16)];
    let z = 1.0 - x.abs() - y.abs();
    let inward = (-z).max(0.0);
    let fold = |a: f32| if a >= 0.0 { a - inward } else { a + inward };
    Vec3::new(fold(x), fold(y), z).normalize()
}

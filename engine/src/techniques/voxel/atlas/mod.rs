//! Surface voxelization by points: the texels of an atlas of the surface, each of which sets the voxel that it lies in.
//!
//! Source: Thiedemann, Henrich, Grosch and Müller 2011, "Voxel-based Global Illumination", section 4: a texture atlas
//! holds the surface's positions, and each texel is inserted as a point. Here a texel inserts its point while the atlas is
//! drawn, and no texture is kept: charts that lie one over the other lose nothing.

mod layout;

use glam::Vec2;

pub use layout::Stretch;

use super::{Axis, Grid, VoxelBits};
use crate::gpu::{Buffer, Caps};
use crate::graph::{BufferHandle, Graph};
use crate::scene::{Faces, GpuScene};
use crate::shader::generated::blocks;
use crate::shader::generated::voxel::atlas::{by_axis_vert, holes_comp, point_frag, second_uvs_vert};
use crate::shader::{Program, Shader};
use crate::{Error, Result};

/// Surface voxelization by the texels of an atlas. Surfaces need not be closed. It may leave holes: see
/// [`Atlas::holes`], and [`Stretch`] for how fine an atlas must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Atlas {
    /// The axis that columns of bits run along.
    pub axis: Axis,
    /// How the surface is laid out.
    pub charts: Charts,
}

/// How a surface is laid out in an atlas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Charts {
    /// Three charts, made here: a triangle lies in that of the axis it faces most, as seen along it. Nothing is stretched
    /// more than √3 times.
    ByAxis {
        /// Texels along a voxel's edge.
        per_voxel: f32,
    },
    /// By the meshes' second texture coordinates, those of all meshes in one square.
    SecondUvs {
        /// Texels along the square's side.
        side: u32,
    },
}

impl Default for Atlas {
    fn default() -> Self {
        Self { axis: Axis::default(), charts: Charts::ByAxis { per_voxel: 2.0 } }
    }
}

/// Words in a row of invocations.
const ROW: u32 = 1 << 20;

impl Atlas {
    /// Sets the voxels that texels' points lie in.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the device cannot bind so many bits or draw so large an atlas at once, or where meshes
    /// have no second texture coordinates.
    pub fn record<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid) -> Result<VoxelBits> {
        let VoxelBits { bits, grid, axis } = VoxelBits::new(graph, "voxel.atlas.bits", grid, self.axis)?;
        let bits = graph.fill("voxel.atlas.clear", bits, 0);
        let layout = Layout::of(self.charts, scene, &grid)?;
        layout.check(graph.caps())?;

        let mut pass = graph.raster("voxel.atlas", vec![Program::new(layout.vertex, Some(&point_frag::SHADER))]);
        pass.area([layout.push.side as u32; 2])
            .uniform(by_axis_vert::VOXEL_GRID, &grid.block(axis))
            .constant(by_axis_vert::INSTANCES, &scene.instances)
            .constant(by_axis_vert::INDICES, &scene.indices)
            .constant(by_axis_vert::POSITIONS, &scene.positions);
        if let Some(vertices) = layout.vertices {
            pass.constant(second_uvs_vert::ALPHA_VERTICES, vertices);
        }
        let bits = pass.write(point_frag::BITS, bits);
        let push = layout.push;
        pass.draw(move |recorder| {
            recorder.push(&push);
            scene.draw_pulled(recorder, Faces::Both, scene.draws.draws());
            Ok(())
        });
        Ok(VoxelBits { bits, grid, axis })
    }

    /// How many of the `wanted` voxels are not among those `found`, a word: holes, where the former are
    /// [`SixSeparating`](super::six_separating::SixSeparating)'s.
    ///
    /// # Errors
    /// [`Error::Invalid`] where they are of different grids or axes.
    pub fn holes(graph: &mut Graph, wanted: &VoxelBits, found: &VoxelBits) -> Result<BufferHandle> {
        if wanted.grid != found.grid || wanted.axis != found.axis {
            return Err(Error::invalid("voxels to compare", "are of different grids or columns"));
        }
        let holes = graph.buffer("voxel.holes", 4);
        let holes = graph.fill("voxel.holes.clear", holes, 0);
        let count = (wanted.bits.size() / 4) as u32;
        let mut pass = graph.compute("voxel.holes", &holes_comp::SHADER);
        pass.read(holes_comp::WANTED, &wanted.bits)
            .read(holes_comp::FOUND, &found.bits)
            .push(&blocks::HolesPush { count, row: ROW });
        let holes = pass.write(holes_comp::HOLES, holes);
        pass.dispatch([count.min(ROW), count.div_ceil(ROW), 1]);
        Ok(holes)
    }
}

/// An atlas to be drawn.
struct Layout<'s> {
    vertex: &'static Shader,
    push: blocks::AtlasPush,
    /// What its vertex shader reads besides.
    vertices: Option<&'s Buffer>,
}

impl<'s> Layout<'s> {
    fn of(charts: Charts, scene: &'s GpuScene, grid: &Grid) -> Result<Self> {
        match charts {
            Charts::ByAxis { per_voxel } => {
                // What lies outside of the grid sets nothing, and need not be drawn.
                let voxels = grid.size().into_iter().max().unwrap_or(1);
                let side = (voxels as f32 * per_voxel).ceil().max(1.0);
                let push = blocks::AtlasPush { texels: Vec2::splat(per_voxel), first: Vec2::ZERO, side };
                Ok(Self { vertex: &by_axis_vert::SHADER, push, vertices: None })
            }
            Charts::SecondUvs { side } => {
                let stretch = Stretch::of(scene, grid)?;
                let side = side.max(1) as f32;
                let push = blocks::AtlasPush { texels: Vec2::splat(side / stretch.extent), first: stretch.first, side };
                Ok(Self { vertex: &second_uvs_vert::SHADER, push, vertices: Some(&scene.alpha_attributes) })
            }
        }
    }

    fn check(&self, caps: &Caps) -> Result<()> {
        let most = caps.limits.max_image_dimension_2d;
        if self.push.side <= most as f32 {
            return Ok(());
        }
        let why = format!("takes {0} × {0} texels, the device draws at most {most} × {most} at once", self.push.side);
        Err(Error::invalid("an atlas", why))
    }
}

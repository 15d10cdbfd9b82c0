//! Solid voxelization slice by slice: a stencil buffer counts the surfaces before each slice of the grid.
//!
//! Source: Crane, Llamas and Tariq 2007, "Real-Time Simulation and Rendering of 3D Fluids", GPU Gems 3, section 30.2.4:
//! front faces count up and back faces down, so that what is not 0 is inside.

use ash::vk;

use super::image::tiles_across;
use super::{Axis, FillRule, Grid, VoxelBits, columns};
use crate::Result;
use crate::gpu::{Caps, Feature, stencil};
use crate::graph::{BufferHandle, Graph, ImageHandle, ImageShape, Load, RasterPass};
use crate::scene::{Faces, GpuScene};
use crate::shader::Program;
use crate::shader::generated::blocks::{SlabPush, SlicePush};
use crate::shader::generated::voxel::stencil::{
    gather_comp, gather_tiles_comp, slice_frag, slice_vert, slices_vert, tiles_vert,
};

/// Solid voxelization by stencil. It draws the scene once for each slice: [`super::winding::Winding`] finds the same
/// voxels in one pass. Winding numbers are counted modulo 256.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stencil {
    /// The axis to look along, across the slices.
    pub axis: Axis,
    /// What is inside.
    pub rule: FillRule,
    /// How slices are drawn. All ways give the same bits, but for [`Slices::Tiled`] where rounding decides.
    pub slices: Slices,
}

/// How slices are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Slices {
    /// Into the layers of one attachment, as many slices a pass as its memory allows. Where the device does not choose
    /// layers in the vertex shader or has no cull distances, [`Slices::Separate`] stands in.
    #[default]
    Layered,
    /// Into tiles of one attachment with a single layer, likewise. Depth is interpolated from another place of the image
    /// and rounded otherwise: a centre within 1/128 voxel of a surface may be on the other side of it. Where the device has
    /// no cull distances, or its images are too small for 32 tiles, [`Slices::Separate`] stands in.
    Tiled,
    /// A pass each.
    Separate,
}

/// Most bytes of stencil at a time, unless 32 slices take more.
const SLAB_BYTES: u32 = 32 << 20;

/// Slices in a word of bits.
const IN_WORD: u32 = 32;

/// Slices that share an attachment.
struct Slab {
    /// In the column coordinates of the grid.
    grid: Grid,
    axis: Axis,
    slices: Slices,
    /// Most slices in it.
    count: u32,
    /// Tiles side by side.
    across: u32,
}

impl Slab {
    fn new(stencil: &Stencil, caps: &Caps, grid: &Grid) -> Self {
        let [width, height, depth] = grid.columns(stencil.axis);
        let [most_across, most_down] = [width, height].map(|n| caps.limits.max_image_dimension_2d / n);
        let tiles = most_across.saturating_mul(most_down);
        let cull = caps.has(Feature::CullDistance);
        let slices = match stencil.slices {
            Slices::Layered if cull && caps.has(Feature::LayerFromVertexShader) => Slices::Layered,
            Slices::Tiled if cull && tiles >= IN_WORD => Slices::Tiled,
            _ => Slices::Separate,
        };
        // Slabs are of whole words, the last one aside.
        let most = if slices == Slices::Tiled { tiles } else { caps.limits.max_framebuffer_layers };
        let most = most.min(SLAB_BYTES / (width * height));
        let count = (most / IN_WORD * IN_WORD).clamp(IN_WORD, depth.next_multiple_of(IN_WORD)).min(depth);
        let across = tiles_across(count, [width, height], caps.limits.max_image_dimension_2d);
        Self { grid: *grid, axis: stencil.axis, slices, count, across }
    }

    fn shape(&self) -> ImageShape {
        let [width, height, _] = self.grid.columns(self.axis);
        let shape = |size| ImageShape::new_2d(vk::Format::S8_UINT, size);
        match self.slices {
            Slices::Tiled => shape([self.across * width, self.count.div_ceil(self.across) * height]),
            Slices::Layered | Slices::Separate => shape([width, height]).layers(self.count),
        }
    }

    /// Where a slice is drawn that is `place` slices behind the slab's first.
    fn push(&self, slice: u32, place: u32) -> SlicePush {
        let [width, height, _] = self.grid.columns(self.axis);
        let [x, y] = match self.slices {
            Slices::Tiled => [place % self.across * width, place / self.across * height],
            Slices::Layered | Slices::Separate => [0; 2],
        };
        let area = self.shape().extent;
        SlicePush { slice, layer: place, corner: [x, y], area: [area[0], area[1]] }
    }
}

impl Stencil {
    /// Sets the voxels whose centres are inside.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the device cannot bind so many bits at once.
    pub fn record<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid) -> Result<VoxelBits> {
        let VoxelBits { mut bits, grid, axis } = VoxelBits::new(graph, &self.axis.named("bits"), grid, self.axis)?;
        let depth = grid.columns(axis)[2];
        let slab = Slab::new(self, graph.caps(), &grid);
        let mut stencil = graph.image(axis.named("slices"), slab.shape());
        for first in (0..depth).step_by(slab.count as usize) {
            // 1. Count the surfaces before each slice.
            let end = depth.min(first + slab.count);
            stencil = self.count(graph, scene, &slab, stencil, [first, end]);
            // 2. A bit for each count that is not 0.
            bits = gather(graph, &slab, bits, &stencil, [first, end]);
        }
        Ok(VoxelBits { bits, grid, axis })
    }

    /// Draws the slices from `first` to `end`.
    fn count<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        slab: &Slab,
        stencil: ImageHandle,
        [first, end]: [u32; 2],
    ) -> ImageHandle {
        let program = self.program(graph.caps(), slab.slices);
        let [width, height, _] = slab.grid.columns(slab.axis);
        if slab.slices != Slices::Separate {
            let mut pass = graph.raster(self.axis.named(format_args!("stencil.{first}")), vec![program]);
            pass.uniform(slice_vert::VOXEL_GRID, &slab.grid.block(slab.axis));
            let stencil = pass.stencil(stencil, Load::Clear(0));
            draw(pass, scene, [width, height], (first..end).map(|slice| slab.push(slice, slice - first)).collect());
            return stencil;
        }
        let parts = graph.split_layers(stencil).into_iter().enumerate();
        let drawn = parts.map(|(layer, part)| {
            // The last slab may fill but some of the layers.
            let slice = first + layer as u32;
            if slice >= end {
                return part;
            }
            let mut pass = graph.raster(self.axis.named(format_args!("stencil.{slice}")), vec![program.clone()]);
            pass.uniform(slice_vert::VOXEL_GRID, &slab.grid.block(slab.axis));
            let part = pass.stencil(part, Load::Clear(0));
            draw(pass, scene, [width, height], vec![slab.push(slice, 0)]);
            part
        });
        let drawn = drawn.collect();
        graph.join(drawn).expect("a slab has layers")
    }

    fn program(&self, caps: &Caps, slices: Slices) -> Program {
        let vertex = match slices {
            Slices::Layered => &slices_vert::SHADER,
            Slices::Tiled => &tiles_vert::SHADER,
            Slices::Separate => &slice_vert::SHADER,
        };
        let [front, back] = match self.rule {
            FillRule::NonZero => [vk::StencilOp::INCREMENT_AND_WRAP, vk::StencilOp::DECREMENT_AND_WRAP],
            FillRule::EvenOdd => [vk::StencilOp::INVERT; 2],
        };
        columns::program(caps, vertex, &slice_frag::SHADER).stencil(stencil::on_pass(front), stencil::on_pass(back))
    }
}

/// Sets a bit for each count of a slab that is not 0.
fn gather(
    graph: &mut Graph,
    slab: &Slab,
    bits: BufferHandle,
    stencil: &ImageHandle,
    [first, end]: [u32; 2],
) -> BufferHandle {
    let tiled = slab.slices == Slices::Tiled;
    let shader = if tiled { &gather_tiles_comp::SHADER } else { &gather_comp::SHADER };
    let [width, height, _] = slab.grid.columns(slab.axis);
    let mut pass = graph.compute(slab.axis.named(format_args!("stencil.gather.{first}")), shader);
    pass.uniform(gather_comp::VOXEL_GRID, &slab.grid.block(slab.axis)).push(&SlabPush {
        first_word: first / IN_WORD,
        slices: end - first,
        across: slab.across,
    });
    if tiled {
        pass.read(gather_tiles_comp::STENCIL, stencil);
    } else {
        pass.read(gather_comp::STENCIL, stencil);
    }
    let bits = pass.write(gather_comp::BITS, bits);
    pass.dispatch([width, height, (end - first).div_ceil(IN_WORD)]);
    bits
}

/// Draws every triangle of the scene, whichever way it faces, once for each slice, and keeps it in its tile.
fn draw<'f>(pass: RasterPass<'_, 'f>, scene: &'f GpuScene, tile: [u32; 2], slices: Vec<SlicePush>) {
    pass.draw(move |recorder| {
        for slice in &slices {
            recorder.scissor(slice.corner, tile);
            recorder.push(slice);
            scene.draw(recorder, Faces::Both, scene.draws.draws());
        }
        Ok(())
    });
}

//! Solid voxelization slice by slice: a stencil buffer counts the surfaces before each slice of the grid.
//!
//! Source: Crane, Llamas and Tariq 2007, "Real-Time Simulation and Rendering of 3D Fluids", GPU Gems 3, section 30.2.4:
//! front faces count up and back faces down, so that what is not 0 is inside.

use ash::vk;

use super::{Axis, FillRule, Grid, VoxelBits, columns};
use crate::Result;
use crate::gpu::{Caps, Feature, stencil};
use crate::graph::{Graph, ImageHandle, ImageShape, Load, RasterPass};
use crate::scene::{Faces, GpuScene};
use crate::shader::Program;
use crate::shader::generated::voxel::stencil::{gather_comp, slice_frag, slice_vert, slices_vert};

/// Solid voxelization by stencil. It draws the scene once for each slice: [`super::winding::Winding`] finds the same
/// voxels in one pass. Winding numbers are counted modulo 256.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stencil {
    /// The axis to look along, across the slices.
    pub axis: Axis,
    /// What is inside.
    pub rule: FillRule,
    /// How slices are drawn; both ways give the same bits.
    pub slices: Slices,
}

/// How slices are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Slices {
    /// Into the layers of one attachment, as many slices a pass as its memory allows. Where the device does not choose
    /// layers in the vertex shader or has no cull distances, [`Slices::Separate`] stands in.
    #[default]
    Layered,
    /// A pass each.
    Separate,
}

/// Most bytes of stencil at a time, unless 32 slices take more.
const SLAB_BYTES: u32 = 32 << 20;

/// Slices in a word of bits.
const IN_WORD: u32 = 32;

impl Stencil {
    /// Sets the voxels whose centres are inside.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the device cannot bind so many bits at once.
    pub fn record<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid) -> Result<VoxelBits> {
        let VoxelBits { mut bits, grid, axis } = VoxelBits::new(graph, &self.axis.named("bits"), grid, self.axis)?;
        let [width, height, depth] = grid.columns(axis);

        // Slabs of whole words share one stencil image.
        let most = graph.caps().limits.max_framebuffer_layers.min(SLAB_BYTES / (width * height));
        let slab = (most / IN_WORD * IN_WORD).clamp(IN_WORD, depth.next_multiple_of(IN_WORD)).min(depth);
        let shape = ImageShape::new_2d(vk::Format::S8_UINT, [width, height]).layers(slab);
        let mut layers = graph.image(axis.named("slices"), shape);

        for first in (0..depth).step_by(slab as usize) {
            // 1. Count the surfaces before each slice.
            let slices = slab.min(depth - first);
            layers = self.count(graph, scene, &grid, layers, [first, first + slices]);
            // 2. A bit for each count that is not 0.
            let mut pass = graph.compute(axis.named(format_args!("stencil.gather.{first}")), &gather_comp::SHADER);
            pass.uniform(gather_comp::VOXEL_GRID, &grid.block(axis)).read(gather_comp::STENCIL, &layers);
            pass.push(&[first / IN_WORD, slices]);
            bits = pass.write(gather_comp::BITS, bits);
            pass.dispatch([width, height, slices.div_ceil(IN_WORD)]);
        }
        Ok(VoxelBits { bits, grid, axis })
    }

    /// Draws the slices from `first` to `end` into the first layers.
    fn count<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        grid: &Grid,
        layers: ImageHandle,
        [first, end]: [u32; 2],
    ) -> ImageHandle {
        let caps = graph.caps();
        let can = caps.has(Feature::LayerFromVertexShader) && caps.has(Feature::CullDistance);
        let layered = self.slices == Slices::Layered && can;
        let program = self.program(caps, layered);
        if layered {
            let mut pass = graph.raster(self.axis.named(format_args!("stencil.{first}")), vec![program]);
            columns::bind(&mut pass, scene, grid, self.axis);
            let layers = pass.stencil(layers, Load::Clear(0));
            draw(pass, scene, (first..end).map(|slice| [slice, slice - first]).collect());
            return layers;
        }
        let parts = graph.split_layers(layers).into_iter().enumerate();
        let drawn = parts.map(|(layer, part)| {
            // The last slab may fill but some of the layers.
            let slice = first + layer as u32;
            if slice >= end {
                return part;
            }
            let mut pass = graph.raster(self.axis.named(format_args!("stencil.{slice}")), vec![program.clone()]);
            columns::bind(&mut pass, scene, grid, self.axis);
            let part = pass.stencil(part, Load::Clear(0));
            draw(pass, scene, vec![[slice, 0]]);
            part
        });
        let drawn = drawn.collect();
        graph.join(drawn).expect("a slab has layers")
    }

    fn program(&self, caps: &Caps, layered: bool) -> Program {
        let vertex = if layered { &slices_vert::SHADER } else { &slice_vert::SHADER };
        let [front, back] = match self.rule {
            FillRule::NonZero => [vk::StencilOp::INCREMENT_AND_WRAP, vk::StencilOp::DECREMENT_AND_WRAP],
            FillRule::EvenOdd => [vk::StencilOp::INVERT; 2],
        };
        columns::program(caps, vertex, &slice_frag::SHADER).stencil(stencil::on_pass(front), stencil::on_pass(back))
    }
}

/// Draws every triangle of the scene, whichever way it faces, once for each slice and its layer.
fn draw<'f>(pass: RasterPass<'_, 'f>, scene: &'f GpuScene, slices: Vec<[u32; 2]>) {
    pass.draw(move |recorder| {
        for slice in &slices {
            recorder.push(slice);
            scene.draw(recorder, Faces::Both, scene.draws.draws());
        }
        Ok(())
    });
}

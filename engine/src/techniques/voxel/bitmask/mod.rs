//! Solid voxelization of a whole grid in one pass: each surface flips the bits of all voxels behind it in its column.
//!
//! Source: Eisemann and Décoret 2008, "Single-Pass GPU Solid Voxelization for Real-Time Applications", sections 3 and 4:
//! a column of voxels is the bits of a texel, and XOR leaves those set that lie behind an odd number of surfaces.

use ash::vk;

use super::{Axis, Grid, VoxelBits, columns};
use crate::Result;
use crate::gpu::Feature;
use crate::graph::{Graph, ImageHandle, ImageShape, Load, RasterPass};
use crate::scene::{Faces, GpuScene};
use crate::shader::generated::voxel::bitmask::{
    columns_vert, flip_bit_frag, flip_mask_frag, flip_targets_1_frag, flip_targets_2_frag, flip_targets_4_frag,
    flip_targets_8_frag, gather_comp, prefix_comp,
};
use crate::shader::{ColorSlot, Program, Shader};

/// Solid voxelization by XOR. Inside is what an odd number of surfaces lies before; for a solid whose surface is not
/// closed, columns are wrong behind its holes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bitmask {
    /// The axis to look along.
    pub axis: Axis,
    /// How bits are flipped; all ways give the same bits.
    pub combine: Combine,
}

/// How a surface flips the bits behind it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Combine {
    /// An atomic XOR flips the first one, and a pass over the columns the others: one memory access a fragment.
    #[default]
    Bit,
    /// An atomic XOR for each word of the column behind the surface.
    Masks,
    /// The XOR logic operation on attachments of 128 voxels each, as in the paper. Without the device's `logicOp`, or
    /// without enough attachments, [`Combine::Masks`] stands in.
    LogicOp,
}

/// Voxels that an attachment holds.
const IN_TARGET: u32 = 128;

/// Fragment shaders for so many attachments.
const FLIP_TARGETS: [(&Shader, &[ColorSlot]); 4] = {
    use {flip_targets_1_frag as one, flip_targets_2_frag as two};
    use {flip_targets_4_frag as four, flip_targets_8_frag as eight};
    [
        (&one::SHADER, &[one::WORDS_0]),
        (&two::SHADER, &[two::WORDS_0, two::WORDS_1]),
        (&four::SHADER, &[four::WORDS_0, four::WORDS_1, four::WORDS_2, four::WORDS_3]),
        (
            &eight::SHADER,
            &[
                eight::WORDS_0,
                eight::WORDS_1,
                eight::WORDS_2,
                eight::WORDS_3,
                eight::WORDS_4,
                eight::WORDS_5,
                eight::WORDS_6,
                eight::WORDS_7,
            ],
        ),
    ]
};

impl Bitmask {
    /// Sets the voxels whose centres are inside.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the device cannot bind so many bits at once.
    pub fn record<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid) -> Result<VoxelBits> {
        let voxels = VoxelBits::new(graph, &self.axis.named("bits"), grid, self.axis)?;
        let targets = grid.columns(self.axis)[2].div_ceil(IN_TARGET).next_power_of_two();
        let caps = graph.caps();
        let can = caps.has(Feature::LogicOp) && targets <= caps.limits.max_color_attachments;
        Ok(match self.combine {
            Combine::Bit => {
                let flipped = flip(graph, scene, voxels, &flip_bit_frag::SHADER);
                prefix(graph, flipped)
            }
            Combine::LogicOp if can => {
                let masks = self.flip_targets(graph, scene, grid, targets);
                gather(graph, voxels, &masks)
            }
            Combine::Masks | Combine::LogicOp => flip(graph, scene, voxels, &flip_mask_frag::SHADER),
        })
    }

    fn flip_targets<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid, targets: u32) -> ImageHandle {
        let [width, height, _] = grid.columns(self.axis);
        let shape = ImageShape::new_2d(vk::Format::R32G32B32A32_UINT, [width, height]).layers(targets);
        let masks = graph.image(self.axis.named("masks"), shape);
        let layers = graph.split_layers(masks);
        let (shader, slots) = FLIP_TARGETS[targets.ilog2() as usize];
        let program = Program {
            logic_op: Some(vk::LogicOp::XOR),
            ..columns::program(graph.caps(), &columns_vert::SHADER, shader)
        };
        let mut pass = graph.raster(self.axis.named("bitmask"), vec![program]);
        columns::bind(&mut pass, scene, grid, self.axis);
        let attach = |(&slot, layer)| pass.color_uint(slot, layer, Load::Clear([0; 4]));
        let written = slots.iter().zip(layers).map(attach).collect();
        draw(pass, scene);
        graph.join(written).expect("a grid has voxels")
    }
}

/// Draws every triangle of the scene, whichever way it faces.
fn draw<'f>(pass: RasterPass<'_, 'f>, scene: &'f GpuScene) {
    pass.draw(move |recorder| {
        scene.draw(recorder, Faces::Both, scene.draws.draws());
        Ok(())
    });
}

fn flip<'f>(graph: &mut Graph<'f>, scene: &'f GpuScene, voxels: VoxelBits, fragment: &'static Shader) -> VoxelBits {
    let VoxelBits { bits, grid, axis } = voxels;
    let [width, height, _] = grid.columns(axis);
    let bits = graph.fill(axis.named("clear"), bits, 0);
    let program = columns::program(graph.caps(), &columns_vert::SHADER, fragment);
    let mut pass = graph.raster(axis.named("bitmask"), vec![program]);
    pass.area([width, height]);
    columns::bind(&mut pass, scene, &grid, axis);
    let bits = pass.write(flip_bit_frag::BITS, bits);
    draw(pass, scene);
    VoxelBits { bits, grid, axis }
}

fn prefix(graph: &mut Graph, VoxelBits { bits, grid, axis }: VoxelBits) -> VoxelBits {
    let [width, height, _] = grid.columns(axis);
    let mut pass = graph.compute(axis.named("bitmask.prefix"), &prefix_comp::SHADER);
    pass.uniform(prefix_comp::VOXEL_GRID, &grid.block(axis));
    let bits = pass.write(prefix_comp::BITS, bits);
    pass.dispatch([width * height, 1, 1]);
    VoxelBits { bits, grid, axis }
}

fn gather(graph: &mut Graph, VoxelBits { bits, grid, axis }: VoxelBits, masks: &ImageHandle) -> VoxelBits {
    let [width, height, _] = grid.columns(axis);
    let mut pass = graph.compute(axis.named("bitmask.gather"), &gather_comp::SHADER);
    pass.uniform(gather_comp::VOXEL_GRID, &grid.block(axis)).read(gather_comp::MASKS, masks);
    let bits = pass.write(gather_comp::BITS, bits);
    pass.dispatch([width, height, 1]);
    VoxelBits { bits, grid, axis }
}

//! Voxelization of a whole grid in one pass: each surface flips the bits of all voxels behind it in its column, or sets
//! the bit of the voxel that it crosses the column in.
//!
//! Sources: Eisemann and Décoret 2006, "Fast Scene Voxelization and Applications", section 3: a column of voxels is the
//! bits of a texel, and OR gathers those of surfaces; the same 2008, "Single-Pass GPU Solid Voxelization for Real-Time
//! Applications", sections 3 and 4: XOR leaves those set that lie behind an odd number of surfaces.

use ash::vk;

use super::frustum::SIGHT;
use super::{Axis, FrustumBits, FrustumGrid, Grid, VoxelBits, columns};
use crate::Result;
use crate::gpu::{Caps, Feature};
use crate::graph::{BufferHandle, Graph, ImageHandle, ImageShape, Load, RasterPass};
use crate::scene::{Faces, GpuScene};
use crate::shader::generated::blocks::{GatherPush, TargetsPush};
use crate::shader::generated::voxel::bitmask::{
    columns_vert, flip_bit_frag, flip_mask_frag, flip_targets_1_frag, flip_targets_2_frag, flip_targets_4_frag,
    flip_targets_8_frag, frustum_vert, gather_comp, prefix_comp,
};
use crate::shader::{ColorSlot, Program, Shader};

/// Voxelization by bits of columns: of solids by XOR, of surfaces by OR. Inside is what an odd number of surfaces lies
/// before; for a solid whose surface is not closed, columns are wrong behind its holes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bitmask {
    /// The axis to look along.
    pub axis: Axis,
    /// How bits are combined; all ways give the same bits.
    pub combine: Combine,
    /// Which voxels are set.
    pub fill: Fill,
}

/// Which voxels are set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fill {
    /// Those whose centres are inside of solids.
    #[default]
    Solid,
    /// Those in which a surface crosses their column's centre line. Surfaces along the columns have gaps:
    /// [`super::conservative::Conservative`] has none.
    Surface,
}

/// How a surface flips the bits behind it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Combine {
    /// An atomic XOR flips the first one, and a pass over the columns the others: one memory access a fragment.
    #[default]
    Bit,
    /// An atomic XOR for each word of the column behind the surface.
    Masks,
    /// The XOR logic operation on attachments of 128 voxels each (of 32 where the grid has no more), as in the paper: up to
    /// eight of them a pass, and as many passes as it takes. Without the device's `logicOp`, [`Combine::Masks`] stands in.
    LogicOp,
}

/// Voxels that an attachment holds.
const IN_TARGET: u32 = 128;

/// Most attachments of a pass.
const MOST_TARGETS: u32 = 8;

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
    /// Sets the voxels of a grid.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the device cannot bind so many bits at once.
    pub fn record<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid) -> Result<VoxelBits> {
        let columns = Columns { grid: *grid, axis: self.axis, frustum: None };
        let bits = self.combined(graph, scene, &columns)?;
        Ok(VoxelBits { bits, grid: *grid, axis: self.axis })
    }

    /// Sets the voxels of a camera's frustum; columns are lines of sight, whatever [`Bitmask::axis`] says. Inside is what an
    /// odd number of surfaces lies behind: before it may be some that the camera, in a solid itself, cannot see.
    ///
    /// # Errors
    /// As [`Bitmask::record`].
    pub fn record_frustum<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        frustum: &FrustumGrid,
    ) -> Result<FrustumBits> {
        let columns = Columns { grid: frustum.grid(), axis: SIGHT, frustum: Some(frustum) };
        Ok(FrustumBits { bits: self.combined(graph, scene, &columns)?, frustum: *frustum })
    }

    fn combined<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, columns: &Columns) -> Result<BufferHandle> {
        let Columns { grid, axis, .. } = columns;
        let VoxelBits { bits, .. } = VoxelBits::new(graph, &columns.named("bits"), grid, *axis)?;
        Ok(match (self.combine, self.fill) {
            (Combine::LogicOp, fill) if graph.caps().has(Feature::LogicOp) => {
                columns.by_logic_operation(graph, scene, bits, fill)
            }
            (Combine::Bit, Fill::Solid) => {
                let flipped = columns.draw_bits(graph, scene, bits, &flip_bit_frag::SHADER, Fill::Solid);
                columns.prefix(graph, flipped)
            }
            (_, Fill::Solid) => columns.draw_bits(graph, scene, bits, &flip_mask_frag::SHADER, Fill::Solid),
            (_, Fill::Surface) => columns.draw_bits(graph, scene, bits, &flip_bit_frag::SHADER, Fill::Surface),
        })
    }
}

/// Where columns run.
struct Columns<'g> {
    /// Of a frustum in its own coordinates.
    grid: Grid,
    axis: Axis,
    frustum: Option<&'g FrustumGrid>,
}

impl Columns<'_> {
    fn named(&self, what: impl std::fmt::Display) -> String {
        match self.frustum {
            None => self.axis.named(what),
            Some(_) => format!("voxel.frustum.{what}"),
        }
    }

    fn program(&self, caps: &Caps, fragment: &'static Shader, fill: Fill) -> Program {
        let vertex = if self.frustum.is_some() { &frustum_vert::SHADER } else { &columns_vert::SHADER };
        columns::program(caps, vertex, fragment).constant(flip_bit_frag::SURFACE, fill == Fill::Surface)
    }

    fn bind(&self, pass: &mut RasterPass) {
        pass.uniform(columns_vert::VOXEL_GRID, &self.grid.block(self.axis));
        if let Some(frustum) = self.frustum {
            pass.uniform(frustum_vert::FRUSTUM, &frustum.block());
        }
    }

    /// Combines bits of attachments, as many voxels of all columns a pass as the device has attachments for.
    fn by_logic_operation<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        mut bits: BufferHandle,
        fill: Fill,
    ) -> BufferHandle {
        let voxels = self.grid.columns(self.axis)[2];
        let most = 1 << graph.caps().limits.max_color_attachments.min(MOST_TARGETS).ilog2();
        for first in (0..voxels).step_by((most * IN_TARGET) as usize) {
            let targets = (voxels - first).div_ceil(IN_TARGET).min(most).next_power_of_two();
            let masks = self.draw_targets(graph, scene, [first, targets], fill);
            bits = self.gather(graph, bits, &masks, [first, targets]);
        }
        bits
    }

    /// Those of so many attachments, from a voxel on.
    fn draw_targets<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        [first, targets]: [u32; 2],
        fill: Fill,
    ) -> ImageHandle {
        let [width, height, voxels] = self.grid.columns(self.axis);
        let format = if voxels <= 32 { vk::Format::R32_UINT } else { vk::Format::R32G32B32A32_UINT };
        let shape = ImageShape::new_2d(format, [width, height]).layers(targets);
        let masks = graph.image(self.named(format_args!("masks.{first}")), shape);
        let layers = graph.split_layers(masks);
        let (shader, slots) = FLIP_TARGETS[targets.ilog2() as usize];
        let operation = if fill == Fill::Surface { vk::LogicOp::OR } else { vk::LogicOp::XOR };
        let program = Program { logic_op: Some(operation), ..self.program(graph.caps(), shader, fill) };
        let mut pass = graph.raster(self.named(format_args!("bitmask.{first}")), vec![program]);
        self.bind(&mut pass);
        let attach = |(&slot, layer)| pass.color_uint(slot, layer, Load::Clear([0; 4]));
        let written = slots.iter().zip(layers).map(attach).collect();
        pass.draw(move |recorder| {
            recorder.push(&TargetsPush { first_word: first / 32 });
            scene.draw(recorder, Faces::Both, scene.draws.draws());
            Ok(())
        });
        graph.join(written).expect("a grid has voxels")
    }

    /// Combines bits of a buffer by atomics.
    fn draw_bits<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        bits: BufferHandle,
        fragment: &'static Shader,
        fill: Fill,
    ) -> BufferHandle {
        let [width, height, _] = self.grid.columns(self.axis);
        let bits = graph.fill(self.named("clear"), bits, 0);
        let program = self.program(graph.caps(), fragment, fill);
        let mut pass = graph.raster(self.named("bitmask"), vec![program]);
        pass.area([width, height]);
        self.bind(&mut pass);
        let bits = pass.write(flip_bit_frag::BITS, bits);
        draw(pass, scene);
        bits
    }

    fn prefix(&self, graph: &mut Graph, bits: BufferHandle) -> BufferHandle {
        let [width, height, _] = self.grid.columns(self.axis);
        let mut pass = graph.compute(self.named("bitmask.prefix"), &prefix_comp::SHADER);
        pass.uniform(prefix_comp::VOXEL_GRID, &self.grid.block(self.axis));
        let bits = pass.write(prefix_comp::BITS, bits);
        pass.dispatch([width * height, 1, 1]);
        bits
    }

    fn gather(
        &self,
        graph: &mut Graph,
        bits: BufferHandle,
        masks: &ImageHandle,
        [first, targets]: [u32; 2],
    ) -> BufferHandle {
        let [width, height, voxels] = self.grid.columns(self.axis);
        let end = voxels.min(first + targets * IN_TARGET);
        let mut pass = graph.compute(self.named(format_args!("bitmask.gather.{first}")), &gather_comp::SHADER);
        pass.uniform(gather_comp::VOXEL_GRID, &self.grid.block(self.axis))
            .read(gather_comp::MASKS, masks)
            .push(&GatherPush { first_word: first / 32, end_word: end.div_ceil(32) });
        let bits = pass.write(gather_comp::BITS, bits);
        pass.dispatch([width, height, 1]);
        bits
    }
}

/// Draws every triangle of the scene, whichever way it faces.
fn draw<'f>(pass: RasterPass<'_, 'f>, scene: &'f GpuScene) {
    pass.draw(move |recorder| {
        scene.draw(recorder, Faces::Both, scene.draws.draws());
        Ok(())
    });
}

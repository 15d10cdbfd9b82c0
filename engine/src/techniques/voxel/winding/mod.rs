//! Solid voxelization by winding numbers, in one pass: each surface is counted at the voxel where a column crosses it.
//!
//! Source: Crane, Llamas and Tariq 2007, "Real-Time Simulation and Rendering of 3D Fluids", GPU Gems 3, section 30.2.4,
//! for the counts of both faces; Eisemann and Décoret 2008, "Single-Pass GPU Solid Voxelization for Real-Time
//! Applications", for a crossing a fragment and what lies behind it found after.

use super::{Axis, FillRule, Grid, VoxelBits, columns};
use crate::Result;
use crate::graph::Graph;
use crate::scene::{Faces, GpuScene};
use crate::shader::generated::voxel::winding::{columns_vert, count_frag, scan_comp};

/// Solid voxelization by signed counting: the fast twin of [`super::stencil::Stencil`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Winding {
    /// The axis to look along.
    pub axis: Axis,
    /// What is inside.
    pub rule: FillRule,
}

/// Most bytes of counts at a time.
const BAND_BYTES: u32 = 128 << 20;

impl Winding {
    /// Sets the voxels whose centres are inside. Where the counts of all columns take more than 128 MiB, rows of columns
    /// are found band by band; each band draws the scene.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the device cannot bind so many bits at once.
    pub fn record<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid) -> Result<VoxelBits> {
        let VoxelBits { mut bits, grid, axis } = VoxelBits::new(graph, &self.axis.named("bits"), grid, self.axis)?;
        let [width, height, depth] = grid.columns(axis);
        let row = 4 * width * depth.next_multiple_of(32);
        let most = BAND_BYTES.min(graph.caps().limits.max_storage_buffer_range);
        let band = (most / row).clamp(1, height);
        let counts = graph.buffer(axis.named("counts"), u64::from(row) * u64::from(band));
        let mut counts = graph.fill(axis.named("winding.clear"), counts, 0);
        bits = graph.fill(axis.named("clear"), bits, 0);

        for first in (0..height).step_by(band as usize) {
            // 1. Count each crossing, and mark where.
            let rows = band.min(height - first);
            let program = columns::program(graph.caps(), &columns_vert::SHADER, &count_frag::SHADER);
            let mut pass = graph.raster(axis.named(format_args!("winding.{first}")), vec![program]);
            pass.area([width, height]);
            pass.uniform(columns_vert::VOXEL_GRID, &grid.block(axis));
            counts = pass.write(count_frag::COUNTS, counts);
            bits = pass.write(count_frag::BITS, bits);
            pass.draw(move |recorder| {
                recorder.scissor([0, first], [width, rows]);
                recorder.push(&[first, rows]);
                scene.draw(recorder, Faces::Both, scene.draws.draws());
                Ok(())
            });
            // 2. Sum the counts of each column; they are 0 again after.
            let mut pass = graph.compute(axis.named(format_args!("winding.scan.{first}")), &scan_comp::SHADER);
            pass.uniform(scan_comp::VOXEL_GRID, &grid.block(axis));
            pass.push(&[first, rows]).specialize(scan_comp::EVEN_ODD, self.rule == FillRule::EvenOdd);
            counts = pass.write(scan_comp::COUNTS, counts);
            bits = pass.write(scan_comp::BITS, bits);
            pass.dispatch([width * rows, 1, 1]);
        }
        Ok(VoxelBits { bits, grid, axis })
    }
}

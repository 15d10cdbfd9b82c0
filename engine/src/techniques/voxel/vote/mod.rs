//! Solids whose surfaces are not closed: what is inside along each of three axes, put to the vote.
//!
//! Source: Nooruddin and Turk 2003, "Simplification and Repair of Polygonal Models Using Volumetric Techniques", section
//! 3.1: parity along several directions with a vote, and what a ray says that meets an odd number of surfaces is left out.

use super::{Axis, FillRule, Grid, VoxelBits, columns};
use crate::graph::{BufferHandle, Graph};
use crate::scene::{Faces, GpuScene};
use crate::shader::generated::blocks;
use crate::shader::generated::voxel::vote::{columns_vert, count_comp, cross_frag, sound_comp, turn_comp, vote_comp};
use crate::{Error, Result};

/// Says which columns leak, and lets those along three axes vote on what is inside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Vote {
    /// The rule by which the voxels were found. A column leaks where a line through it enters surfaces more often than it
    /// leaves them, or with [`FillRule::EvenOdd`] meets an odd number of them.
    pub rule: FillRule,
}

/// Which columns leak. Closed surfaces have none.
pub struct Leaks {
    /// Surfaces that face the viewer less those that face away, an `i32` a column, by axis and row by row.
    pub crossings: [BufferHandle; 3],
    /// How many columns leak along x, y and z: three `u32`.
    pub counts: BufferHandle,
}

impl Vote {
    /// Counts the surfaces of all columns along all axes, in the grid and beyond.
    pub fn leaks<'f>(&self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid) -> Leaks {
        // 1. The surfaces of each column.
        let axes = [Axis::X, Axis::Y, Axis::Z];
        let crossings = axes.map(|axis| cross(graph, scene, grid, axis));
        // 2. The columns that leak.
        let counts = graph.buffer("voxel.leaks", 12);
        let mut counts = graph.fill("voxel.leaks.clear", counts, 0);
        for (axis, crossings) in axes.into_iter().zip(&crossings) {
            let [width, height, _] = grid.columns(axis);
            let mut pass = graph.compute(axis.named("vote.count"), &count_comp::SHADER);
            pass.push(&blocks::LeaksPush { width, rows: height, axis: axis as u32 })
                .specialize(count_comp::EVEN_ODD, self.rule == FillRule::EvenOdd)
                .read(count_comp::CROSSINGS, crossings);
            counts = pass.write(count_comp::LEAKS, counts);
            pass.dispatch([height, 1, 1]);
        }
        Leaks { crossings, counts }
    }

    /// Sets the voxels that are inside by the majority of their three columns, of those that do not leak where they agree.
    /// `along`: one grid's voxels, with columns along x, y and z. The result has columns along z.
    ///
    /// # Errors
    /// [`Error::Invalid`] where `along` are not those.
    pub fn record(&self, graph: &mut Graph, along: [&VoxelBits; 3], leaks: &Leaks) -> Result<VoxelBits> {
        let [x, y, z] = along;
        if along.map(|voxels| voxels.axis) != [Axis::X, Axis::Y, Axis::Z] || x.grid != z.grid || y.grid != z.grid {
            let why = "it takes one grid's voxels along x, y and z, in this order";
            return Err(Error::invalid("the vote on voxels", why));
        }
        // 1. Words of all columns along z: columns along x stand at (y, z), those along y at (z, x).
        let [width, height, depth] = z.grid.size();
        let turned_x = blocks::TurnPush {
            size: [width, height, depth],
            from: [height * depth, 1, height],
            to: [1, width, width * height],
        };
        let turned_y = blocks::TurnPush {
            size: [height, width, depth],
            from: [width * depth, depth, 1],
            to: [width, 1, width * height],
        };
        let along_x = turn(graph, x, turned_x)?;
        let along_y = turn(graph, y, turned_y)?;
        let sound_x = blocks::SoundPush { size: [height, depth], from: [1, height] };
        let sound_y = blocks::SoundPush { size: [width, depth], from: [depth, 1] };
        let sound_x = self.sound(graph, Axis::X, leaks, sound_x);
        let sound_y = self.sound(graph, Axis::Y, leaks, sound_y);

        // 2. The vote.
        let bits = VoxelBits::new(graph, "voxel.voted", &z.grid, Axis::Z)?;
        let mut pass = graph.compute("voxel.vote", &vote_comp::SHADER);
        pass.push(&blocks::VotePush { size: [width, height, depth] })
            .specialize(vote_comp::EVEN_ODD, self.rule == FillRule::EvenOdd)
            .read(vote_comp::ALONG_X, &along_x)
            .read(vote_comp::ALONG_Y, &along_y)
            .read(vote_comp::ALONG_Z, &z.bits)
            .read(vote_comp::SOUND_X, &sound_x)
            .read(vote_comp::SOUND_Y, &sound_y)
            .read(vote_comp::CROSSINGS_Z, &leaks.crossings[2]);
        let bits = VoxelBits { bits: pass.write(vote_comp::BITS, bits.bits), ..bits };
        pass.dispatch([width, height, depth.div_ceil(32)]);
        Ok(bits)
    }

    /// Which columns along an axis do not leak, as bits along z.
    fn sound(&self, graph: &mut Graph, axis: Axis, leaks: &Leaks, push: blocks::SoundPush) -> BufferHandle {
        let [across, depth] = push.size;
        let words = depth.div_ceil(32);
        let sound = graph.buffer(axis.named("sound"), 4 * u64::from(across) * u64::from(words));
        let mut pass = graph.compute(axis.named("vote.sound"), &sound_comp::SHADER);
        pass.push(&push)
            .specialize(sound_comp::EVEN_ODD, self.rule == FillRule::EvenOdd)
            .read(sound_comp::CROSSINGS, &leaks.crossings[axis as usize]);
        let sound = pass.write(sound_comp::SOUND, sound);
        pass.dispatch([across, words, 1]);
        sound
    }
}

/// The words that a grid's columns along z would have.
fn turn(graph: &mut Graph, voxels: &VoxelBits, push: blocks::TurnPush) -> Result<BufferHandle> {
    let VoxelBits { axis, grid, .. } = voxels;
    let turned = VoxelBits::new(graph, &axis.named("turned"), grid, Axis::Z)?;
    let [along, across, depth] = push.size;
    let mut pass = graph.compute(axis.named("vote.turn"), &turn_comp::SHADER);
    pass.push(&push).read(turn_comp::COLUMNS, &voxels.bits);
    let turned = pass.write(turn_comp::TURNED, turned.bits);
    pass.dispatch([across, along.div_ceil(32), depth.div_ceil(32)]);
    Ok(turned)
}

/// Counts the surfaces of each column along an axis.
fn cross<'f>(graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid, axis: Axis) -> BufferHandle {
    let [width, height, _] = grid.columns(axis);
    let crossings = graph.buffer(axis.named("crossings"), 4 * u64::from(width) * u64::from(height));
    let crossings = graph.fill(axis.named("crossings.clear"), crossings, 0);
    let program = columns::program(graph.caps(), &columns_vert::SHADER, &cross_frag::SHADER);
    let mut pass = graph.raster(axis.named("vote.cross"), vec![program]);
    pass.area([width, height]);
    pass.uniform(columns_vert::VOXEL_GRID, &grid.block(axis));
    let crossings = pass.write(cross_frag::CROSSINGS, crossings);
    pass.draw(move |recorder| {
        scene.draw(recorder, Faces::Both, scene.draws.draws());
        Ok(())
    });
    crossings
}

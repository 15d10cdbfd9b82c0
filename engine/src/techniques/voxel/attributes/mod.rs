//! What surfaces are like in each voxel: albedo, opacity, normal and emission, averaged by area. Sums are in fixed point,
//! so the order of triangles has no say in them.
//!
//! Sources: Crassin and Green 2012, "Octree-Based Sparse Voxelization Using the GPU Hardware Rasterizer", OpenGL Insights,
//! sections 22.3 and 22.4, for lists of what falls into voxels and values averaged by atomics; Sutherland and Hodgman 1974,
//! "Reentrant Polygon Clipping", for the part of a triangle in a voxel.

mod pairs;
mod values;

pub use values::{Attribute, VoxelAttributes};

use ash::vk;

use self::pairs::Pairs;
use super::ranks::{Count, Ranks};
use super::surface::{self, Surfaces};
use super::{VoxelSet, voxel_set};
use crate::Result;
use crate::graph::{BufferHandle, Checkpoint, Graph};
use crate::scene::{DrawClass, GpuScene};
use crate::shader::Program;
use crate::shader::generated::blocks;
use crate::shader::generated::voxel::attributes::{average_comp, pairs_vert, sum_frag};

/// Averages what surfaces are like over the parts of triangles in each set voxel.
///
/// A part counts by its area times its alpha, and is looked at in its middle, with textures filtered as wide as it is.
/// Alpha is that of glTF: 1 for opaque materials, and for masked ones not compared with the cutoff, so that what a voxel
/// sees of a fence is how much of it is there. Normals are shading normals of fronts, normal maps included. Albedo and
/// alpha are taken as 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attributes {}

/// Attributes of the set voxels of a grid, one behind the other: by word of the bits, and within a word from its lowest bit.
/// Those of a voxel stand at `firsts[word]` plus the set bits below its own in that word, whether words are those of a whole
/// grid or of bricks.
pub struct AttributeBuffers {
    /// How many set bits come before each word of the bits.
    pub firsts: BufferHandle,
    /// Four floats a voxel: linear albedo, of what is there; opacity, which is the mean alpha. Zeros where set voxels hold
    /// no surface.
    pub albedo: BufferHandle,
    /// Four floats a voxel: the mean normal, world space, the shorter the less normals agree; area of surfaces, in squares
    /// of a voxel's edge.
    pub normals: BufferHandle,
    /// Four floats a voxel: emitted radiance, cd/m², and 0.
    pub emission: BufferHandle,
}

/// Bits of a sum.
const SUM_BITS: u32 = 64;
/// Bits of alpha, and of the attribute that it and the weight are multiplied with.
const VALUE_BITS: u32 = 8 + 16;
/// Most bits of a weight, so that its product with alpha is one word.
const WEIGHT_BITS: u32 = 24;

impl Attributes {
    /// Attributes of all set voxels, of a whole grid or in bricks: equal ones. The host reads how many there are, and how many
    /// triangles they hold, which sizes the buffers.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] for more than 2³² triangles. Where the device cannot bind the sums of so many voxels at once,
    /// or the lists of so many triangles in them, the frame ends with an error that names the buffer.
    pub fn record<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        voxels: &impl VoxelSet,
    ) -> Result<AttributeBuffers> {
        // 1. A place for each set voxel.
        let Ranks { firsts, count: Count { total, told } } = voxel_set::ranks(graph, "voxel.attributes", voxels);
        // 2. The sums, each of two words; which triangles have a part in each voxel, and what they add.
        let mut sums = [("weight", 2), ("albedo", 3), ("normal", 3), ("emission", 3)].map(|(name, values)| {
            let sums = records(graph, &told, format!("voxel.{name}.sums"), 8 * values);
            graph.fill(format!("voxel.{name}.clear"), sums, 0)
        });
        let triangle_count = surface::triangle_count(scene, Surfaces::All)?;
        let scales = scales(scene, triangle_count);
        if triangle_count > 0 {
            let pairs = Pairs::record(graph, scene, voxels, &firsts)?;
            sums = sum(graph, scene, voxels, pairs, sums, &scales);
        }
        // 3. Averages.
        let [albedo, normals, emission] =
            ["albedo", "normals", "emission"].map(|name| records(graph, &told, format!("voxel.{name}"), 16));
        let mut pass = graph.compute("voxel.attributes.average", &average_comp::SHADER);
        let [weight_sums, albedo_sums, normal_sums, emission_sums] = &sums;
        pass.uniform(average_comp::SCALES, &scales)
            .read(average_comp::TOTAL, &total)
            .read(average_comp::WEIGHT_SUMS, weight_sums)
            .read(average_comp::ALBEDO_SUMS, albedo_sums)
            .read(average_comp::NORMAL_SUMS, normal_sums)
            .read(average_comp::EMISSION_SUMS, emission_sums);
        let albedo = pass.write(average_comp::ALBEDO, albedo);
        let normals = pass.write(average_comp::NORMALS, normals);
        let emission = pass.write(average_comp::EMISSION, emission);
        pass.dispatch_indirect(&total, 4);
        Ok(AttributeBuffers { firsts, albedo, normals, emission })
    }
}

/// A buffer with so many bytes for each set voxel.
fn records(graph: &mut Graph, told: &Checkpoint<blocks::Total>, name: String, stride: u64) -> BufferHandle {
    graph.buffer_after(told, name, move |total| stride * u64::from(total[0].total.max(1)))
}

/// Pixels of a pass along each side: every device draws so many.
const SIDE: u32 = 4096;

/// Adds triangles to the sums of their voxels, a pixel a pair, draw by draw as each has textures of its own.
fn sum<'f>(
    graph: &mut Graph<'f>,
    scene: &'f GpuScene,
    voxels: &impl VoxelSet,
    pairs: Pairs,
    [weights, albedo, normals, emission]: [BufferHandle; 4],
    scales: &blocks::AttributeScales,
) -> [BufferHandle; 4] {
    let texture_sets = scene.draws.texture_sets(&[DrawClass::Opaque, DrawClass::Masked, DrawClass::Blend]);
    let program = Program::new(&pairs_vert::SHADER, Some(&sum_frag::SHADER))
        .set_layout(1, &scene.material_layout)
        .constant(sum_frag::EMITS, scales.greatest_emission > 0.0);
    let programs = texture_sets.iter().map(|&set| program.clone().constant(sum_frag::TEXTURES, set)).collect();
    let mut pass = graph.raster("voxel.attributes", programs);
    pass.area([SIDE; 2])
        .uniform(sum_frag::VOXEL_GRID, &voxels.grid().block(voxels.axis()))
        .uniform(sum_frag::SCALES, scales)
        .constant(sum_frag::INSTANCES, &scene.instances)
        .constant(sum_frag::INDICES, &scene.indices)
        .constant(sum_frag::POSITIONS, &scene.positions)
        .constant(sum_frag::ALPHA_VERTICES, &scene.alpha_attributes)
        .constant(sum_frag::SHADING_VERTICES, &scene.shading_attributes)
        .read(sum_frag::PAIR_TRIANGLES, &pairs.triangles)
        .read(sum_frag::PAIR_VOXELS, &pairs.voxels);
    let weights = pass.write(sum_frag::WEIGHT_SUMS, weights);
    let albedo = pass.write(sum_frag::ALBEDO_SUMS, albedo);
    let normals = pass.write(sum_frag::NORMAL_SUMS, normals);
    let emission = pass.write(sum_frag::EMISSION_SUMS, emission);
    pass.draw(move |recorder| {
        let counts = pairs.counts.values()?;
        for ((draw, &count), start) in scene.draws.draws().iter().zip(counts).zip(pairs::starts(counts)) {
            recorder.program(texture_sets.iter().position(|&set| set == draw.textures).unwrap_or(0));
            recorder.faces(vk::CullModeFlags::NONE, false);
            recorder.material(&scene.material_sets[draw.material]);
            for begin in (0..count).step_by((SIDE * SIDE) as usize) {
                // About as high as wide, for drivers that draw pixels by blocks.
                let count = (count - begin).min(SIDE * SIDE);
                let width = f64::from(count).sqrt().ceil() as u32;
                let is_opaque = u32::from(draw.class == DrawClass::Opaque);
                recorder.push(&blocks::AttributesPush { is_opaque, first: start + begin, count, width });
                recorder.scissor([0; 2], [width, count.div_ceil(width)]);
                recorder.draw(0..3, 0..1);
            }
        }
        Ok(())
    });
    [weights, albedo, normals, emission]
}

/// Units of the sums. A triangle has one part in a voxel, of at most √2 squares of its edge: with so many triangles, no sum
/// of weights of that many bits reaches 64 bits.
fn scales(scene: &GpuScene, triangles: u32) -> blocks::AttributeScales {
    let triangle_bits = u32::BITS - triangles.leading_zeros();
    let weight_bits = WEIGHT_BITS.min(SUM_BITS - VALUE_BITS - triangle_bits);
    let emitted = scene.materials.iter().map(|material| material.emissive.max_element());
    let greatest = emitted.filter(|most| most.is_finite()).fold(0.0, f32::max);
    let area_scale = f32::from(2_u16).powi(weight_bits as i32 - 1);
    blocks::AttributeScales { area_scale, greatest_emission: greatest, channels: 3 }
}

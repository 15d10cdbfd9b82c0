//! What surfaces are like in each voxel: albedo, opacity, normal and emission, averaged by area. Sums are in fixed point,
//! so the order of triangles has no say in them.
//!
//! Sources: Crassin and Green 2012, "Octree-Based Sparse Voxelization Using the GPU Hardware Rasterizer", OpenGL Insights,
//! section 22.3, for triangles drawn along the axis they face most and values averaged by atomics; Sutherland and Hodgman
//! 1974, "Reentrant Polygon Clipping", for the part of a triangle in a voxel.

mod ranks;
mod values;

pub use values::{Attribute, VoxelAttributes};

use super::{VoxelBits, cover, surface};
use crate::Result;
use crate::graph::{BufferHandle, Checkpoint, Graph};
use crate::scene::{Draw, DrawClass, Faces, GpuScene};
use crate::shader::Program;
use crate::shader::generated::blocks;
use crate::shader::generated::voxel::attributes::{average_comp, sum_frag, sum_vert};
use ranks::Ranks;

/// Averages what surfaces are like over the parts of triangles in each set voxel.
///
/// A part counts by its area times its alpha, and is looked at in its middle, with textures filtered as wide as it is.
/// Alpha is that of glTF: 1 for opaque materials, and for masked ones not compared with the cutoff, so that what a voxel
/// sees of a fence is how much of it is there. Normals are shading normals of fronts, normal maps included. Albedo and
/// alpha are taken as 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attributes {}

/// Attributes of the set voxels of a grid, one behind the other: by word of the bits, and within a word from its lowest bit.
/// Those of voxel `k` of a column stand at `firsts[word]` plus the set bits below bit `k % 32` of that word.
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
    /// Attributes of all set voxels. Their number is read by the host, and sizes the buffers.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where the device cannot bind the counts at once. Where it cannot bind the sums of so many
    /// voxels, the frame ends with an error that names the buffer.
    pub fn record<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        voxels: &VoxelBits,
    ) -> Result<AttributeBuffers> {
        // 1. A place for each set voxel.
        let Ranks { firsts, total, told } = Ranks::record(graph, voxels)?;
        // 2. The sums, each of two words.
        let sums = [("weight", 2), ("albedo", 3), ("normal", 3), ("emission", 3)].map(|(name, values)| {
            let sums = records(graph, &told, format!("voxel.{name}.sums"), 8 * values);
            graph.fill(format!("voxel.{name}.clear"), sums, 0)
        });
        let scales =
            scales(scene, surface::triangle_starts(scene, surface::Surfaces::All).last().copied().unwrap_or(0));
        let sums = sum(graph, scene, voxels, &firsts, sums, &scales);
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

/// Draws every triangle over its voxels, and adds it to their sums.
fn sum<'f>(
    graph: &mut Graph<'f>,
    scene: &'f GpuScene,
    voxels: &VoxelBits,
    firsts: &BufferHandle,
    [weights, albedo, normals, emission]: [BufferHandle; 4],
    scales: &blocks::AttributeScales,
) -> [BufferHandle; 4] {
    let texture_sets = scene.draws.texture_sets(&[DrawClass::Opaque, DrawClass::Masked, DrawClass::Blend]);
    let program = Program::new(&sum_vert::SHADER, Some(&sum_frag::SHADER)).set_layout(1, &scene.material_layout);
    let programs = texture_sets.iter().map(|&set| program.clone().constant(sum_frag::TEXTURES, set)).collect();
    let mut pass = graph.raster("voxel.attributes", programs);
    cover::bind(&mut pass, scene, &voxels.grid, voxels.axis);
    pass.uniform(sum_frag::SCALES, scales)
        .constant(sum_frag::ALPHA_VERTICES, &scene.alpha_attributes)
        .constant(sum_frag::SHADING_VERTICES, &scene.shading_attributes)
        .read(sum_frag::BITS, &voxels.bits)
        .read(sum_frag::FIRSTS, firsts);
    let weights = pass.write(sum_frag::WEIGHT_SUMS, weights);
    let albedo = pass.write(sum_frag::ALBEDO_SUMS, albedo);
    let normals = pass.write(sum_frag::NORMAL_SUMS, normals);
    let emission = pass.write(sum_frag::EMISSION_SUMS, emission);
    pass.draw(move |recorder| {
        let state = |draw: &Draw| (draw.textures, draw.class == DrawClass::Opaque);
        for run in scene.draws.draws().chunk_by(|a, b| state(a) == state(b)) {
            let (textures, is_opaque) = state(&run[0]);
            recorder.program(texture_sets.iter().position(|&set| set == textures).unwrap_or(0));
            recorder.push(&u32::from(is_opaque));
            scene.draw_pulled(recorder, Faces::Both, run);
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
    blocks::AttributeScales { area_scale: f32::from(2_u16).powi(weight_bits as i32 - 1), greatest_emission: greatest }
}

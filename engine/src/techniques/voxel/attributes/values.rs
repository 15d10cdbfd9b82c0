//! Attributes of voxels on the host.

use glam::{Vec3, Vec4};

use super::AttributeBuffers;
use crate::graph::{Executed, Graph};
use crate::techniques::voxel::Voxels;
use crate::{Error, Result};

/// What surfaces are like in a voxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attribute {
    /// Linear, of what is there.
    pub albedo: Vec3,
    /// Mean alpha, 0 to 1.
    pub opacity: f32,
    /// Mean of unit normals, world space.
    pub normal: Vec3,
    /// Of surfaces, in squares of a voxel's edge; 0 where the voxel holds none.
    pub area: f32,
    /// Radiance, cd/m².
    pub emission: Vec3,
}

/// Voxels with their attributes.
#[derive(Clone, Debug, PartialEq)]
pub struct VoxelAttributes {
    voxels: Voxels,
    firsts: Vec<u32>,
    attributes: Vec<Attribute>,
}

/// Names of the captures, in the order of [`AttributeBuffers`].
const NAMES: [&str; 4] = ["firsts", "albedo", "normals", "emission"];

impl AttributeBuffers {
    /// Captures all of them, for [`VoxelAttributes::read`].
    pub fn capture(&self, graph: &mut Graph) {
        let all = [&self.firsts, &self.albedo, &self.normals, &self.emission];
        for (name, buffer) in NAMES.iter().zip(all) {
            graph.capture(format!("voxel.attributes.{name}"), buffer);
        }
    }
}

impl VoxelAttributes {
    /// From the captures of [`AttributeBuffers::capture`], for the voxels that they were recorded with.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a capture is not there or has another size; [`Error::Vulkan`] where it cannot be read.
    pub fn read(executed: &Executed, voxels: Voxels) -> Result<Self> {
        let capture = |name: &str| executed.capture(&format!("voxel.attributes.{name}"));
        let firsts: Vec<u32> = capture(NAMES[0])?.texels()?;
        let [albedo, normals, emission] = [1, 2, 3].map(|i| capture(NAMES[i])?.texels::<[f32; 4]>());
        let (albedo, normals, emission) = (albedo?, normals?, emission?);
        let lengths = [albedo.len(), normals.len(), emission.len()];
        if firsts.len() != voxels.words().len() || lengths != [voxels.count().max(1) as usize; 3] {
            let why = format!("they are of {lengths:?} voxels in {} words", firsts.len());
            return Err(Error::invalid("the captured attributes", format!("{why}; {} are set", voxels.count())));
        }
        let attributes = albedo.into_iter().zip(normals).zip(emission).map(|((albedo, normal), emission)| Attribute {
            albedo: Vec4::from(albedo).truncate(),
            opacity: albedo[3],
            normal: Vec4::from(normal).truncate(),
            area: normal[3],
            emission: Vec4::from(emission).truncate(),
        });
        Ok(Self { firsts, attributes: attributes.collect(), voxels })
    }

    /// Which voxels are set.
    pub fn voxels(&self) -> &Voxels {
        &self.voxels
    }

    /// Of a set voxel.
    pub fn get(&self, voxel: [u32; 3]) -> Option<&Attribute> {
        let (word, before) = self.voxels.rank(voxel)?;
        self.attributes.get((self.firsts[word] + before) as usize)
    }
}

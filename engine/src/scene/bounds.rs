//! Extent and size of a scene.

use super::{Mesh, Primitive, Scene};
use crate::geometry::Aabb;

impl Scene {
    /// World-space box around all vertices that the objects' triangles use; `None` for a scene without triangles.
    pub fn bounds(&self) -> Option<Aabb> {
        let objects = self.objects.iter().filter_map(|object| {
            let mesh = self.meshes.get(object.mesh)?;
            Aabb::around(mesh.corners().map(|p| object.world_from_object.transform_point3(p)))
        });
        objects.reduce(Aabb::union)
    }

    /// Triangles drawn: those of a mesh count once for each of its objects.
    pub fn triangle_count(&self) -> u64 {
        let triangles: Vec<u64> = self.meshes.iter().map(Mesh::triangle_count).collect();
        self.objects.iter().filter_map(|object| triangles.get(object.mesh)).sum()
    }
}

impl Mesh {
    /// Triangles of all primitives.
    pub fn triangle_count(&self) -> u64 {
        self.primitives.iter().map(Primitive::triangle_count).sum()
    }

    /// Object-space box around all triangles; `None` without triangles.
    pub fn bounds(&self) -> Option<Aabb> {
        Aabb::around(self.corners())
    }

    /// Positions that triangles use; of an indexed vertex at least once.
    fn corners(&self) -> impl Iterator<Item = glam::Vec3> {
        self.primitives.iter().flat_map(|primitive| {
            let mut used = vec![false; primitive.positions.len()];
            for &index in &primitive.indices {
                if let Some(used) = used.get_mut(index as usize) {
                    *used = true;
                }
            }
            primitive.positions.iter().zip(used).filter(|(_, used)| *used).map(|(p, _)| *p)
        })
    }
}

impl Primitive {
    /// A third of the indices.
    pub fn triangle_count(&self) -> u64 {
        self.indices.len() as u64 / 3
    }
}

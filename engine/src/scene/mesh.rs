//! Triangle meshes and their instances.

use std::collections::{HashMap, HashSet};

use glam::{Mat4, Vec2, Vec3, Vec4};

use super::Scene;

/// Geometry that objects share.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name, for messages.
    pub name: String,
    /// Parts with one material each.
    pub primitives: Vec<Primitive>,
}

impl Mesh {
    /// Edges that an odd number of triangles share: 0 where the surface is closed, so that points are inside or
    /// outside. Vertices at equal positions count as one.
    pub fn open_edges(&self) -> usize {
        let mut points: HashMap<[u32; 3], usize> = HashMap::new();
        let mut odd: HashSet<[usize; 2]> = HashSet::new();
        for primitive in &self.primitives {
            // Adding 0 makes of -0 what it equals.
            let key = |&index: &u32| primitive.positions[index as usize].to_array().map(|c| (c + 0.0).to_bits());
            for triangle in primitive.indices.as_chunks::<3>().0 {
                let corners = triangle.each_ref().map(|index| {
                    let next = points.len();
                    *points.entry(key(index)).or_insert(next)
                });
                for [a, b] in [[0, 1], [1, 2], [2, 0]].map(|edge| edge.map(|i: usize| corners[i])) {
                    let edge = [a.min(b), a.max(b)];
                    if a != b && !odd.insert(edge) {
                        odd.remove(&edge);
                    }
                }
            }
        }
        odd.len()
    }
}

impl Scene {
    /// Meshes whose surface is not closed, with the number of their open edges.
    pub fn open_meshes(&self) -> Vec<(&str, usize)> {
        let open = self.meshes.iter().map(|mesh| (mesh.name.as_str(), mesh.open_edges()));
        open.filter(|&(_, edges)| edges > 0).collect()
    }
}

/// Indexed triangles with one material. All attribute arrays are as long as `positions`.
///
/// `id.primitive` counts triangles over the primitives of a mesh in order, from 1.
#[derive(Clone, Debug, Default)]
pub struct Primitive {
    /// Object space, metres.
    pub positions: Vec<Vec3>,
    /// Object space, unit length.
    pub normals: Vec<Vec3>,
    /// Object space, unit length; `w` is the sign of the bitangent, `cross(normal, tangent) * w`. Zero vectors
    /// where the material has no normal map.
    pub tangents: Vec<Vec4>,
    /// First and second texture coordinates, (0, 0) at the upper left.
    pub uvs: [Vec<Vec2>; 2],
    /// Linear RGBA factors, 1 where the file has none.
    pub colors: Vec<Vec4>,
    /// Three a triangle, counter-clockwise seen from the front. All in range.
    pub indices: Vec<u32>,
    /// Index into [`crate::scene::Scene::materials`].
    pub material: usize,
}

/// An instance of a mesh.
#[derive(Clone, Debug)]
pub struct Object {
    /// Name made unique in the scene.
    pub name: String,
    /// Index into [`crate::scene::Scene::meshes`].
    pub mesh: usize,
    /// Affine; may mirror, shear, or be singular.
    pub world_from_object: Mat4,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_closed_surface_has_no_open_edge() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 1.0]].map(Vec3::from);
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        // Every triangle with vertices of its own, as flat shading has them, over two primitives.
        let primitive = |faces: &[[usize; 3]]| {
            let positions: Vec<_> = faces.iter().flatten().map(|&corner| corners[corner]).collect();
            Primitive { indices: (0..positions.len() as u32).collect(), positions, ..Primitive::default() }
        };
        let mesh = |parts: &[&[[usize; 3]]]| Mesh {
            name: String::new(),
            primitives: parts.iter().map(|faces| primitive(faces)).collect(),
        };
        // The same point may be written with either zero.
        let mut halves = mesh(&[&faces[..2], &faces[2..]]);
        halves.primitives[1].positions.iter_mut().for_each(|p| *p = p.map(|c| if c == 0.0 { -c } else { c }));
        assert_eq!(halves.open_edges(), 0);
        assert_eq!(mesh(&[&faces[..1], &faces[1..]]).open_edges(), 0);
        assert_eq!(mesh(&[&faces[1..]]).open_edges(), 3);
        assert_eq!(mesh(&[&faces, &[[1, 1, 2]]]).open_edges(), 0, "a folded triangle opens nothing");
        assert_eq!(mesh(&[]).open_edges(), 0);
    }
}

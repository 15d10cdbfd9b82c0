//! Triangle meshes and their instances.

use glam::{Mat4, Vec2, Vec3, Vec4};

/// Geometry that objects share.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name, for messages.
    pub name: String,
    /// Parts with one material each.
    pub primitives: Vec<Primitive>,
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

//! Tangents by MikkTSpace, as glTF 2.0 asks where a file has none (section 3.7.2.1).

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec3, Vec4};

use crate::scene::{Primitive, TextureSlot};

/// Gives each vertex a tangent along u as the normal map is laid, with its transform. Where triangles that share a
/// vertex disagree, it is split. All other attributes stand already.
pub fn generate(primitive: &mut Primitive, normal_map: &TextureSlot) {
    let mut corners = Corners { primitive, normal_map, tangents: vec![Vec4::ZERO; primitive.indices.len()] };
    // Its error type has no value.
    let _ = generate_tangents(&mut corners);
    let tangents = corners.tangents;
    split(primitive, &tangents);
}

/// Unit length and a sign; where there is no direction, one perpendicular to the normal.
pub fn repaired(tangent: Vec4, normal: Vec3) -> Vec4 {
    let direction = tangent.truncate().try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
    direction.extend(if tangent.w < 0.0 { -1.0 } else { 1.0 })
}

struct Corners<'a> {
    primitive: &'a Primitive,
    normal_map: &'a TextureSlot,
    tangents: Vec<Vec4>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.primitive.indices.get(face * 3 + corner).map_or(0, |&index| index as usize)
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.primitive.indices.len() / 3
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.positions.get(self.vertex(face, corner)).map_or([0.0; 3], |p| p.to_array())
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.normals.get(self.vertex(face, corner)).map_or([0.0; 3], |n| n.to_array())
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        // MikkTSpace has v point up, glTF down: its bitangent is to point up the image.
        let TextureSlot { uv_set, transform, .. } = *self.normal_map;
        let uv = self.primitive.uvs.get(uv_set).and_then(|uvs| uvs.get(self.vertex(face, corner)));
        uv.map_or([0.0; 2], |&uv| {
            let uv = transform.transform_point2(uv);
            [uv.x, 1.0 - uv.y]
        })
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let normal = Vec3::from(self.normal(face, corner));
        let tangent = space.map_or(Vec4::W, |space| Vec4::from(space.tangent_encoded()));
        if let Some(place) = self.tangents.get_mut(face * 3 + corner) {
            *place = repaired(tangent, normal);
        }
    }
}

/// Sets tangents that are known by corner, and appends a copy of a vertex for each further tangent.
fn split(primitive: &mut Primitive, corners: &[Vec4]) {
    const NONE: u32 = u32::MAX;
    let count = primitive.positions.len();
    primitive.tangents = primitive.normals.iter().map(|&normal| repaired(Vec4::W, normal)).collect();
    let mut set = vec![false; count];
    // Copies of a vertex form a chain.
    let mut next = vec![NONE; count];
    for (index, &tangent) in primitive.indices.iter_mut().zip(corners) {
        let mut vertex = *index as usize;
        if !set[vertex] {
            set[vertex] = true;
            primitive.tangents[vertex] = tangent;
            continue;
        }
        while primitive.tangents[vertex] != tangent && next[vertex] != NONE {
            vertex = next[vertex] as usize;
        }
        if primitive.tangents[vertex] != tangent {
            let copy = primitive.positions.len();
            next[vertex] = copy as u32;
            next.push(NONE);
            set.push(true);
            primitive.positions.push(primitive.positions[vertex]);
            primitive.normals.push(primitive.normals[vertex]);
            primitive.colors.push(primitive.colors[vertex]);
            primitive.uvs.iter_mut().for_each(|uvs| uvs.push(uvs[vertex]));
            primitive.tangents.push(tangent);
            vertex = copy;
        }
        *index = vertex as u32;
    }
}

#[cfg(test)]
mod tests {
    use glam::{Mat3, Vec2};

    use super::*;

    const fn map(uv_set: usize) -> TextureSlot {
        TextureSlot { texture: 0, uv_set, transform: Mat3::IDENTITY }
    }

    /// A quad in the xy plane, seen from +z, with an image upright on it.
    fn quad(mirrored: bool) -> Primitive {
        let u = |x: f32| if mirrored { 1.0 - x } else { x };
        Primitive {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            normals: vec![Vec3::Z; 4],
            uvs: [
                vec![Vec2::new(u(0.0), 1.0), Vec2::new(u(1.0), 1.0), Vec2::new(u(1.0), 0.0), Vec2::new(u(0.0), 0.0)],
                vec![Vec2::ZERO; 4],
            ],
            colors: vec![Vec4::ONE; 4],
            indices: vec![0, 1, 2, 0, 2, 3],
            ..Primitive::default()
        }
    }

    #[test]
    fn the_bitangent_points_up_the_image() {
        for mirrored in [false, true] {
            let mut quad = quad(mirrored);
            generate(&mut quad, &map(0));
            assert_eq!(quad.positions.len(), 4);
            for (normal, tangent) in quad.normals.iter().zip(&quad.tangents) {
                let along_u = if mirrored { Vec3::NEG_X } else { Vec3::X };
                assert!((tangent.truncate() - along_u).length() < 1e-6, "{tangent}");
                let bitangent = normal.cross(tangent.truncate()) * tangent.w;
                assert!((bitangent - Vec3::Y).length() < 1e-6, "{bitangent}");
            }
        }
    }

    #[test]
    fn a_turned_normal_map_turns_the_tangents() {
        let mut quad = quad(false);
        // u runs down the quad: u' = v.
        let transform = Mat3::from_cols_array_2d(&[[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        generate(&mut quad, &TextureSlot { transform, ..map(0) });
        for tangent in &quad.tangents {
            assert!((tangent.truncate() - Vec3::NEG_Y).length() < 1e-6, "{tangent}");
            // v' = −u: the image's up runs with u.
            let bitangent = Vec3::Z.cross(tangent.truncate()) * tangent.w;
            assert!((bitangent - Vec3::X).length() < 1e-6, "{bitangent}");
        }
    }

    #[test]
    fn without_coordinates_a_tangent_is_still_a_unit_vector() {
        let mut quad = quad(false);
        generate(&mut quad, &map(1));
        assert!(quad.tangents.iter().all(|t| (t.truncate().length() - 1.0).abs() < 1e-6), "{:?}", quad.tangents);
    }

    #[test]
    fn a_vertex_on_a_mirror_seam_is_split() {
        // Two triangles that share an edge, with u running away from it on both sides.
        let mut primitive = Primitive {
            positions: vec![Vec3::ZERO, Vec3::Y, Vec3::X, Vec3::NEG_X],
            normals: vec![Vec3::Z; 4],
            uvs: [vec![Vec2::Y, Vec2::ZERO, Vec2::ONE, Vec2::ONE], vec![Vec2::ZERO; 4]],
            colors: vec![Vec4::ONE; 4],
            indices: vec![0, 2, 1, 0, 1, 3],
            ..Primitive::default()
        };
        generate(&mut primitive, &map(0));
        assert_eq!(primitive.positions.len(), 6);
        let right = primitive.tangents[primitive.indices[0] as usize];
        let left = primitive.tangents[primitive.indices[3] as usize];
        assert!(right.x > 0.99 && left.x < -0.99, "{right} {left}");
        assert_eq!(right.w, -left.w);
        assert_eq!(primitive.positions[primitive.indices[3] as usize], Vec3::ZERO);
    }
}

//! Tangents by MikkTSpace, as glTF 2.0 asks where a file has none (section 3.7.2.1).

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec3, Vec4};

use crate::parallel;
use crate::scene::{Primitive, TextureSlot};

/// Gives each vertex a tangent along u as the normal map is laid, with its transform. Where triangles that share a
/// vertex disagree, it is split. All other attributes stand already.
pub fn generate(primitive: &mut Primitive, normal_map: &TextureSlot) {
    let groups = independent_faces(primitive, normal_map);
    let of_group = |i: usize| Ok(corner_tangents(primitive, normal_map, &groups[i]));
    // Tangents perpendicular to the normals stand in for a group that could not be done.
    let done: Result<Vec<_>, ()> = parallel::map(groups.len(), of_group, |_| ());
    let mut corners: Vec<Vec4> = primitive
        .indices
        .iter()
        .map(|&index| repaired(Vec4::W, primitive.normals.get(index as usize).copied().unwrap_or(Vec3::Y)))
        .collect();
    let (faces, _) = corners.as_chunks_mut::<3>();
    for (&face, tangents) in groups.iter().flatten().zip(done.unwrap_or_default().iter().flatten()) {
        faces[face] = *tangents;
    }
    split(primitive, &corners);
}

/// Tangents of these faces, by face and corner.
fn corner_tangents(primitive: &Primitive, normal_map: &TextureSlot, faces: &[usize]) -> Vec<[Vec4; 3]> {
    let mut corners = Corners { primitive, normal_map, faces, tangents: vec![[Vec4::ZERO; 3]; faces.len()] };
    // Its error type has no value.
    let _ = generate_tangents(&mut corners);
    corners.tangents
}

/// Faces in groups, so that faces of different groups have no vertex in common. MikkTSpace looks no further than
/// that: the groups can be done at the same time, with the same result.
fn independent_faces(primitive: &Primitive, normal_map: &TextureSlot) -> Vec<Vec<usize>> {
    /// A mesh of fewer faces is done sooner than it is divided.
    const WORTHWHILE: usize = 10_000;
    const GROUPS: usize = 8;
    let faces = primitive.indices.as_chunks::<3>().0;
    if faces.len() < WORTHWHILE {
        return vec![(0..faces.len()).collect()];
    }

    // 1. Vertices that MikkTSpace welds have equal position, normal and coordinates. Adding 0 makes -0 equal to 0.
    let whole = Corners { primitive, normal_map, faces: &[], tangents: Vec::new() };
    let mut welded = HashMap::new();
    let mut parents: Vec<usize> = Vec::with_capacity(primitive.positions.len());
    for (vertex, (position, normal)) in primitive.positions.iter().zip(&primitive.normals).enumerate() {
        let [u, v] = whole.coordinates(vertex);
        let key = [position.x, position.y, position.z, normal.x, normal.y, normal.z, u, v].map(|x| (x + 0.0).to_bits());
        parents.push(*welded.entry(key).or_insert(vertex));
    }

    // 2. The corners of a face belong together.
    fn root(parents: &mut [usize], mut vertex: usize) -> usize {
        while parents[vertex] != vertex {
            parents[vertex] = parents[parents[vertex]];
            vertex = parents[vertex];
        }
        vertex
    }
    for face in faces {
        let [a, b, c] = face.map(|index| root(&mut parents, index as usize));
        let least = a.min(b).min(c);
        for other in [a, b, c] {
            parents[other] = least;
        }
    }

    // 3. Whole islands into the group that has the fewest faces so far; faces keep their order.
    let mut sizes = vec![0usize; parents.len()];
    let roots: Vec<usize> = faces.iter().map(|face| root(&mut parents, face[0] as usize)).collect();
    roots.iter().for_each(|&root| sizes[root] += 1);
    let mut group_of = vec![usize::MAX; parents.len()];
    let mut filled = [0usize; GROUPS];
    let mut groups = vec![Vec::new(); GROUPS];
    for (face, &root) in roots.iter().enumerate() {
        if group_of[root] == usize::MAX {
            let emptiest = (0..GROUPS).min_by_key(|&group| filled[group]).unwrap_or(0);
            group_of[root] = emptiest;
            filled[emptiest] += sizes[root];
        }
        groups[group_of[root]].push(face);
    }
    groups
}

/// Unit length and a sign; where there is no direction, one perpendicular to the normal.
pub fn repaired(tangent: Vec4, normal: Vec3) -> Vec4 {
    let direction = tangent.truncate().try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
    direction.extend(if tangent.w < 0.0 { -1.0 } else { 1.0 })
}

struct Corners<'a> {
    primitive: &'a Primitive,
    normal_map: &'a TextureSlot,
    /// The faces that are looked at.
    faces: &'a [usize],
    tangents: Vec<[Vec4; 3]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        let index = self.faces.get(face).and_then(|face| self.primitive.indices.get(face * 3 + corner));
        index.map_or(0, |&index| index as usize)
    }

    /// MikkTSpace has v point up, glTF down: its bitangent is to point up the image.
    fn coordinates(&self, vertex: usize) -> [f32; 2] {
        let TextureSlot { uv_set, transform, .. } = *self.normal_map;
        self.primitive.uvs.get(uv_set).and_then(|uvs| uvs.get(vertex)).map_or([0.0; 2], |&uv| {
            let uv = transform.transform_point2(uv);
            [uv.x, 1.0 - uv.y]
        })
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.faces.len()
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
        self.coordinates(self.vertex(face, corner))
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let normal = Vec3::from(self.normal(face, corner));
        let tangent = space.map_or(Vec4::W, |space| Vec4::from(space.tangent_encoded()));
        if let Some(place) = self.tangents.get_mut(face).and_then(|corners| corners.get_mut(corner)) {
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

    #[test]
    fn groups_of_faces_give_what_the_whole_gives() {
        // Forty bent patches of 288 triangles with their faces interleaved; half of them mirror their coordinates.
        let mut primitive = Primitive::default();
        let mut faces: Vec<Vec<[u32; 3]>> = Vec::new();
        for patch in 0..40u32 {
            let first = primitive.positions.len() as u32;
            for (i, j) in (0..13).flat_map(|j| (0..13).map(move |i| (i as f32, j as f32))) {
                primitive
                    .positions
                    .push(Vec3::new(i, j, (i * 0.7).sin() + (j * 0.4).cos()) + Vec3::X * 20.0 * patch as f32);
                primitive.normals.push(Vec3::new((i * 0.7).cos() * -0.7, (j * 0.4).sin() * 0.4, 1.0).normalize());
                let side = if patch % 2 == 0 { 1.0 } else { -1.0 };
                primitive.uvs[0].push(Vec2::new(side * i * 0.1 + 0.01 * j, j * j * 0.02));
                primitive.uvs[1].push(Vec2::ZERO);
                primitive.colors.push(Vec4::ONE);
            }
            let quads = (0..12).flat_map(|j| (0..12).map(move |i| first + j * 13 + i));
            faces.push(quads.flat_map(|q| [[q, q + 1, q + 14], [q, q + 14, q + 13]]).collect());
        }
        let interleaved = (0..288).flat_map(|k| faces.iter().map(move |patch| patch[k]));
        primitive.indices = interleaved.flatten().collect();

        let groups = independent_faces(&primitive, &map(0));
        assert_eq!(groups.len(), 8);
        assert!(
            groups.iter().all(|group| group.len() == 5 * 288),
            "{:?}",
            groups.iter().map(Vec::len).collect::<Vec<_>>()
        );
        let all: Vec<usize> = (0..primitive.indices.len() / 3).collect();
        let whole = corner_tangents(&primitive, &map(0), &all);
        for group in &groups {
            let part = corner_tangents(&primitive, &map(0), group);
            for (face, tangents) in group.iter().zip(part) {
                assert_eq!(tangents, whole[*face], "face {face}");
            }
        }
    }
}

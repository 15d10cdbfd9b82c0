//! Builders of small meshes with normals, tangents and texture coordinates in metres.
//!
//! A [`Shape`] collects triangles; its methods add boxes, turned profiles, swept and extruded outlines, patches and
//! cards under a transform.

use glam::{Vec2, Vec3, Vec4};

use crate::scene::Primitive;

/// Triangles under construction: one material, counter-clockwise seen from the front.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    tangents: Vec<Vec4>,
    uvs: Vec<Vec2>,
    indices: Vec<u32>,
}

/// A vertex of a [`Shape::grid`].
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// Metres.
    pub position: Vec3,
    /// Unit length, or zero where the triangles around it are to give the normal.
    pub normal: Vec3,
    /// Metres, v down.
    pub uv: Vec2,
}

impl Shape {
    /// No triangles.
    pub fn new() -> Self {
        Self::default()
    }

    /// As many as there are.
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// All of it as a primitive of this material.
    pub fn primitive(self, material: usize) -> Primitive {
        let count = self.positions.len();
        Primitive {
            positions: self.positions,
            normals: self.normals,
            tangents: self.tangents,
            uvs: [self.uvs, vec![Vec2::ZERO; count]],
            colors: vec![Vec4::ONE; count],
            indices: self.indices,
            material,
        }
    }

    /// A planar quad: corners counter-clockwise from the lower left, coordinates in metres along its first edge.
    pub fn quad(&mut self, corners: [Vec3; 4]) -> &mut Self {
        let [a, b, c, d] = corners;
        let u = (b - a).normalize_or(Vec3::X);
        let normal = (b - a).cross(d - a).normalize_or(Vec3::Y);
        let up = normal.cross(u);
        let uv = |p: Vec3| Vec2::new((p - a).dot(u), -(p - a).dot(up));
        let first = self.positions.len() as u32;
        for p in [a, b, c, d] {
            self.push(p, normal, u.extend(1.0), uv(p));
        }
        self.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
        self
    }

    /// A box from `min` to `max`, its six faces outwards.
    pub fn cuboid(&mut self, min: Vec3, max: Vec3) -> &mut Self {
        let p = |x: f32, y: f32, z: f32| min + (max - min) * Vec3::new(x, y, z);
        self.quad([p(0., 0., 1.), p(1., 0., 1.), p(1., 1., 1.), p(0., 1., 1.)]);
        self.quad([p(1., 0., 0.), p(0., 0., 0.), p(0., 1., 0.), p(1., 1., 0.)]);
        self.quad([p(1., 0., 1.), p(1., 0., 0.), p(1., 1., 0.), p(1., 1., 1.)]);
        self.quad([p(0., 0., 0.), p(0., 0., 1.), p(0., 1., 1.), p(0., 1., 0.)]);
        self.quad([p(0., 1., 1.), p(1., 1., 1.), p(1., 1., 0.), p(0., 1., 0.)]);
        self.quad([p(0., 0., 0.), p(1., 0., 0.), p(1., 0., 1.), p(0., 0., 1.)])
    }

    fn push(&mut self, position: Vec3, normal: Vec3, tangent: Vec4, uv: Vec2) {
        self.positions.push(position);
        self.normals.push(normal);
        self.tangents.push(tangent);
        self.uvs.push(uv);
    }
}

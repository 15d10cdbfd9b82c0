//! A scene as world-space triangles in double precision, and rays through it.
//!
//! - World positions are `world_from_object · position`, in double precision.
//! - A triangle's front is where its vertices run counter-clockwise; under a transform with a negative determinant,
//!   where they run clockwise (glTF 2.0, section 3.7.4).
//! - Camera rays pass through the backs of single-sided materials (section 3.9.5); shadow rays stop at both faces.
//! - `MASK` materials are there where alpha ≥ cutoff (section 3.9.4). Alpha is filtered as [`super::texture`] says;
//!   with [`Footprint::Quad`] at the level of detail that a device takes from the 2×2 quad of pixels.
//! - `BLEND` materials are left out by both [`Rule`]s: they are not among the first opaque surfaces, and cast no shadow.
//! - Triangles without area are dropped.
//! - The test of a ray against an edge gives exactly opposite values for the two triangles that share it, so no ray
//!   slips through between them (at a vertex, rounding might let one). A camera ray *on* an edge hits by the top-left rule; any other ray hits.
//! - Of surfaces at equal distance the one with the lower triangle number is seen.

use std::ops::ControlFlow;
use std::sync::OnceLock;

use glam::{DMat3, DMat4, DVec3};
use shadowgraph::scene::{AlphaMode, Scene as Source};

use super::bvh::{Bounds, Bvh};
use super::texture::Levels;

/// A scene that rays can be cast through.
pub struct Scene<'a> {
    /// What it was made from.
    pub source: &'a Source,
    /// All triangles, by object, then by primitive, then in order.
    pub triangles: Vec<Triangle>,
    pub(super) placements: Vec<Placement>,
    /// By texture; linear, then sRGB.
    levels: Vec<[OnceLock<Levels>; 2]>,
    bvh: Bvh,
    /// Whether rays meet what is blended; else they pass through it.
    sees_blended: bool,
}

/// A triangle of an object.
#[derive(Clone, Debug)]
pub struct Triangle {
    /// World space.
    pub positions: [DVec3; 3],
    /// Index of the object.
    pub object: u32,
    /// Number within the mesh, counted over its primitives from 0.
    pub number: u32,
    /// Index of the material.
    pub material: u32,
    /// Index of the primitive in the mesh.
    pub primitive: u32,
    /// Indices into the attributes of the primitive.
    pub vertices: [u32; 3],
}

/// How an object's vectors come to world space.
pub(super) struct Placement {
    /// For tangents.
    pub linear: DMat3,
    /// For normals: the cofactor matrix, turned so that a normal stays on the front where the transform mirrors.
    pub normal: DMat3,
    /// −1 where the transform mirrors.
    pub handedness: f64,
}

/// A straight line, by the distance parameter t: `origin + t · direction`.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// At t = 0.
    pub origin: DVec3,
    /// Need not have unit length.
    pub direction: DVec3,
}

/// A line with the part of it that counts, and the width of what it stands for.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// The line.
    pub line: Line,
    /// Least t.
    pub near: f64,
    /// Greatest t.
    pub far: f64,
    /// Area over which textures are filtered.
    pub footprint: Footprint,
}

/// Area over which textures are filtered.
#[derive(Clone, Copy, Debug)]
pub enum Footprint {
    /// None: level 0, magnified.
    Point,
    /// A square of this width in metres on the surface.
    Width(f64),
    /// A pixel: the lines through the upper left, upper right and lower left pixel centres of its 2×2 quad.
    Quad([Line; 3]),
}

/// Which surfaces a ray sees.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Backs of single-sided materials are not there.
    pub culls_backs: bool,
}

impl Rule {
    /// For camera rays.
    pub const CAMERA: Self = Self { culls_backs: true };
    /// For shadow rays.
    pub const SHADOW: Self = Self { culls_backs: false };
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Parameter of the ray's line.
    pub t: f64,
    /// Index into [`Scene::triangles`].
    pub triangle: u32,
    /// Barycentric coordinates.
    pub weights: DVec3,
    /// The ray comes from the front.
    pub front: bool,
    /// Alpha minus cutoff: infinite where the material is not `MASK`. The surface is there where it is not negative.
    pub alpha_excess: f64,
}

impl<'a> Scene<'a> {
    /// Flattens a scene and builds its hierarchy.
    pub fn new(source: &'a Source) -> Self {
        let placements: Vec<_> =
            source.objects.iter().map(|o| Placement::new(o.world_from_object.as_dmat4())).collect();
        let mut triangles = Vec::new();
        for (index, object) in source.objects.iter().enumerate() {
            let world = object.world_from_object.as_dmat4();
            let mut number = 0;
            for (part, primitive) in source.meshes[object.mesh].primitives.iter().enumerate() {
                let positions: Vec<_> =
                    primitive.positions.iter().map(|p| world.transform_point3(p.as_dvec3())).collect();
                for corner in primitive.indices.chunks_exact(3) {
                    let vertices = [corner[0], corner[1], corner[2]];
                    let [a, b, c] = vertices.map(|v| positions[v as usize]);
                    let normal = (b - a).cross(c - a);
                    if normal.is_finite() && normal != DVec3::ZERO {
                        triangles.push(Triangle {
                            positions: [a, b, c],
                            object: index as u32,
                            number,
                            material: primitive.material as u32,
                            primitive: part as u32,
                            vertices,
                        });
                    }
                    number += 1;
                }
            }
        }
        let bounds: Vec<_> = triangles.iter().map(|t| Bounds::of(t.positions)).collect();
        let levels = source.textures.iter().map(|_| Default::default()).collect();
        Self { source, triangles, placements, levels, bvh: Bvh::new(&bounds), sees_blended: false }
    }

    /// The same, where rays meet what is blended as well.
    pub fn seeing_blended(self) -> Self {
        Self { sees_blended: true, ..self }
    }

    /// The box around all triangles, world space.
    pub fn bounds(&self) -> Bounds {
        self.bvh.bounds()
    }

    /// Whether any material is `MASK`.
    pub fn has_masks(&self) -> bool {
        self.source.materials.iter().any(|m| matches!(m.alpha_mode, AlphaMode::Mask { .. }))
    }

    /// The nearest surface.
    pub fn closest(&self, ray: &Ray, rule: Rule) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.each(ray, rule, |hit, far| {
            let nearer = best.is_none_or(|b| hit.t < b.t || (hit.t == b.t && hit.triangle < b.triangle));
            if hit.alpha_excess >= 0.0 && nearer {
                *far = hit.t;
                best = Some(hit);
            }
            ControlFlow::Continue(())
        });
        best
    }

    /// Whether any surface lies on the ray.
    pub fn any(&self, ray: &Ray, rule: Rule) -> bool {
        let mut found = false;
        self.each(ray, rule, |hit, _| {
            found = hit.alpha_excess >= 0.0;
            if found { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        found
    }

    /// All triangles on the ray, in no particular order, those that alpha takes away included. `visit` may lower the
    /// far end, and ends the search with `Break`.
    pub fn each(&self, ray: &Ray, rule: Rule, mut visit: impl FnMut(Hit, &mut f64) -> ControlFlow<()>) {
        self.bvh.walk(ray.line.origin, ray.line.direction, ray.near, ray.far, |index, far| {
            match self.meet(index, ray, *far, rule) {
                Some(hit) => visit(hit, far),
                None => ControlFlow::Continue(()),
            }
        });
    }

    fn meet(&self, index: u32, ray: &Ray, far: f64, rule: Rule) -> Option<Hit> {
        let triangle = &self.triangles[index as usize];
        let (t, weights, along_normal) = triangle.intersect(ray)?;
        let material = &self.source.materials[triangle.material as usize];
        let front = along_normal * self.placements[triangle.object as usize].handedness < 0.0;
        let culled = rule.culls_backs && !front && !material.double_sided;
        if !(ray.near <= t && t <= far) || culled || (material.is_blended() && !self.sees_blended) {
            return None;
        }
        let alpha_excess = match material.alpha_mode {
            AlphaMode::Mask { cutoff } => self.base_color(triangle, weights, ray).w - f64::from(cutoff),
            _ => f64::INFINITY,
        };
        Some(Hit { t, triangle: index, weights, front, alpha_excess })
    }

    pub(super) fn levels(&self, texture: usize, srgb: bool) -> &Levels {
        self.levels[texture][usize::from(srgb)].get_or_init(|| Levels::new(&self.source.textures[texture], srgb))
    }
}

impl Triangle {
    /// Unit normal by the order of the vertices.
    pub fn winding_normal(&self) -> DVec3 {
        let [a, b, c] = self.positions;
        (b - a).cross(c - a).normalize()
    }

    /// Signed volumes that a line spans with the three edges: of one sign where the line passes through the triangle,
    /// and proportional to the barycentric coordinates.
    pub fn edge_volumes(&self, line: &Line) -> DVec3 {
        let [a, b, c] = self.positions.map(|p| p - line.origin);
        DVec3::new(b.cross(c).dot(line.direction), c.cross(a).dot(line.direction), a.cross(b).dot(line.direction))
    }

    /// Barycentric coordinates of the point where a line meets the triangle's plane.
    pub fn weights(&self, line: &Line) -> DVec3 {
        let volumes = self.edge_volumes(line);
        volumes / volumes.element_sum()
    }

    /// t, barycentric coordinates, and direction · normal.
    fn intersect(&self, ray: &Ray) -> Option<(f64, DVec3, f64)> {
        let volumes = self.edge_volumes(&ray.line);
        let sum = volumes.element_sum();
        // Points inside have positive values from here on.
        let inside = volumes * sum.signum();
        if sum == 0.0 || inside.min_element() < 0.0 {
            return None;
        }
        if inside.min_element() == 0.0
            && let Footprint::Quad(quad) = &ray.footprint
        {
            let [at, right, below] = quad.map(|line| self.edge_volumes(&line) * sum.signum());
            let (dx, dy) = (right - at, below - at);
            // Pixels run right and down: left edges have their inside to the right, top edges below.
            let counts = |i: usize| inside[i] > 0.0 || dx[i] > 0.0 || (dx[i] == 0.0 && dy[i] > 0.0);
            if !(0..3).all(counts) {
                return None;
            }
        }
        let [a, b, c] = self.positions;
        let normal = (b - a).cross(c - a);
        let along_normal = normal.dot(ray.line.direction);
        Some((normal.dot(a - ray.line.origin) / along_normal, volumes / sum, along_normal))
    }
}

impl Placement {
    fn new(world: DMat4) -> Self {
        let linear = DMat3::from_mat4(world);
        let handedness = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        let (x, y, z) = (linear.x_axis, linear.y_axis, linear.z_axis);
        let normal = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * handedness;
        Self { linear, normal, handedness }
    }
}

impl Line {
    /// The point at t.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

impl Ray {
    /// All of a half-line, without a footprint.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        let line = Line { origin, direction };
        Self { line, near: 0.0, far: f64::INFINITY, footprint: Footprint::Point }
    }
}

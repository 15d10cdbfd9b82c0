//! Builders of small meshes with normals, tangents and texture coordinates in metres.
//!
//! A [`Shape`] collects triangles of one material; its methods add boxes, patches, turned profiles, lofted outlines,
//! walls with an arch, and cards.

use std::f32::consts::{PI, TAU};

use glam::{Mat3, Mat4, Vec2, Vec3, Vec4, vec2, vec3};

use crate::scene::Primitive;

/// Triangles under construction: counter-clockwise seen from the front, texture coordinates in metres with v down,
/// tangents along u, bitangents up.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    tangents: Vec<Vec4>,
    uvs: Vec<Vec2>,
    indices: Vec<u32>,
}

impl Shape {
    /// No triangles.
    pub fn new() -> Self {
        Self::default()
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

    /// Another shape under a transform that does not mirror.
    pub fn add(&mut self, other: &Self, matrix: Mat4) -> &mut Self {
        let linear = Mat3::from_mat4(matrix);
        let of_normals = linear.inverse().transpose();
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions.iter().map(|&p| matrix.transform_point3(p)));
        self.normals.extend(other.normals.iter().map(|&n| (of_normals * n).normalize()));
        self.tangents.extend(other.tangents.iter().map(|t| (linear * t.truncate()).normalize().extend(t.w)));
        self.uvs.extend(&other.uvs);
        self.indices.extend(other.indices.iter().map(|index| first + index));
        self
    }

    /// A planar quad: corners counter-clockwise from the lower left. Coordinates run along its first edge from its
    /// first corner.
    pub fn quad(&mut self, corners: [Vec3; 4]) -> &mut Self {
        let u = (corners[1] - corners[0]).normalize_or(Vec3::X);
        self.face(corners, corners[0], u)
    }

    /// A planar quad with coordinates that run along `u` from `origin`, so that neighbours fit together.
    pub fn face(&mut self, corners: [Vec3; 4], origin: Vec3, u: Vec3) -> &mut Self {
        let [a, b, c, d] = corners;
        let normal = (c - a).cross(d - b).normalize_or(Vec3::Y);
        let up = normal.cross(u);
        let first = self.positions.len() as u32;
        for p in corners {
            self.vertex(p, normal, u, vec2((p - origin).dot(u), -(p - origin).dot(up)));
        }
        self.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
        self
    }

    /// A box from `min` to `max`, its six faces outwards.
    pub fn cuboid(&mut self, min: Vec3, max: Vec3) -> &mut Self {
        let p = |x: f32, y: f32, z: f32| min + (max - min) * vec3(x, y, z);
        self.face([p(0., 0., 1.), p(1., 0., 1.), p(1., 1., 1.), p(0., 1., 1.)], Vec3::ZERO, Vec3::X);
        self.face([p(1., 0., 0.), p(0., 0., 0.), p(0., 1., 0.), p(1., 1., 0.)], Vec3::ZERO, Vec3::NEG_X);
        self.face([p(1., 0., 1.), p(1., 0., 0.), p(1., 1., 0.), p(1., 1., 1.)], Vec3::ZERO, Vec3::NEG_Z);
        self.face([p(0., 0., 0.), p(0., 0., 1.), p(0., 1., 1.), p(0., 1., 0.)], Vec3::ZERO, Vec3::Z);
        self.face([p(0., 1., 1.), p(1., 1., 1.), p(1., 1., 0.), p(0., 1., 0.)], Vec3::ZERO, Vec3::X);
        self.face([p(0., 0., 0.), p(1., 0., 0.), p(1., 0., 1.), p(0., 0., 1.)], Vec3::ZERO, Vec3::X)
    }

    /// A box of this size that stands on `foot`.
    pub fn block(&mut self, foot: Vec3, size: Vec3) -> &mut Self {
        let half = vec3(size.x * 0.5, 0.0, size.z * 0.5);
        self.cuboid(foot - half, foot + vec3(half.x, size.y, half.z))
    }

    /// A smooth patch of `columns` × `rows` quads. `at` gives position and coordinates for (s, t) in 0 to 1; seen from
    /// the front, s runs to the right with u and t up, against v. A `closed` patch meets itself at s = 1.
    pub fn grid(
        &mut self,
        [columns, rows]: [usize; 2],
        closed: bool,
        at: impl Fn(f32, f32) -> (Vec3, Vec2),
    ) -> &mut Self {
        let width = columns + 1;
        let points: Vec<(Vec3, Vec2)> = (0..=rows)
            .flat_map(|j| (0..=columns).map(move |i| (i as f32 / columns as f32, j as f32 / rows as f32)))
            .map(|(s, t)| at(s, t))
            .collect();
        let point = |i: usize, j: usize| points[j * width + i].0;
        // Differences across a vertex; at an open edge, to one side.
        let along_s = |i: usize, j: usize| match (closed, i) {
            (true, 0) => point(1, j) - point(columns - 1, j),
            (true, i) if i == columns => point(1, j) - point(columns - 1, j),
            _ => point((i + 1).min(columns), j) - point(i.saturating_sub(1), j),
        };
        let along_t = |i: usize, j: usize| point(i, (j + 1).min(rows)) - point(i, j.saturating_sub(1));

        let first = self.positions.len() as u32;
        for j in 0..=rows {
            for i in 0..=columns {
                let (position, uv) = points[j * width + i];
                let mut ds = along_s(i, j);
                if ds.length_squared() < 1e-12 {
                    // A pole: the neighbouring row tells the direction.
                    ds = along_s(i, if j == 0 { 1 } else { j - 1 });
                }
                let normal = ds.cross(along_t(i, j)).normalize_or(Vec3::Y);
                self.vertex(position, normal, ds, uv);
            }
        }
        for j in 0..rows {
            for i in 0..columns {
                let corner = |i: usize, j: usize| first + (j * width + i) as u32;
                let quad = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                for [a, b, c] in [[0, 1, 2], [0, 2, 3]].map(|t: [usize; 3]| t.map(|k| quad[k])) {
                    let [p, q, r] = [a, b, c].map(|index| self.positions[index as usize]);
                    if (q - p).cross(r - p).length_squared() > 1e-16 {
                        self.indices.extend([a, b, c]);
                    }
                }
            }
        }
        self
    }

    /// A profile of (radius, height), from the bottom up on the outside, turned about the y axis. A point given twice
    /// makes an edge.
    pub fn lathe(&mut self, profile: &[[f32; 2]], sides: usize) -> &mut Self {
        let widest = profile.iter().fold(0.0f32, |widest, p| widest.max(p[0]));
        let mut length = 0.0;
        for run in smooth_runs(&profile.iter().map(|&p| Vec2::from(p)).collect::<Vec<_>>()) {
            let lengths = running_length(&run, length);
            length = lengths.last().copied().unwrap_or(length);
            let rows = run.len() - 1;
            self.grid([sides, rows], true, |s, t| {
                let j = (t * rows as f32).round() as usize;
                let (sin, cos) = (s * TAU).sin_cos();
                let p = run[j];
                (vec3(p.x * cos, p.y, -p.x * sin), vec2(s * TAU * widest, -lengths[j]))
            });
        }
        self
    }

    /// An outline through a row of sections: point (x, y) of the outline stands at `section * (x, y, 0)`. The outline
    /// runs counter-clockwise about the direction of travel (x × y) to face outwards; a point given twice makes an
    /// edge. `closed` joins its end to its start.
    pub fn loft(&mut self, sections: &[Mat4], outline: &[[f32; 2]], closed: bool) -> &mut Self {
        let mut outline: Vec<Vec2> = outline.iter().map(|&p| Vec2::from(p)).collect();
        if closed {
            outline.extend(outline.first().copied());
        }
        let centers: Vec<Vec3> = sections.iter().map(|section| section.w_axis.truncate()).collect();
        let mut travelled = vec![0.0];
        travelled.extend(centers.windows(2).scan(0.0, |sum, pair| {
            *sum += pair[0].distance(pair[1]);
            Some(*sum)
        }));
        let runs = smooth_runs(&outline);
        let smooth_all_round = closed && runs.len() == 1;
        let mut length = 0.0;
        for run in runs {
            let lengths = running_length(&run, length);
            length = lengths.last().copied().unwrap_or(length);
            let [columns, rows] = [run.len() - 1, sections.len() - 1];
            self.grid([columns, rows], smooth_all_round, |s, t| {
                let i = (s * columns as f32).round() as usize;
                let j = (t * rows as f32).round() as usize;
                (sections[j].transform_point3(run[i].extend(0.0)), vec2(lengths[i], -travelled[j]))
            });
        }
        self
    }

    /// A straight moulding between two points with its outline's x along `out` and y up, drawn from the bottom up.
    pub fn moulding(&mut self, from: Vec3, to: Vec3, out: Vec3, outline: &[[f32; 2]]) -> &mut Self {
        let (from, to) = if (to - from).dot(out.cross(Vec3::Y)) > 0.0 { (from, to) } else { (to, from) };
        let section =
            |at: Vec3| Mat4::from_cols(out.extend(0.0), Vec4::Y, out.cross(Vec3::Y).extend(0.0), at.extend(1.0));
        self.loft(&[section(from), section(to)], outline, false)
    }

    /// A wall in the xy plane, `width` wide about x = 0 and `depth` deep about z = 0, from `spring` up to `top`, with
    /// half of a round opening of `radius` whose centre is at `spring`.
    pub fn arch(&mut self, width: f32, depth: f32, spring: f32, top: f32, radius: f32, segments: usize) -> &mut Self {
        let half = depth * 0.5;
        let rim = |k: usize| {
            let angle = PI * (1.0 - k as f32 / segments as f32);
            vec2(radius * angle.cos(), spring + radius * angle.sin())
        };
        for (z, u) in [(half, Vec3::X), (-half, Vec3::NEG_X)] {
            // Turned for the back, so that it is counter-clockwise from there.
            let mut front = |corners: [Vec2; 4]| {
                let mut corners = corners.map(|p| p.extend(z));
                if z < 0.0 {
                    corners.reverse();
                }
                self.face(corners, Vec3::ZERO, u);
            };
            for (left, right) in [(-width * 0.5, -radius), (radius, width * 0.5)] {
                front([vec2(left, spring), vec2(right, spring), vec2(right, top), vec2(left, top)]);
            }
            for k in 0..segments {
                let (p, q) = (rim(k), rim(k + 1));
                front([p, q, vec2(q.x, top), vec2(p.x, top)]);
            }
        }
        self.grid([1, segments], false, |s, t| {
            let p = rim((t * segments as f32).round() as usize);
            (p.extend(half - s * depth), vec2(s * depth, -t * PI * radius))
        })
    }

    /// A rectangle about `center` with these half edges; it faces `right × up`. Coordinates run over the unit square.
    pub fn card(&mut self, center: Vec3, right: Vec3, up: Vec3) -> &mut Self {
        let normal = right.cross(up).normalize_or(Vec3::Y);
        let first = self.positions.len() as u32;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let uv = vec2(x * 0.5 + 0.5, 0.5 - y * 0.5);
            self.vertex(center + right * x + up * y, normal, right, uv);
        }
        self.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
        self
    }

    /// Adds a vertex; the tangent is made perpendicular to the normal.
    fn vertex(&mut self, position: Vec3, normal: Vec3, along_u: Vec3, uv: Vec2) {
        let tangent = (along_u - normal * normal.dot(along_u)).try_normalize();
        let tangent = tangent.unwrap_or_else(|| normal.any_orthonormal_vector());
        self.positions.push(position);
        self.normals.push(normal);
        self.tangents.push(tangent.extend(1.0));
        self.uvs.push(uv);
    }
}

/// Splits a line at points given twice.
fn smooth_runs(points: &[Vec2]) -> Vec<Vec<Vec2>> {
    let mut runs: Vec<Vec<Vec2>> = vec![Vec::new()];
    for &point in points {
        match runs.last_mut() {
            Some(run) if run.last() != Some(&point) => run.push(point),
            _ => runs.push(vec![point]),
        }
    }
    runs.retain(|run| run.len() > 1);
    runs
}

fn running_length(points: &[Vec2], start: f32) -> Vec<f32> {
    let mut lengths = vec![start];
    lengths.extend(points.windows(2).scan(start, |sum, pair| {
        *sum += pair[0].distance(pair[1]);
        Some(*sum)
    }));
    lengths
}

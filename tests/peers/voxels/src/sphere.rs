//! The sphere that all of them turn into voxels.

use std::f64::consts::{PI, TAU};

/// Corners and triangles, counterclockwise from outside.
pub struct Sphere {
    pub corners: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

impl Sphere {
    /// Of radius 1, with about `segments`² triangles.
    pub fn new(segments: u32) -> Self {
        let rings = segments / 2 + 1;
        let mut corners = Vec::new();
        for ring in 0..=rings {
            for segment in 0..segments {
                let (theta, phi) =
                    (PI * f64::from(ring) / f64::from(rings), TAU * f64::from(segment) / f64::from(segments));
                let around = if ring % rings == 0 { 0.0 } else { theta.sin() };
                corners.push([around * phi.sin(), theta.cos(), around * phi.cos()].map(|c| c as f32));
            }
        }
        let at = |ring: u32, segment: u32| ring * segments + segment % segments;
        let mut triangles = Vec::new();
        for (ring, segment) in (0..rings).flat_map(|ring| (0..segments).map(move |segment| (ring, segment))) {
            let [a, b] = [at(ring, segment), at(ring, segment + 1)];
            let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
            if ring > 0 {
                triangles.push([a, c, b]);
            }
            if ring + 1 < rings {
                triangles.push([b, c, d]);
            }
        }
        Self { corners, triangles }
    }

    /// As text that every tool reads (Wavefront OBJ).
    pub fn obj(&self) -> String {
        let corners = self.corners.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
        let triangles = self.triangles.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
        corners.chain(triangles).collect()
    }
}

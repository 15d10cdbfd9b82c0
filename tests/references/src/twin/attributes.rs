//! What surfaces are like in each voxel.
//!
//! - A triangle has a part in a voxel: what lies in its closed box. Parts without area are left out.
//! - A part is looked at in its centroid, its front, with textures filtered over a square of the part's area.
//! - How much a part's area may change where the voxel's faces move by [`EASE`] is what is not known of it.
//! - It counts by its area times its alpha, which is 1 for opaque materials and the filtered alpha for all others.
//! - Opacity is the mean of alpha by area. Where nothing counts, all else is 0.

use std::collections::HashMap;

use glam::{DVec3, DVec4};
use shadowgraph::scene::AlphaMode;
use shadowgraph::techniques::voxel::Grid;

use super::scene::{Footprint, Hit, Ray, Scene};

/// How exact places are, in voxels: single precision in coordinates of up to 128 voxels.
pub const EASE: f64 = 2e-5;

/// Of a voxel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Average {
    /// How much its area may change where its faces move by [`EASE`].
    pub doubt: f64,
    /// Of its parts, in squares of its edge.
    pub area: f64,
    /// The same by alpha.
    pub seen: f64,
    /// Linear.
    pub albedo: DVec3,
    /// Mean of unit normals, world space.
    pub normal: DVec3,
    /// cd/m².
    pub emission: DVec3,
}

impl Average {
    /// Mean alpha.
    pub fn opacity(&self) -> f64 {
        if self.area > 0.0 { self.seen / self.area } else { 0.0 }
    }
}

/// By voxel, of those with a part, or nearly so.
pub fn averages(scene: &Scene, grid: &Grid) -> HashMap<[u32; 3], Average> {
    let (min, edge) = (grid.min().as_dvec3(), f64::from(grid.edge()));
    let mut averages: HashMap<[u32; 3], Average> = HashMap::new();
    for (index, triangle) in scene.triangles.iter().enumerate() {
        let corners = triangle.positions.map(|p| (p - min) / edge);
        let material = &scene.source.materials[triangle.material as usize];
        for voxel in boxes(&corners, grid.size()) {
            let within = |ease: f64| part(&corners, DVec3::from(voxel.map(f64::from)), ease);
            let area = |ease: f64| within(ease).map_or(0.0, |(area, _)| area);
            let doubt = area(EASE) - area(-EASE);
            if doubt > 0.0 {
                averages.entry(voxel).or_default().doubt += doubt;
            }
            let Some((area, weights)) = within(0.0) else { continue };
            let mut ray = Ray::new(DVec3::ZERO, DVec3::X);
            ray.footprint = Footprint::Width(area.sqrt() * edge);
            let hit = Hit { t: 0.0, triangle: index as u32, weights, front: true, alpha_excess: 0.0 };
            let surface = scene.surface(&ray, &hit);
            let alpha = if material.alpha_mode == AlphaMode::Opaque { 1.0 } else { surface.base_color.w };
            let average = averages.entry(voxel).or_default();
            average.area += area;
            average.seen += area * alpha;
            average.albedo += area * alpha * surface.base_color.truncate();
            average.normal += area * alpha * surface.normal;
            average.emission += area * alpha * surface.emissive;
        }
    }
    for average in averages.values_mut().filter(|average| average.seen > 0.0) {
        for sum in [&mut average.albedo, &mut average.normal, &mut average.emission] {
            *sum /= average.seen;
        }
    }
    averages
}

/// Voxels whose boxes meet a triangle's bounds.
fn boxes(corners: &[DVec3; 3], size: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    let [a, b, c] = *corners;
    let (least, most) = (a.min(b).min(c), a.max(b).max(c));
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let n = f64::from(size[axis]);
        let (first, end) = ((least[axis] - EASE).ceil() - 1.0, (most[axis] + EASE).floor() + 1.0);
        first.clamp(0.0, n) as u32..end.clamp(0.0, n) as u32
    });
    z.flat_map(move |k| {
        let x = x.clone();
        y.clone().flat_map(move |j| x.clone().map(move |i| [i, j, k]))
    })
}

/// Area and centroid, in barycentric coordinates, of what lies of a triangle in the unit cube with this lower corner,
/// whose faces are moved out.
fn part(corners: &[DVec3; 3], lower: DVec3, out: f64) -> Option<(f64, DVec3)> {
    // A corner is its place and its weights; planes keep what is on their inner side.
    let mut polygon: Vec<(DVec3, DVec3)> =
        corners.iter().zip([DVec3::X, DVec3::Y, DVec3::Z]).map(|(&p, w)| (p - lower, w)).collect();
    let planes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| [axis.extend(out), (-axis).extend(1.0 + out)]);
    for plane in planes.concat() {
        let height = |(place, _): &(DVec3, DVec3)| plane.dot(DVec4::from((*place, 1.0)));
        let mut kept = Vec::new();
        for (i, here) in polygon.iter().enumerate() {
            let next = &polygon[(i + 1) % polygon.len()];
            let (h, k) = (height(here), height(next));
            if h >= 0.0 {
                kept.push(*here);
            }
            if (h > 0.0 && k < 0.0) || (h < 0.0 && k > 0.0) {
                let t = h / (h - k);
                kept.push((here.0.lerp(next.0, t), here.1.lerp(next.1, t)));
            }
        }
        polygon = kept;
    }
    let (first, rest) = polygon.split_first()?;
    let (mut area, mut moment) = (0.0, DVec3::ZERO);
    for pair in rest.windows(2) {
        let own = 0.5 * (pair[0].0 - first.0).cross(pair[1].0 - first.0).length();
        area += own;
        moment += own * (first.1 + pair[0].1 + pair[1].1) / 3.0;
    }
    (area > 0.0).then(|| (area, moment / area))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_triangle_make_it_up() {
        let corners = [[0.1, 0.2, 0.3], [3.7, 1.1, 0.9], [1.3, 3.2, 2.8]].map(DVec3::from);
        let whole = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
        let (mut area, mut middle) = (0.0, DVec3::ZERO);
        for voxel in boxes(&corners, [4; 3]) {
            if let Some((own, weights)) = part(&corners, DVec3::from(voxel.map(f64::from)), 0.0) {
                area += own;
                middle += own * weights;
            }
        }
        assert!((area - whole).abs() < 1e-12 && (middle / area - 1.0 / 3.0).length() < 1e-12, "{area} of {whole}");
    }
}

//! Points of an atlas's texels, in double precision.
//!
//! - Grid coordinates as in [`super::voxel`]; a chart's coordinates count texels, whose centres are at halves.
//! - A texel shows a triangle where its centre lies in the triangle's layout. A rasteriser snaps corners, most to 1/256
//!   pixel: nearer than [`snap`] to an edge a texel may or may not show it, and its point may be as far aside.

use glam::{DVec2, DVec3};
use shadowgraph::scene::Scene;
use shadowgraph::techniques::voxel::Grid;

/// Of a rasteriser with so many bits below a pixel, in texels: twice what a corner moves, and a little.
pub fn snap(sub_pixel_bits: u32) -> f64 {
    2.56 / f64::from(1 << sub_pixel_bits)
}

/// Rounding of coordinates in single precision, in voxels.
const ROUNDING: f64 = 2e-4;

/// A triangle, and where it lies in an atlas.
pub struct Laid {
    /// Grid coordinates.
    pub corners: [DVec3; 3],
    /// In texels.
    pub chart: [DVec2; 3],
    /// Whether single precision may lay it out in another way.
    pub doubtful: bool,
}

/// A scene's triangles, each in every chart it may lie in: seen along the axis it faces most.
pub fn by_axis(triangles: &[[DVec3; 3]], per_voxel: f64) -> Vec<Laid> {
    let mut laid = Vec::new();
    for &corners in triangles {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).abs();
        let most = normal.max_element();
        // What little area says of a direction is rounding.
        let longest = (b - a).length().max((c - a).length());
        let slack = 1e-3 * most + 1e-4 * longest;
        let axes: Vec<usize> = (0..3).filter(|&axis| normal[axis] >= most - slack).collect();
        for &axis in &axes {
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            let chart = corners.map(|p| DVec2::new(p[u], p[v]) * per_voxel);
            laid.push(Laid { corners, chart, doubtful: axes.len() > 1 });
        }
    }
    laid
}

/// By second texture coordinates, all of them in a square of so many texels a side.
pub fn second_uvs(scene: &Scene, grid: &Grid, side: f64) -> Vec<Laid> {
    let (min, edge) = (grid.min().as_dvec3(), f64::from(grid.edge()));
    let mut laid = Vec::new();
    for object in &scene.objects {
        let world = object.world_from_object.as_dmat4();
        for primitive in &scene.meshes[object.mesh].primitives {
            for corners in primitive.indices.as_chunks::<3>().0 {
                let place = |i: u32| (world.transform_point3(primitive.positions[i as usize].as_dvec3()) - min) / edge;
                let chart = corners.map(|i| primitive.uvs[1][i as usize].as_dvec2());
                laid.push(Laid { corners: corners.map(place), chart, doubtful: false });
            }
        }
    }
    let all = || laid.iter().flat_map(|triangle| triangle.chart);
    let first = all().fold(DVec2::INFINITY, DVec2::min);
    let extent = (all().fold(DVec2::NEG_INFINITY, DVec2::max) - first).max_element();
    laid.iter_mut().for_each(|triangle| triangle.chart = triangle.chart.map(|uv| (uv - first) * side / extent));
    laid
}

/// Voxels that must be set and that may be set by the points of an atlas of `side`² texels; `[z][y][x]`. `snap`: in texels.
pub fn voxels(laid: &[Laid], side: u32, size: [u32; 3], snap: f64) -> [Vec<bool>; 2] {
    let count = size.iter().map(|&n| n as usize).product();
    let [mut must, mut may] = [vec![false; count], vec![false; count]];
    for triangle in laid {
        let [a, b, c] = triangle.chart;
        let error = ROUNDING + snap * stretch(triangle, snap);
        let rows = |axis: usize| {
            let [least, most] = [a[axis].min(b[axis]).min(c[axis]), a[axis].max(b[axis]).max(c[axis])];
            let clamp = |value: f64| value.clamp(0.0, f64::from(side)) as u32;
            clamp((least - snap - 0.5).ceil())..clamp((most + snap + 0.5).floor())
        };
        for (x, y) in rows(1).flat_map(|y| rows(0).map(move |x| (x, y))) {
            let texel = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
            let inwards = from_edges(triangle, texel);
            // Beside the triangle, the nearest point of an edge.
            let shown = if inwards > 0.0 { Some(within(triangle, texel)) } else { beside(triangle, texel, snap) };
            let Some(point) = shown else { continue };
            mark(&mut may, size, point, error);
            if inwards > snap && !triangle.doubtful && (point - error).floor() == (point + error).floor() {
                mark(&mut must, size, point, 0.0);
            }
        }
    }
    [must, may]
}

/// Distance of a texel's centre from the nearest edge, in texels; negative outside, and for a layout without area.
fn from_edges(triangle: &Laid, texel: DVec2) -> f64 {
    let [a, b, c] = triangle.chart;
    let area = (b - a).perp_dot(c - a);
    let inwards =
        |(from, to): (DVec2, DVec2)| (to - from).perp_dot(texel - from) * area.signum() / (to - from).length();
    let least = [(b, c), (c, a), (a, b)].map(inwards).into_iter().fold(f64::INFINITY, f64::min);
    if area == 0.0 || !least.is_finite() { -1.0 } else { least }
}

fn within(triangle: &Laid, texel: DVec2) -> DVec3 {
    let ([a, b, c], [p, q, r]) = (triangle.chart, triangle.corners);
    let weights = [(b, c), (c, a), (a, b)].map(|(from, to)| (to - from).perp_dot(texel - from));
    (p * weights[0] + q * weights[1] + r * weights[2]) / weights.iter().sum::<f64>()
}

/// The point shown by an edge that passes a texel's centre near enough.
fn beside(triangle: &Laid, texel: DVec2, snap: f64) -> Option<DVec3> {
    let edges = [0, 1, 2].map(|i| {
        let [from, to] = [triangle.chart[i], triangle.chart[(i + 1) % 3]];
        let way = to - from;
        let along = if way.length_squared() > 0.0 { (texel - from).dot(way) / way.length_squared() } else { 0.0 };
        let along = along.clamp(0.0, 1.0);
        (from.lerp(to, along).distance(texel), triangle.corners[i].lerp(triangle.corners[(i + 1) % 3], along))
    });
    let near = edges.into_iter().filter(|(distance, _)| *distance <= snap);
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, point)| point)
}

/// Voxels that a texel spans on a triangle, at most.
fn stretch(triangle: &Laid, snap: f64) -> f64 {
    let [a, b] = [triangle.chart[1] - triangle.chart[0], triangle.chart[2] - triangle.chart[0]];
    let [p, q] = [triangle.corners[1] - triangle.corners[0], triangle.corners[2] - triangle.corners[0]];
    let area = a.perp_dot(b);
    let (u, v) = ((p * b.y - q * a.y) / area, (q * a.x - p * b.x) / area);
    // No less than the greatest singular value, and at most √2 times it. A corner that moves by so much moves a point no
    // further than the triangle is long.
    let longest = p.length().max(q.length());
    let root = (u.length_squared() + v.length_squared()).sqrt();
    if root.is_finite() { root.min(longest / snap) } else { longest / snap }
}

/// Marks every voxel that is so near to a point.
fn mark(voxels: &mut [bool], size: [u32; 3], point: DVec3, error: f64) {
    let range = |axis: usize| {
        let n = f64::from(size[axis]);
        let first = (point[axis] - error).floor().clamp(0.0, n) as usize;
        first..((point[axis] + error).floor() + 1.0).clamp(0.0, n) as usize
    };
    for z in range(2) {
        for y in range(1) {
            for x in range(0) {
                voxels[(z * size[1] as usize + y) * size[0] as usize + x] = true;
            }
        }
    }
}

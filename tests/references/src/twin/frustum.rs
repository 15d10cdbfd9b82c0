//! Voxels of a camera's frustum, by exact crossings of lines of sight.
//!
//! - Depth is the distance along the view axis. Slices are counted from the far end towards the eye, and voxels given in
//!   the order `[slice][row][column]`.
//! - A voxel is inside where an odd number of crossings lies beyond its centre on the line through its pixel's centre.
//! - It is on the surface where a crossing lies in it; a slice holds its farther end.
//! - The line's test against an edge gives exactly opposite values for the two triangles that share it, so a closed surface
//!   is crossed an even number of times.

use glam::{DMat3, DVec3, DVec4};
use shadowgraph::scene::Scene;
use shadowgraph::techniques::voxel::FrustumGrid;

use super::camera::Camera;
use super::scene::Line;
use super::voxel::{is_near, world_triangles};
use crate::parallel;

/// What the lines of sight of a frustum cross.
pub struct Sight {
    camera: Camera,
    size: [usize; 3],
    far: f64,
    thickness: f64,
    triangles: Vec<[DVec3; 3]>,
    /// By row of the picture: triangles that may lie in it, with their first and last column.
    rows: Vec<Vec<(usize, [f64; 2])>>,
}

impl Sight {
    /// Of a scene's triangles, those behind the eye too.
    pub fn new(scene: &Scene, frustum: &FrustumGrid) -> Self {
        let camera = Camera::new(frustum.view());
        let size = frustum.grid().size().map(|n| n as usize);
        let [near, far] = frustum.distances().map(f64::from);
        let triangles = world_triangles(scene);
        let mut rows = vec![Vec::new(); size[1]];
        let clip_from_world = frustum.view().clip_from_view.as_dmat4() * frustum.view().view_from_world.as_dmat4();
        for (index, triangle) in triangles.iter().enumerate() {
            let [left, top, right, bottom] = pixels(&triangle.map(|p| clip_from_world * p.extend(1.0)), size);
            for row in &mut rows[top as usize..bottom as usize] {
                row.push((index, [left, right]));
            }
        }
        Self { camera, size, far, thickness: (far - near) / size[2] as f64, triangles, rows }
    }

    /// Of each column, where a line of sight so far from its pixel's centre crosses triangles, in slices from the far end.
    fn columns(&self, aside: [f64; 2]) -> Vec<Vec<f64>> {
        let [width, height, _] = self.size;
        parallel::rows(height, |row| {
            let crossings = |column: usize| {
                let x = column as f64 + 0.5;
                let line = self.camera.line(x + aside[0], row as f64 + 0.5 + aside[1]);
                let near = self.rows[row].iter().filter(|(_, [left, right])| *left <= x && x <= *right);
                let depths = near.filter_map(|&(index, _)| crossing(&self.triangles[index], &line));
                depths.map(|depth| (self.far - depth) / self.thickness).collect()
            };
            (0..width).map(crossings).collect()
        })
    }

    fn slices(&self, columns: &[Vec<f64>], is_set: impl Fn(&[f64], f64) -> bool) -> Vec<bool> {
        let slices = 0..self.size[2];
        slices.flat_map(|k| columns.iter().map(|column| is_set(column, k as f64)).collect::<Vec<_>>()).collect()
    }

    /// Whether each voxel's centre is inside.
    pub fn solid(&self) -> Vec<bool> {
        let columns = self.columns([0.0; 2]);
        self.slices(&columns, |column, k| column.iter().filter(|&&at| at <= k + 0.5).count() % 2 == 1)
    }

    /// Voxels that must be set where every corner of triangles moves by up to `limit` pixels and slices, and those that may
    /// be, but for [`Sight::is_beside`].
    pub fn surface(&self, limit: f64) -> [Vec<bool>; 2] {
        let around = [
            [0.0, 0.0],
            [1.0, 0.0],
            [-1.0, 0.0],
            [0.0, 1.0],
            [0.0, -1.0],
            [1.0, 1.0],
            [-1.0, -1.0],
            [1.0, -1.0],
            [-1.0, 1.0],
        ];
        let must: Vec<_> = around
            .iter()
            .map(|[dx, dy]| {
                let columns = self.columns([limit * dx, limit * dy]);
                self.slices(&columns, |column, k| column.iter().any(|&at| k + limit <= at && at <= k + 1.0 - limit))
            })
            .collect();
        let must = (0..must[0].len()).map(|i| must.iter().all(|set| set[i])).collect();
        let columns = self.columns([0.0; 2]);
        let may = self.slices(&columns, |column, k| column.iter().any(|&at| k - limit <= at && at <= k + 1.0 + limit));
        [must, may]
    }

    /// Whether a triangle comes at most so near to a voxel's line of sight within the voxel, or to its centre, in pixels and
    /// slices.
    pub fn is_beside(&self, voxel: [usize; 3], limit: f64, whole: bool) -> bool {
        let [x, y, k] = voxel.map(|i| i as f64 + 0.5);
        let depth = self.far - k * self.thickness;
        let center = self.camera.line(x, y).at(depth);
        // Near the centre, coordinates of the frustum are those of world space but for a linear map.
        let step = 1e-3;
        let along = |dx: f64, dy: f64, dk: f64| {
            let at = |sign: f64| {
                let line = self.camera.line(x + sign * step * dx, y + sign * step * dy);
                line.at(depth - sign * step * dk * self.thickness)
            };
            (at(1.0) - at(-1.0)) / (2.0 * step)
        };
        let to_frustum = DMat3::from_cols(along(1.0, 0.0, 0.0), along(0.0, 1.0, 0.0), along(0.0, 0.0, 1.0)).inverse();
        let local = self.triangles.iter().map(|triangle| triangle.map(|p| to_frustum * (p - center)));
        let local: Vec<_> = local.filter(|triangle| !is_apart(triangle, limit)).collect();
        let steps = if whole { (1.0 / limit).ceil() as i32 * 4 } else { 0 };
        (-steps..=steps).any(|i| {
            let along = if whole { 0.5 * f64::from(i) / f64::from(steps) } else { 0.0 };
            is_near(DVec3::Z * along, &local, limit)
        })
    }
}

/// The part of a picture that a triangle lies in, with a pixel more on every side: left, top, right, bottom. All of it where
/// the triangle reaches through the eye's plane, and nothing where it lies behind.
fn pixels(corners: &[DVec4; 3], size: [usize; 3]) -> [f64; 4] {
    let [width, height] = [size[0] as f64, size[1] as f64];
    match corners.iter().filter(|corner| corner.w < 1e-6).count() {
        0 => {}
        3 => return [0.0; 4],
        _ => return [0.0, 0.0, width, height],
    }
    let at = corners.map(|corner| (corner.truncate() / corner.w + 1.0) * 0.5 * DVec3::new(width, height, 1.0));
    let (least, most) = (at[0].min(at[1]).min(at[2]) - 1.0, at[0].max(at[1]).max(at[2]) + 1.0);
    let within = |value: f64, end: f64| value.clamp(0.0, end);
    [least.x, within(least.y.floor(), height), most.x, within(most.y.ceil(), height)]
}

/// Whether a triangle's bounds are apart from the voxel around the origin.
fn is_apart(triangle: &[DVec3; 3], limit: f64) -> bool {
    let [a, b, c] = *triangle;
    let reach = DVec3::new(limit, limit, 0.5 + limit);
    a.min(b).min(c).cmpgt(reach).any() || a.max(b).max(c).cmplt(-reach).any()
}

/// Where a line crosses a triangle.
fn crossing(triangle: &[DVec3; 3], line: &Line) -> Option<f64> {
    let corners = triangle.map(|p| p - line.origin);
    let sides = [0, 1, 2].map(|i| side(corners[(i + 1) % 3], corners[(i + 2) % 3], line.direction));
    if sides.iter().any(|&(positive, _)| positive != sides[0].0) {
        return None;
    }
    let total: f64 = sides.iter().map(|&(_, volume)| volume).sum();
    let point: DVec3 = corners.iter().zip(sides).map(|(&corner, (_, volume))| corner * (volume / total)).sum();
    let t = point.dot(line.direction) / line.direction.length_squared();
    // A triangle along the line spans nothing: any of its corners will do.
    Some(if t.is_finite() { t } else { corners[0].dot(line.direction) / line.direction.length_squared() })
}

/// Which side of an edge a line from the origin passes, and the volume they span: exactly opposite ones for the two
/// triangles that share it. A line through an edge or a corner is taken as turned by less than anything, and always alike.
fn side(a: DVec3, b: DVec3, direction: DVec3) -> (bool, f64) {
    let across = a.cross(b);
    let turns = [direction, DVec3::new(0.3, 0.5, 0.8), DVec3::new(0.7, -0.4, 0.1)].map(|turn| across.dot(turn));
    let decides = turns.into_iter().find(|&volume| volume != 0.0);
    (decides.is_some_and(|volume| volume > 0.0), turns[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tiny;
    use glam::{Mat4, Vec3};
    use shadowgraph::scene::Camera as Lens;

    #[test]
    fn a_cube_before_the_camera_is_where_it_is() {
        // Two metres wide, from 4 to 6 metres away; a picture that is 10 metres wide at 5 metres.
        let cube = tiny::one("cube", vec![(tiny::cuboid(Vec3::splat(-1.0), Vec3::ONE, 0), Mat4::IDENTITY)]);
        let view = Lens::look_at(Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, std::f32::consts::FRAC_PI_2, 0.1).view([100, 100]);
        let frustum = FrustumGrid::new(&view, [1.0, 11.0], 20).unwrap_or_else(|error| panic!("{error}"));
        let sight = Sight::new(&cube, &frustum);
        let solid = sight.solid();
        // Centres at 4.25 to 5.75 metres; a pixel spans 2 % of the distance.
        let expected = |i: usize, k: usize| {
            let depth = 11.0 - 0.5 * (k as f64 + 0.5);
            (4.0..6.0).contains(&depth) && ((i as f64 + 0.5) / 50.0 - 1.0).abs() * depth <= 1.0
        };
        let all = (0..20).flat_map(|k| (0..100).flat_map(move |j| (0..100).map(move |i| (k, j, i))));
        for ((k, j, i), inside) in all.zip(&solid) {
            assert_eq!(*inside, expected(i, k) && expected(j, k), "{i} {j} {k}");
        }
        let [must, may] = sight.surface(1e-3);
        let at = |set: &[bool], i: usize, k: usize| set[(k * 100 + 50) * 100 + i];
        // The front at 4 metres lies between slices 13 and 14, and the middle line passes no side.
        assert!(!at(&must, 50, 13) && at(&may, 50, 13) && at(&may, 50, 14) && !at(&may, 50, 12));
        assert!(sight.is_beside([50, 50, 13], 1e-3, true) && !sight.is_beside([50, 50, 13], 1e-3, false));
    }
}

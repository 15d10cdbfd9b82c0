//! What second texture coordinates make of a surface.

use glam::{Vec2, Vec3};

use super::super::Grid;
use super::Charts;
use crate::scene::{Primitive, Scene};
use crate::{Error, Result};

/// How a scene's second texture coordinates stretch its surface, and how fine an atlas by them must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Least coordinates.
    pub first: Vec2,
    /// Side of the square that holds all of them.
    pub extent: f32,
    /// Voxels that a unit of the coordinates spans, at most: the greatest singular value of a triangle's layout.
    pub most: f32,
    /// Triangles with an area whose layout has none: no texel shows them.
    pub flat: u32,
}

impl Stretch {
    /// Of a scene's objects, with voxels of a grid.
    ///
    /// # Errors
    /// [`Error::Invalid`] where no triangle is laid out.
    pub fn of(scene: &Scene, grid: &Grid) -> Result<Self> {
        let mut stretch = Self { first: Vec2::INFINITY, extent: 0.0, most: 0.0, flat: 0 };
        let mut last = Vec2::NEG_INFINITY;
        for object in &scene.objects {
            for primitive in &scene.meshes[object.mesh].primitives {
                for corners in primitive.indices.as_chunks::<3>().0 {
                    let laid = corners.map(|i| primitive.uvs[1][i as usize]);
                    let world = corners.map(|i| position(primitive, i, &object.world_from_object) / grid.edge());
                    stretch.first = laid.into_iter().fold(stretch.first, Vec2::min);
                    last = laid.into_iter().fold(last, Vec2::max);
                    match greatest(laid, world) {
                        Some(most) => stretch.most = stretch.most.max(most),
                        None if (world[1] - world[0]).cross(world[2] - world[0]).length() > 1e-6 => stretch.flat += 1,
                        None => {}
                    }
                }
            }
        }
        stretch.extent = (last - stretch.first).max_element();
        if stretch.extent > 0.0 && stretch.most > 0.0 {
            return Ok(stretch);
        }
        let why =
            "have no second texture coordinates (TEXCOORD_1) that lay their triangles out; charts by axis need none";
        Err(Error::invalid("the scene's meshes", why))
    }

    /// Charts so fine that no two texels beside each other are further apart on the surface than a voxel's edge over
    /// `per_voxel`.
    pub fn charts(&self, per_voxel: f32) -> Charts {
        Charts::SecondUvs { side: (self.most * self.extent * per_voxel).ceil().clamp(1.0, u32::MAX as f32) as u32 }
    }
}

fn position(primitive: &Primitive, index: u32, world_from_object: &glam::Mat4) -> Vec3 {
    world_from_object.transform_point3(primitive.positions[index as usize])
}

/// The greatest singular value of the map from a triangle's layout to the triangle; none for a layout without area.
fn greatest(laid: [Vec2; 3], world: [Vec3; 3]) -> Option<f32> {
    let [a, b] = [laid[1] - laid[0], laid[2] - laid[0]];
    let area = a.perp_dot(b);
    if area == 0.0 || !area.is_finite() {
        return None;
    }
    // What a unit of each coordinate is on the surface.
    let [p, q] = [world[1] - world[0], world[2] - world[0]];
    let u = (p * b.y - q * a.y) / area;
    let v = (q * a.x - p * b.x) / area;
    let [uu, uv, vv] = [u.length_squared(), u.dot(v), v.length_squared()];
    let root = (0.25 * (uu - vv) * (uu - vv) + uv * uv).sqrt();
    Some((0.5 * (uu + vv) + root).sqrt())
}

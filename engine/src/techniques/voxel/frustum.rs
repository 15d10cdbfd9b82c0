//! A camera's frustum cut into voxels.
//!
//! Source: Eisemann and Décoret 2006, "Fast Scene Voxelization and Applications", section 3: columns are a picture's pixels,
//! slices lie evenly in view depth.

use glam::{DVec4, Vec3};

use super::{Axis, Grid};
use crate::geometry::Aabb;
use crate::graph::BufferHandle;
use crate::scene::View;
use crate::shader::generated::blocks;
use crate::{Error, Result};

/// Voxels in what a camera sees. A column is a pixel of its picture, and slices are equally thick along the view axis.
///
/// Voxel (i, j, k) lies in pixel (i, j), whose rows run from the top, at `k · thickness` to `(k + 1) · thickness` metres
/// before the far end: as depth is reversed, slices run from far to near.
#[derive(Clone, Copy, Debug)]
pub struct FrustumGrid {
    view: View,
    near: f32,
    far: f32,
    grid: Grid,
}

/// Bits of a frustum on the device, a bit a voxel.
pub struct FrustumBits {
    /// As [`super::VoxelBits::bits`] of [`FrustumGrid::grid`] along z: [`super::Voxels::read`] takes them so.
    pub bits: BufferHandle,
    /// Where the voxels are.
    pub frustum: FrustumGrid,
}

impl FrustumGrid {
    /// With a column for each pixel of a view, and so many slices between two distances along its axis, in metres.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the distances are not finite and in order, and for a perspective view positive, or where
    /// there is no voxel or more than [`super::MAX_RESOLUTION`] of them along an axis.
    pub fn new(view: &View, [near, far]: [f32; 2], slices: u32) -> Result<Self> {
        let least = if view.is_orthographic() { f32::NEG_INFINITY } else { 0.0 };
        if !(near.is_finite() && far.is_finite() && least < near && near < far) {
            let why = format!("it reaches from {near} to {far} m: both are finite, the former less, and before an eye");
            return Err(Error::invalid("the frustum of voxels", why));
        }
        let grid = Grid::new(Vec3::ZERO, 1.0, [view.size[0], view.size[1], slices])?;
        Ok(Self { view: *view, near, far, grid })
    }

    /// As [`FrustumGrid::new`], with slices from where the view may first see something of a box to where it last may.
    ///
    /// # Errors
    /// As [`FrustumGrid::new`].
    pub fn around(view: &View, bounds: &Aabb, slices: u32) -> Result<Self> {
        Self::new(view, view.distances(bounds), slices)
    }

    /// What the camera sees.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// Distances of both ends along the view axis, metres.
    pub fn distances(&self) -> [f32; 2] {
        [self.near, self.far]
    }

    /// Thickness of a slice, metres.
    pub fn thickness(&self) -> f32 {
        (self.far - self.near) / self.grid.size()[2] as f32
    }

    /// The same voxels as a grid of unit cubes, in coordinates of the frustum: pixels, pixels and slices.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Centre of a voxel, world space.
    pub fn center(&self, voxel: [u32; 3]) -> Vec3 {
        let [x, y, slice] = voxel.map(|i| i as f32 + 0.5);
        let depth = self.far - slice * self.thickness();
        let lens = self.view.clip_from_view;
        let w = lens.w_axis.w - lens.z_axis.w * depth;
        // Along each axis, clip = a · view − b · depth + c.
        let solve =
            |pixel: f32, size: u32, a: f32, b: f32, c: f32| ((2.0 * pixel / size as f32 - 1.0) * w + b * depth - c) / a;
        let [width, height] = self.view.size;
        let x = solve(x, width, lens.x_axis.x, lens.z_axis.x, lens.w_axis.x);
        let y = solve(y, height, lens.y_axis.y, lens.z_axis.y, lens.w_axis.y);
        self.view.world_from_view.transform_point3(Vec3::new(x, y, -depth))
    }

    /// The uniform block `Frustum`.
    pub(super) fn block(&self) -> blocks::Frustum {
        let clip = self.view.clip_from_view.as_dmat4() * self.view.view_from_world.as_dmat4();
        let thickness = f64::from(self.thickness());
        // Depth is −z of view space.
        let slices = (self.view.view_from_world.as_dmat4().row(2) + DVec4::W * f64::from(self.far)) / thickness;
        let row = |row: DVec4| -> [f32; 4] { row.as_vec4().into() };
        blocks::Frustum {
            clip_x: row(clip.row(0)),
            clip_y: row(clip.row(1)),
            clip_w: row(clip.row(3)),
            slices: row(slices),
            // What lies before the near end has no say in the voxels. Lines of sight that are parallel have w = 1.
            nearest: if self.view.is_orthographic() { 0.5 } else { self.near },
        }
    }
}

/// The axis that bits of a frustum run along, in its own coordinates.
pub(super) const SIGHT: Axis = Axis::Z;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Projection};
    use glam::Vec4;

    #[test]
    fn centres_lie_in_their_pixels_and_slices() {
        let mut camera = Camera::look_at(Vec3::new(1.0, 2.0, 5.0), Vec3::ZERO, Vec3::Y, 0.9, 0.1);
        for projection in [camera.projection, Projection::Orthographic { half_height: 2.0, near: -1.0, far: 9.0 }] {
            camera.projection = projection;
            let view = camera.view([40, 30]);
            let frustum = FrustumGrid::new(&view, [2.0, 7.0], 20).unwrap();
            for voxel in [[0, 0, 0], [39, 0, 19], [7, 29, 11]] {
                let center = frustum.center(voxel);
                let clip: Vec4 = view.clip_from_world() * center.extend(1.0);
                let pixel = [(clip.x / clip.w + 1.0) * 20.0, (clip.y / clip.w + 1.0) * 15.0];
                let slice = (7.0 + view.view_from_world.transform_point3(center).z) / 0.25;
                let found = [pixel[0], pixel[1], slice];
                let near = |i: usize| (found[i] - voxel[i] as f32 - 0.5).abs() < 1e-3;
                assert!((0..3).all(near), "{voxel:?} at {found:?}");
            }
        }
    }

    #[test]
    fn frusta_that_cannot_be_are_refused() {
        let view = Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 0.9, 0.1).view([8, 8]);
        for ends in [[2.0, 2.0], [0.0, 1.0], [-1.0, 1.0], [1.0, f32::INFINITY], [f32::NAN, 1.0]] {
            assert!(FrustumGrid::new(&view, ends, 8).is_err(), "{ends:?}");
        }
        assert!(FrustumGrid::new(&view, [1.0, 2.0], 0).is_err());
        let wide = View { size: [4096, 8], ..view };
        assert!(FrustumGrid::new(&wide, [1.0, 2.0], 8).unwrap_err().to_string().contains("1 to 2048"));
    }
}

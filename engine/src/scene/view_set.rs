//! View sets: what a pass sees through. One view for a camera, several for cascades, cube faces or slices.

use glam::{Mat4, Vec3, Vec4};

use super::{Projection, View};
use crate::geometry::{Aabb, Frustum};
use crate::shader::generated::blocks;
use crate::{Error, Result};

/// Most views of a set; `MAX_VIEWS` in `common/views.glsl`.
pub const MAX_VIEWS: usize = 8;

/// Views that one pass (or one pass each) draws into the layers of one target, in order.
#[derive(Clone, Debug)]
pub struct ViewSet {
    views: Vec<View>,
    /// By view, what of its picture is drawn.
    regions: Vec<Region>,
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// The first one, from the upper left.
    pub offset: [u32; 2],
    /// Width and height.
    pub size: [u32; 2],
}

impl Region {
    /// All of a picture.
    pub fn whole(size: [u32; 2]) -> Self {
        Self { offset: [0; 2], size }
    }

    /// The smallest around two.
    pub fn union(self, other: Self) -> Self {
        let offset = [0, 1].map(|axis| self.offset[axis].min(other.offset[axis]));
        let end = |region: &Self, axis: usize| region.offset[axis] + region.size[axis];
        Self { offset, size: [0, 1].map(|axis| end(&self, axis).max(end(&other, axis)) - offset[axis]) }
    }
}

impl ViewSet {
    /// A set of these views.
    ///
    /// # Errors
    /// [`Error::Invalid`] where there is none, or more than [`MAX_VIEWS`].
    pub fn new(views: Vec<View>) -> Result<Self> {
        match views.len() {
            1..=MAX_VIEWS => Ok(Self { regions: views.iter().map(|view| Region::whole(view.size)).collect(), views }),
            count => Err(Error::invalid("a set of views", format!("has {count} of them; 1 to {MAX_VIEWS} can be"))),
        }
    }

    /// The views.
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// Draws no more than these pixels, view by view.
    pub fn cropped(mut self, regions: impl IntoIterator<Item = Region>) -> Self {
        self.regions.iter_mut().zip(regions).for_each(|(region, cropped)| *region = cropped);
        self
    }

    /// By view, what of its picture is drawn.
    pub fn regions(&self) -> &[Region] {
        &self.regions
    }

    /// What each view sees of what is drawn.
    pub fn frusta(&self) -> Vec<Frustum> {
        self.views.iter().zip(&self.regions).map(|(view, region)| view.frustum(*region)).collect()
    }

    /// The set as `common/views.glsl` reads it.
    pub fn block(&self) -> blocks::Views {
        let mut block: blocks::Views = bytemuck::Zeroable::zeroed();
        for (record, view) in block.views.iter_mut().zip(&self.views) {
            *record = view.record();
        }
        block
    }
}

impl From<View> for ViewSet {
    fn from(view: View) -> Self {
        Self { regions: vec![Region::whole(view.size)], views: vec![view] }
    }
}

impl View {
    /// A light's parallel view along `direction`: a square of `width` metres around `center`, from `toward` metres
    /// before it to `beyond` metres behind it.
    pub fn parallel(center: Vec3, direction: Vec3, width: f32, toward: f32, beyond: f32, size: [u32; 2]) -> Self {
        let eye = center - direction * toward;
        let projection = Projection::Orthographic { half_height: 0.5 * width, near: 0.0, far: toward + beyond };
        Self::along(eye, direction, projection, size)
    }

    /// A square view from `eye` along `direction`, with an up vector that depends on the direction alone.
    pub fn along(eye: Vec3, direction: Vec3, projection: Projection, size: [u32; 2]) -> Self {
        let up = if direction.y.abs() < 0.99 { Vec3::Y } else { Vec3::Z };
        let right = direction.cross(up).normalize();
        let world_from_view = Mat4::from_cols(
            right.extend(0.0),
            right.cross(direction).extend(0.0),
            (-direction).extend(0.0),
            eye.extend(1.0),
        );
        Self {
            size,
            world_from_view,
            view_from_world: world_from_view.inverse(),
            clip_from_view: projection.clip_from_view(size[0] as f32 / size[1] as f32),
        }
    }

    /// Distance of the near plane along the view axis, metres.
    pub fn near(&self) -> f32 {
        let p = self.clip_from_view;
        // Solves z_clip = w_clip along the axis: p.z z + p.w = q.z z + q.w.
        -(p.w_axis.w - p.w_axis.z) / (p.z_axis.z - p.z_axis.w)
    }

    /// View-space position of the upper right corner of what is seen at a distance along the view axis.
    pub fn corner(&self, distance: f32) -> Vec3 {
        let p = self.clip_from_view;
        let w = -distance * p.z_axis.w + p.w_axis.w;
        Vec3::new(w / p.x_axis.x.abs(), w / p.y_axis.y.abs(), -distance)
    }

    /// Nearest and farthest distance along the view axis at which the view may see something of a box, metres.
    pub fn distances(&self, bounds: &Aabb) -> [f32; 2] {
        let in_view = bounds.transformed(self.view_from_world);
        let near = self.near().max(1e-6).max(-in_view.max.z);
        [near, (-in_view.min.z).max(near * 1.001)]
    }

    /// What is seen through a part of the picture.
    fn frustum(&self, Region { offset, size }: Region) -> Frustum {
        // From the region's part of clip space to all of it.
        let axis = |axis: usize| {
            let [whole, offset, size] = [self.size[axis], offset[axis], size[axis].max(1)].map(|pixels| pixels as f32);
            (whole / size, (whole - 2.0 * offset - size) / size)
        };
        let ((x, x_offset), (y, y_offset)) = (axis(0), axis(1));
        let crop = Mat4::from_cols(Vec4::X * x, Vec4::Y * y, Vec4::Z, Vec4::new(x_offset, y_offset, 0.0, 1.0));
        Frustum::new(&(crop * self.clip_from_world()))
    }

    /// Whether lines of sight are parallel.
    pub fn is_orthographic(&self) -> bool {
        self.clip_from_view.w_axis.w != 0.0
    }

    fn record(&self) -> blocks::ViewData {
        let eye: Vec4 = match self.is_orthographic() {
            true => self.world_from_view.z_axis.truncate().extend(0.0),
            false => self.eye().extend(1.0),
        };
        blocks::ViewData {
            clip_from_world: self.clip_from_world().to_cols_array_2d(),
            view_from_world: self.view_from_world.to_cols_array_2d(),
            world_from_view: self.world_from_view.to_cols_array_2d(),
            view_from_clip: self.clip_from_view.inverse().to_cols_array_2d(),
            eye: eye.to_array(),
            size: self.size.map(|pixels| pixels as f32).into(),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::Camera;

    #[test]
    fn a_set_has_a_view_and_no_more_than_shaders_take() {
        let view = Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0, 0.1).view([8, 8]);
        assert_eq!(ViewSet::new(vec![view; MAX_VIEWS]).unwrap().frusta().len(), MAX_VIEWS);
        for count in [0, MAX_VIEWS + 1] {
            let error = ViewSet::new(vec![view; count]).unwrap_err().to_string();
            assert!(error.contains(&format!("has {count} of them")), "{error}");
        }
    }
}

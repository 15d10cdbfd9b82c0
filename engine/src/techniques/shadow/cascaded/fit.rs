//! A light's parallel view around one slice of a camera's frustum, which keeps its size when the camera turns and
//! moves by whole texels: Valient 2007.

use glam::{Mat4, Vec3};

use crate::geometry::Aabb;
use crate::scene::{Region, View};

/// One cascade.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// The light's view of it.
    pub view: View,
    /// Size of a texel, metres.
    pub texel: f32,
    /// Start and end along the camera's axis, metres.
    pub distances: [f32; 2],
    /// Texels that may be looked at: what else the map has is not drawn.
    pub region: Region,
}

/// Fits a map of `resolution`² texels around the part of a camera's frustum between two distances, with `border`
/// texels to spare on each side, deep enough for all of the scene.
pub fn fit(camera: &View, distances: [f32; 2], direction: Vec3, scene: &Aabb, resolution: u32, border: f32) -> Fit {
    // 1. A sphere around the slice: its radius depends on the lens and the distances alone.
    let (center, radius) = bounding_sphere(camera, distances);
    let radius = round_up(radius);
    let width = 2.0 * radius * resolution as f32 / (resolution as f32 - 2.0 * border).max(1.0);
    let texel = width / resolution as f32;

    // 2. Its centre on the light's grid of texels.
    let light = View::parallel(Vec3::ZERO, direction, width, 0.0, 1.0, [resolution; 2]);
    let in_light = light.view_from_world.transform_point3(camera.world_from_view.transform_point3(center));
    let snapped = Vec3::new((in_light.x / texel).floor() * texel, (in_light.y / texel).floor() * texel, in_light.z);
    let center = light.world_from_view.transform_point3(snapped);

    // 3. Depth around all casters: those before the slice throw shadows into it.
    let [near, far] = depth_range(scene, &light.view_from_world, snapped.z);
    let slack = 1e-3 * (far - near).max(radius);
    let view = View::parallel(center, direction, width, slack - near, far + slack, [resolution; 2]);
    let region = Region::whole([resolution; 2]);
    Fit { view, texel, distances, region }
}

impl Fit {
    /// Draws no more than what surfaces between these distances from the camera look at, within so many texels around
    /// them.
    pub(super) fn crop(&mut self, camera: &View, distances: [f32; 2], scene: &Aabb, around: f32) {
        let slice = distances.into_iter().flat_map(|distance| {
            let corner = camera.corner(distance);
            [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]]
                .map(|[x, y]| camera.world_from_view.transform_point3(corner * Vec3::new(x, y, 1.0)))
        });
        let slice: Vec<Vec3> = slice.collect();
        let texels = |points: &[Vec3]| {
            let size = self.view.size[0] as f32;
            let clip = self.view.clip_from_world();
            Aabb::around(points.iter().map(|&point| (clip.project_point3(point) * 0.5 + 0.5) * size))
        };
        let Some(slice_box) = Aabb::around(slice.iter().copied()) else { return };
        let inside = Aabb { min: slice_box.min.max(scene.min), max: slice_box.max.min(scene.max) };
        let (Some(seen), Some(filled)) = (texels(&slice), texels(&inside.corners())) else { return };
        let in_map = |texel: Vec3| texel.clamp(Vec3::ZERO, Vec3::splat(self.view.size[0] as f32));
        let first = in_map((seen.min.max(filled.min) - around).floor());
        let size = in_map((seen.max.min(filled.max) + around).ceil()) - first;
        // What is less than nothing becomes 0.
        self.region = Region { offset: [first.x as u32, first.y as u32], size: [size.x as u32, size.y as u32] };
    }
}

/// Smallest sphere around a frustum slice, in view space.
fn bounding_sphere(camera: &View, [near, far]: [f32; 2]) -> (Vec3, f32) {
    let corner = |distance: f32| camera.corner(distance);
    let (n, f) = (corner(near), corner(far));
    // The centre lies on the axis where both rims are equally far, but not beyond the far plane.
    let (n2, f2) = (n.truncate().length_squared(), f.truncate().length_squared());
    let middle = 0.5 * (near + far) + 0.5 * (f2 - n2) / (far - near).max(f32::MIN_POSITIVE);
    let at = middle.clamp(near, far);
    let center = Vec3::new(0.0, 0.0, -at);
    (center, center.distance(f).max(center.distance(n)))
}

/// Up to the next sixteenth of a power of two, so that rounding errors do not change the size from frame to frame.
fn round_up(radius: f32) -> f32 {
    let step = radius.max(f32::MIN_POSITIVE).log2().floor().exp2() / 16.0;
    (radius / step).ceil() * step
}

/// Distances of a box along the light's axis, from the plane at `z` in the light's view space.
fn depth_range(scene: &Aabb, view_from_world: &Mat4, z: f32) -> [f32; 2] {
    let bounds = scene.transformed(*view_from_world);
    [z - bounds.max.z, z - bounds.min.z]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::scene::Camera;

    fn vector(most: f32) -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-most..most).prop_map(Vec3::from)
    }

    proptest! {
        #[test]
        fn what_a_surface_in_view_looks_at_is_drawn(
            eye in vector(10.0),
            towards in vector(1.0).prop_filter("a direction", |way| way.length() > 0.1 && way.y.abs() < 0.9 * way.length()),
            light in vector(1.0).prop_filter("a direction", |way| way.length() > 0.1),
            fov in 0.2..2.0f32,
            scene in (vector(10.0), vector(10.0)),
            distances in (0.1..20.0f32, 1.01..4.0f32, 0.5..1.0f32),
            places in prop::collection::vec((-1.0..1.0f32, -1.0..1.0f32, 0.0..1.0f32), 64),
        ) {
            let camera = Camera::look_at(eye, eye + towards, Vec3::Y, fov, 0.05).view([160, 90]);
            let scene = Aabb { min: scene.0.min(scene.1), max: scene.0.max(scene.1) };
            let (start, end) = (distances.0, distances.0 * distances.1);
            let (from, around) = (start * distances.2, 4.0);
            let mut fit = fit(&camera, [start, end], light.normalize(), &scene, 512, 2.5);
            fit.crop(&camera, [from, end], &scene, around);
            let Region { offset, size } = fit.region;
            for (x, y, z) in places {
                let distance = from + (end - from) * z;
                let point = camera.world_from_view.transform_point3(camera.corner(distance) * Vec3::new(x, y, 1.0));
                if point.cmplt(scene.min).any() || point.cmpgt(scene.max).any() {
                    continue;
                }
                let texel = (fit.view.clip_from_world().project_point3(point) * 0.5 + 0.5) * 512.0;
                for axis in [0, 1] {
                    let (first, end) = (texel[axis] - around + 0.01, texel[axis] + around - 0.01);
                    prop_assert!(first.max(0.0) >= offset[axis] as f32, "{point}: {first} before {:?}", fit.region);
                    prop_assert!(end.min(512.0) <= (offset[axis] + size[axis]) as f32, "{point}: {end} after {:?}", fit.region);
                }
            }
        }
    }
}

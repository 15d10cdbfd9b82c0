//! Cascaded shadow maps of a directional light: Zhang et al. 2006, "Parallel-split shadow maps for large-scale
//! virtual environments", with cascades that move by whole texels (Valient 2007, "Stable rendering of cascaded shadow
//! maps").

mod fit;
mod split;

use ash::vk;
use glam::{Mat3, Vec3};

pub use fit::{Fit, fit};
pub use split::{Splits, split_distances};

use super::{Filter, Receivers, map_sampler};
use crate::Result;
use crate::geometry::Aabb;
use crate::graph::{Graph, ImageHandle, ImageShape};
use crate::scene::{Faces, GpuScene, View, ViewSet};
use crate::shader::generated::blocks;
use crate::shader::generated::shadow::cascaded::mask_comp as shader;

/// Most cascades; `MAX_CASCADES` in `visibility.glsl`.
pub const MAX_CASCADES: u32 = 8;

/// Cascaded shadow maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cascaded {
    /// 1 to [`MAX_CASCADES`].
    pub cascades: u32,
    /// Where they end.
    pub splits: Splits,
    /// Width and height of each map in texels.
    pub resolution: u32,
    /// Filter of the mask.
    pub filter: Filter,
    /// Share of each cascade, at its end, in which the next one is blended in; 0 to 1.
    pub fade: f32,
    /// Metres along the view axis beyond which there is no shadow; at most the scene's farthest point.
    pub max_distance: f32,
}

impl Default for Cascaded {
    fn default() -> Self {
        Self {
            cascades: 4,
            splits: Splits::Practical(0.8),
            resolution: 2048,
            filter: Filter::Bilinear,
            fade: 0.1,
            max_distance: f32::INFINITY,
        }
    }
}

/// What the technique gives.
pub struct CascadedShadow {
    /// Visibility of the light at each pixel, 1 is lit.
    pub mask: ImageHandle,
    /// Cascade of each pixel from 1; 0 in the background and beyond the last.
    pub index: ImageHandle,
    /// Depth maps, a layer a cascade.
    pub map: ImageHandle,
    /// Parameters for `visibility.glsl`.
    pub parameters: blocks::Cascades,
    /// Its constant `CASCADE_TAPS`.
    pub taps: u32,
}

impl Cascaded {
    /// Renders the maps and writes the mask of a light that travels along `direction` (unit length, world space).
    ///
    /// # Errors
    /// As [`ViewSet::new`].
    pub fn record<'f>(
        &self,
        graph: &mut Graph<'f>,
        scene: &'f GpuScene,
        receivers: &Receivers,
        direction: Vec3,
        mask: ImageHandle,
    ) -> Result<CascadedShadow> {
        let fits = self.fit(receivers.view, &scene.bounds, direction);
        let map = graph.image(
            "shadow.cascaded.map",
            ImageShape::new_2d(vk::Format::D32_SFLOAT, [self.resolution; 2]).layers(fits.len() as u32),
        );
        let views = ViewSet::new(fits.iter().map(|fit| fit.view).collect())?;
        let views = views.cropped(fits.iter().map(|fit| fit.region));
        let map = scene.record_depth(graph, "shadow.cascaded.map", &views, map, Faces::Both);

        let index_shape = ImageShape::new_2d(vk::Format::R32_SFLOAT, receivers.view.size);
        let index = graph.image("shadow.cascaded.index", index_shape);
        let parameters = self.parameters(&fits);
        let taps = self.filter.taps();
        let mut pass = graph.compute("shadow.cascaded.mask", &shader::SHADER);
        pass.uniform(shader::VIEWS, &ViewSet::from(*receivers.view).block())
            .uniform(shader::CASCADES, &parameters)
            .read(shader::DEPTH, receivers.depth)
            .read(shader::IDS, receivers.ids)
            .sample(shader::CASCADE_MAP, &map, map_sampler())
            .specialize(shader::CASCADE_TAPS, taps);
        let mask = pass.write(shader::MASK, mask);
        let index = pass.write(shader::CASCADE_INDEX, index);
        pass.dispatch([receivers.view.size[0], receivers.view.size[1], 1]);
        Ok(CascadedShadow { mask, index, map, parameters, taps })
    }

    /// Where the cascades lie for a camera, a scene and a direction of light.
    pub fn fit(&self, view: &View, scene: &Aabb, direction: Vec3) -> Vec<Fit> {
        let [near, far] = view.distances(scene);
        let far = far.min(self.max_distance.max(near * 1.001));
        // A near plane at the lens would spend whole cascades on the first centimetres.
        let ends = split_distances(self.splits, self.cascades.clamp(1, MAX_CASCADES), near.max(1e-3 * far), far);
        let border = 0.5 * self.filter.taps() as f32 + 2.0;
        // How far off a point is looked up: lifted along its normal, in a filter's outermost texel.
        let taps = self.filter.taps() as f32;
        let around = 2f32.sqrt() * (0.5 * taps + 0.5) + 0.5 * taps + 2.0;
        let mut start = near;
        // Where the cascade before begins to fade.
        let mut from = near;
        let fits = ends.into_iter().map(|end| {
            let mut fit = fit(view, [start, end], direction, scene, self.resolution, border);
            fit.crop(view, [from, end], scene, around);
            (start, from) = (end, self.fades_from([start, end]));
            fit
        });
        fits.collect()
    }

    /// Distance from which the next cascade is blended in.
    fn fades_from(&self, [start, end]: [f32; 2]) -> f32 {
        end - (end - start) * self.fade.clamp(0.0, 1.0)
    }

    /// The cascades differ by scale and offset alone: their views are all turned the same way.
    fn parameters(&self, fits: &[Fit]) -> blocks::Cascades {
        let none = blocks::Cascade { end: f32::INFINITY, ..bytemuck::Zeroable::zeroed() };
        let mut cascades = [none; MAX_CASCADES as usize];
        for (cascade, fit) in cascades.iter_mut().zip(fits) {
            let view_from_light = fit.view.view_from_world.w_axis.truncate();
            let clip = &fit.view.clip_from_view;
            // From clip space, −1 to 1, to texture coordinates, 0 to 1; depth stays.
            let half = Vec3::new(0.5, 0.5, 1.0);
            let scale = Vec3::new(clip.x_axis.x, clip.y_axis.y, clip.z_axis.z) * half;
            let offset = clip.w_axis.truncate() * half + Vec3::new(0.5, 0.5, 0.0) + scale * view_from_light;
            let fade = self.fades_from(fit.distances);
            *cascade = blocks::Cascade { scale, offset, texel: fit.texel, end: fit.distances[1], fade };
        }
        let turned = fits.first().map_or(Mat3::IDENTITY, |fit| Mat3::from_mat4(fit.view.view_from_world)).transpose();
        blocks::Cascades {
            light_from_world: [turned.x_axis, turned.y_axis, turned.z_axis].map(Into::into),
            cascade_count: fits.len() as u32,
            map_texel: 1.0 / self.resolution as f32,
            cascades,
        }
    }
}

//! A captured frame against the twins, layer by layer.

use glam::DVec3;
use shadowgraph::scene::{Light, View};

use crate::compare::{Comparison, degrees, relative};
use crate::exr_file::Part;
use crate::twin::brdf::Material;
use crate::twin::camera::{Camera, Picture, Pixel, Tolerance, cast};
use crate::twin::lighting::{self, Sample};
use crate::twin::scene::Scene;
use crate::twin::{shadow, transmittance};

const NEAR_EDGE: &str = "near an edge";
const RGB: [&str; 3] = ["R", "G", "B"];
const XYZ: [&str; 3] = ["X", "Y", "Z"];

/// The layers of a captured view, and what the ray caster sees of it.
pub struct Judge<'a> {
    name: &'a str,
    part: &'a Part,
    scene: &'a Scene<'a>,
    view: &'a View,
    /// What the ray caster sees.
    pub picture: Picture,
}

impl<'a> Judge<'a> {
    /// Casts the rays. `name` goes before the layers' names in reports and file names.
    pub fn new(name: &'a str, part: &'a Part, scene: &'a Scene<'a>, view: &'a View) -> Self {
        assert_eq!(part.size, view.size, "{name}: the capture has another size than the view");
        Self { name, part, scene, view, picture: cast(scene, view, Tolerance::default()) }
    }

    /// Layer `Z`: relative, 1e-4.
    pub fn depth(&self) -> Comparison {
        let z = self.part.floats("Z");
        self.pixels("Z", 1e-4, |i, pixel| relative(f64::from(z[i]), pixel.z, 0.0))
    }

    /// Layer `P`: distance, relative to `Z`, 1e-4.
    pub fn position(&self) -> Comparison {
        let p = self.part.vectors("P.", XYZ);
        self.pixels("P", 1e-4, |i, pixel| {
            pixel.surface.as_ref().map_or(0.0, |surface| p[i].distance(surface.position) / pixel.z)
        })
    }

    /// Layers `id`: all three exactly; 0 where there is no surface.
    pub fn ids(&self) -> Comparison {
        let ids = ["id.object", "id.primitive", "id.material"].map(|layer| self.part.uints(layer));
        self.pixels("id", 0.0, |i, pixel| {
            let expected = pixel.surface.as_ref().map_or([0; 3], |surface| surface.ids);
            if ids.map(|layer| layer[i]) == expected { 0.0 } else { f64::INFINITY }
        })
    }

    /// Layer `N`: degrees, 0.1; and of unit length, to what 16 bits hold.
    pub fn normal(&self) -> Comparison {
        let n = self.part.vectors("N.", XYZ);
        self.pixels("N", 0.1, |i, pixel| match &pixel.surface {
            Some(_) if (n[i].length() - 1.0).abs() > 1e-3 => f64::INFINITY,
            Some(surface) => degrees(n[i], surface.normal),
            None => 0.0,
        })
    }

    /// Pixels with a surface on either side are compared unless they are near an edge.
    fn pixels(&self, layer: &str, tolerance: f64, error: impl Fn(usize, &Pixel) -> f64) -> Comparison {
        let mut comparison = Comparison::new(format!("{}: {layer}", self.name), self.view.size, tolerance);
        let z = self.part.floats("Z");
        for (i, pixel) in self.picture.pixels.iter().enumerate() {
            if pixel.near_edge {
                comparison.leave_out(i, NEAR_EDGE);
            } else if pixel.surface.is_some() != z[i].is_finite() {
                comparison.same(i, false);
            } else if pixel.surface.is_some() {
                comparison.error(i, error(i, pixel));
            }
        }
        comparison
    }

    /// Layer `shadow.<light>`, on either side of one half, where the light reaches a surface on which camera and ray
    /// caster agree. `texel` gives the width of a shadow-map texel at a pixel in metres; where the surface is within two
    /// texels of a shadow's edge, it is left out. `offset`: see [`shadow::lit`].
    pub fn shadow(&self, light: &Light, texel: impl Fn(&Pixel) -> f64, offset: f64) -> Comparison {
        let layer = format!("shadow.{}", light.name);
        let mask = self.part.floats(&layer);
        let (objects, triangles) = (self.part.uints("id.object"), self.part.uints("id.primitive"));
        let seen = shadow::cast(self.scene, light, &self.picture.receivers(texel), self.view.size[0], offset);
        let mut comparison = Comparison::new(format!("{}: {layer}", self.name), self.view.size, 0.5);
        for (i, (pixel, seen)) in self.picture.pixels.iter().zip(seen).enumerate() {
            let (Some(surface), Some(seen)) = (&pixel.surface, seen) else { continue };
            if !seen.reached || surface.ids[..2] != [objects[i], triangles[i]] {
                continue;
            }
            if seen.near_edge {
                comparison.leave_out(i, "near a shadow's edge");
            } else {
                comparison.error(i, f64::from(mask[i]) - f64::from(u8::from(seen.lit)));
            }
        }
        comparison
    }

    /// Layers `transmittance.<light>`, where the light reaches a surface on which camera and ray caster agree: largest
    /// difference of a channel. `texel` as in [`Judge::shadow`]; left out is what changes by more than `tolerance` within
    /// two texels.
    pub fn transmittance(
        &self,
        light: &Light,
        texel: impl Fn(&Pixel) -> f64,
        offset: f64,
        tolerance: f64,
    ) -> Comparison {
        let layer = format!("transmittance.{}", light.name);
        let found = self.part.vectors(&format!("{layer}."), RGB);
        let (objects, triangles) = (self.part.uints("id.object"), self.part.uints("id.primitive"));
        let casters = transmittance::casters(self.scene.source);
        let casters = Scene::new(&casters).seeing_blended();
        let receivers = self.picture.receivers(texel);
        let seen = transmittance::cast(&casters, light, &receivers, self.view.size[0], offset, tolerance);
        let mut comparison = Comparison::new(format!("{}: {layer}", self.name), self.view.size, tolerance);
        for (i, (pixel, seen)) in self.picture.pixels.iter().zip(seen).enumerate() {
            let (Some(surface), Some(seen)) = (&pixel.surface, seen) else { continue };
            if !seen.reached || surface.ids[..2] != [objects[i], triangles[i]] {
                continue;
            }
            if seen.near_edge {
                comparison.leave_out(i, "near an edge of glass");
            } else {
                comparison.error(i, (found[i] - seen.through).abs().max_element());
            }
        }
        comparison
    }

    /// Layer `direct` times `1 / exposure`, against the BRDF of the captured G-buffer under lights with their captured
    /// shadow masks (1 where a light has none): distance over the expected length, 1e-3. The length counts as at least
    /// 1e-3 of the mean, for what is almost black. Surfaces of unlit materials are passed over.
    pub fn direct(&self, exposure: f64) -> Comparison {
        self.radiance("direct", &self.part.vectors("direct.", RGB), exposure, None)
    }

    /// Layers `R,G,B` likewise, with emission, and occlusion of a constant environment of this radiance. The scene must
    /// have no blended surfaces.
    pub fn color(&self, exposure: f64, environment: DVec3) -> Comparison {
        self.radiance("color", &self.part.vectors("", RGB), exposure, Some(environment))
    }

    /// `environment`: with all that is not the lights' too.
    fn radiance(&self, layer: &str, found: &[DVec3], exposure: f64, environment: Option<DVec3>) -> Comparison {
        let camera = Camera::new(self.view);
        let part = self.part;
        let [p, n] = ["P.", "N."].map(|layer| part.vectors(layer, XYZ));
        let albedo = part.vectors("albedo.", RGB);
        let [roughness, metallic] = ["roughness", "metallic"].map(|layer| part.floats(layer));
        let rest = environment.map(|_| (part.vectors("emissive.", RGB), part.floats("occlusion")));
        let materials = part.uints("id.material");
        let source = self.scene.source;
        let masks: Vec<_> = source
            .lights
            .iter()
            .map(|light| part.channels.get(&format!("shadow.{}", light.name)).map(|_| format!("shadow.{}", light.name)))
            .map(|layer| layer.map(|layer| part.floats(&layer)))
            .collect();

        let is_lit = |i: usize| {
            let material = (materials[i] as usize).checked_sub(1).and_then(|k| source.materials.get(k));
            material.is_some_and(|m| !m.unlit && !m.is_blended())
        };
        let expected = |i: usize| -> DVec3 {
            let material =
                Material { albedo: albedo[i], metallic: f64::from(metallic[i]), roughness: f64::from(roughness[i]) };
            let (emissive, occlusion) = match &rest {
                Some((emissive, occlusion)) => (emissive[i], f64::from(occlusion[i])),
                None => (DVec3::ZERO, 1.0),
            };
            let sample = Sample { position: p[i], normal: n[i].normalize(), material, emissive, occlusion };
            let lights = source.lights.iter().zip(&masks);
            let visible = lights.map(|(light, mask)| (light, mask.map_or(1.0, |mask| f64::from(mask[i]))));
            lighting::radiance(&sample, camera.toward_viewer(p[i]), visible, environment.unwrap_or_default())
        };
        let all: Vec<_> = (0..p.len()).filter(|&i| is_lit(i)).map(|i| (i, expected(i))).collect();
        let mean = all.iter().map(|(_, e)| e.length()).sum::<f64>() / all.len().max(1) as f64;
        let mut comparison = Comparison::new(format!("{}: {layer}", self.name), self.view.size, 1e-3);
        for (i, expected) in all {
            comparison.error(i, (found[i] / exposure).distance(expected) / expected.length().max(1e-3 * mean));
        }
        comparison
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exr_file::Channel;
    use crate::tiny;
    use glam::{Mat4, Vec3};
    use shadowgraph::scene::{Camera as Lens, Scene as Source};

    fn source() -> Source {
        let mut source = tiny::empty();
        let plane = tiny::quad(Vec3::new(-9.0, 0.0, 9.0), Vec3::X * 18.0, Vec3::NEG_Z * 18.0, 0);
        tiny::add(&mut source, plane, Mat4::IDENTITY);
        tiny::add(&mut source, tiny::cuboid(Vec3::splat(-1.0), Vec3::ONE, 0), Mat4::from_translation(Vec3::Y));
        source.lights = vec![
            tiny::sun(Vec3::new(0.4, -1.0, -0.3)),
            tiny::spot(Vec3::new(0.0, 5.0, 5.0), Vec3::new(0.0, -1.0, -1.0), 0.3, 0.7),
        ];
        source
    }

    /// What a perfect engine would capture, from the twins themselves.
    fn capture(scene: &Scene, view: &View) -> Part {
        let picture = cast(scene, view, Tolerance::default());
        let camera = Camera::new(view);
        let mut part =
            Part { name: String::new(), size: view.size, channels: Default::default(), texts: Default::default() };
        let mut floats = |name: &str, value: &dyn Fn(usize, &Pixel) -> f64| {
            let values = picture.pixels.iter().enumerate().map(|(i, p)| value(i, p) as f32).collect();
            part.channels.insert(name.into(), Channel::Float(values));
        };
        let vector = |p: &Pixel, k: usize, f: &dyn Fn(&crate::twin::surface::Surface) -> DVec3| {
            p.surface.as_ref().map_or(0.0, |s| f(s)[k])
        };
        floats("Z", &|_, p| p.z);
        for (k, (axis, color)) in XYZ.iter().zip(RGB).enumerate() {
            floats(&format!("P.{axis}"), &|_, p| vector(p, k, &|s| s.position));
            floats(&format!("N.{axis}"), &|_, p| vector(p, k, &|s| s.normal));
            floats(&format!("albedo.{color}"), &|_, p| vector(p, k, &|s| s.base_color.truncate()));
        }
        floats("roughness", &|_, p| p.surface.as_ref().map_or(0.0, |s| s.roughness));
        floats("metallic", &|_, p| p.surface.as_ref().map_or(0.0, |s| s.metallic));
        let lights = &scene.source.lights;
        let lit: Vec<Vec<f64>> = lights
            .iter()
            .map(|l| shadow::cast(scene, l, &picture.receivers(|_| 0.01), view.size[0], 1e-5))
            .map(|seen| seen.iter().map(|v| f64::from(u8::from(v.is_some_and(|v| v.lit)))).collect())
            .collect();
        for (light, lit) in lights.iter().zip(&lit) {
            floats(&format!("shadow.{}", light.name), &|i, _| lit[i]);
        }
        for (k, color) in RGB.iter().enumerate() {
            floats(&format!("direct.{color}"), &|i, p| {
                vector(p, k, &|s| {
                    let material =
                        Material { albedo: s.base_color.truncate(), metallic: s.metallic, roughness: s.roughness };
                    let sample = Sample {
                        position: s.position,
                        normal: s.normal,
                        material,
                        emissive: DVec3::ZERO,
                        occlusion: 1.0,
                    };
                    let seen = lights.iter().zip(&lit).map(|(l, lit)| (l, lit[i]));
                    0.5 * lighting::radiance(&sample, camera.toward_viewer(s.position), seen, DVec3::ZERO)
                })
            });
        }
        for (k, name) in ["id.object", "id.primitive", "id.material"].into_iter().enumerate() {
            let values = picture.pixels.iter().map(|p| p.surface.as_ref().map_or(0, |s| s.ids[k])).collect();
            part.channels.insert(name.into(), Channel::Uint(values));
        }
        part
    }

    #[test]
    fn a_perfect_capture_agrees_and_a_wrong_layer_does_not() {
        let source = source();
        let scene = Scene::new(&source);
        let view = Lens::look_at(Vec3::new(3.0, 4.0, 7.0), Vec3::Y * 0.5, Vec3::Y, 0.9, 0.1).view([96, 64]);
        let perfect = capture(&scene, &view);
        let shares = |part: &Part| {
            let judge = Judge::new("judge", part, &scene, &view);
            let shadows = |k: usize| judge.shadow(&source.lights[k], |_| 0.01, 1e-5);
            [judge.depth(), judge.position(), judge.ids(), judge.normal(), shadows(0), shadows(1), judge.direct(0.5)]
                .map(|comparison| comparison.tally())
                .map(|tally| (tally.compared, tally.agreement(), tally.left_out_share()))
        };
        for (compared, agreement, left_out) in shares(&perfect) {
            assert!(compared > 1000 && agreement == 1.0 && left_out < 0.05, "{:?}", shares(&perfect));
        }

        // A layer that is wrong in every pixel is caught where it is judged.
        let wrong = [("Z", 0), ("P.X", 1), ("N.Y", 3), ("shadow.sun", 4), ("shadow.spot", 5), ("direct.G", 6)];
        for (channel, k) in wrong {
            let mut part = perfect.clone();
            let Some(Channel::Float(values)) = part.channels.get_mut(channel) else { panic!("{channel}") };
            values.iter_mut().for_each(|v| *v = 0.9 - *v * 0.8);
            assert!(shares(&part)[k].1 < 0.1, "{channel}: {:?}", shares(&part)[k]);
        }
        for channel in ["id.object", "id.primitive", "id.material"] {
            let mut part = perfect.clone();
            let Some(Channel::Uint(values)) = part.channels.get_mut(channel) else { panic!("{channel}") };
            values.iter_mut().for_each(|v| *v += 1);
            assert_eq!(shares(&part)[2].1, 0.0);
        }
    }
}

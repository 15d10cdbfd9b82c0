//! Panes of blended materials, shaded and composited on the host: layers are cast one by one.

use glam::{DVec3, DVec4, Mat3, Mat4, Quat, Vec3, Vec4};
use shadowgraph::frame::FrameSettings;
use shadowgraph::gpu::Gpu;
use shadowgraph::scene::{AlphaMode, Camera as Lens, Light, LightKind, Material, Scene as Source, TextureSlot};

use crate::compare::Comparison;
use crate::exr_file::Part;
use crate::figures::Check;
use crate::render::Subject;
use crate::tiny;
use crate::twin::brdf::Material as Brdf;
use crate::twin::camera::{Camera, Picture, Tolerance, cast};
use crate::twin::lighting::{Sample, radiance};
use crate::twin::scene::Scene;
use crate::twin::shadow;

const SIZE: [u32; 2] = [320, 180];
const ENVIRONMENT: Vec3 = Vec3::new(0.05, 0.06, 0.08);

/// Four panes before a wall, one behind the other, not in the order of the scene; the third is seen from behind. A bar
/// throws its shadow on them.
pub fn panes(unlit: bool) -> Subject {
    let mut scene = tiny::empty();
    scene.materials[0].roughness = 0.6;
    let colors = [[0.9, 0.2, 0.1, 0.5], [0.1, 0.8, 0.2, 0.3], [0.2, 0.3, 0.9, 0.7], [0.9, 0.8, 0.1, 0.4]];
    let depths = [1.0, -1.0, 0.0, 2.0];
    for (k, (color, z)) in colors.into_iter().zip(depths).enumerate() {
        scene.materials.push(Material {
            name: format!("pane {k}"),
            base_color: Vec4::from(color),
            metallic: 0.0,
            roughness: 0.3 + 0.15 * k as f32,
            alpha_mode: AlphaMode::Blend,
            double_sided: true,
            unlit,
            ..Material::default()
        });
        let pane = tiny::quad(Vec3::new(-1.0, -0.6, 0.0), Vec3::X * 2.0, Vec3::Y * 1.2, k + 1);
        let back = if k == 2 { std::f32::consts::PI } else { 0.0 };
        let aside = Vec3::new(0.35 * z - 0.2, 0.12 * z, z);
        tiny::add(&mut scene, pane, Mat4::from_rotation_translation(Quat::from_rotation_y(back), aside));
    }
    tiny::add(&mut scene, tiny::quad(Vec3::new(-2.0, -1.5, -2.0), Vec3::X * 3.2, Vec3::Y * 3.0, 0), Mat4::IDENTITY);
    let bar = tiny::cuboid(Vec3::new(-0.1, -2.0, 2.5), Vec3::new(0.1, 2.0, 2.6), 0);
    tiny::add(&mut scene, bar, Mat4::from_translation(Vec3::X * 1.5));
    scene.lights = vec![tiny::sun(Vec3::new(-0.5, -0.3, -1.0))];
    let kind = LightKind::Point { position: Vec3::new(-1.0, 1.0, 3.5), intensity: 3.0, range: f32::INFINITY };
    scene.lights.push(Light { name: "bulb".into(), color: Vec3::new(1.0, 0.8, 0.6), kind });
    scene.cameras = vec![Lens::look_at(Vec3::new(0.3, 0.2, 6.0), Vec3::ZERO, Vec3::Y, 0.7, 0.1)];
    scene.name = format!("panes, {}", if unlit { "unlit" } else { "lit" });
    Subject::new(scene, SIZE)
}

/// The same, lit, of glass that multiplies what lies behind: with alpha, without, and textured.
pub fn glass() -> Subject {
    panes(false).changed(|subject| {
        for (material, transmission) in subject.scene.materials[1..].iter_mut().zip([0.9, 0.6, 1.0, 0.8]) {
            material.transmission = transmission;
        }
        subject.scene.materials[2].alpha_mode = AlphaMode::Opaque;
        // Half of it by a texture.
        subject.scene.textures.push(tiny::texel("half", [128, 0, 255, 255]));
        let slot = TextureSlot { texture: 0, uv_set: 0, transform: Mat3::IDENTITY };
        subject.scene.materials[4].transmission_texture = Some(slot);
        subject.scene.materials[3].base_color.w = 1.0;
        subject.name = "panes of glass, lit".into();
        subject.scene.name = subject.name.clone();
    })
}

/// The picture of a subject, with what `change` does to its settings.
pub fn capture(gpu: &Gpu, subject: &Subject, change: impl FnOnce(&mut FrameSettings)) -> Part {
    let settings = |settings: &mut FrameSettings| {
        settings.environment = ENVIRONMENT;
        change(settings);
    };
    subject.capture(gpu, settings).parts.remove(0)
}

/// A layer: distance, premultiplied colour and what is let through of each pixel it covers, and where rounding may decide.
struct Layer {
    texels: Vec<Option<(f64, DVec3, DVec3)>>,
    near_edge: Vec<bool>,
}

/// The scene with a single object.
fn alone(source: &Source, object: usize) -> Source {
    Source { objects: vec![source.objects[object].clone()], ..source.clone() }
}

/// Shades what a picture sees, under lights that only the opaque objects of `scene` hide.
fn shade(scene: &Scene, camera: &Camera, picture: &Picture) -> Layer {
    let lights = &scene.source.lights;
    // As wide as the coarsest cascade's texels; point lights throw no shadows.
    let seen: Vec<_> = lights
        .iter()
        .map(|light| match light.kind {
            LightKind::Point { .. } => None,
            _ => Some(shadow::cast(scene, light, &picture.receivers(|_| 0.008), SIZE[0], 1e-4)),
        })
        .collect();
    let mut near_edge: Vec<_> = picture.pixels.iter().map(|pixel| pixel.near_edge).collect();
    let mut texels = Vec::new();
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let Some(surface) = &pixel.surface else {
            texels.push(None);
            continue;
        };
        let source = &scene.source.materials[surface.ids[2] as usize - 1];
        // KHR_materials_transmission: what passes is not diffused. (No pane is of metal: albedo is the diffuse colour.)
        let transmission = surface.transmission;
        let albedo = surface.base_color.truncate() * (1.0 - transmission);
        let color = if source.unlit {
            albedo + surface.emissive
        } else {
            near_edge[i] |= seen.iter().flatten().any(|seen| seen[i].is_some_and(|v| v.near_edge));
            let material = Brdf { albedo, metallic: surface.metallic, roughness: surface.roughness };
            let sample = Sample {
                position: surface.position,
                normal: surface.normal,
                material,
                emissive: surface.emissive,
                occlusion: surface.occlusion,
            };
            let visible = |seen: &Option<Vec<Option<shadow::Visibility>>>| {
                seen.as_ref().is_none_or(|seen| seen[i].is_some_and(|v| v.lit))
            };
            let lights = lights.iter().zip(&seen).map(|(light, seen)| (light, f64::from(u8::from(visible(seen)))));
            radiance(&sample, camera.toward_viewer(surface.position), lights, ENVIRONMENT.as_dvec3())
        };
        let alpha = if source.alpha_mode == AlphaMode::Blend { surface.base_color.w } else { 1.0 };
        let to_eye = camera.toward_viewer(surface.position);
        let fresnel = 0.04 + 0.96 * (1.0 - surface.normal.dot(to_eye).abs()).powi(5);
        let passing = surface.base_color.truncate() * transmission * if source.unlit { 1.0 } else { 1.0 - fresnel };
        texels.push(Some((pixel.z, color * alpha, DVec3::ONE - alpha * (DVec3::ONE - passing))));
    }
    Layer { texels, near_edge }
}

/// Colour and alpha of each pixel: 1e-3 of the larger of its length and a tenth of the mean.
pub fn compare(truth: &Subject, part: &Part) -> Check {
    let view = truth.view();
    let camera = Camera::new(&view);
    let whole = Scene::new(&truth.scene);
    let see = |scene: &Scene| cast(scene, &view, Tolerance::default());

    // 1. The opaque surfaces, and each pane alone
    let mut layers = vec![shade(&whole, &camera, &see(&whole))];
    for (k, object) in truth.scene.objects.iter().enumerate() {
        let material = truth.scene.meshes[object.mesh].primitives[0].material;
        if truth.scene.materials[material].is_blended() {
            let source = alone(&truth.scene, k);
            layers.push(shade(&whole, &camera, &see(&Scene::new(&source).seeing_blended())));
        }
    }

    // 2. Front to back, up to the opaque surface
    let over = |i: usize| {
        let opaque = layers[0].texels[i].map_or(f64::INFINITY, |(z, ..)| z);
        let mut hits: Vec<_> = layers.iter().filter_map(|l| l.texels[i]).filter(|(z, ..)| *z <= opaque).collect();
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut color, mut through) = (DVec3::ZERO, DVec3::ONE);
        for (_, radiance, lets) in hits {
            color += through * radiance;
            through *= lets;
        }
        color.extend(1.0 - through.element_sum() / 3.0)
    };
    let expected: Vec<_> = (0..layers[0].texels.len()).map(over).collect();

    // 3. Against the capture
    let mean = expected.iter().map(|c| c.length()).sum::<f64>() / expected.len() as f64;
    let (found, alpha) = (part.vectors("", ["R", "G", "B"]), part.floats("A"));
    let mut comparison = Comparison::new(format!("{}: color", truth.name), truth.size, 1e-3);
    for (i, expected) in expected.iter().enumerate() {
        if layers.iter().any(|layer| layer.near_edge[i]) {
            comparison.leave_out(i, "near an edge");
        } else {
            let found: DVec4 = found[i].extend(alpha[i].into());
            comparison.error(i, found.distance(*expected) / expected.length().max(0.1 * mean));
        }
    }
    Check::new(comparison, 0.999, 0.1)
}

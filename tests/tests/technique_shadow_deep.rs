//! Deep shadow maps against rays: what comes through glass, channel by channel.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{Mat4, Quat, Vec3, Vec4};
use shadowgraph::capture::auto_exposure;
use shadowgraph::frame::{FrameSettings, Transparency};
use shadowgraph::scene::{AlphaMode, Camera, Light, LightKind, Material};
use shadowgraph::techniques::shadow::deep::DeepShadow;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::exr_file::Part;
use shadowgraph_tests::figures::{self, Check, Figure, Picture};
use shadowgraph_tests::judge::Judge;
use shadowgraph_tests::render::{Subject, only};
use shadowgraph_tests::tiny;
use shadowgraph_tests::twin::camera::Pixel;
use shadowgraph_tests::twin::scene::Scene;
use shadowgraph_tests::twin::shadow::spot_texel;

const SIZE: [u32; 2] = [320, 180];
const TOLERANCE: f64 = 2e-3;

/// Of glass, alpha and light: panes one behind the other and through each other, and a ball, over a floor.
fn glasshouse() -> Subject {
    let mut scene = tiny::empty();
    scene.materials[0].base_color = Vec4::new(0.8, 0.8, 0.78, 1.0);
    scene.materials[0].roughness = 0.9;
    let mut material = |name: &str, base: [f32; 4], transmission, alpha_mode| {
        scene.materials.push(Material {
            name: name.into(),
            base_color: base.into(),
            metallic: 0.0,
            roughness: 0.1,
            transmission,
            alpha_mode,
            double_sided: true,
            ..Material::default()
        });
        scene.materials.len() - 1
    };
    let ruby = material("ruby", [0.95, 0.06, 0.05, 1.0], 1.0, AlphaMode::Opaque);
    let amber = material("amber", [1.0, 0.62, 0.08, 1.0], 1.0, AlphaMode::Opaque);
    let emerald = material("emerald", [0.08, 0.85, 0.25, 1.0], 1.0, AlphaMode::Opaque);
    let cobalt = material("cobalt", [0.07, 0.2, 0.98, 0.95], 0.9, AlphaMode::Blend);
    let veil = material("veil", [0.9, 0.9, 0.9, 0.4], 0.0, AlphaMode::Blend);
    let glow = material("glow", [0.02, 0.02, 0.05, 1.0], 0.0, AlphaMode::Add);
    let clear = material("clear", [0.75, 0.95, 1.0, 1.0], 1.0, AlphaMode::Opaque);

    tiny::add(&mut scene, tiny::quad(Vec3::new(-4.0, 0.0, 3.0), Vec3::X * 9.0, Vec3::NEG_Z * 6.0, 0), Mat4::IDENTITY);
    let pane =
        |x: f32, z: f32, turn: f32| Mat4::from_rotation_translation(Quat::from_rotation_y(turn), Vec3::new(x, 0.0, z));
    let upright = |material| tiny::quad(Vec3::new(-0.45, 0.05, 0.0), Vec3::X * 0.9, Vec3::Y * 1.8, material);
    for (k, material) in [ruby, amber, emerald, cobalt].into_iter().enumerate() {
        tiny::add(&mut scene, upright(material), pane(-1.5 + k as f32, -0.6 + 0.1 * k as f32, 0.15));
    }
    // Behind and through others.
    tiny::add(&mut scene, upright(amber), pane(0.9, -1.1, -0.5));
    tiny::add(&mut scene, upright(cobalt), pane(-1.4, -1.0, 0.8));
    tiny::add(&mut scene, upright(veil), pane(-0.3, -1.2, 0.3));
    tiny::add(&mut scene, upright(glow), pane(2.3, -0.9, 0.1));
    let ball = Mat4::from_scale_rotation_translation(Vec3::splat(0.4), Quat::IDENTITY, Vec3::new(2.4, 0.45, 0.4));
    tiny::add(&mut scene, tiny::sphere(64, 32, clear), ball);
    // A frame that lets nothing through.
    for k in 0..5 {
        let x = -2.0 + k as f32;
        let bar = tiny::cuboid(Vec3::new(-0.04, 0.0, -0.04), Vec3::new(0.04, 1.95, 0.04), 0);
        tiny::add(&mut scene, bar, Mat4::from_translation(Vec3::new(x, 0.0, -0.65 + 0.1 * k as f32)));
    }
    let mut sun = tiny::sun(Vec3::new(0.25, -0.75, 1.0));
    if let LightKind::Directional { illuminance, .. } = &mut sun.kind {
        *illuminance = 4.0;
    }
    let mut spot = tiny::spot(Vec3::new(-3.0, 2.6, -3.0), Vec3::new(0.75, -0.6, 0.75), 0.3, 0.55);
    spot.color = Vec3::new(1.0, 0.9, 0.7);
    if let LightKind::Spot { intensity, .. } = &mut spot.kind {
        *intensity = 14.0;
    }
    scene.lights = vec![sun, spot];
    scene.cameras = vec![Camera::look_at(Vec3::new(1.2, 2.6, 5.2), Vec3::new(0.25, 0.35, 0.3), Vec3::Y, 0.75, 0.1)];
    scene.name = "glasshouse".into();
    Subject::new(scene, SIZE)
}

fn render(subject: &Subject, deep: Option<DeepShadow>, layers: &[&str]) -> Part {
    let wanted = only(layers);
    let change = |settings: &mut FrameSettings| {
        wanted(settings);
        settings.deep_shadow = deep;
        settings.transparency = Transparency::ABuffer;
        settings.environment = Vec3::splat(0.12);
        settings.spot.resolution = 2048;
    };
    subject.capture(shared(), change).parts.remove(0)
}

fn layers(subject: &Subject, deep: DeepShadow) -> Part {
    render(subject, Some(deep), &["Z", "id", "transmittance"])
}

/// What comes through of each light that has a map.
fn compare(truth: &Subject, deep: DeepShadow, part: &Part) -> Vec<Check> {
    let twin = Scene::new(&truth.scene);
    let view = truth.view();
    let judge = Judge::new(&truth.name, part, &twin, &view);
    let casters = truth.scene.clone().upload(shared()).unwrap();
    let blended = casters.draws.draws().iter().filter(|draw| draw.class == shadowgraph::scene::DrawClass::Blend);
    let bounds = blended.map(|draw| draw.bounds).reduce(shadowgraph::geometry::Aabb::union).unwrap();
    let of_light = |light: &Light| -> Option<Check> {
        part.channels.get(&format!("transmittance.{}.R", light.name))?;
        let side = deep.resolution;
        let texel = |pixel: &Pixel| match light.kind {
            LightKind::Spot { position, direction, outer, .. } => {
                let along = pixel.surface.as_ref().unwrap().position - position.as_dvec3();
                spot_texel(outer.into(), side, along.dot(direction.as_dvec3()))
            }
            _ => {
                let view = deep.view(light, &bounds, 1.0).unwrap();
                f64::from(2.0 / (view.clip_from_view.x_axis.x * side as f32))
            }
        };
        Some(Check::new(judge.transmittance(light, texel, 1e-4, TOLERANCE), 0.995, 0.25))
    };
    let checks: Vec<_> = truth.scene.lights.iter().filter_map(of_light).collect();
    assert!(!checks.is_empty(), "{}: no light has a map", truth.name);
    checks
}

fn agrees(subject: &Subject, deep: DeepShadow) -> Vec<Figure> {
    figures::demand(&compare(subject, deep, &layers(subject, deep)))
}

const FINE: DeepShadow = DeepShadow { resolution: 2048 };

#[test]
fn shadow_deep_agrees_with_its_reference() {
    let mut rows = agrees(&glasshouse(), FINE);
    // Many layers: longer than registers are.
    let stack = glasshouse().changed(|s| {
        let pane = s.scene.objects[1].clone();
        for k in 1..40 {
            let mut another = pane.clone();
            another.world_from_object =
                Mat4::from_translation(Vec3::new(0.0, 0.0, -0.02 * k as f32)) * another.world_from_object;
            another.name = format!("stacked {k}");
            s.scene.objects.push(another);
        }
        s.scene.materials[1].base_color = Vec4::new(0.99, 0.94, 0.9, 1.0);
        s.name = "glasshouse, 40 panes in a row".into();
    });
    rows.extend(agrees(&stack, DeepShadow { resolution: 1024 }));
    silent(shared());

    let shown = glasshouse().changed(|s| s.size = [640, 360]);
    let part = render(&shown, Some(FINE), &["color"]);
    let pixels: Vec<_> = part.vectors("", ["R", "G", "B"]).iter().map(|c| c.as_vec3().to_array()).collect();
    let rgba: Vec<_> = pixels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
    let caption = "Panes of glass and a ball throw coloured light, of the sun and of a lamp behind them".into();
    let picture = Picture { size: shown.size, exposure: auto_exposure(&rgba), pixels, caption };
    figures::publish(shared(), "shadow", "deep", &rows, Some(&picture));
}

/// What is lit behind glass is lit by what comes through: the picture without deep shadows times the mask.
#[test]
fn shadow_deep_dims_the_light_of_opaque_surfaces() {
    let only_sun = glasshouse().changed(|s| s.scene.lights.truncate(1));
    let wanted = ["direct", "transmittance"];
    let [plain, deep] =
        [None, Some(FINE)].map(|deep| render(&only_sun, deep, &wanted).vectors("direct.", ["R", "G", "B"]));
    let through = render(&only_sun, Some(FINE), &wanted).vectors("transmittance.sun.", ["R", "G", "B"]);
    let mut coloured = 0;
    for ((plain, deep), through) in plain.iter().zip(&deep).zip(&through) {
        // Half-floats.
        assert!(
            (*deep - *plain * *through).abs().max_element() <= 2e-3 * plain.max_element().max(1.0),
            "{plain} {deep}"
        );
        coloured += usize::from((through.x - through.z).abs() > 0.3 && plain.max_element() > 0.1);
    }
    assert!(coloured > 1000, "{coloured} pixels in coloured light");
    silent(shared());
}

#[test]
fn portable_shadow_deep_of_the_glasshouse() {
    agrees(&glasshouse(), DeepShadow { resolution: 1024 });
    // A scene with nothing to look through has no maps and no layers.
    let bare = glasshouse().without_blending();
    let part = layers(&bare, FINE);
    assert!(part.channels.keys().all(|name| !name.starts_with("transmittance")));
    silent(shared());
}

#[test]
fn shadow_deep_with_a_seeded_mistake_is_caught() {
    let truth = glasshouse();
    let fails = |change: fn(&mut Subject), deep: DeepShadow| -> bool {
        compare(&truth, FINE, &layers(&truth.changed(change), deep)).iter().all(Check::fails)
    };
    assert!(!fails(|_| (), FINE));
    // Ruby for emerald; a veil that hides more; a pane aside; maps that are too coarse.
    assert!(fails(|s| s.scene.materials.swap(1, 3), FINE));
    assert!(fails(|s| s.scene.materials[5].base_color.w = 0.45, FINE));
    assert!(fails(|s| s.scene.objects[1].world_from_object.w_axis.x += 0.2, FINE));
    assert!(fails(|_| (), DeepShadow { resolution: 128 }));
    silent(shared());
}

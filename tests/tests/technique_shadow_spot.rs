//! Shadow maps of spot lights against rays.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::Vec3;
use shadowgraph::frame::FrameSettings;
use shadowgraph::scene::{Light, LightKind};
use shadowgraph::techniques::shadow::Filter;
use shadowgraph::techniques::shadow::spot::Spot;
use shadowgraph_tests::compare::Comparison;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::exr_file::Part;
use shadowgraph_tests::figures::{self, Check, Figure, Picture};
use shadowgraph_tests::judge::Judge;
use shadowgraph_tests::render::{Subject, only, turn};
use shadowgraph_tests::twin::camera::Pixel;
use shadowgraph_tests::twin::scene::Scene;
use shadowgraph_tests::twin::shadow::spot_texel;

const SIZE: [u32; 2] = [320, 180];

fn layers(subject: &Subject, spot: Spot) -> Part {
    let wanted = only(&["Z", "id", "shadow"]);
    let change = |settings: &mut FrameSettings| {
        wanted(settings);
        settings.spot = spot;
        settings.cascaded.resolution = 256;
    };
    subject.capture(shared(), change).parts.remove(0)
}

fn spots(subject: &Subject) -> impl Iterator<Item = &Light> {
    subject.scene.lights.iter().filter(|light| matches!(light.kind, LightKind::Spot { .. }))
}

/// The mask of each spot that reaches at least a fiftieth of the picture, and how many there are.
fn compare(truth: &Subject, spot: &Spot, part: &Part) -> Vec<Check> {
    let twin = Scene::new(&truth.scene);
    let view = truth.view();
    let judge = Judge::new(&truth.name, part, &twin, &view);
    let mask = |light: &Light| -> Comparison {
        let LightKind::Spot { position, direction, outer, .. } = light.kind else { panic!() };
        let along = |pixel: &Pixel| {
            let surface = pixel.surface.as_ref().unwrap();
            (surface.position - position.as_dvec3()).dot(direction.as_dvec3())
        };
        judge.shadow(light, |pixel| spot_texel(outer.into(), spot.resolution, along(pixel)), 1e-4)
    };
    let masks = spots(truth).map(mask).filter(|mask| mask.tally().compared > part.size[0] as usize * 4);
    let checks: Vec<_> = masks.map(|mask| Check::new(mask, 0.995, 0.1)).collect();
    assert!(!checks.is_empty(), "{}: no spot reaches what is seen", truth.name);
    checks
}

fn agrees(subject: &Subject, spot: Spot) -> Vec<Figure> {
    figures::demand(&compare(subject, &spot, &layers(subject, spot)))
}

/// Fine maps: the Cornell box's lamp shines into a wide cone, so that a texel is a hundredth of the box in coarser ones.
fn settings() -> Spot {
    Spot { resolution: 2048, ..Spot::default() }
}

/// With its lamp nearer to the viewer: where it hangs, a side of the tall block stands edge-on in its light, and all of
/// it is two texels from the dark.
fn cornell() -> Subject {
    Subject::builtin("cornell", SIZE).changed(|s| {
        let toward_viewer = s.camera.world_from_view.z_axis.truncate();
        let LightKind::Spot { position, .. } = &mut s.scene.lights[0].kind else { panic!() };
        *position += toward_viewer * 0.12;
    })
}

/// Under two spots, one of which has a hard rim.
fn shadow_room() -> Option<Subject> {
    let room = Subject::file("ShadowRoom", SIZE)?;
    Some(room.seen_from(Vec3::new(3.2, 2.3, 5.2), Vec3::new(-0.5, 0.5, 0.0)))
}

#[test]
fn shadow_spot_agrees_with_its_reference() {
    let mut found = agrees(&cornell(), settings());
    let wide = cornell().changed(|s| s.name += ", 5×5 taps");
    found.extend(agrees(&wide, Spot { filter: Filter::Grid(5), ..settings() }));
    let court = Subject::builtin("courtyard", SIZE).seen_from(Vec3::new(-1.8, 2.2, 13.0), Vec3::new(-0.6, 0.3, 8.5));
    found.extend(agrees(&court, settings()));
    found.extend(shadow_room().iter().flat_map(|room| agrees(room, settings())));
    silent(shared());

    let shown = cornell().changed(|s| s.size = [480, 270]);
    let part = layers(&shown, settings());
    let name = format!("shadow.{}", spots(&shown).next().unwrap().name);
    let z = part.floats("Z");
    let grey = |(z, mask): (&f32, &f32)| if z.is_finite() { [0.04 + 0.7 * mask; 3] } else { [0.0; 3] };
    let pixels = z.iter().zip(part.floats(&name)).map(grey).collect();
    let caption = "The Cornell box: what the lamp reaches".into();
    let picture = Picture { size: shown.size, pixels, exposure: 1.0, caption };
    figures::publish(shared(), "shadow", "spot", &found, Some(&picture));
}

#[test]
fn portable_shadow_spot_of_the_cornell_box() {
    agrees(&cornell(), settings());
    silent(shared());
}

#[test]
fn shadow_spot_with_a_seeded_mistake_is_caught() {
    let truth = cornell();
    let fails = |mistaken: &Subject, spot: Spot| -> bool {
        compare(&truth, &settings(), &layers(mistaken, spot)).iter().all(Check::fails)
    };
    assert!(!fails(&truth, settings()));
    // The lamp 3 cm aside, and maps too coarse for what is asked.
    let aside = truth.changed(|s| {
        let LightKind::Spot { position, .. } = &mut s.scene.lights[0].kind else { panic!() };
        *position += Vec3::X * 0.03;
    });
    assert!(fails(&aside, settings()));
    assert!(fails(&truth, Spot { resolution: 64, ..settings() }));
    // Turning the lamp moves its map, not its shadows.
    let turned = truth.changed(|s| turn(&mut s.scene.lights[0], 1.0));
    assert!(!fails(&turned, settings()));
    silent(shared());
}

//! Deferred shading against the BRDF in double precision.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{DVec3, Vec3};
use shadowgraph::capture::auto_exposure;
use shadowgraph::frame::FrameSettings;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::exr_file::Part;
use shadowgraph_tests::figures::{self, Check, Picture};
use shadowgraph_tests::judge::Judge;
use shadowgraph_tests::render::{Subject, turn};
use shadowgraph_tests::twin::scene::Scene;

const SIZE: [u32; 2] = [320, 180];

/// Light from everywhere, of a strength that shows beside the scene's lights.
fn environment(subject: &Subject) -> Vec3 {
    Vec3::new(0.5, 0.7, 1.0) * if subject.scene.name == "courtyard" { 2000.0 } else { 2.0 }
}

fn layers(subject: &Subject, environment: Vec3) -> Part {
    let change = |settings: &mut FrameSettings| {
        settings.environment = environment;
        settings.cascaded.resolution = 1024;
    };
    let mut parts = subject.capture(shared(), change).parts;
    parts.retain(|part| part.size == subject.size);
    parts.remove(0)
}

fn compare(truth: &Subject, part: &Part) -> Vec<Check> {
    let twin = Scene::new(&truth.scene);
    let view = truth.view();
    let judge = Judge::new(&truth.name, part, &twin, &view);
    let environment: DVec3 = environment(truth).as_dvec3();
    [judge.direct(1.0), judge.color(1.0, environment)].map(|comparison| Check::new(comparison, 1.0, 0.0)).into()
}

fn shaded(subject: &Subject) -> Part {
    layers(subject, environment(subject))
}

#[test]
fn shading_lighting_agrees_with_its_reference() {
    let mut subjects = vec![Subject::builtin("cornell", SIZE), Subject::builtin("courtyard", SIZE).without_blending()];
    subjects.extend(["ShadowRoom", "DungeonHall"].iter().filter_map(|name| Subject::file(name, SIZE)));
    let spheres = Subject::file("MetalRoughSpheresNoTextures", SIZE).map(|spheres| {
        let lit = |s: &mut Subject| s.scene.lights.push(shadowgraph_tests::tiny::sun(Vec3::new(-0.5, -0.6, -0.7)));
        spheres.changed(lit)
    });
    subjects.extend(spheres);
    let found: Vec<_> =
        subjects.iter().flat_map(|subject| figures::demand(&compare(subject, &shaded(subject)))).collect();
    silent(shared());

    let shown = Subject::builtin("courtyard", [480, 270]).without_blending();
    let part = shaded(&shown);
    let pixels: Vec<[f32; 3]> = part.vectors("", ["R", "G", "B"]).iter().map(|c| c.as_vec3().to_array()).collect();
    let rgba: Vec<_> = pixels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
    let caption = "The courtyard, its panes opaque".into();
    let picture = Picture { size: shown.size, exposure: auto_exposure(&rgba), pixels, caption };
    figures::publish(shared(), "shading", "lighting", &found, Some(&picture));
}

#[test]
fn portable_shading_lighting_of_the_cornell_box() {
    let subject = Subject::builtin("cornell", [160, 120]);
    figures::demand(&compare(&subject, &shaded(&subject)));
    silent(shared());
}

#[test]
fn shading_lighting_with_a_seeded_mistake_is_caught() {
    let truth = Subject::builtin("cornell", SIZE);
    let fails = |part: &Part| -> Vec<bool> { compare(&truth, part).iter().map(Check::fails).collect() };
    assert_eq!(fails(&shaded(&truth)), [false, false]);
    // The lamp turned by one degree; its light two thousandths stronger; an environment a hundredth brighter.
    assert_eq!(fails(&shaded(&truth.changed(|s| turn(&mut s.scene.lights[0], 1.0)))), [true, true]);
    assert_eq!(fails(&shaded(&truth.changed(|s| s.scene.lights[0].color *= 1.002))), [true, true]);
    assert_eq!(fails(&layers(&truth, environment(&truth) * 1.01)), [false, true]);
    // A G-buffer that says another roughness than the one that was shaded.
    let mut part = shaded(&truth);
    let Some(shadowgraph_tests::exr_file::Channel::Float(values)) = part.channels.get_mut("roughness") else {
        panic!()
    };
    values.iter_mut().for_each(|v| *v *= 0.98);
    assert_eq!(fails(&part), [true, true]);
    silent(shared());
}

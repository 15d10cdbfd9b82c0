//! Position from depth against rays.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{Mat4, Vec3};
use shadowgraph::scene::Projection;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::exr_file::Part;
use shadowgraph_tests::figures::{self, Check, Picture};
use shadowgraph_tests::judge::Judge;
use shadowgraph_tests::render::{Subject, only};
use shadowgraph_tests::twin::scene::Scene;

const SIZE: [u32; 2] = [320, 180];

fn layers(subject: &Subject) -> Part {
    subject.capture(shared(), only(&["P", "Z"])).parts.remove(0)
}

fn compare(truth: &Subject, part: &Part) -> Vec<Check> {
    let twin = Scene::new(&truth.scene);
    let view = truth.view();
    let judge = Judge::new(&truth.name, part, &twin, &view);
    [judge.position(), judge.depth()].map(|comparison| Check::new(comparison, 0.999, 0.2)).into()
}

fn subjects() -> Vec<Subject> {
    let mut subjects = vec![Subject::builtin("cornell", SIZE), Subject::builtin("courtyard", SIZE)];
    let mut parallel = subjects[0].changed(|s| s.name += ", parallel");
    parallel.camera.projection = Projection::Orthographic { half_height: 1.5, near: 0.1, far: 20.0 };
    subjects.push(parallel);
    subjects.extend(["ShadowRoom", "NegativeScaleTest"].iter().filter_map(|name| Subject::file(name, SIZE)));
    subjects
}

#[test]
fn surface_position_agrees_with_its_reference() {
    let figures: Vec<_> =
        subjects().iter().flat_map(|subject| figures::demand(&compare(subject, &layers(subject)))).collect();
    silent(shared());

    let shown = layers(&Subject::builtin("courtyard", [480, 270]));
    let positions = shown.vectors("P.", ["X", "Y", "Z"]);
    let pixels = positions.iter().map(|p| (p.fract() + p.fract().map(|c| if c < 0.0 { 1.0 } else { 0.0 })).as_vec3());
    let caption = "The courtyard: position in each cubic metre as a colour".into();
    let pixels = pixels.map(|c| (c * 0.6).to_array()).collect();
    let picture = Picture { size: shown.size, pixels, exposure: 1.0, caption };
    figures::publish(shared(), "surface", "position", &figures, Some(&picture));
}

#[test]
fn surface_position_with_a_seeded_mistake_is_caught() {
    let truth = Subject::builtin("cornell", SIZE);
    assert!(compare(&truth, &layers(&truth)).iter().all(|check| !check.fails()));
    // The camera 2 mm to the side; a lens a thousandth wider.
    let aside = truth.changed(|s| s.camera.world_from_view *= Mat4::from_translation(Vec3::X * 2e-3));
    assert!(compare(&truth, &layers(&aside))[0].fails());
    let wider = truth.changed(|s| {
        let Projection::Perspective { fov_y, .. } = &mut s.camera.projection else { panic!() };
        *fov_y *= 1.001;
    });
    assert!(compare(&truth, &layers(&wider))[0].fails());
    silent(shared());
}

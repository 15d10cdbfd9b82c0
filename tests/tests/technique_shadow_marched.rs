//! Rays from pixels to lights through voxels, against walks on the host and against rays through the triangles.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::Vec3;
use shadowgraph::frame::{FrameSettings, VoxelVisibility};
use shadowgraph::graph::ImageShape;
use shadowgraph::scene::{Light, LightKind};
use shadowgraph::techniques::shadow::marched::Marched as Technique;
use shadowgraph::techniques::voxel::{CLEAR_OF_SURFACE, Grid};
use shadowgraph_tests::compare::Comparison;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Check, Figure, Picture};
use shadowgraph_tests::judge::Judge;
use shadowgraph_tests::marched::Marched;
use shadowgraph_tests::render::{Subject, only};
use shadowgraph_tests::twin::scene::Scene;

const SIZE: [u32; 2] = [320, 180];

/// The masks of all lights of a scene.
fn masks(subject: &Subject, resolution: u32, technique: Technique) -> Marched {
    let lights: Vec<&Light> = subject.scene.lights.iter().collect();
    Marched::capture(shared(), subject, resolution, |graph, occluders, seen| {
        let shape = ImageShape::new_2d(ash::vk::Format::R32_SFLOAT, subject.size).layers(lights.len() as u32);
        let masks = graph.image("masks", shape);
        technique.record(graph, occluders, seen, &lights, masks)
    })
}

/// Every light's mask against the walk on the host, from where the technique says that rays begin.
fn exactly(subject: &Subject, resolution: u32, found: &Marched) -> Check {
    let grid = *found.voxels.grid();
    let [offset, reach] =
        [CLEAR_OF_SURFACE, Vec3::from(grid.size().map(|n| n as f32)).length()].map(|n| n * grid.edge());
    let [width, height] = found.size;
    let lights = &subject.scene.lights;
    let size = [width, height * lights.len() as u32];
    let mut comparison = Comparison::new(format!("{} at {resolution}³: walks to all lights", subject.name), size, 0.0);
    let layers = found.found.chunks_exact((width * height) as usize);
    for (number, (light, layer)) in lights.iter().zip(layers).enumerate() {
        let expected = found.expected(1.0, |_, position, normal| {
            let (to_light, end) = match light.kind {
                LightKind::Directional { direction, .. } => {
                    (-direction, position + offset * normal - reach * direction)
                }
                LightKind::Point { position: place, .. } | LightKind::Spot { position: place, .. } => {
                    (place - position, place)
                }
            };
            let lit = normal.dot(to_light) > 0.0 && !found.is_blocked(position + offset * normal, end);
            f32::from(u8::from(lit))
        });
        for (i, (found, expected)) in layer.iter().zip(expected).enumerate() {
            comparison.same(number * layer.len() + i, *found == expected);
        }
    }
    // Rounding of a ray's ends may move it into the next voxel.
    Check::new(comparison, 0.9995, 0.0)
}

/// A frame's masks of point lights against rays through triangles that begin where marched ones do. A voxel's diagonal
/// from the edges of shadows is left out, as is what shares a voxel with an edge.
fn against_triangles(truth: &Subject, shown: &Subject, resolution: u32, technique: Technique) -> Vec<Check> {
    let part = shown.capture(shared(), |settings: &mut FrameSettings| {
        only(&["Z", "id", "shadow"])(settings);
        settings.cascaded.resolution = 256;
        settings.spot.resolution = 256;
        settings.voxels = Some(VoxelVisibility { resolution, shadows: technique, occlusion: Default::default() });
    });
    let part = &part.parts[0];
    let around = truth.scene.bounds().unwrap();
    let edge = f64::from(Grid::around(&around, resolution).unwrap().edge());
    let (twin, view) = (Scene::new(&truth.scene), truth.view());
    let judge = Judge::new(&truth.name, part, &twin, &view);
    let points = truth.scene.lights.iter().filter(|light| matches!(light.kind, LightKind::Point { .. }));
    let mask = |light| judge.shadow(light, |_| edge * 3.0_f64.sqrt(), f64::from(CLEAR_OF_SURFACE) * edge);
    let masks = points.map(mask).filter(|mask| mask.tally().compared > 500);
    masks.map(|mask| Check::new(mask, 0.99, 0.5)).collect()
}

/// Its lamp a point, somewhat into the room.
fn cornell() -> Subject {
    Subject::builtin("cornell", SIZE).changed(|s| {
        let LightKind::Spot { position, intensity, .. } = s.scene.lights[0].kind else { panic!() };
        let position = position - Vec3::Y * 0.3;
        s.scene.lights[0].kind = LightKind::Point { position, intensity, range: f32::INFINITY };
    })
}

/// Before the lamp of the west side.
fn courtyard() -> Subject {
    Subject::builtin("courtyard", SIZE)
}

#[test]
fn shadow_marched_agrees_with_its_reference() {
    let mut found: Vec<Figure> = Vec::new();
    for (subject, resolution) in [(cornell(), 100), (courtyard(), 256)] {
        let captured = masks(&subject, resolution, Technique::default());
        let lit = captured.found.iter().sum::<f32>() / captured.found.len() as f32;
        println!("{}: {lit} of all is lit", subject.name);
        assert!((0.05..0.95).contains(&lit), "{}: {lit} of all is lit", subject.name);
        found.push(exactly(&subject, resolution, &captured).demand());
    }
    for (subject, resolution) in [(cornell(), 256), (courtyard().without_cut_outs(), 512)] {
        let checks = against_triangles(&subject, &subject, resolution, Technique::default());
        assert!(!checks.is_empty(), "{}: no light reaches what is seen", subject.name);
        found.extend(figures::demand(&checks));
    }
    silent(shared());

    let shown = courtyard().changed(|s| s.size = [480, 270]);
    let captured = masks(&shown, 512, Technique::default());
    let sun = shown.scene.lights.iter().position(|light| matches!(light.kind, LightKind::Directional { .. })).unwrap();
    let layer = &captured.found[sun * captured.positions.len()..];
    let grey = |(place, lit): (&glam::Vec4, &f32)| if place.w.is_finite() { [0.04 + 0.7 * lit; 3] } else { [0.0; 3] };
    let pixels = captured.positions.iter().zip(layer).map(grey).collect();
    let caption = "The courtyard: what the sun reaches through 512³ voxels, without a shadow map".into();
    figures::publish(
        shared(),
        "shadow",
        "marched",
        &found,
        Some(&Picture { size: shown.size, pixels, exposure: 1.0, caption }),
    );
}

#[test]
fn portable_shadow_marched_of_the_cornell_box() {
    exactly(&cornell(), 64, &masks(&cornell(), 64, Technique::default())).demand();
    silent(shared());
}

#[test]
fn shadow_marched_with_a_seeded_mistake_is_caught() {
    let truth = cornell();
    let fails = |found: &Marched| exactly(&truth, 64, found).fails();
    assert!(!fails(&masks(&truth, 64, Technique::default())));
    // From the surface itself, and the lamp half a voxel aside.
    assert!(fails(&masks(&truth, 64, Technique { offset: 0.0 })));
    let aside = truth.changed(|s| {
        let LightKind::Point { position, .. } = &mut s.scene.lights[0].kind else { panic!() };
        *position += Vec3::X * 0.02;
    });
    assert!(fails(&masks(&aside, 64, Technique::default())));

    let fails = |shown: &Subject, technique| against_triangles(&truth, shown, 256, technique).iter().any(Check::fails);
    assert!(fails(&truth, Technique { offset: 0.0 }));
    let far = truth.changed(|s| {
        let LightKind::Point { position, .. } = &mut s.scene.lights[0].kind else { panic!() };
        *position += Vec3::X * 0.2;
    });
    assert!(fails(&far, Technique::default()));
    silent(shared());
}

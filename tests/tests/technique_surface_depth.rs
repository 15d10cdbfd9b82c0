//! Depth pre-pass against rays.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::Quat;
use glam::{Mat4, Vec3};
use shadowgraph::graph::Graph;
use shadowgraph::scene::{GpuScene, Projection};
use shadowgraph::techniques::surface::depth::DepthPrepass;
use shadowgraph_tests::device::{shared, silent, snaps_finely};
use shadowgraph_tests::exr_file::{Channel, Part};
use shadowgraph_tests::figures::{self, Check, Figure, Picture};
use shadowgraph_tests::judge::Judge;
use shadowgraph_tests::render::Subject;
use shadowgraph_tests::twin::scene::Scene;

const SIZE: [u32; 2] = [320, 180];

/// The depth buffer of the subject as a layer `Z`.
fn depth(subject: &Subject) -> Part {
    let view = subject.view();
    let executed = subject.execute(shared(), |graph: &mut Graph, scene: &GpuScene| {
        let depth = DepthPrepass.record(graph, scene, &view);
        graph.capture("depth", &depth);
    });
    let stored: Vec<f32> = executed.capture("depth").unwrap().texels().unwrap();
    // d = (b − a z) / w, with w = z for perspective views and 1 for parallel ones.
    let clip = view.clip_from_view.as_dmat4();
    let (a, b) = (clip.z_axis.z, clip.w_axis.z);
    let perspective = clip.w_axis.w == 0.0;
    let distance = |d: f64| if perspective { b / (d + a) } else { (b - d) / a };
    let z = stored.iter().map(|&d| if d == 0.0 { f32::INFINITY } else { distance(f64::from(d)) as f32 });
    Part {
        name: String::new(),
        size: subject.size,
        channels: [("Z".to_string(), Channel::Float(z.collect()))].into(),
        texts: Default::default(),
    }
}

fn compare(truth: &Subject, part: &Part) -> Check {
    let twin = Scene::new(&truth.scene);
    let view = truth.view();
    Check::new(Judge::new(&truth.name, part, &twin, &view).depth(), 0.999, 0.2)
}

fn agrees(subject: &Subject) -> Figure {
    let figure = compare(subject, &depth(subject)).demand();
    silent(shared());
    figure
}

#[test]
fn surface_depth_agrees_with_its_reference() {
    let mut subjects = vec![Subject::builtin("cornell", SIZE), Subject::builtin("courtyard", SIZE)];
    let mut parallel = subjects[0].changed(|s| s.name += ", parallel");
    parallel.camera.projection = Projection::Orthographic { half_height: 1.5, near: 0.1, far: 20.0 };
    subjects.push(parallel);
    let files = ["ShadowRoom", "DungeonHall", "NegativeScaleTest", "OrientationTest"];
    subjects.extend(files.iter().filter_map(|name| Subject::file(name, SIZE)));
    // Spheres of a millimetre in thousands of triangles: seen close up, else all is edges.
    subjects.extend(Subject::file("MetalRoughSpheresNoTextures", SIZE).map(|spheres| spheres.zoomed(0.06)));
    let figures: Vec<_> = subjects.iter().map(agrees).collect();

    let shown = depth(&Subject::builtin("courtyard", [480, 270]));
    let pixels = shown.floats("Z").iter().map(|&z| [(4.0 / z).min(1.0).powi(2); 3]).collect();
    let caption = "The courtyard: the nearer, the brighter".into();
    let picture = Picture { size: shown.size, pixels, exposure: 0.7, caption };
    figures::publish(shared(), "surface", "depth", &figures, Some(&picture));
}

#[test]
fn portable_surface_depth_of_the_cornell_box() {
    if !snaps_finely(shared()) {
        return;
    }
    agrees(&Subject::builtin("cornell", [160, 120]));
}

#[test]
fn surface_depth_with_a_seeded_mistake_is_caught() {
    let truth = Subject::builtin("cornell", SIZE);
    assert!(!compare(&truth, &depth(&truth)).fails());
    // A camera turned by a twentieth of a degree, and one that stands 2 mm further back.
    let turned =
        truth.changed(|s| s.camera.world_from_view *= Mat4::from_quat(Quat::from_rotation_y(0.05_f32.to_radians())));
    assert!(compare(&truth, &depth(&turned)).fails());
    let back = truth.changed(|s| s.camera.world_from_view *= Mat4::from_translation(Vec3::Z * 2e-3));
    assert!(compare(&truth, &depth(&back)).fails());
    silent(shared());
}

//! G-buffer against rays.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{DVec3, Mat4, Quat};
use shadowgraph::graph::Graph;
use shadowgraph::scene::GpuScene;
use shadowgraph::techniques::surface::depth::DepthPrepass;
use shadowgraph::techniques::surface::gbuffer::{GBuffer, Precision};
use shadowgraph_tests::compare::{Comparison, degrees};
use shadowgraph_tests::device::{shared, silent, snaps_finely};
use shadowgraph_tests::exr_file::Part;
use shadowgraph_tests::figures::{self, Check, Figure, Picture};
use shadowgraph_tests::judge::Judge;
use shadowgraph_tests::render::{Subject, only};
use shadowgraph_tests::twin::scene::Scene;

const SIZE: [u32; 2] = [320, 180];
const LAYERS: [&str; 9] = ["Z", "N", "id", "albedo", "occlusion", "roughness", "metallic", "emissive", "P"];
const RGB: [&str; 3] = ["R", "G", "B"];
const XYZ: [&str; 3] = ["X", "Y", "Z"];

fn layers(subject: &Subject, precision: Precision) -> Part {
    let wanted = only(&LAYERS);
    let change = |settings: &mut shadowgraph::frame::FrameSettings| {
        wanted(settings);
        settings.precision = precision;
    };
    subject.capture(shared(), change).parts.remove(0)
}

/// Ids always; normals where no normal map turns them, as how a device filters textures is not its own affair alone.
fn compare(truth: &Subject, part: &Part) -> Vec<Check> {
    let twin = Scene::new(&truth.scene);
    let view = truth.view();
    let judge = Judge::new(&truth.name, part, &twin, &view);
    let mut checks = vec![judge.ids()];
    if truth.scene.materials.iter().all(|material| material.normal_texture.is_none()) {
        checks.push(judge.normal());
    }
    if truth.scene.textures.is_empty() {
        checks.push(material(&judge, truth, part));
    }
    checks.into_iter().map(|comparison| Check::new(comparison, 0.999, 0.2)).collect()
}

/// Albedo, occlusion, roughness, metallic and emission without textures: 1e-4.
fn material(judge: &Judge, truth: &Subject, part: &Part) -> Comparison {
    let mut comparison = Comparison::new(format!("{}: material", truth.name), truth.size, 1e-4);
    let [albedo, emissive] = ["albedo.", "emissive."].map(|layer| part.vectors(layer, RGB));
    let [occlusion, roughness, metallic] = ["occlusion", "roughness", "metallic"].map(|layer| part.floats(layer));
    for (i, pixel) in judge.picture.pixels.iter().enumerate() {
        match &pixel.surface {
            _ if pixel.near_edge => comparison.leave_out(i, "near an edge"),
            Some(surface) => {
                let scalars = DVec3::new(occlusion[i].into(), roughness[i].into(), metallic[i].into());
                let expected = DVec3::new(surface.occlusion, surface.roughness, surface.metallic);
                let glow = emissive[i].distance(surface.emissive) / surface.emissive.length().max(1.0);
                let color = albedo[i].distance(surface.base_color.truncate());
                comparison.error(i, color.max(glow).max(scalars.distance(expected)));
            }
            None => {}
        }
    }
    comparison
}

/// Compact against 32-bit floats: half a step of 8 bits for roughness and metallic, one of the two nearest steps
/// of 8 bits sRGB for albedo, 0.06° for normals, 2⁻¹⁰ of the emission.
fn quantisation(subject: &Subject) -> Vec<Check> {
    let [fine, coarse] = [Precision::Float, Precision::Compact].map(|precision| layers(subject, precision));
    let compare = |what: &str, tolerance: f64, error: &dyn Fn(usize) -> f64| {
        let name = format!("{}: compact {what}", subject.name);
        let mut comparison = Comparison::new(name, subject.size, tolerance);
        let z = fine.floats("Z");
        (0..z.len()).filter(|&i| z[i].is_finite()).for_each(|i| comparison.error(i, error(i)));
        Check::new(comparison, 1.0, 0.0)
    };
    let pair = |layer: &str, axes| [&fine, &coarse].map(|part: &Part| part.vectors(layer, axes));
    let encode = |c: f64| if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    let (albedo, normal, glow) = (pair("albedo.", RGB), pair("N.", XYZ), pair("emissive.", RGB));
    let step = |layer: &str, i: usize| f64::from(fine.floats(layer)[i] - coarse.floats(layer)[i]).abs() * 255.0;
    // How exactly a device encodes sRGB is its own affair: it must choose one of the two nearest steps.
    vec![
        compare("albedo, steps of 1/255 sRGB", 1.0, &|i| {
            let encoded = albedo.each_ref().map(|layer| layer[i].map(encode));
            (encoded[0] - encoded[1]).abs().max_element() * 255.0
        }),
        compare("roughness and metallic, steps of 1/255", 0.505, &|i| {
            ["roughness", "metallic"].map(|layer| step(layer, i)).into_iter().fold(0.0, f64::max)
        }),
        compare("normal, degrees", 0.06, &|i| degrees(normal[0][i], normal[1][i])),
        compare("emission, relative", 1.0 / 1024.0, &|i| {
            glow[0][i].distance(glow[1][i]) / glow[0][i].length().max(1e-3)
        }),
    ]
}

/// The buffers, byte by byte.
fn buffers(subject: &Subject, gbuffer: GBuffer) -> Vec<(String, Vec<u8>)> {
    let view = subject.view();
    let executed = subject.execute(shared(), |graph: &mut Graph, scene: &GpuScene| {
        let depth = DepthPrepass.record(graph, scene, &view);
        let s = gbuffer.record(graph, scene, &view, depth);
        let all = [("ids", &s.ids), ("albedo", &s.albedo), ("normal", &s.normal), ("material", &s.material)];
        all.into_iter().chain([("emissive", &s.emissive)]).for_each(|(name, image)| graph.capture(name, image));
    });
    executed.captures.iter().map(|c| (c.name.clone(), c.bytes(|bytes| bytes.to_vec()).unwrap())).collect()
}

/// Bytes by which pulled vertices give another picture than indexed ones.
fn pulled(subject: &Subject) -> Figure {
    let float = GBuffer::default().precision(Precision::Float);
    let (indexed, pulled) = (buffers(subject, float), buffers(subject, float.pull_vertices()));
    let mut compared = 0;
    for ((name, a), (_, b)) in indexed.iter().zip(&pulled) {
        let differ = a.iter().zip(b).filter(|(a, b)| a != b).count();
        assert!(a.len() == b.len() && differ == 0, "{}: {name}: {differ} of {} bytes differ", subject.name, a.len());
        assert!(a.iter().any(|&byte| byte != 0) || name == "emissive", "{}: {name} is empty", subject.name);
        compared += a.len();
    }
    Figure {
        what: format!("{}: vertices pulled", subject.name),
        value: format!("0 of {compared} bytes differ"),
        bound: "none differ".into(),
    }
}

#[test]
fn surface_gbuffer_agrees_with_its_reference() {
    let (cornell, courtyard) = (Subject::builtin("cornell", SIZE), Subject::builtin("courtyard", SIZE));
    let mut subjects = vec![cornell.clone(), courtyard.clone()];
    let files = ["ShadowRoom", "DungeonHall", "NegativeScaleTest", "OrientationTest"];
    subjects.extend(files.iter().filter_map(|name| Subject::file(name, SIZE)));
    // Spheres of a millimetre in thousands of triangles: seen close up, else all is edges.
    subjects.extend(Subject::file("MetalRoughSpheresNoTextures", SIZE).map(|spheres| spheres.zoomed(0.06)));
    let float = |subject: &Subject| compare(subject, &layers(subject, Precision::Float));
    let mut found: Vec<_> = subjects.iter().flat_map(|subject| figures::demand(&float(subject))).collect();
    found.extend(figures::demand(&quantisation(&courtyard)));
    found.extend([&cornell, &courtyard].map(pulled));
    silent(shared());

    let shown = layers(&Subject::builtin("courtyard", [480, 270]), Precision::Float);
    let (albedo, normal) = (shown.vectors("albedo.", RGB), shown.vectors("N.", XYZ));
    let pixel = |i: usize| match i % 480 < 240 {
        true => albedo[i],
        false => (normal[i] * 0.5 + 0.5) * normal[i].length(),
    };
    let pixels = (0..albedo.len()).map(|i| pixel(i).as_vec3().to_array()).collect();
    let caption = "The courtyard: base colour on the left, normals on the right".into();
    let picture = Picture { size: shown.size, pixels, exposure: 1.0, caption };
    figures::publish(shared(), "surface", "gbuffer", &found, Some(&picture));
}

#[test]
fn portable_surface_gbuffer_of_the_cornell_box() {
    if !snaps_finely(shared()) {
        return;
    }
    let subject = Subject::builtin("cornell", [160, 120]);
    figures::demand(&compare(&subject, &layers(&subject, Precision::Float)));
    silent(shared());
}

#[test]
fn surface_gbuffer_with_a_seeded_mistake_is_caught() {
    let truth = Subject::builtin("cornell", SIZE);
    let failing = |mistaken: &Subject| -> Vec<bool> {
        compare(&truth, &layers(mistaken, Precision::Float)).iter().map(Check::fails).collect()
    };
    assert_eq!(failing(&truth), [false; 3]);
    // Another view; normals bent by up to a fifth of a degree; materials a little rougher.
    let turn = Quat::from_rotation_y(0.5_f32.to_radians());
    assert!(failing(&truth.changed(|s| s.camera.world_from_view *= Mat4::from_quat(turn)))[0]);
    let bent = truth.changed(|s| {
        let primitives = s.scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives);
        let bend = Quat::from_euler(glam::EulerRot::XYZ, 0.002, 0.002, 0.002);
        primitives.flat_map(|p| &mut p.normals).for_each(|n| *n = bend * *n);
    });
    assert_eq!(failing(&bent), [false, true, false]);
    let rougher = truth.changed(|s| s.scene.materials.iter_mut().for_each(|m| m.roughness *= 0.999));
    assert_eq!(failing(&rougher), [false, false, true]);
    silent(shared());
}

//! Hemispheres of rays through voxels, against walks on the host and against rays through the triangles.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{Mat3, Vec3};
use shadowgraph::techniques::voxel::CLEAR_OF_SURFACE;
use shadowgraph::techniques::voxel::ambient_occlusion::AmbientOcclusion;
use shadowgraph_tests::compare::Comparison;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Check, Figure, Picture};
use shadowgraph_tests::harness;
use shadowgraph_tests::marched::Marched;
use shadowgraph_tests::render::Subject;
use shadowgraph_tests::twin::scene::{Footprint, Line, Ray, Rule, Scene};

const SIZE: [u32; 2] = [192, 108];

fn capture(subject: &Subject, resolution: u32, technique: AmbientOcclusion) -> Marched {
    Marched::capture(shared(), subject, resolution, |graph, occluders, [position, ids]| {
        technique.record(graph, occluders, position, ids)
    })
}

/// Directions of a pixel's rays: uniform points of a disc, lifted onto the hemisphere above it.
fn directions([x, y]: [u32; 2], normal: Vec3, rays: u32) -> impl Iterator<Item = Vec3> {
    let turn = (52.982_918 * (x as f32 * 0.067_110_56 + y as f32 * 0.005_837_15).fract()).fract();
    let sign = if normal.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    let across = Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x);
    let up = Vec3::new(b, sign + normal.y * normal.y * a, -normal.y);
    let frame = Mat3::from_cols(across, up, normal);
    (0..rays).map(move |i| {
        let square = (i as f32 + 0.5) / rays as f32;
        let angle = std::f32::consts::TAU * (i.reverse_bits() as f32 / 4_294_967_296.0 + turn).fract();
        frame * (Vec3::new(angle.cos(), angle.sin(), 0.0) * square.sqrt() + Vec3::Z * (1.0 - square).sqrt())
    })
}

/// The open share by `is_blocked`, from the place where rays begin.
fn open(found: &Marched, technique: &AmbientOcclusion, is_blocked: impl Fn(Vec3, Vec3) -> bool + Sync) -> Vec<f32> {
    let offset = CLEAR_OF_SURFACE * found.voxels.grid().edge();
    found.expected(1.0, |pixel, position, normal| {
        let origin = position + offset * normal;
        let rays = directions(pixel, normal, technique.rays);
        let blocked = rays.filter(|&direction| is_blocked(origin, origin + direction * technique.reach)).count();
        1.0 - blocked as f32 / technique.rays as f32
    })
}

/// Against the same rays on the host: a ray more or less where rounding takes one into the next voxel.
fn exactly(name: &str, found: &Marched, technique: &AmbientOcclusion) -> Check {
    let expected = open(found, technique, |origin, end| found.is_blocked(origin, end));
    let mut comparison = Comparison::new(format!("{name}: walks of {} rays", technique.rays), found.size, 1e-6);
    for (i, (found, expected)) in found.found.iter().zip(expected).enumerate() {
        comparison.error(i, f64::from((found - expected).abs()));
    }
    Check::new(comparison, 0.99, 0.0)
}

/// Against the same rays through triangles: what voxels make of thin things, edges and curves. The mean error.
fn against_triangles(subject: &Subject, found: &Marched, technique: &AmbientOcclusion) -> f64 {
    let twin = Scene::new(&subject.scene);
    let expected = open(found, technique, |origin, end| {
        let line = Line { origin: origin.as_dvec3(), direction: (end - origin).as_dvec3().normalize() };
        let far = f64::from(technique.reach);
        twin.any(&Ray { line, near: 0.0, far, footprint: Footprint::Width(0.0) }, Rule::SHADOW)
    });
    let pairs = found.found.iter().zip(&expected).zip(&found.positions).filter(|(_, place)| place.w.is_finite());
    let (mut sum, mut count) = (0.0, 0);
    for ((found, expected), _) in pairs {
        sum += f64::from((found - expected).abs());
        count += 1;
    }
    sum / f64::from(count)
}

fn cornell() -> (Subject, AmbientOcclusion) {
    (Subject::builtin("cornell", SIZE), AmbientOcclusion { reach: 0.5, ..AmbientOcclusion::default() })
}

fn courtyard() -> (Subject, AmbientOcclusion) {
    (Subject::builtin("courtyard", SIZE), AmbientOcclusion { reach: 2.0, ..AmbientOcclusion::default() })
}

#[test]
fn voxel_ambient_occlusion_agrees_with_its_reference() {
    let mut figures = Vec::new();
    let whole = (courtyard().0.without_cut_outs(), courtyard().1);
    for ((subject, technique), [coarse, fine], most) in [(cornell(), [64, 128], 0.02), (whole, [256, 512], 0.06)] {
        let errors = [coarse, fine].map(|resolution| {
            let found = capture(&subject, resolution, technique);
            figures.push(exactly(&format!("{} at {resolution}³", subject.name), &found, &technique).demand());
            against_triangles(&subject, &found, &technique)
        });
        let what = format!("{} at {coarse}³ and {fine}³: the same rays through triangles", subject.name);
        println!("{what}: {errors:?}");
        assert!(errors[1] < most && errors[1] < 0.7 * errors[0], "{what}: mean errors {errors:?}");
        let value = format!("mean error {:.4} and {:.4}", errors[0], errors[1]);
        let bound = format!("the latter below {most} and 0.7 of the former");
        figures.push(Figure { what, value, bound });
    }
    silent(shared());

    // 16 million rays.
    let picture = harness::writes_figures().then(|| {
        let (courtyard, technique) = courtyard();
        let shown = courtyard.changed(|s| s.size = [480, 270]);
        let found = capture(&shown, 512, AmbientOcclusion { rays: 128, ..technique });
        let pixels = found.found.iter().map(|open| [open * open; 3]).collect();
        let caption = "The courtyard through 512³ voxels: how open the space is, 128 rays a pixel".into();
        Picture { size: shown.size, pixels, exposure: 1.0, caption }
    });
    figures::publish(shared(), "voxel", "ambient_occlusion", &figures, picture.as_ref());
}

#[test]
fn portable_voxel_ambient_occlusion_of_the_cornell_box() {
    let (subject, technique) = cornell();
    exactly("cornell", &capture(&subject, 64, technique), &technique).demand();
    silent(shared());
}

#[test]
fn voxel_ambient_occlusion_with_a_seeded_mistake_is_caught() {
    let (subject, truth) = cornell();
    let fails = |technique: AmbientOcclusion| {
        let found = capture(&subject, 128, technique);
        [exactly("cornell", &found, &truth).fails(), against_triangles(&subject, &found, &truth) >= 0.02]
    };
    assert_eq!(fails(truth), [false; 2]);
    assert_eq!(fails(AmbientOcclusion { offset: 0.0, ..truth }), [true; 2]);
    assert_eq!(fails(AmbientOcclusion { reach: 0.3, ..truth }), [true; 2]);
    assert!(fails(AmbientOcclusion { rays: 31, ..truth })[0]);
    silent(shared());
}

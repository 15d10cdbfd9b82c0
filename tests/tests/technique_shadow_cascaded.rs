//! Cascaded shadow maps against rays to the sun.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::Vec3;
use shadowgraph::frame::FrameSettings;
use shadowgraph::geometry::Aabb;
use shadowgraph::scene::{Light, LightKind};
use shadowgraph::techniques::shadow::Filter;
use shadowgraph::techniques::shadow::cascaded::{Cascaded, Splits};
use shadowgraph_tests::compare::Comparison;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::exr_file::{ExrFile, Part};
use shadowgraph_tests::figures::{self, Check, Picture};
use shadowgraph_tests::judge::Judge;
use shadowgraph_tests::render::{Subject, only, turn};
use shadowgraph_tests::twin::camera::Pixel;
use shadowgraph_tests::twin::cascades;
use shadowgraph_tests::twin::scene::Scene;

const SIZE: [u32; 2] = [320, 180];

fn layers(subject: &Subject, cascaded: Cascaded) -> Part {
    let wanted = only(&["Z", "id", "shadow", "cascade"]);
    let change = |settings: &mut FrameSettings| {
        wanted(settings);
        settings.cascaded = cascaded;
    };
    let ExrFile { mut parts } = subject.capture(shared(), change);
    parts.remove(0)
}

/// Where the cascades end, from the split scheme: `count + 1` distances from the eye.
fn splits(subject: &Subject, twin: &Scene, cascaded: &Cascaded) -> Vec<f64> {
    let bounds = twin.bounds();
    let bounds = Aabb { min: bounds.min.as_vec3(), max: bounds.max.as_vec3() };
    let [near, far] = subject.view().distances(&bounds).map(f64::from);
    let lambda = match cascaded.splits {
        Splits::Uniform => 0.0,
        Splits::Logarithmic => 1.0,
        Splits::Practical(lambda) => lambda.into(),
    };
    cascades::splits(near.max(1e-3 * far), far, cascaded.cascades as usize, lambda)
}

/// Mask and cascades.
fn compare(truth: &Subject, cascaded: &Cascaded, part: &Part) -> Vec<Check> {
    let twin = Scene::new(&truth.scene);
    let view = truth.view();
    let judge = Judge::new(&truth.name, part, &twin, &view);
    let splits = splits(truth, &twin, cascaded);
    let LightKind::Directional { direction, .. } = truth.sun().kind else { panic!() };
    let texels: Vec<_> = splits
        .windows(2)
        .map(|s| cascades::fit(&view, s[0], s[1], direction.as_dvec3(), cascaded.resolution).texel)
        .collect();
    // Near the end of a cascade the next one counts too: its texels are wider.
    let cascade = |pixel: &Pixel| cascades::select(&splits, pixel.z, cascaded.fade.into());
    let texel = |pixel: &Pixel| {
        let (index, share) = cascade(pixel).unwrap_or((texels.len() - 1, 0.0));
        texels[index + usize::from(share > 0.0)]
    };
    let shadow = judge.shadow(truth.sun(), texel, 1e-4);

    let mut index = Comparison::new(format!("{}: cascade.index", truth.name), truth.size, 0.0);
    let (found, z) = (part.floats("cascade.index"), part.floats("Z"));
    for i in 0..found.len() {
        let z = f64::from(z[i]);
        if splits.iter().any(|split| (z / split - 1.0).abs() < 1e-5) {
            index.leave_out(i, "at a split");
        } else {
            let expected = cascades::select(&splits, z, 0.0).map_or(0.0, |(index, _)| index as f32 + 1.0);
            index.same(i, found[i] == if z.is_finite() { expected } else { 0.0 });
        }
    }
    vec![Check::new(shadow, 0.995, 0.1), Check::new(index, 1.0, 0.001)]
}

/// Fine maps: of the foliage's shadows, few points are two texels of coarser ones from an edge.
fn settings() -> Cascaded {
    Cascaded { resolution: 4096, ..Cascaded::default() }
}

fn agrees(subject: &Subject, cascaded: Cascaded) -> Vec<figures::Figure> {
    let part = layers(subject, cascaded);
    let checks = compare(subject, &cascaded, &part);
    let mask = part.floats(&format!("shadow.{}", subject.sun().name));
    let (lit, dark) =
        mask.iter().fold((0, 0), |(lit, dark), &v| (lit + usize::from(v > 0.5), dark + usize::from(v < 0.5)));
    assert!(lit.min(dark) > mask.len() / 50, "{}: {lit} pixels lit, {dark} dark", subject.name);
    figures::demand(&checks)
}

/// The court, part of it in the sun, past the trees.
fn courtyard() -> Subject {
    Subject::builtin("courtyard", SIZE).seen_from(Vec3::new(-3.6, 1.45, 8.6), Vec3::new(5.0, 0.5, -3.0))
}

/// A hall with openings in its roof, from above.
fn dungeon_hall() -> Option<Subject> {
    let hall = Subject::file("DungeonHall", SIZE)?;
    Some(hall.seen_from(Vec3::new(3.0, 30.0, 30.0), Vec3::new(0.0, 0.0, 0.0)))
}

#[test]
fn shadow_cascaded_agrees_with_its_reference() {
    let mut found = agrees(&courtyard(), settings());
    let named = |name: &str| courtyard().changed(|s| s.name = format!("courtyard, {name}"));
    // Other splits choose other maps, no other way to read them: coarse ones will do to see which.
    let coarse = Cascaded { resolution: 256, ..settings() };
    let uniform = Cascaded { splits: Splits::Uniform, cascades: 3, ..coarse };
    let logarithmic = Cascaded { splits: Splits::Logarithmic, ..coarse };
    for (name, cascaded) in [("3 uniform", uniform), ("4 logarithmic", logarithmic)] {
        let subject = named(name);
        found.push(compare(&subject, &cascaded, &layers(&subject, cascaded))[1].demand());
    }
    found.extend(agrees(&named("3×3 taps"), Cascaded { filter: Filter::Grid(3), ..settings() }));
    found.extend(dungeon_hall().iter().flat_map(|hall| agrees(hall, settings())));
    silent(shared());

    let shown = courtyard().changed(|s| s.size = [480, 270]);
    let part = layers(&shown, settings());
    let mask = part.floats("shadow.sun");
    let colors = [[0.5; 3], [1.0, 0.45, 0.4], [0.5, 0.9, 0.45], [0.45, 0.6, 1.0], [1.0, 0.9, 0.4]];
    let tint = |(index, mask): (&f32, &f32)| colors[*index as usize].map(|c| c * (0.12 + 0.88 * mask));
    let pixels = part.floats("cascade.index").iter().zip(mask).map(tint).collect();
    let caption = "The courtyard: what the sun reaches, in the colour of its cascade".into();
    let picture = Picture { size: shown.size, pixels, exposure: 0.8, caption };
    figures::publish(shared(), "shadow", "cascaded", &found, Some(&picture));
}

#[test]
fn shadow_cascaded_with_a_seeded_mistake_is_caught() {
    let truth = courtyard();
    let fails = |mistaken: &Subject, cascaded: Cascaded| -> Vec<bool> {
        compare(&truth, &settings(), &layers(mistaken, cascaded)).iter().map(Check::fails).collect()
    };
    assert_eq!(fails(&truth, settings()), [false, false]);
    // The sun turned by one degree; cascades that end elsewhere; maps too coarse for what is asked.
    let sun = |light: &&mut Light| matches!(light.kind, LightKind::Directional { .. });
    let turned = truth.changed(|s| turn(s.scene.lights.iter_mut().find(sun).unwrap(), 1.0));
    assert_eq!(fails(&turned, settings()), [true, false]);
    assert!(fails(&truth, Cascaded { splits: Splits::Practical(0.79), ..settings() })[1]);
    assert!(fails(&truth, Cascaded { resolution: 256, ..settings() })[0]);
    silent(shared());
}

//! Sorted transparency against layers that are cast one by one and composited on the host.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::DVec3;
use shadowgraph::capture::auto_exposure;
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::exr_file::Part;
use shadowgraph_tests::figures::{self, Picture as Shown};
use shadowgraph_tests::panes::{capture, compare, panes};
use shadowgraph_tests::render::{Subject, only, turn};

fn layers(subject: &Subject) -> Part {
    capture(shared(), subject, only(&["color"]))
}

#[test]
fn transparency_sorted_agrees_with_its_reference() {
    let found: Vec<_> = [true, false].map(panes).iter().map(|s| compare(s, &layers(s)).demand()).collect();
    silent(shared());

    let shown = panes(false).changed(|s| s.size = [480, 270]);
    let colors: Vec<DVec3> = layers(&shown).vectors("", ["R", "G", "B"]);
    let pixels: Vec<[f32; 3]> = colors.iter().map(|c| c.as_vec3().to_array()).collect();
    let rgba: Vec<_> = pixels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
    let caption = "Four panes before a wall, one behind the other, and the shadow of a bar".into();
    let picture = Shown { size: shown.size, exposure: auto_exposure(&rgba), pixels, caption };
    figures::publish(shared(), "transparency", "sorted", &found, Some(&picture));
}

#[test]
fn portable_transparency_sorted_of_unlit_panes() {
    let subject = panes(true);
    compare(&subject, &layers(&subject)).demand();
    silent(shared());
}

#[test]
fn transparency_sorted_with_a_seeded_mistake_is_caught() {
    let truth = panes(false);
    let fails = |mistaken: &Subject| compare(&truth, &layers(mistaken)).fails();
    assert!(!fails(&truth));
    // Two panes in the wrong order; a pane a little denser; the sun turned by one degree.
    assert!(fails(&truth.changed(|s| s.scene.materials.swap(1, 3))));
    assert!(fails(&truth.changed(|s| s.scene.materials[2].base_color.w += 0.02)));
    assert!(fails(&truth.changed(|s| turn(&mut s.scene.lights[0], 1.0))));
    silent(shared());
}

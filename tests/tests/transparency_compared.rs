//! All techniques of transparency on the same scenes: how far off they are, how long they take, what memory they need.
#![allow(missing_docs, clippy::unwrap_used)]

use shadowgraph::capture::{ToneMap, auto_exposure, picture};
use shadowgraph::frame::{FrameSettings, Selection, Transparency};
use shadowgraph::gpu::{FormatInfo, Gpu};
use shadowgraph::graph::description::{Description, Shape};
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::{GpuScene, Scene, View};
use shadowgraph::techniques::surface::gbuffer::Precision;
use shadowgraph::techniques::transparency::adaptive::Adaptive;
use shadowgraph::techniques::transparency::depth_peeling::DepthPeeling;
use shadowgraph::techniques::transparency::dual_depth_peeling::DualDepthPeeling;
use shadowgraph::techniques::transparency::kbuffer::KBuffer;
use shadowgraph::techniques::transparency::moments::Moments;
use shadowgraph::techniques::transparency::stochastic::Stochastic;
use shadowgraph::techniques::transparency::weighted::{Weight, Weighted};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{Figure, Picture, publish_page, publish_picture};
use shadowgraph_tests::flip::Seen;
use shadowgraph_tests::harness::{is_whole, require_scene};
use shadowgraph_tests::soup::Soup;

/// What is compared: a name, the technique, and whether it must be exact.
fn techniques() -> Vec<(&'static str, Transparency, bool)> {
    let weighted = |weight| Transparency::Weighted(Weighted { weight });
    vec![
        ("A-buffer", Transparency::ABuffer, true),
        ("depth peeling", Transparency::DepthPeeling(DepthPeeling { layers: 256 }), true),
        ("dual depth peeling", Transparency::DualDepthPeeling(DualDepthPeeling { layers: 256 }), true),
        ("k-buffer of 4", Transparency::KBuffer(KBuffer { kept: 4 }), false),
        ("k-buffer of 8", Transparency::KBuffer(KBuffer { kept: 8 }), false),
        ("adaptive, 4 nodes", Transparency::Adaptive(Adaptive { kept: 4 }), false),
        ("adaptive, 8 nodes", Transparency::Adaptive(Adaptive { kept: 8 }), false),
        ("moments", Transparency::Moments(Moments), false),
        ("stochastic, 8 samples", Transparency::Stochastic(Stochastic { samples: 8 }), false),
        ("stochastic, 32 samples", Transparency::Stochastic(Stochastic { samples: 32 }), false),
        ("weighted, equation 7", weighted(Weight::Equation7), false),
        ("weighted, equation 9", weighted(Weight::Equation9), false),
        ("weighted, equation 10", weighted(Weight::Equation10), false),
        ("sorted by object", Transparency::Sorted, false),
    ]
}

/// What a technique made, and what that took.
struct Measured {
    pixels: Vec<[f32; 4]>,
    /// Layers of each pixel, of the A-buffer.
    count: Option<Vec<f32>>,
    /// In the technique's own passes.
    seconds: f64,
    /// Of the technique's own images and buffers.
    bytes: u64,
}

/// A scene on the device.
struct Stage<'g> {
    name: String,
    gpu: &'g Gpu,
    scene: GpuScene,
    view: View,
    executor: Executor<'g>,
}

impl<'g> Stage<'g> {
    fn soup(gpu: &'g Gpu, soup: &Soup) -> Self {
        let scene = soup.scene().upload(gpu).unwrap();
        Self { name: soup.name.clone(), gpu, scene, view: soup.view(), executor: Executor::new(gpu) }
    }

    /// A file of the folder of scenes, as one of its cameras sees it.
    fn file(gpu: &'g Gpu, path: &str, camera: usize, size: [u32; 2]) -> Option<Self> {
        let scene = Scene::load(require_scene(path)?).unwrap();
        let view = scene.cameras[camera].view(size);
        Some(Self {
            name: scene.name.clone(),
            gpu,
            scene: scene.upload(gpu).unwrap(),
            view,
            executor: Executor::new(gpu),
        })
    }

    /// The shortest of three runs; what takes long is run once more only, as it was compiled in the first.
    fn measure(&mut self, transparency: Transparency) -> Measured {
        let first = self.run(transparency);
        let more = if first.seconds > 1.0 { 1 } else { 2 };
        let runs = (0..more).map(|_| self.run(transparency));
        runs.fold(first, |best, run| if run.seconds < best.seconds { run } else { best })
    }

    fn run(&mut self, transparency: Transparency) -> Measured {
        let own = match transparency {
            Transparency::Sorted => "transparency.sorted".to_string(),
            other => format!("{}.", other.name()),
        };
        let layers = Selection::Only(vec!["color".into(), "abuffer.count".into()]);
        let settings =
            FrameSettings { transparency, layers, precision: Precision::Float, ..FrameSettings::new(self.view) };
        let mut graph = Graph::new("compared", self.gpu.caps());
        let frame = settings.record(&mut graph, &self.scene);
        let described = graph.description().clone();
        let plan = graph.compile(self.gpu).unwrap();
        let executed = self.executor.execute(&plan, graph).unwrap_or_else(|error| panic!("{}: {error}", self.name));
        // Sizes that followed from a checkpoint are known to the last segment.
        let described = executed.later.last().map_or(&described, |segment| &segment.description);
        let times = executed.passes.iter().filter(|pass| pass.name.starts_with(&own));
        Measured {
            pixels: picture(&frame, &executed).unwrap(),
            count: executed.capture("abuffer.count").ok().map(|count| count.texels().unwrap()),
            seconds: times.map(|pass| pass.seconds).sum(),
            bytes: bytes(described, &own),
        }
    }
}

/// Bytes of the images and buffers whose names begin so.
fn bytes(description: &Description, own: &str) -> u64 {
    let resources = description.resources.iter().filter(|resource| resource.name.starts_with(own));
    let size = |shape: &Shape| match shape {
        Shape::Buffer { size } => *size,
        Shape::Image(image) => FormatInfo::of(image.format).unwrap().bytes(image.extent) * u64::from(image.layers),
    };
    resources.map(|resource| size(&resource.shape)).sum()
}

/// As it is shown, from 0 to 1: exposure, tone curve, sRGB.
fn shown(rgba: [f32; 4], exposure: f32) -> [f64; 3] {
    let [r, g, b, _] = rgba.map(|c| c * exposure);
    ToneMap::Neutral.apply([r, g, b]).map(|c| {
        let c = f64::from(c);
        if c <= 0.0031308 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
    })
}

/// How far a picture is from the exact one where there are layers.
#[derive(Clone, Copy, Debug)]
struct Distance {
    mean: f64,
    max: f64,
    /// Decibels.
    psnr: f64,
    /// Mean of FLIP.
    flip: f64,
}

fn distance(size: [u32; 2], found: &Measured, exact: &Measured) -> Distance {
    let count = exact.count.as_ref().unwrap();
    let exposure = auto_exposure(&exact.pixels);
    let pixels = found.pixels.iter().zip(&exact.pixels).zip(count).filter(|(_, count)| **count > 0.0);
    let errors: Vec<f64> = pixels
        .flat_map(|((a, b), _)| {
            let (a, b) = (shown(*a, exposure), shown(*b, exposure));
            [0, 1, 2].map(|k| (a[k] - b[k]).abs())
        })
        .collect();
    assert!(errors.len() > 1000, "too little is covered");
    let mean = |of: &dyn Fn(f64) -> f64| errors.iter().map(|&e| of(e)).sum::<f64>() / errors.len() as f64;
    let max = errors.iter().copied().fold(0.0, f64::max);
    let seen = [found, exact].map(|measured| {
        let picture: Vec<_> =
            measured.pixels.iter().map(|&pixel| shown(pixel, exposure).map(|c| c.clamp(0.0, 1.0))).collect();
        Seen::new(size, &picture)
    });
    let flip = seen[0].difference(&seen[1]).into_iter().zip(count).filter(|(_, count)| **count > 0.0);
    let flips: Vec<f64> = flip.map(|(flip, _)| flip).collect();
    let flip = flips.iter().sum::<f64>() / flips.len() as f64;
    Distance { mean: mean(&|e| e), max, psnr: -10.0 * mean(&|e| e * e).log10(), flip }
}

fn stages(gpu: &Gpu) -> Vec<Stage<'_>> {
    let size = [64, 64];
    let mut soups = vec![Soup::random(21, size, 0, 8).with_any_alpha()];
    if is_whole() {
        soups.push(Soup::random(22, size, 0, 32).with_any_alpha());
        soups.push(Soup::random(23, [32, 32], 0, 64).with_any_alpha());
    }
    soups.extend([Soup::interpenetrating(size, 12), Soup::coplanar(size, 21)]);
    let files = [("LayeredGlass/LayeredGlass.gltf", 1), ("HairTuft/HairTuft.glb", 0)];
    let files = files.into_iter().filter_map(|(path, camera)| Stage::file(gpu, path, camera, [240, 135]));
    soups.iter().map(|soup| Stage::soup(gpu, soup)).chain(files).collect()
}

#[test]
fn transparency_compared_on_the_same_scenes() {
    let mut rows: Vec<Figure> = Vec::new();
    for mut stage in stages(shared()) {
        let exact = stage.measure(Transparency::ABuffer);
        let longest = exact.count.as_ref().unwrap().iter().copied().fold(0.0, f32::max);
        let mut found = Vec::new();
        for (name, technique, must_be_exact) in techniques() {
            let measured = stage.measure(technique);
            let far = distance(stage.view.size, &measured, &exact);
            if must_be_exact {
                assert!(far.max <= 1e-5, "{}: {name}: {far:?}", stage.name);
            }
            let pixels = u64::from(stage.view.size[0]) * u64::from(stage.view.size[1]);
            let Distance { mean, max, psnr, flip } = far;
            let decibels = if psnr.is_finite() { format!("{psnr:.1} dB") } else { "same bits".into() };
            rows.push(Figure {
                what: format!("{}, up to {longest} layers: {name}", stage.name),
                value: format!(
                    "mean {mean:.1e}, max {max:.1e}, {decibels}, FLIP {flip:.4}; {:.2} ms, {} B a pixel",
                    measured.seconds * 1e3,
                    measured.bytes / pixels
                ),
                bound: if must_be_exact { "max 1e-5".into() } else { "no bound".into() },
            });
            found.push((name, psnr));
        }
        let psnr = |wanted: &str| found.iter().find(|(name, _)| *name == wanted).unwrap().1;
        // What costs more is worth it.
        assert!(psnr("k-buffer of 8") >= psnr("k-buffer of 4"), "{}", stage.name);
        assert!(psnr("adaptive, 8 nodes") >= psnr("adaptive, 4 nodes") - 1e-6, "{}", stage.name);
        assert!(psnr("stochastic, 32 samples") >= psnr("stochastic, 8 samples") - 1e-6, "{}", stage.name);
    }
    silent(shared());
    if is_whole() {
        publish_page("transparency.md", "transparency_compared", &shared().caps().title(), &rows);
    }
}

/// Some of them side by side, for the page.
#[test]
fn transparency_compared_side_by_side() {
    let size = [256, 128];
    let mut stage = Stage::soup(shared(), &Soup::random(31, size, 24, 0));
    let shown =
        ["A-buffer", "k-buffer of 4", "moments", "stochastic, 8 samples", "weighted, equation 7", "sorted by object"];
    let found: Vec<_> = shown
        .iter()
        .map(|wanted| stage.run(techniques().iter().find(|(name, ..)| name == wanted).unwrap().1).pixels)
        .collect();
    // Three a row.
    let sheet = [3 * size[0], 2 * size[1]];
    let texel = |i: u32| {
        let (x, y) = (i % sheet[0], i / sheet[0]);
        let tile = &found[(y / size[1] * 3 + x / size[0]) as usize];
        let [r, g, b, _] = tile[(y % size[1] * size[0] + x % size[0]) as usize];
        [r, g, b]
    };
    let pixels = (0..sheet[0] * sheet[1]).map(texel).collect();
    let picture = Picture { size: sheet, exposure: auto_exposure(&found[0]), pixels, caption: shown.join(", ") };
    publish_picture("images", "transparency", &picture);
    assert!(found[1..].iter().all(|other| *other != found[0]), "the scene tells none of them apart");
    silent(shared());
}

/// A scene whose strips have 1 to 32 layers, with colours from its generator: every exact technique has them.
#[test]
fn transparency_compared_with_a_scene_that_knows_its_colors() {
    let Some(path) = require_scene("LayeredGlass/expected.json") else { return };
    let expected: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let strips = expected["strips"].as_array().unwrap();
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    // The first camera is orthographic: 8 metres by 5.
    let size = [320, 200];
    let mut stage = Stage::file(shared(), "LayeredGlass/LayeredGlass.gltf", 0, size).unwrap();
    for (name, technique, exact) in techniques() {
        let found = stage.run(technique).pixels;
        let off = |strip: &serde_json::Value| {
            let middle =
                |axis: &str| (number(&strip[format!("{axis}_min")]) + number(&strip[format!("{axis}_max")])) / 2.0;
            let x = (middle("x") / 4.0 * 0.5 + 0.5) * f64::from(size[0]);
            let y = (0.5 - middle("y") / 2.5 * 0.5) * f64::from(size[1]);
            let pixel = found[y as usize * size[0] as usize + x as usize];
            (0..3).map(|k| (f64::from(pixel[k]) - number(&strip["rgb_linear"][k])).abs()).fold(0.0, f64::max)
        };
        let worst = strips.iter().map(off).fold(0.0, f64::max);
        println!("{name}: off by {worst:.1e} at most over {} strips", strips.len());
        // The file has six digits.
        assert_eq!(worst < 2e-6, exact, "{name}: {worst}");
    }
    silent(shared());
}

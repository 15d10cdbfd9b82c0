//! The HTML page of a report: what is in its file, and what it does in a browser.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use ash::vk::PipelineStageFlags2 as Stages;
use serde_json::{Value, json};
use shadowgraph::frame::{FrameSettings, Selection, Transparency};
use shadowgraph::graph::description::{Access, Queue};
use shadowgraph::graph::plan::plan;
use shadowgraph::graph::report::{Report, html};
use shadowgraph::graph::{Executor, Graph, PassTime};
use shadowgraph_tests::browser::Browser;
use shadowgraph_tests::device::isolated_device;
use shadowgraph_tests::hazard::{Draft, MadeUpDevice};
use shadowgraph_tests::render::Subject;

/// Names that end scripts, elements, attributes and comments, that fill templates, and that objects have anyway.
const HOSTILE: &[&str] = &[
    "</script><script>window.hacked = 1</script>",
    "<!--<script>",
    "\"><img src=x onerror='window.hacked = 2'>",
    "{{report}}{{script}}",
    "constructor",
    "__proto__",
    "\u{2028}\u{2029}\\u003c\u{0}",
    "&lt;b&gt; ${window.hacked = 3} `",
];

/// A chain of passes that take turns on two queues, named as asked; one pass and one image that nobody needs.
fn chain(names: &[&str]) -> Report {
    let mut draft = Draft::new(names[0]);
    let mut last = None;
    for (index, name) in names.iter().enumerate() {
        let image = draft.image(name, [64, 64]);
        let queue = if index % 2 == 0 { Queue::Graphics } else { Queue::Compute };
        last = Some(draft.pass(name, queue, |pass| {
            if let Some(last) = last {
                pass.read("in", last, Access::sampled(Stages::COMPUTE_SHADER));
            }
            pass.overwrite("out", image, Access::storage_image_write(Stages::COMPUTE_SHADER))
        }));
    }
    let unused = draft.image("unused", [8, 8]);
    draft.pass("debug", Queue::Graphics, |pass| pass.overwrite("out", unused, Access::color_attachment(false)));
    draft.capture("last", last.unwrap());
    let plan = plan(&draft.description, &MadeUpDevice::two_queues()).unwrap();
    Report::new(&draft.description, &plan)
}

/// What a browser takes for the page's report.
fn embedded(page: &str) -> Value {
    let (_, rest) = page.split_once("<script type=\"application/json\" id=\"report\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn the_page_holds_the_report() {
    let mut report = chain(&["a", "b", "c"]);
    report.add_times(&[PassTime { name: "b".into(), seconds: 0.0015 }, PassTime { name: "last".into(), seconds: 1.0 }]);
    let page = html(&report).unwrap();
    assert_eq!(embedded(&page), serde_json::to_value(&report).unwrap());
    let times: Vec<_> = report.steps.iter().map(|step| step.milliseconds).collect();
    assert_eq!(times, [None, Some(1.5), None, None]);
    assert_eq!(embedded(&page)["steps"][1]["milliseconds"], 1.5);
    let depends = json!([{ "step": 0, "resource": "a", "part": "", "overwrites": false }]);
    assert_eq!(embedded(&page)["steps"][1]["depends"], depends);
    let resource = json!({ "name": "a", "kind": "image", "shape": "64 × 64, R8G8B8A8_UNORM", "origin": "transient" });
    assert_eq!(embedded(&page)["resources"][0], resource);
}

#[test]
fn hostile_names_stay_inside_the_report() {
    let report = chain(HOSTILE);
    let page = html(&report).unwrap();
    assert_eq!(embedded(&page), serde_json::to_value(&report).unwrap());
    let plain = html(&chain(&["a"])).unwrap();
    for mark in ["<script", "</script", "<img", "<!--"] {
        assert_eq!(page.matches(mark).count(), plain.matches(mark).count(), "{mark}");
    }
    assert!(!page.contains(['\u{2028}', '\u{2029}', '\u{0}']));
}

#[test]
fn the_page_names_no_place_to_fetch_from() {
    let page = html(&chain(&["a", "b"])).unwrap();
    for mark in ["http:", "https:", "//cdn", "@import", "url(", "src=", "fetch(", "import("] {
        assert!(!page.contains(mark), "{mark}");
    }
    assert!(page.contains("default-src 'none'"));
}

/// A page in a file, opened.
struct Opened {
    browser: Browser,
    file: PathBuf,
    _folder: tempfile::TempDir,
}

impl Opened {
    /// `None`, said aloud, where there is no browser.
    fn new(page: &str) -> Option<Self> {
        let mut browser = Browser::start()?;
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("page.html");
        std::fs::write(&file, page).unwrap();
        browser.open(&file, "");
        Some(Self { browser, file, _folder: folder })
    }

    fn js(&mut self, expression: &str) -> Value {
        self.browser.evaluate(expression)
    }

    /// The middle of the first element of a selector.
    fn middle(&mut self, selector: &str) -> [f64; 2] {
        let place = self.js(&format!(
            "(b => [b.x + b.width / 2, b.y + b.height / 2])(document.querySelector('{selector}').getBoundingClientRect())"
        ));
        [0, 1].map(|axis| place[axis].as_f64().unwrap())
    }

    /// Waits until an expression is true.
    fn until(&mut self, expression: &str) {
        let told = format!(
            "new Promise(done => {{ let left = 200; const look = () => ({expression}) || !left-- ? done(left >= 0) : \
             setTimeout(look, 20); look(); }})"
        );
        assert_eq!(self.js(&told), true, "{expression}");
    }

    fn drag(&mut self, from: [f64; 2], to: [f64; 2]) {
        for (kind, [x, y]) in [("mousePressed", from), ("mouseMoved", to), ("mouseReleased", to)] {
            let event = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1 });
            self.browser.call("Input.dispatchMouseEvent", &event);
        }
    }

    fn touch(&mut self, kind: &str, fingers: &[[f64; 2]]) {
        let points: Vec<_> = fingers.iter().map(|[x, y]| json!({ "x": x, "y": y })).collect();
        self.browser.call("Input.dispatchTouchEvent", &json!({ "type": kind, "touchPoints": points }));
    }

    fn details(&mut self) -> String {
        self.js("document.getElementById('about').innerText").as_str().unwrap().to_owned()
    }

    /// The page said nothing, and asked for itself alone.
    fn is_quiet(&mut self) {
        assert_eq!(self.browser.complaints(), [""; 0]);
        let requests = self.browser.requests();
        let own = format!("file://{}", self.file.display());
        assert!(
            !requests.is_empty() && requests.iter().all(|url| url.starts_with(&own) || url == "data:,"),
            "{requests:?}"
        );
    }
}

#[test]
fn a_frame_is_drawn_searched_and_explained() {
    isolated_device("a_frame_is_drawn_searched_and_explained", |gpu| {
        let subject = Subject::builtin("courtyard", [320, 180]);
        let view = subject.view();
        let scene = subject.scene.upload(gpu).unwrap();
        let mut graph = Graph::new("courtyard", gpu.caps());
        let mut settings = FrameSettings::new(view);
        settings.layers = Selection::Only(vec!["color".into(), "Z".into()]);
        settings.record(&mut graph, &scene);
        let plan = graph.compile(gpu).unwrap();
        let report = Report::new(graph.description(), &plan);
        assert!(report.steps.len() > 8 && report.memory.saved_bytes > 0);
        if let Some(mut page) = Opened::new(&html(&report).unwrap()) {
            whole_frame(&mut page, &report);
        }
    });
}

fn whole_frame(page: &mut Opened, report: &Report) {
    page.browser.window([1280, 800], false);
    // 1. Everything is there.
    assert_eq!(page.js("document.querySelectorAll('.pass-node').length"), report.steps.len());
    let placed: usize = report.memory.heaps.iter().map(|heap| heap.placements.len()).sum();
    assert_eq!(page.js("document.querySelectorAll('.resource-node').length"), placed);
    let pairs: std::collections::BTreeSet<_> =
        report.steps.iter().enumerate().flat_map(|(to, step)| step.depends.iter().map(move |d| (d.step, to))).collect();
    assert_eq!(page.js("document.querySelectorAll('path.edge').length"), pairs.len());
    assert_eq!(page.js("document.querySelectorAll('#resources > li').length"), report.resources.len());
    let bare = "[...document.querySelectorAll('.node')].filter(node => !node.getAttribute('aria-label')).length";
    assert_eq!(page.js(bare), 0);

    // 2. The search finds a pass and resources, marks them, and brings the pass into view.
    let step = report.steps.iter().position(|step| step.name == "lighting").unwrap();
    let type_in =
        "(f => { f.value = 'LIGHTing'; f.dispatchEvent(new Event('input')); })(document.getElementById('search'))";
    page.js(type_in);
    assert_eq!(page.js("document.querySelector('.pass-node.match').dataset.step"), step.to_string());
    let in_view = "(([a, b]) => a.left >= b.left && a.right <= b.right)(['.pass-node.match', '#view'].map(s => \
        document.querySelector(s).getBoundingClientRect()))";
    assert_eq!(page.js(in_view), true);
    let matches = report.resources.iter().filter(|resource| resource.name.contains("lighting")).count();
    assert!(matches > 0);
    let shown = "[...document.querySelectorAll('#resources > li')].filter(li => !li.hidden).length";
    assert_eq!(page.js(shown), matches);

    // 3. The pointer and the keyboard show details; a click keeps them.
    let place = page.middle(".pass-node.match");
    page.browser.mouse(place, false);
    let told = page.details();
    assert!(told.starts_with("lighting\n"), "{told}");
    let of = &report.steps[step];
    let reasons = of.barriers.iter().map(|barrier| &barrier.reason);
    for needed in of.reads.iter().chain(&of.writes).map(|used| &used.resource).chain(reasons) {
        assert!(told.contains(needed), "{needed} is not in {told}");
    }
    page.browser.mouse([2.0, 2.0], false);
    assert!(page.details().starts_with("Point at"));
    page.browser.mouse(place, true);
    page.browser.mouse([2.0, 2.0], false);
    assert!(page.details().starts_with("lighting\n"));
    page.browser.key("Escape");
    page.js("document.querySelector('.pass-node[data-step=\"0\"]').focus()");
    page.browser.key("ArrowRight");
    assert!(page.details().starts_with(&format!("{}\n", report.steps[1].name)));

    // 4. Zoom changes the size of the drawing.
    let width = "document.getElementById('diagram').getBoundingClientRect().width";
    let before = page.js(width).as_f64().unwrap();
    page.js("document.getElementById('in').click()");
    assert!(page.js(width).as_f64().unwrap() > before * 1.2);
    page.js("document.getElementById('fit').click()");
    assert!(
        page.js(width).as_f64().unwrap()
            <= page.js("document.getElementById('view').clientWidth").as_f64().unwrap() + 1.0
    );
    let wheel = |ctrl: bool| json!({ "type": "mouseWheel", "x": place[0], "y": place[1], "deltaX": 0, "deltaY": -200, "modifiers": 2 * i32::from(ctrl) });
    let before = page.js(width).as_f64().unwrap();
    page.browser.call("Input.dispatchMouseEvent", &wheel(true));
    page.until(&format!("{width} > {before} * 1.5"));
    let left = "document.getElementById('view').scrollLeft";
    page.js(&format!("{left} = 200"));
    page.drag(place, [place[0] + 120.0, place[1]]);
    assert_eq!(page.js(left), 80);
    assert!(page.js("document.querySelector('.node.selected')").is_null(), "a drag chooses nothing");
    page.is_quiet();

    // 5. A telephone in the dark: nothing is wider than the window, and a tap opens the details.
    page.browser.window([360, 740], true);
    let file = page.file.clone();
    page.browser.open(&file, "#search=lighting");
    assert_eq!(page.js("document.querySelectorAll('.pass-node.match').length"), 1);
    assert_eq!(page.js("document.documentElement.scrollWidth"), 360);
    assert_eq!(page.js("getComputedStyle(document.querySelector('aside')).display"), "none");
    page.js("document.getElementById('view').scrollIntoView({ block: 'start' })");
    let [x, y] = page.middle(".pass-node.match");
    page.browser.call("Emulation.setTouchEmulationEnabled", &json!({ "enabled": true }));
    let before = page.js(width).as_f64().unwrap();
    page.touch("touchStart", &[[x - 20.0, y], [x + 20.0, y]]);
    page.touch("touchMove", &[[x - 30.0, y], [x + 30.0, y]]);
    page.touch("touchMove", &[[x - 60.0, y], [x + 60.0, y]]);
    page.touch("touchEnd", &[]);
    page.until(&format!("Math.abs({width} / {before} - 2) < 0.1"));
    let [x, y] = page.middle(".pass-node.match");
    page.touch("touchStart", &[[x, y]]);
    page.touch("touchEnd", &[]);
    // A tap becomes a click in its own time.
    page.until("document.querySelector('aside.open') !== null");
    assert!(page.details().starts_with("lighting\n"));
    assert!(contrast(page, "#about .muted") >= 4.5 && contrast(page, "h2") >= 4.5);
    page.is_quiet();
    if let Some(folder) = pictures_folder() {
        pictures(page, &folder);
    }
}

/// Contrast of an element's text with the page's ground, by WCAG 2.1's definition (relative luminance).
fn contrast(page: &mut Opened, selector: &str) -> f64 {
    let colors = page.js(&format!(
        "[document.querySelector('{selector}'), document.body].map((node, i) => \
         getComputedStyle(node)[i ? 'backgroundColor' : 'color'].match(/[0-9.]+/g).map(Number))"
    ));
    let luminance = |color: &Value| {
        let linear = |channel: usize| {
            let value = color[channel].as_f64().unwrap() / 255.0;
            if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(0) + 0.7152 * linear(1) + 0.0722 * linear(2)
    };
    let [text, ground] = [0, 1].map(|index| luminance(&colors[index]));
    (text.max(ground) + 0.05) / (text.min(ground) + 0.05)
}

/// Where pictures to look at go, where they are asked for.
fn pictures_folder() -> Option<PathBuf> {
    std::env::var_os("SHADOWGRAPH_TEST_PICTURES").filter(|value| value == "1")?;
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../target/test-pictures");
    std::fs::create_dir_all(&folder).unwrap();
    Some(folder)
}

fn pictures(page: &mut Opened, folder: &Path) {
    let file = page.file.clone();
    page.browser.picture(&folder.join("report-phone-dark-details.png"));
    page.browser.call("Emulation.setTouchEmulationEnabled", &json!({ "enabled": false }));
    for (name, size, dark, hash) in [
        ("report-desktop", [1280, 800], false, ""),
        ("report-desktop-dark", [1280, 800], true, "#search=shadow"),
        ("report-phone", [360, 740], false, ""),
        ("report-phone-dark", [360, 740], true, "#search=shadow"),
    ] {
        page.browser.window(size, dark);
        page.browser.open(&file, hash);
        page.js("document.querySelectorAll('.pass-node')[4].dispatchEvent(new PointerEvent('pointerenter', \
            { pointerType: 'mouse' }))");
        page.browser.picture(&folder.join(format!("{name}.png")));
    }
}

/// Frames with checkpoints are drawn segment by segment.
#[test]
fn every_segment_is_drawn() {
    isolated_device("every_segment_is_drawn", |gpu| {
        let subject = Subject::builtin("courtyard", [64, 36]);
        let scene = subject.scene.clone().upload(gpu).unwrap();
        let mut settings = FrameSettings::new(subject.view());
        settings.layers = Selection::Only(vec!["color".into()]);
        settings.transparency = Transparency::ABuffer;
        let mut graph = Graph::new("courtyard", gpu.caps());
        settings.record(&mut graph, &scene);
        let plan = graph.compile(gpu).unwrap();
        let whole = graph.description().clone();
        let mut report = Report::new(&whole, &plan);
        let executed = Executor::new(gpu).execute(&plan, graph).unwrap();
        report.add_segments(&whole, &executed.later);
        report.add_times(&executed.passes);
        let later = &report.later[0];
        assert_eq!((report.later.len(), later.after.as_deref()), (1, Some("abuffer.totals")));
        assert!(later.steps.iter().any(|step| step.name == "abuffer.fill" && step.milliseconds.is_some()));
        let Some(mut page) = Opened::new(&html(&report).unwrap()) else { return };
        page.browser.window([1280, 800], false);
        assert_eq!(page.js("document.querySelectorAll('#segment option').length"), 2);
        assert_eq!(page.js("document.getElementById('segments').checkVisibility()"), true);
        assert_eq!(page.js("document.querySelectorAll('.pass-node').length"), report.steps.len());
        let choose =
            "(s => { s.value = 1; s.dispatchEvent(new Event('change')); })(document.getElementById('segment'))";
        page.browser.reload_by(choose);
        assert_eq!(page.js("document.querySelectorAll('.pass-node').length"), later.steps.len());
        let file = page.file.clone();
        page.browser.open(&file, "#segment=1&search=fill");
        assert_eq!(
            page.js("document.getElementById('segment').selectedOptions[0].text"),
            "2 of 2, after abuffer.totals"
        );
        assert_eq!(page.js("document.querySelectorAll('.pass-node.match').length"), 1);
        if let Some(folder) = pictures_folder() {
            page.browser.picture(&folder.join("segment.png"));
        }
        page.is_quiet();
    });
}

#[test]
fn hostile_names_run_nothing_and_break_nothing() {
    let report = chain(HOSTILE);
    let Some(mut page) = Opened::new(&html(&report).unwrap()) else { return };
    assert_eq!(page.js("String(window.hacked)"), "undefined");
    assert_eq!(page.js("document.querySelectorAll('.pass-node').length"), report.steps.len());
    assert_eq!(page.js("document.querySelectorAll('#resources > li').length"), HOSTILE.len());
    assert_eq!(page.js("document.querySelectorAll('img').length"), 0);
    // Everything is opened, so that all names are shown.
    page.js("document.querySelectorAll('details').forEach(details => { details.open = true; })");
    page.js("document.querySelectorAll('.node').forEach(node => node.focus())");
    page.js("new Promise(done => setTimeout(done, 50))");
    assert_eq!(page.js("String(window.hacked)"), "undefined");
    let names = page.js("[...document.querySelectorAll('#resources summary')].map(node => node.firstChild.data)");
    assert_eq!(names, json!(HOSTILE));
    assert_eq!(page.js("document.querySelectorAll('#culled > li').length"), 1);
    let rows = page.js("[...document.querySelectorAll('.lane')].map(node => node.textContent)");
    assert_eq!(rows[0], "Graphics queue");
    assert_eq!(rows[1], "Compute queue");
    page.is_quiet();
    if let Some(folder) = pictures_folder() {
        page.js("scrollTo(0, 0); document.querySelectorAll('.pass-node')[2].focus()");
        page.browser.window([1280, 800], true);
        page.browser.picture(&folder.join("report-hostile.png"));
    }
}

#[test]
fn a_frame_of_nothing_and_a_frame_of_a_thousand_passes_are_drawn() {
    let names: Vec<String> = (0..1000).map(|index| format!("Pass {index}")).collect();
    let long = chain(&names.iter().map(String::as_str).collect::<Vec<_>>());
    let empty = Draft::new("nothing");
    let nothing = plan(&empty.description, &MadeUpDevice::one_queue()).unwrap();
    let nothing = Report::new(&empty.description, &nothing);
    for (report, steps) in [(&long, 1001), (&nothing, 0)] {
        let Some(mut page) = Opened::new(&html(report).unwrap()) else { return };
        assert_eq!(page.js("document.querySelectorAll('.pass-node').length"), steps);
        // 99 and 990 to 999, passes and their images.
        page.js("location.hash = 'search=PASS%2099'");
        page.until("document.getElementById('found').textContent !== ''");
        let found = if steps == 0 { "0 steps, 0 resources" } else { "11 steps, 11 resources" };
        assert_eq!(page.js("document.getElementById('found').textContent"), found);
        page.is_quiet();
    }
}

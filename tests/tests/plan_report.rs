//! Reports of a plan: JSON by its schema, DOT as Graphviz wants it.
#![allow(clippy::unwrap_used)]

use ash::vk::PipelineStageFlags2 as Stages;
use shadowgraph::graph::description::{Access, Queue, ResourceId};
use shadowgraph::graph::plan::{apart, plan};
use shadowgraph::graph::report::{Report, SCHEMA, critical_path, dot, text};
use shadowgraph_tests::hazard::{Draft, MadeUpDevice};

/// ```text
/// draw ─x─► blur ─y─► [read-back]
///   └─► debug ─z              nobody needs z
/// ```
fn draft() -> Draft {
    let mut draft = Draft::new("a \"frame\"");
    let [x, y, z] = ["x", "y", "z"].map(|name| draft.image(name, [8, 8]));
    let x = draft.pass("draw", Queue::Graphics, |pass| pass.overwrite("out", x, Access::color_attachment(false)));
    let y = draft.pass("blur", Queue::Compute, |pass| {
        pass.read("in", x, Access::sampled(Stages::COMPUTE_SHADER));
        pass.overwrite("out", y, Access::storage_image_write(Stages::COMPUTE_SHADER))
    });
    draft.pass("debug", Queue::Graphics, |pass| {
        pass.read("in", x, Access::sampled(Stages::FRAGMENT_SHADER));
        pass.overwrite("out", z, Access::color_attachment(false))
    });
    draft.capture("y", y);
    draft
}

#[test]
fn json_has_steps_barriers_reasons_and_memory() {
    let draft = draft();
    let plan = plan(&draft.description, &MadeUpDevice::one_queue()).unwrap();
    let report = Report::new(&draft.description, &plan);
    let json: serde_json::Value = serde_json::from_str(&report.json().unwrap()).unwrap();
    assert_eq!(json["schema"], SCHEMA);
    assert_eq!(json["graph"], "a \"frame\"");
    let names: Vec<_> = json["steps"].as_array().unwrap().iter().map(|step| step["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["draw", "blur", "y"]);
    assert_eq!(json["steps"][2]["kind"], "read-back");
    let used = &json["steps"][1]["reads"][0];
    assert_eq!(used["resource"], "x");
    assert_eq!(used["layout"], "READ_ONLY_OPTIMAL");
    let barrier = &json["steps"][1]["barriers"][0];
    assert_eq!(barrier["reason"], "read after write: `blur` reads `x`, written by `draw`");
    assert_eq!(barrier["from"], serde_json::json!(["COLOR_ATTACHMENT_OUTPUT", "COLOR_ATTACHMENT_WRITE"]));
    assert_eq!(barrier["layouts"], serde_json::json!(["ATTACHMENT_OPTIMAL", "READ_ONLY_OPTIMAL"]));
    let reason = "nothing reads `z`, which it writes; no root needs it";
    assert_eq!(json["culled"], serde_json::json!([{ "name": "debug", "reason": reason }]));
    let memory = &json["memory"];
    assert_eq!(memory["bytes"], 512);
    assert_eq!(memory["over_lower_bound"], 1.0);
    assert_eq!(memory["heaps"][0]["placements"][0]["steps"], serde_json::json!([0, 1]));
    let apart = serde_json::json!([{ "resources": ["x", "y"], "reason": "both are in use in `blur`" }]);
    assert_eq!(memory["apart"], apart);
    assert_eq!(memory["saved_share"], 0.0);
    assert_eq!(json["critical_path"], serde_json::json!([0, 1, 2]));
    assert_eq!(json["batches"][0], serde_json::json!({ "queue": "Graphics", "signal": 1, "waits": [], "release": [] }));
}

#[test]
fn dot_draws_steps_edges_and_culled_passes() {
    let draft = draft();
    let plan = plan(&draft.description, &MadeUpDevice::two_queues()).unwrap();
    let expected = r##"digraph "a \"frame\"" {
  rankdir=LR; node [shape=box, style=filled, fontname="sans-serif"]; edge [fontname="sans-serif"];
  pass0 [label="0: draw\n1 barrier", shape=box, fillcolor="#cfe3ff"];
  pass1 [label="1: blur\n2 barriers", shape=box, fillcolor="#ffe3c2"];
  readback0 [label="2: y\n1 barrier", shape=note, fillcolor="#cfe3ff"];
  pass2 [label="debug\nculled: nothing reads `z`, which it writes; no root needs it", style="dashed", fontcolor="#777777"];
  pass0 -> pass1 [label="x", penwidth=3];
  pass1 -> readback0 [label="y", penwidth=3];
}
"##;
    assert_eq!(dot(&draft.description, &plan), expected);
}

#[test]
fn json_has_waits_and_releases() {
    let draft = draft();
    let plan = plan(&draft.description, &MadeUpDevice::two_queues()).unwrap();
    let json: serde_json::Value =
        serde_json::from_str(&Report::new(&draft.description, &plan).json().unwrap()).unwrap();
    let waits = serde_json::json!([{ "queue": "Graphics", "value": 1, "stages": "COMPUTE_SHADER" }]);
    assert_eq!(json["batches"][1]["waits"], waits);
    assert_eq!(json["batches"][0]["release"][0]["families"], serde_json::json!([0, 1]));
}

/// ```text
/// p0 ─a─► p1 ─b─► p2 ─c─► [read-back];  b is kept; n lies in another memory type; u is not used
/// ```
#[test]
fn resources_that_do_not_share_memory_say_why() {
    let mut draft = Draft::new("frame");
    let [a, b, c] = ["a", "b", "c"].map(|name| draft.image(name, [8, 8]));
    let (n, _) = (draft.buffer("n", 64), draft.image("u", [8, 8]));
    let write = Access::color_attachment(false);
    let (a, n) = draft.pass("p0", Queue::Graphics, |pass| {
        (pass.overwrite("a", a, write), pass.overwrite("n", n, Access::storage_buffer_write(Stages::FRAGMENT_SHADER)))
    });
    let b = draft.pass("p1", Queue::Graphics, |pass| {
        pass.read("a", a, Access::sampled(Stages::FRAGMENT_SHADER));
        pass.read("n", n, Access::storage_buffer_read(Stages::FRAGMENT_SHADER));
        pass.overwrite("b", b, write)
    });
    let c = draft.pass("p2", Queue::Graphics, |pass| {
        pass.read("b", b, Access::sampled(Stages::FRAGMENT_SHADER));
        pass.overwrite("c", c, write)
    });
    draft.capture("c", c);
    draft.keep("b", b);
    let device = MadeUpDevice { type_bits: [1, 1, 2], ..MadeUpDevice::one_queue() };
    let plan = plan(&draft.description, &device).unwrap();
    let [a, b, c, n, u] = [0, 1, 2, 3, 4].map(ResourceId);
    let why = |one, other| apart(&draft.description, &plan, one, other).map(|why| why.explain(&draft.description));
    assert_eq!(why(a, c), None);
    assert_eq!(why(a, b).unwrap(), "both are in use in `p1`");
    assert_eq!(why(b, c).unwrap(), "both are in use from `p2` to the read-back of `c`");
    assert_eq!(why(a, n).unwrap(), "no memory type suits both");
    assert_eq!(why(u, a).unwrap(), "no step uses `u`");
    assert_eq!(critical_path(&draft.description, &plan, |_| 1.0), [0, 1, 2, 3]);
    let heavy = |step| if step == 3 { 0.0 } else { 1.0 };
    assert_eq!(critical_path(&draft.description, &plan, heavy).len(), 3);

    let text = text(&draft.description, &plan);
    assert!(text.contains("critical path, 4 of 4 steps: `p0`, `p1`, `p2`, the read-back of `c`"), "{text}");
    assert!(text.contains("heaps hold 576 bytes of 832: 256 saved, lower bound 576"), "{text}");
    let rows: Vec<&str> = text.lines().filter(|line| line.starts_with("heap 0 map")).collect();
    assert_eq!(rows.len(), 12);
    assert!(rows.iter().any(|row| row.ends_with(" AACC")) && rows.iter().any(|row| row.ends_with(" .BBB")), "{text}");
}

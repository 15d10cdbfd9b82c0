//! Reports of a plan: JSON by its schema, DOT as Graphviz wants it.
#![allow(clippy::unwrap_used)]

use ash::vk::PipelineStageFlags2 as Stages;
use shadowgraph::graph::description::{Access, Queue};
use shadowgraph::graph::plan::plan;
use shadowgraph::graph::report::{Report, SCHEMA, dot};
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
  pass0 -> pass1 [label="x"];
  pass1 -> readback0 [label="y"];
}
"##;
    assert_eq!(dot(&draft.description, &plan), expected);
}

//! `info`: the device, its driver, and what they can do.

use serde_json::json;
use shadowgraph::gpu::{Caps, Feature};

use crate::cli::InfoArguments;
use crate::failure::{Failure, Result};
use crate::output::print;
use crate::session;

/// Opens the device and prints what it is.
pub fn run(arguments: &InfoArguments) -> Result<()> {
    let gpu = session::open(&arguments.device)?;
    let caps = gpu.caps().clone();
    session::close(gpu)?;
    if arguments.json {
        let object = json!({ "shadowgraph": env!("CARGO_PKG_VERSION"), "device": caps });
        print(serde_json::to_string_pretty(&object).map_err(Failure::failed)?)
    } else {
        print(table(&caps))
    }
}

fn table(caps: &Caps) -> String {
    let [major, minor, patch] = caps.api_version;
    let list = |features: Vec<&Feature>| {
        let names: Vec<_> = features.into_iter().map(|feature| feature.vulkan_name()).collect();
        if names.is_empty() { "none".into() } else { names.join(", ") }
    };
    let (has, lacks): (Vec<_>, Vec<_>) = Feature::ALL.iter().partition(|&&feature| caps.has(feature));
    let rows = [
        ("Shadowgraph", env!("CARGO_PKG_VERSION").to_string()),
        ("device", format!("{} ({:?})", caps.device, caps.kind)),
        ("driver", format!("{} {}", caps.driver, caps.driver_info)),
        ("Vulkan", format!("{major}.{minor}.{patch}")),
        ("largest image", format!("{0} x {0} texels", caps.limits.max_image_dimension_2d)),
        ("subgroup", format!("{} invocations", caps.limits.subgroup_size)),
        ("optional features", list(has)),
        ("lacks", list(lacks)),
    ];
    rows.map(|(name, value)| format!("{name:<18} {value}")).join("\n")
}

//! The demo: one command from a bare machine to a picture.

use crate::failure::{Failure, Result};
use crate::setup::setup;
use crate::shell;
use crate::workspace::{Workspace, make_folder};
use std::time::Instant;

const CAPTURE: &[&str] =
    &["capture", "builtin:courtyard", "--size", "1280x720", "--layers", "all", "--transparency", "abuffer"];

/// Sets up, builds, captures the courtyard, and says where the pictures are.
pub fn demo(workspace: &Workspace) -> Result<()> {
    setup(workspace)?;
    shell::run(&mut shell::cargo(&workspace.root, &["build", "--profile", "demo", "--package", "shadowgraph-cli"]))?;

    make_folder(&workspace.path("out"))?;
    let program = workspace.target().join(format!("demo/shadowgraph{}", std::env::consts::EXE_SUFFIX));
    let mut capture = shell::command(&workspace.root, &program.to_string_lossy(), CAPTURE);
    let start = Instant::now();
    shell::run(capture.args(["-o", "out/demo.exr", "--png", "out/demo.png"]))?;
    let seconds = start.elapsed().as_secs_f64();

    for file in ["out/demo.exr", "out/demo.png"] {
        let path = workspace.path(file);
        let size = path.metadata().map_err(|error| Failure::io("find", &path, &error))?.len();
        println!("{} ({:.1} MB)", path.display(), size as f64 / 1e6);
    }
    println!("captured in {seconds:.1} s");
    Ok(())
}

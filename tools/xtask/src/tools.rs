//! Tools that take minutes to build, fetched when first asked for.

use crate::failure::{Failure, Result};
use crate::shell;
use crate::workspace::Workspace;
use std::process::Command;

/// Checks the dependencies' licences, sources, duplicates and known advisories against `deny.toml`.
pub fn deny(workspace: &Workspace) -> Result<()> {
    let program = tool(workspace, "cargo-deny", "0.18")?;
    let check = |what: &[&str]| {
        let mut command = shell::command(&workspace.root, &program, &["--all-features", "check"]);
        shell::run(command.args(what))
    };
    check(&["licenses", "bans", "sources"])?;
    // Apart, because these come from a data base on the network.
    check(&["advisories"]).map_err(|failure| {
        Failure::Failed(format!(
            "{failure}\nLicences, duplicates and sources are fine. The advisories were either found (listed above) or \
             their data base could not be fetched, in which case nothing is known about them."
        ))
    })
}

/// Builds the book into `target/book`.
pub fn docs(workspace: &Workspace) -> Result<()> {
    let program = tool(workspace, "mdbook", "0.4")?;
    shell::run(&mut shell::command(&workspace.root, &program, &["build", "docs"]))?;
    println!("{}", workspace.path("target/book/index.html").display());
    Ok(())
}

/// The program of a crate: the one in `PATH`, or one built into `target/tools`.
fn tool(workspace: &Workspace, name: &str, version: &str) -> Result<String> {
    if shell::has(name) {
        return Ok(name.to_owned());
    }
    let folder = workspace.path("target/tools");
    let program = folder.join(format!("bin/{name}{}", std::env::consts::EXE_SUFFIX));
    if !program.exists() {
        println!("{name} is not installed: building it into {} (a few minutes)", folder.display());
        let mut install = Command::new("cargo");
        install.args(["install", "--locked", "--version", version, name, "--root"]).arg(&folder);
        shell::run(install.current_dir(&workspace.root))?;
    }
    Ok(program.to_string_lossy().into_owned())
}

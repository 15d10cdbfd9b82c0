//! Tools that take minutes to build, fetched when first asked for.

use crate::failure::{Failure, Result};
use crate::shell;
use crate::workspace::Workspace;
use std::process::Command;

/// Checks the dependencies' licences, sources, duplicates and known advisories against `deny.toml`.
pub fn deny(workspace: &Workspace) -> Result<()> {
    let program = tool(workspace, "cargo-deny", "0.20.2")?;
    let deny = |arguments: &[&str]| {
        let mut command = shell::command(&workspace.root, &program, &["--all-features"]);
        shell::run(command.args(arguments))
    };
    deny(&["check", "--hide-inclusion-graph", "licenses", "bans", "sources"])?;
    // Apart, because their data base comes from the network.
    deny(&["fetch", "db"]).map_err(|failure| {
        Failure::Failed(format!(
            "{failure}\nLicences, duplicates and sources are as they should be. Known advisories were NOT checked: their \
             data base could not be fetched."
        ))
    })?;
    deny(&["check", "--disable-fetch", "advisories"])
}

/// Builds the book into `target/book`.
pub fn docs(workspace: &Workspace) -> Result<()> {
    let program = tool(workspace, "mdbook", "0.5.4")?;
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use crate::workspace::{Workspace, read};

    #[test]
    fn third_party_names_every_direct_dependency() {
        let workspace = Workspace::find().unwrap();
        let notices = read(&workspace.path("THIRD_PARTY.md")).unwrap();
        let mut compared = 0;
        for manifest in [
            "Cargo.toml",
            "engine/Cargo.toml",
            "engine/core/Cargo.toml",
            "tests/Cargo.toml",
            "tools/shadowgraph/Cargo.toml",
        ] {
            let text = read(&workspace.path(manifest)).unwrap();
            for name in dependencies(&text).filter(|name| !name.starts_with("shadowgraph")) {
                let named =
                    notices.split(|c: char| !(c.is_alphanumeric() || c == '-' || c == '_')).any(|word| word == name);
                assert!(named, "{manifest} depends on {name}, which THIRD_PARTY.md does not name");
                compared += 1;
            }
        }
        assert!(compared > 20, "only {compared} dependencies found");
    }

    /// The keys of all dependency tables of a manifest that begin a line.
    fn dependencies(manifest: &str) -> impl Iterator<Item = &str> {
        let mut inside = false;
        manifest.lines().filter_map(move |line| {
            if line.starts_with('[') {
                inside = line.trim_end().ends_with("dependencies]");
                return None;
            }
            let key = line.split(['=', '.', ' ']).next()?;
            (inside && key.starts_with(|c: char| c.is_ascii_lowercase())).then_some(key)
        })
    }
}

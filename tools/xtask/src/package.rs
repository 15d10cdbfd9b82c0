//! Packing the engine for dependants, who have no shader compiler.

use crate::failure::{Failure, Result};
use crate::shell;
use crate::workspace::{Workspace, make_folder, read, write};
use std::fs;
use std::path::{Path, PathBuf};

/// How to pack.
#[derive(Debug, clap::Args)]
pub struct PackageOptions {
    /// Also build a program outside the workspace against the package, and run it.
    #[arg(long)]
    pub check: bool,
}

/// What is packed: the library, and its lower floors.
const PACKAGES: [&str; 2] = ["shadowgraph", "shadowgraph-core"];

/// The file that `engine/examples/capture.rs` writes.
const RESULT: &str = "sun.npy";

/// Packs the engine with its compiled shaders.
pub fn package(workspace: &Workspace, options: &PackageOptions) -> Result<()> {
    let prebuilt = workspace.path("engine/prebuilt");
    let packed = compile_shaders(workspace, &prebuilt).and_then(|()| {
        // What it would verify, the program outside the workspace shows.
        let mut pack = shell::cargo(&workspace.root, &["package", "--allow-dirty", "--no-verify"]);
        PACKAGES.iter().for_each(|name| {
            pack.args(["--package", name]);
        });
        shell::run(&mut pack)
    });
    // A checkout compiles its own shaders: these would be out of date at the next edit.
    let _ = fs::remove_dir_all(&prebuilt);
    packed?;
    if options.check { check(workspace) } else { Ok(()) }
}

/// Has the engine's build script leave its compiled shaders in a folder.
fn compile_shaders(workspace: &Workspace, folder: &Path) -> Result<()> {
    let mut check =
        shell::cargo(&workspace.root, &["check", "--package", "shadowgraph", "--features", "compile-shaders"]);
    shell::run(check.env("SHADOWGRAPH_PREBUILT_OUT", folder))?;
    if folder.is_dir() {
        return Ok(());
    }
    Err(Failure::Failed(format!("the engine's build script left no compiled shaders in {}", folder.display())))
}

/// Builds the engine's example against the package, outside the workspace and without a shader compiler, and runs it.
fn check(workspace: &Workspace) -> Result<()> {
    let packages = workspace.target().join("package");
    let [engine, core] = PACKAGES.map(|package| unpack(&packages, package));
    let (engine, core) = (engine?, core?);

    let outside = workspace.target().join("outside");
    make_folder(&outside.join("src"))?;
    let result = outside.join(RESULT);
    let _ = fs::remove_file(&result);
    // The workspace's versions and profile, so that dependencies are compiled once for both.
    let workspace_manifest = read(&workspace.path("Cargo.toml"))?;
    write(&outside.join("Cargo.toml"), &(manifest(&engine, &core) + &profile(&workspace_manifest)))?;
    write(&outside.join("Cargo.lock"), &read(&workspace.path("Cargo.lock"))?)?;
    write(&outside.join("src/main.rs"), &read(&engine.join("examples/capture.rs"))?)?;

    let tree = shell::checked_output(&mut shell::cargo(&outside, &["tree", "--edges", "all"]))?;
    if let Some(line) = tree.lines().find(|line| line.contains("shaderc")) {
        return Err(Failure::Failed(format!("the package depends on the shader compiler: {}", line.trim())));
    }
    shell::run(shell::cargo(&outside, &["run"]).env("CARGO_TARGET_DIR", workspace.target()))?;
    let size = result.metadata().map_err(|error| Failure::io("find", &result, &error))?.len();
    println!("a program outside the workspace rendered {} ({size} bytes)", result.display());
    Ok(())
}

/// The folder of a package, anew from its archive.
fn unpack(packages: &Path, package: &str) -> Result<PathBuf> {
    let name = format!("{package}-{}", env!("CARGO_PKG_VERSION"));
    let folder = packages.join(&name);
    let _ = fs::remove_dir_all(&folder);
    shell::run(&mut shell::command(packages, "tar", &["-xzf", &format!("{name}.crate")]))?;
    Ok(folder)
}

/// What dependencies depend on, with the features that the workspace's tools ask of it too: else most would be compiled
/// twice. The engine uses none of it itself, so that what it asks for stays tested.
const SHARED: &str = "num-traits = { version = \"0.2\", features = [\"libm\"] }\nlibm = \"0.2\"\n\n\
    [build-dependencies]\nsyn = { version = \"3\", features = [\"full\"] }\n";

/// Cargo would look for the lower floors where packages are published.
fn manifest(engine: &Path, core: &Path) -> String {
    format!(
        "[package]\nname = \"outside\"\nversion = \"0.0.0\"\nedition = \"2024\"\npublish = false\n\n\
         [dependencies]\nshadowgraph = {{ path = {engine:?} }}\n{SHARED}\n\
         [patch.crates-io]\nshadowgraph-core = {{ path = {core:?} }}\n\n[workspace]\n"
    )
}

/// The tables of a workspace's manifest that say how to compile dependencies.
fn profile(manifest: &str) -> String {
    let of_dependencies = |table: &&str| match table.strip_prefix("profile.dev.package.") {
        Some(package) => !package.starts_with("shadowgraph") && !package.starts_with("xtask"),
        None => table.starts_with("profile.dev]"),
    };
    let tables = manifest.split("\n[").filter(of_dependencies);
    tables.map(|table| format!("\n[{table}")).collect::<String>() + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_of_dependencies_is_taken() {
        let manifest = "[workspace]\n\n[profile.release]\ndebug = 1\n\n[profile.dev]\nopt-level = 2\n\n\
            [profile.dev.package.\"*\"]\ndebug = false\n\n[profile.dev.package.xtask]\nopt-level = 0\n\n\
            [profile.dev.package.exr]\nopt-level = 3\n";
        let profile = profile(manifest);
        let expected = "\n[profile.dev]\nopt-level = 2\n\n[profile.dev.package.\"*\"]\ndebug = false\n\n\
            [profile.dev.package.exr]\nopt-level = 3\n\n";
        assert_eq!(profile, expected);
    }
}

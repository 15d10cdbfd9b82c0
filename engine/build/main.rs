//! Turns `../shaders_glsl/` into SPIR-V and Rust: see the documentation of `shadowgraph::shader`.
//!
//! With the feature `compile-shaders`, shaders are compiled and reflected here. Without it, the files that a build
//! with it left in `prebuilt/` are used: a dependant needs no C++ tool chain.

#[cfg_attr(not(feature = "compile-shaders"), allow(dead_code))]
mod files;
#[cfg_attr(feature = "compile-shaders", allow(dead_code))]
mod prebuilt;
#[cfg(feature = "compile-shaders")]
mod shaders;
#[cfg_attr(not(feature = "compile-shaders"), allow(dead_code))]
mod source;

use std::env;
use std::path::{Path, PathBuf};

/// What went wrong, each with the file and, where there is one, the line.
pub type Problems = Vec<String>;

/// Environment variable that names a folder to write a prebuilt set to.
const PREBUILT_OUT: &str = "SHADOWGRAPH_PREBUILT_OUT";

fn main() {
    if let Err(problems) = run() {
        for problem in problems {
            // Cargo shows each of these as an error of its own and fails the build.
            for line in problem.lines() {
                println!("cargo::error={line}");
            }
        }
    }
}

fn run() -> Result<(), Problems> {
    let package = PathBuf::from(variable("CARGO_MANIFEST_DIR")?);
    let out = PathBuf::from(variable("OUT_DIR")?);
    let sources = package.join("../shaders_glsl");

    println!("cargo::rerun-if-env-changed={PREBUILT_OUT}");
    if sources.is_dir() {
        println!("cargo::rerun-if-changed={}", sources.display());
    }

    make(&package, &sources, &out)?;

    if let Some(folder) = env::var_os(PREBUILT_OUT).filter(|folder| !folder.is_empty()) {
        let folder = Path::new(&folder);
        prebuilt::copy(&out, folder).map_err(|problem| vec![problem])?;
        // Removed between two builds, it is made again.
        println!("cargo::rerun-if-changed={}", folder.join(prebuilt::MANIFEST).display());
    }
    Ok(())
}

#[cfg(feature = "compile-shaders")]
fn make(_package: &Path, sources: &Path, out: &Path) -> Result<(), Problems> {
    let report = shaders::build(sources, out)?;
    for warning in report.warnings {
        println!("cargo::warning={warning}");
    }
    Ok(())
}

#[cfg(not(feature = "compile-shaders"))]
fn make(package: &Path, sources: &Path, out: &Path) -> Result<(), Problems> {
    let prebuilt = package.join("prebuilt");
    if prebuilt.is_dir() {
        println!("cargo::rerun-if-changed={}", prebuilt.display());
    }
    prebuilt::restore(&prebuilt, sources, out)
}

fn variable(name: &str) -> Result<String, Problems> {
    env::var(name).map_err(|problem| vec![format!("environment variable {name}: {problem}")])
}

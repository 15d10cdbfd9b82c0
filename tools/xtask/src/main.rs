//! `cargo xtask`: set-up, demo, tests, checks and documentation of the workspace.

mod archive;
mod ci;
mod demo;
mod drivers;
mod failure;
mod package;
mod packages;
mod programs;
mod setup;
mod shell;
mod technique;
mod test;
mod tools;
mod workspace;

use clap::{Parser, Subcommand};
use failure::Result;
use std::process::ExitCode;
use workspace::Workspace;

/// Set-up, demo, tests, checks and documentation of Shadowgraph.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Install what the build needs (as root, on Debian and Ubuntu), or say what to install.
    Setup,
    /// Set up, build, capture the built-in courtyard to out/demo.exr and out/demo.png.
    Demo,
    /// Set up, then run the tests with validation on.
    Test(test::TestOptions),
    /// Everything the gate checks: format, clippy, rustdoc, all tests, the portable tests on the other drivers, a dependant.
    Ci,
    /// Check licences, advisories and sources of the dependencies with cargo-deny (fetched on demand).
    Deny,
    /// Build the book in docs/ with mdBook (fetched on demand) into target/book.
    Docs,
    /// Pack the engine with its compiled shaders, as `cargo publish` would.
    Package(package::PackageOptions),
    /// Make the folders, the test and the page of a new technique, and register it.
    NewTechnique(technique::TechniqueName),
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(arguments.task) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("xtask: {failure}");
            ExitCode::from(failure.exit_code())
        }
    }
}

fn run(task: Task) -> Result<()> {
    let workspace = Workspace::find()?;
    match task {
        Task::Setup => setup::setup(&workspace),
        Task::Demo => demo::demo(&workspace),
        Task::Test(options) => test::test(&workspace, &options),
        Task::Ci => ci::ci(&workspace),
        Task::Deny => tools::deny(&workspace),
        Task::Docs => tools::docs(&workspace),
        Task::Package(options) => package::package(&workspace, &options),
        Task::NewTechnique(name) => technique::new_technique(&workspace, &name),
    }
}

//! What the gate checks, in order, each step timed.

use crate::drivers::Driver;
use crate::failure::{Failure, Result};
use crate::package::{PackageOptions, package};
use crate::setup::setup_gate;
use crate::test::{self, TestOptions};
use crate::workspace::Workspace;
use crate::{packages, shell};
use std::time::Instant;

/// Runs every step, and stops at the first that fails.
pub fn ci(workspace: &Workspace) -> Result<()> {
    let mut steps = Steps::default();
    steps.run("format", || {
        no_leftovers(workspace)?;
        cargo(workspace, &["fmt", "--all", "--check"])
    })?;
    steps.run("set-up", || setup_gate(workspace))?;
    steps
        .run("clippy", || cargo(workspace, &["clippy", "--workspace", "--all-targets", "--", "--deny", "warnings"]))?;
    steps.run("rustdoc", || {
        let mut doc = shell::cargo(&workspace.root, &["doc", "--workspace", "--no-deps"]);
        shell::run(doc.env("RUSTDOCFLAGS", "--deny warnings"))
    })?;
    steps.run("tests", || test::run(workspace, &TestOptions { strict: true, ..TestOptions::default() }))?;
    if packages::is_debian() {
        steps.run("portable tests on lavapipe25", || portable_tests(workspace, Driver::Lavapipe25))?;
        steps.run("portable tests on swiftshader", || portable_tests(workspace, Driver::Swiftshader))?;
    } else {
        println!("skipped: the portable tests on other drivers, which come from Debian's packages");
    }
    steps.run("a dependant outside the workspace", || package(workspace, &PackageOptions { check: true }))?;
    steps.print();
    Ok(())
}

fn cargo(workspace: &Workspace, arguments: &[&str]) -> Result<()> {
    shell::run(&mut shell::cargo(&workspace.root, arguments))
}

/// Fails on spaces at line ends and on what a merge left of both sides, in any file of a checkout.
fn no_leftovers(workspace: &Workspace) -> Result<()> {
    /// Git's tree without files: all else differs from it.
    const EMPTY: &str = "4b825dc642cb6eb9a060e54bf8d69288fbee4904";
    if !workspace.path(".git").exists() {
        return Ok(());
    }
    let arguments = ["-c", "core.whitespace=-blank-at-eof", "--no-pager", "diff", "--check", EMPTY];
    shell::run(&mut shell::command(&workspace.root, "git", &arguments))
}

fn portable_tests(workspace: &Workspace, driver: Driver) -> Result<()> {
    let options = TestOptions { driver: Some(driver), portable: true, strict: true, ..TestOptions::default() };
    test::run(workspace, &options)
}

/// The steps so far, with their times.
#[derive(Default)]
struct Steps {
    done: Vec<(&'static str, f64)>,
}

impl Steps {
    fn run(&mut self, name: &'static str, step: impl FnOnce() -> Result<()>) -> Result<()> {
        println!("\n== {name}");
        let start = Instant::now();
        let result = step();
        self.done.push((name, start.elapsed().as_secs_f64()));
        result.map_err(|failure| {
            self.print();
            Failure::Failed(format!("{name}: {failure}"))
        })
    }

    fn print(&self) {
        println!("\n== times");
        for (name, seconds) in &self.done {
            println!("{seconds:8.1} s  {name}");
        }
        println!("{:8.1} s  in all", self.done.iter().map(|(_, seconds)| seconds).sum::<f64>());
    }
}

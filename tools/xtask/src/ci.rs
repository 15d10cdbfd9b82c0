//! What the gate checks, in order, each step timed.

use crate::drivers::Driver;
use crate::failure::{Failure, Result};
use crate::setup::setup;
use crate::test::{self, TestOptions};
use crate::workspace::Workspace;
use crate::{packages, shell};
use std::time::Instant;

/// Runs every step, and stops at the first that fails.
pub fn ci(workspace: &Workspace) -> Result<()> {
    let mut steps = Steps::default();
    steps.run("format", || cargo(workspace, &["fmt", "--all", "--check"]))?;
    steps.run("set-up", || setup(workspace))?;
    steps
        .run("clippy", || cargo(workspace, &["clippy", "--workspace", "--all-targets", "--", "--deny", "warnings"]))?;
    steps.run("rustdoc", || {
        let mut doc = shell::cargo(&workspace.root, &["doc", "--workspace", "--no-deps"]);
        shell::run(doc.env("RUSTDOCFLAGS", "--deny warnings"))
    })?;
    steps.run("tests", || all_tests(workspace))?;
    if packages::is_debian() {
        steps.run("portable tests on lavapipe25", || portable_tests(workspace, Driver::Lavapipe25))?;
        steps.run("portable tests on swiftshader", || portable_tests(workspace, Driver::Swiftshader))?;
    } else {
        println!("skipped: the portable tests on other drivers, which come from Debian's packages");
    }
    steps.print();
    Ok(())
}

fn cargo(workspace: &Workspace, arguments: &[&str]) -> Result<()> {
    shell::run(&mut shell::cargo(&workspace.root, arguments))
}

/// All tests; where scenes are there, none may be skipped for want of one.
fn all_tests(workspace: &Workspace) -> Result<()> {
    let skipped = test::run(workspace, &TestOptions::default())?;
    let without_scene = skipped.iter().filter(|line| line.starts_with("scene\t")).count();
    if without_scene > 0 && test::scenes(workspace).is_some() {
        return Err(Failure::Failed(format!("{without_scene} tests were skipped for want of a scene")));
    }
    Ok(())
}

fn portable_tests(workspace: &Workspace, driver: Driver) -> Result<()> {
    let options = TestOptions { driver: Some(driver), portable: true, ..TestOptions::default() };
    test::run(workspace, &options).map(|_| ())
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

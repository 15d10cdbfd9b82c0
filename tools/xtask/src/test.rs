//! Running the tests on a driver, and counting what ran.

use crate::drivers::{self, Driver};
use crate::failure::{Failure, Result};
use crate::setup::setup;
use crate::workspace::Workspace;
use crate::{programs, shell};
use std::path::PathBuf;
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};
use std::{env, fs};

/// Every driver must pass the tests with this in their names, and all tests of these programs.
const PORTABLE: &str = "portable_";
const PORTABLE_PROGRAMS: &[&str] = &["gpu_device", "gpu_memory", "gpu_pipeline"];

/// What chooses the cases of random tests.
const SEED: &str = "PROPTEST_RNG_SEED";

/// Which tests to run, and on what.
#[derive(Debug, Default, clap::Args)]
pub struct TestOptions {
    /// The Vulkan driver; the system's lavapipe where it is installed.
    #[arg(long)]
    pub driver: Option<Driver>,
    /// Run the ignored tests as well, and many more random cases.
    #[arg(long)]
    pub long: bool,
    /// Run only the tests that every driver must pass.
    #[arg(long)]
    pub portable: bool,
    /// Run only tests whose names contain one of these.
    pub filter: Vec<String>,
    /// A tool that a test needs and that is missing is a failure.
    #[arg(skip)]
    pub strict: bool,
    /// Arguments for the test programs, such as --nocapture.
    #[arg(last = true)]
    pub arguments: Vec<String>,
}

/// What the test programs reported.
#[derive(Debug, Default, PartialEq, Eq)]
struct Tally {
    passed: u32,
    failed: u32,
    ignored: u32,
}

/// Sets up, then runs the tests.
pub fn test(workspace: &Workspace, options: &TestOptions) -> Result<()> {
    setup(workspace)?;
    run(workspace, options)
}

/// Runs the tests, and says what ran and what was skipped.
pub fn run(workspace: &Workspace, options: &TestOptions) -> Result<()> {
    let seed = options.long.then(fresh_seed);
    if let Some(seed) = &seed {
        println!("random cases: {SEED}={seed}");
    }
    let driver = options.driver.unwrap_or_else(default_driver);
    let skipped = SkipList::new(workspace, driver);
    let manifest = driver.manifest(workspace)?;
    let prepare = |command: &mut Command| {
        environment(command, workspace, options);
        command.env("SHADOWGRAPH_SKIPPED", &skipped.path);
        if let Some(seed) = &seed {
            command.env(SEED, seed);
        }
        if let Some(manifest) = &manifest {
            drivers::select(command, manifest);
        }
    };
    let mut tally = Tally::default();
    let programs: Vec<_> = programs::build(workspace)?
        .into_iter()
        .map(|program| {
            let arguments = arguments(options, &program.name);
            (program, arguments)
        })
        .collect();
    let mut succeeded = programs::run(&programs, prepare, |line| tally.add(line));
    if !options.portable {
        let mut examples = shell::cargo(&workspace.root, &["test", "--workspace", "--doc", "--no-fail-fast", "--"]);
        prepare(examples.args(arguments(options, "")));
        succeeded &= shell::run_lines(&mut examples, |line| tally.add(line))?;
    }
    let skipped = skipped.read();
    for line in &skipped {
        println!("skipped: {line}");
    }
    println!(
        "{} passed, {} failed, {} ignored, {} skipped on {}",
        tally.passed,
        tally.failed,
        tally.ignored,
        skipped.len(),
        driver.name()
    );
    if !succeeded {
        return Err(Failure::Failed("tests failed".to_owned()));
    }
    if tally.passed == 0 {
        return Err(Failure::Failed("no test ran: no name contains the filter".to_owned()));
    }
    Ok(())
}

/// Chooses the random cases that no run drew before.
fn fresh_seed() -> String {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_millis().to_string()
}

/// The folder of scenes beside the checkout or named by the user. Where tests are told one, a scene that it lacks is a
/// failure.
fn scenes(workspace: &Workspace) -> Option<PathBuf> {
    if let Some(folder) = env::var_os("SHADOWGRAPH_SCENES") {
        return Some(PathBuf::from(folder));
    }
    let folder = workspace.root.parent()?.join("shared/scenes");
    folder.is_dir().then_some(folder)
}

/// A loader told by the user which driver to load is left alone.
fn default_driver() -> Driver {
    let told =
        ["VK_DRIVER_FILES", "VK_ICD_FILENAMES", "VK_ADD_DRIVER_FILES"].iter().any(|key| env::var_os(key).is_some());
    if told || drivers::system_lavapipe().is_none() { Driver::System } else { Driver::Lavapipe }
}

/// The arguments of a test program.
fn arguments(options: &TestOptions, program: &str) -> Vec<String> {
    let mut arguments = options.filter.clone();
    if options.portable && !PORTABLE_PROGRAMS.contains(&program) {
        arguments.push(PORTABLE.to_owned());
    }
    if options.long {
        arguments.push("--include-ignored".to_owned());
    }
    arguments.extend_from_slice(&options.arguments);
    arguments
}

/// What the tests rely on.
fn environment(command: &mut Command, workspace: &Workspace, options: &TestOptions) {
    command.env("SHADOWGRAPH_VALIDATION", "1");
    if let Some(scenes) = scenes(workspace) {
        command.env("SHADOWGRAPH_SCENES", scenes);
    }
    if options.long {
        command.env("SHADOWGRAPH_LONG", "1");
    }
    if options.strict {
        command.env("SHADOWGRAPH_CI", "1");
    }
}

/// The file to which a test that cannot run adds a line: its name, a colon, and the reason.
struct SkipList {
    path: PathBuf,
}

impl SkipList {
    fn new(workspace: &Workspace, driver: Driver) -> Self {
        let path = workspace.target().join(format!("skipped-{}.txt", driver.name()));
        let _ = fs::remove_file(&path);
        Self { path }
    }

    fn read(&self) -> Vec<String> {
        let text = fs::read_to_string(&self.path).unwrap_or_default();
        let mut lines: Vec<_> = text.lines().map(str::to_owned).collect();
        lines.sort();
        lines.dedup();
        lines
    }
}

impl Tally {
    /// Adds a line of a test program's output, where it is the closing one.
    fn add(&mut self, line: &str) {
        let Some((_, counts)) = line.strip_prefix("test result: ").and_then(|rest| rest.split_once(". ")) else {
            return;
        };
        for count in counts.split("; ") {
            match count.split_once(' ').map(|(number, what)| (number.parse::<u32>(), what)) {
                Some((Ok(number), "passed")) => self.passed += number,
                Some((Ok(number), "failed")) => self.failed += number,
                Some((Ok(number), "ignored")) => self.ignored += number,
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn portable_tests_are_whole_programs_and_names() {
        let portable = TestOptions { portable: true, ..TestOptions::default() };
        assert_eq!(arguments(&TestOptions::default(), "plan_order"), [""; 0]);
        assert_eq!(arguments(&portable, "gpu_device"), [""; 0]);
        assert_eq!(arguments(&portable, "plan_order"), [PORTABLE]);
        for program in PORTABLE_PROGRAMS {
            let file = format!("{}/../../tests/tests/{program}.rs", env!("CARGO_MANIFEST_DIR"));
            assert!(fs::exists(&file).is_ok_and(|exists| exists), "{file}");
        }
    }

    #[test]
    fn closing_lines_are_summed() {
        let mut tally = Tally::default();
        tally.add("running 3 tests");
        tally.add("test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 2 filtered out; finished in 0.01s");
        tally.add("test result: FAILED. 10 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1.00s");
        assert_eq!(tally, Tally { passed: 13, failed: 2, ignored: 1 });
    }

    #[test]
    fn other_lines_count_nothing() {
        let mut tally = Tally::default();
        tally.add("test graph::plan::orders_passes ... ok");
        tally.add("I said: test result: ok. 3 passed");
        assert_eq!(tally, Tally::default());
    }
}

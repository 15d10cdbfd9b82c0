//! Where tests find scenes, and tests that need a process of their own.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Set in a process that [`isolated`] started, to the name of its test.
const ISOLATED: &str = "SHADOWGRAPH_TEST_ISOLATED";
const SCENES: &str = "SHADOWGRAPH_SCENES";

/// The folder with test scenes: `SHADOWGRAPH_SCENES`, else `../shared/scenes` beside the checkout where it exists.
pub fn scenes() -> Option<PathBuf> {
    if let Some(folder) = std::env::var_os(SCENES) {
        return Some(folder.into());
    }
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    beside.is_dir().then_some(beside)
}

/// A scene by its path in the folder of scenes. Without one, prints which scene the test skips; where
/// `SHADOWGRAPH_SCENES` is set and the scene is not there, the test fails.
pub fn require_scene(relative: &str) -> Option<PathBuf> {
    let must = std::env::var_os(SCENES).is_some();
    match find_scene(scenes(), must, relative) {
        Ok(found) => Some(found),
        Err(why) if must => panic!("{why}"),
        Err(why) => {
            skip(&why);
            None
        }
    }
}

/// Says that the running test is skipped, and why: on standard output, and in the list that `cargo xtask test` prints at
/// its end (a line in the file that `SHADOWGRAPH_SKIPPED` names).
pub fn skip(why: &str) {
    println!("skipped: {why}");
    let Some(list) = std::env::var_os("SHADOWGRAPH_SKIPPED") else { return };
    let thread = std::thread::current();
    let line = format!("{}: {why}\n", thread.name().unwrap_or("a test"));
    let mut options = std::fs::OpenOptions::new();
    let written = options.create(true).append(true).open(&list).and_then(|mut file| file.write_all(line.as_bytes()));
    written.unwrap_or_else(|error| panic!("cannot write {}: {error}", list.display()));
}

fn find_scene(folder: Option<PathBuf>, must: bool, relative: &str) -> Result<PathBuf, String> {
    let Some(folder) = folder else {
        return Err(format!("scene {relative}: no folder of scenes; {SCENES} names one"));
    };
    let path = folder.join(relative);
    if path.is_file() {
        return Ok(path);
    }
    let by = if must { format!(", named by {SCENES}") } else { String::new() };
    Err(format!("scene {relative} is not in {}{by}", folder.display()))
}

/// Whether this is the long run, `cargo xtask test --long`.
pub fn is_long() -> bool {
    std::env::var_os("SHADOWGRAPH_LONG").is_some_and(|value| value != "0")
}

/// Whether tests write the book's figures.
pub fn writes_figures() -> bool {
    std::env::var_os("SHADOWGRAPH_FIGURES").is_some_and(|wish| wish == "write")
}

/// Whether sweeps run whole, to their finest cases: in the long run, and where they write the book's figures.
pub fn is_whole() -> bool {
    is_long() || writes_figures()
}

/// Runs the body of test `name` in a process of its own, so that messages, leaks and environment are its alone, and
/// gives back what it printed.
///
/// `name` is the test's name as the test binary lists it, with modules (`folder::test`). The binary runs again with
/// that one test; there this function runs `body`. Panics where the test fails there, or does not exist.
pub fn isolated(name: &str, body: impl FnOnce()) -> String {
    isolated_with(name, &[], body)
}

/// [`isolated`], with variables set in the environment of the process.
pub fn isolated_with(name: &str, variables: &[(&str, &str)], body: impl FnOnce()) -> String {
    let mark = format!("isolated test {name} is done");
    if std::env::var(ISOLATED).is_ok_and(|running| running == name) {
        body();
        println!("{mark}");
        return String::new();
    }

    let program = std::env::current_exe().expect("a running program has a path");
    let output = Command::new(&program)
        .args([name, "--exact", "--nocapture", "--include-ignored", "--test-threads=1"])
        .env(ISOLATED, name)
        .envs(variables.iter().copied())
        .output()
        .unwrap_or_else(|error| panic!("cannot run {} again for {name}: {error}", program.display()));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (printed, errors) = (text(&output.stdout), text(&output.stderr));
    assert!(
        output.status.success() && printed.contains(&mark),
        "{name}, in a process of its own: {}{}\n--- printed\n{printed}\n--- errors\n{errors}",
        output.status,
        if output.status.success() { "; no test of this name ran to its end" } else { "" },
    );
    print!("{printed}");
    eprint!("{errors}");
    printed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_found_skipped_or_missed_by_name() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.glb"), "").unwrap();
        let find = |relative| find_scene(Some(folder.path().into()), true, relative);
        assert_eq!(find("a.glb").unwrap(), folder.path().join("a.glb"));
        assert!(find("b/b.glb").unwrap_err().contains("scene b/b.glb is not in"));
        assert!(find("b/b.glb").unwrap_err().contains(SCENES));
        assert!(find_scene(None, false, "c.glb").unwrap_err().contains("c.glb"));
    }

    #[test]
    fn an_isolated_test_has_a_process_of_its_own() {
        let outer = std::process::id();
        let name = "harness::tests::an_isolated_test_has_a_process_of_its_own";
        let printed = isolated_with(name, &[("SHADOWGRAPH_TEST_VALUE", "seen")], || {
            println!("process {} {:?}", std::process::id(), std::env::var("SHADOWGRAPH_TEST_VALUE"));
        });
        if !printed.is_empty() {
            assert!(printed.contains("Ok(\"seen\")") && !printed.contains(&format!("process {outer} ")), "{printed}");
        }
    }

    #[test]
    #[should_panic(expected = "this must be told")]
    fn an_isolated_test_that_fails_fails() {
        isolated("harness::tests::an_isolated_test_that_fails_fails", || {
            // `should_panic` holds for the inner process too: only an exit fails it.
            println!("this must be told");
            std::process::exit(3);
        });
    }

    #[test]
    #[should_panic(expected = "no test of this name")]
    fn an_isolated_test_that_does_not_exist_fails() {
        isolated("harness::tests::nothing_of_this_name", || ());
    }
}

//! The workspace's test programs: built, found, and run side by side.

use crate::failure::Result;
use crate::shell;
use crate::workspace::Workspace;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::{io, thread};

/// Programs that run at once. A test keeps the cores busy while it renders or casts rays, and one of them otherwise: a
/// second program fills the gaps.
const AT_ONCE: usize = 2;

/// A test program.
#[derive(Debug, PartialEq, Eq)]
pub struct Program {
    /// What cargo calls it.
    pub name: String,
    path: PathBuf,
    /// Its package's, where tests expect to run.
    folder: PathBuf,
}

/// Builds every test program.
pub fn build(workspace: &Workspace) -> Result<Vec<Program>> {
    let arguments = ["test", "--workspace", "--no-run", "--message-format", "json-render-diagnostics"];
    let built = shell::piped(&mut shell::cargo(&workspace.root, &arguments))?;
    Ok(built.lines().filter_map(Program::find).collect())
}

/// Runs programs, each with arguments, prints what each printed when it ends, and hands each line of that to `line`.
/// Gives whether all succeeded.
pub fn run(
    programs: &[(Program, Vec<String>)],
    prepare: impl Fn(&mut Command) + Sync,
    line: impl FnMut(&str) + Send,
) -> bool {
    let waiting = Mutex::new(programs.iter());
    let sink = Mutex::new((line, true));
    let next = || lock(&waiting).next();
    let work = || {
        while let Some((program, arguments)) = next() {
            let mut command = program.command();
            prepare(command.args(arguments));
            let (text, success) = merged_output(command).unwrap_or_else(|error| (format!("{error}\n"), false));
            let mut sink = lock(&sink);
            println!("> {}", program.name);
            print!("{text}");
            text.lines().for_each(&mut sink.0);
            if !success {
                println!("{} failed", program.path.display());
                sink.1 = false;
            }
        }
    };
    thread::scope(|scope| (0..AT_ONCE).for_each(|_| drop(scope.spawn(work))));
    lock(&sink).1
}

/// What a thread that panicked left behind still counts.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Program {
    /// The test program that a line of cargo's messages names.
    fn find(line: &str) -> Option<Self> {
        let (_, profile) = line.split_once("\"profile\":{")?;
        let (profile, _) = profile.split_once('}')?;
        if !profile.contains("\"test\":true") {
            return None;
        }
        let path = PathBuf::from(text_of(line, "executable")?);
        let folder = Path::new(&text_of(line, "manifest_path")?).parent()?.to_owned();
        let (name, _hash) = path.file_stem()?.to_str()?.rsplit_once('-')?;
        Some(Self { name: name.to_owned(), path, folder })
    }

    fn command(&self) -> Command {
        let mut command = Command::new(&self.path);
        command.current_dir(&self.folder).env("CARGO_MANIFEST_DIR", &self.folder);
        command
    }
}

/// A text of a JSON object on one line. Paths have no other escapes than those of backslashes.
fn text_of(line: &str, key: &str) -> Option<String> {
    let (_, rest) = line.split_once(&format!("\"{key}\":\""))?;
    Some(rest.split_once('"')?.0.replace("\\\\", "\\"))
}

/// What a command prints, errors in their places, and whether it succeeds.
fn merged_output(mut command: Command) -> io::Result<(String, bool)> {
    let (mut reader, writer) = io::pipe()?;
    let mut child = command.stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer).spawn()?;
    // It holds ends to write to, which would keep the reader waiting.
    drop(command);
    let mut bytes = Vec::new();
    reader.read_to_end(&mut bytes)?;
    Ok((String::from_utf8_lossy(&bytes).into_owned(), child.wait()?.success()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEST: &str = r#"{"reason":"compiler-artifact","package_id":"path+file:///p/tests#0.1.0","manifest_path":"/p/tests/Cargo.toml","target":{"kind":["test"],"crate_types":["bin"],"name":"gpu_device","src_path":"/p/tests/tests/gpu_device.rs","edition":"2024","doc":false,"doctest":false,"test":true},"profile":{"opt_level":"1","debuginfo":"line-tables-only","debug_assertions":true,"overflow_checks":true,"test":true},"features":[],"filenames":["/p/target/debug/deps/gpu_device-0c5b"],"executable":"/p/target/debug/deps/gpu_device-0c5b","fresh":true}"#;

    #[test]
    fn a_test_program_is_found_with_its_folder() {
        let expected = Program {
            name: "gpu_device".into(),
            path: "/p/target/debug/deps/gpu_device-0c5b".into(),
            folder: "/p/tests".into(),
        };
        assert_eq!(Program::find(TEST), Some(expected));
    }

    #[test]
    fn libraries_and_programs_themselves_are_none() {
        assert_eq!(Program::find(&TEST.replace(r#""test":true},"features""#, r#""test":false},"features""#)), None);
        assert_eq!(
            Program::find(&TEST.replace(r#""/p/target/debug/deps/gpu_device-0c5b","fresh""#, r#"null,"fresh""#)),
            None
        );
        assert_eq!(Program::find(r#"{"reason":"build-finished","success":true}"#), None);
    }

    #[test]
    fn what_programs_print_and_how_they_end_comes_back() {
        // `cargo --version` stands for a test program that passes, an unknown option for one that fails.
        let cargo = || PathBuf::from(env!("CARGO"));
        let program = |name: &str| Program { name: name.into(), path: cargo(), folder: ".".into() };
        let run_with = |arguments: &[&str]| {
            let programs: Vec<_> =
                arguments.iter().map(|argument| (program(argument), vec![(*argument).to_owned()])).collect();
            let mut lines = Vec::new();
            let success = run(&programs, |_| (), |line| lines.push(line.to_owned()));
            (success, lines)
        };
        let (success, lines) = run_with(&["--version", "--version", "--version"]);
        assert!(success && lines.len() == 3 && lines.iter().all(|line| line.starts_with("cargo ")), "{lines:?}");
        let (success, lines) = run_with(&["--version", "--no-such-option"]);
        assert!(!success && lines.iter().any(|line| line.contains("--no-such-option")), "{lines:?}");
    }
}

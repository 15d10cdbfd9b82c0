//! Whole captures, each in a process of its own: what a user waits for.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio, id};

use crate::cache;
use crate::cli::BenchArguments;
use crate::failure::{Failure, Result};
use crate::phases::{Report, unix_seconds};

use super::{Measurement, median};

/// Cold: an empty cache folder each time. Warm: one that a run before has filled.
pub fn run(arguments: &BenchArguments, tell: &mut impl FnMut(Measurement) -> Result<()>) -> Result<()> {
    let folder = Folder::new()?;
    let warm = folder.0.join("warm");
    once(arguments, &folder.0, &warm)?;
    for case in ["cold", "warm"].into_iter().filter(|case| arguments.wants(case)) {
        let mut runs = Vec::new();
        for number in 0..arguments.runs {
            let cache = if case == "cold" { folder.0.join(format!("cold{number}")) } else { warm.clone() };
            runs.push(once(arguments, &folder.0, &cache)?);
        }
        for (metric, value) in medians(&runs) {
            tell(Measurement { bench: "capture", case: case.into(), metric, value: value * 1e3, unit: "ms" })?;
        }
    }
    Ok(())
}

/// Name and seconds of each phase of one run, process start and total included.
type Run = Vec<(String, f64)>;

fn once(arguments: &BenchArguments, folder: &Path, cache: &Path) -> Result<Run> {
    fs::create_dir_all(cache).map_err(|error| shadowgraph::Error::io("create", cache, error))?;
    let program = std::env::current_exe().map_err(Failure::failed)?;
    let mut command = Command::new(program);
    command
        .args(["capture", &arguments.scene.to_string(), "--size", &arguments.size.to_string(), "--phases", "--output"])
        .arg(folder.join("frame.exr"))
        .env(cache::FOLDER_VARIABLE, cache)
        .env_remove(cache::DRIVER_VARIABLE)
        .stderr(Stdio::inherit());
    let before = unix_seconds();
    let output = command.output().map_err(Failure::failed)?;
    if !output.status.success() {
        let failure = format!("the capture ended with {}", output.status);
        // What was bad for the capture is bad for the benchmark.
        return Err(if output.status.code() == Some(2) { Failure::input(failure) } else { Failure::failed(failure) });
    }
    let report: Report = serde_json::from_slice(&output.stdout).map_err(Failure::failed)?;
    let start = (report.began - before).max(0.0);
    // The second frame was rendered for the sake of measuring; a user does not wait for it.
    let again = report.phases.iter().find(|(name, _)| name == "rendering").map_or(0.0, |(_, time)| *time);
    let mut run = vec![("process start".to_string(), start)];
    run.extend(report.phases);
    run.push(("total".to_string(), start + report.total - again));
    Ok(run)
}

/// Median of each phase, in the order of the first run.
fn medians(runs: &[Run]) -> Run {
    let Some(first) = runs.first() else { return Vec::new() };
    let of = |name: &str| {
        let times = runs.iter().flatten().filter(|(n, _)| n == name).map(|(_, time)| *time);
        median(times.collect())
    };
    first.iter().map(|(name, _)| (name.clone(), of(name))).collect()
}

/// A folder for one benchmark, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Result<Self> {
        let path = std::env::temp_dir().join(format!("shadowgraph-bench-{}", id()));
        fs::create_dir_all(&path).map_err(|error| shadowgraph::Error::io("create", &path, error))?;
        Ok(Self(path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if let Err(error) = fs::remove_dir_all(&self.0) {
            log::warn!("cannot remove {}: {error}", self.0.display());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_keep_their_order_and_take_medians() {
        let run = |a: f64, b: f64| vec![("b".to_string(), b), ("a".to_string(), a)];
        let medians = medians(&[run(1.0, 5.0), run(3.0, 4.0), run(2.0, 9.0)]);
        assert_eq!(medians, vec![("b".to_string(), 5.0), ("a".to_string(), 2.0)]);
    }
}

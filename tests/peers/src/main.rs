//! What a pass costs on the host: the same chain of compute passes by hand and with several render graphs.
//!
//! A chain clears image 0; pass `i` reads image `i` and writes image `i + 1`, one more, 64×64 texels of RGBA8. Every
//! frame records its commands anew, with other push constants, and the texel that it reads back is checked.
//!
//! Each measurement has a process of its own, and repetitions are interleaved: what else the machine does falls on all
//! of them.

mod chains;
mod measure;
mod shader;

use std::process::{Command, ExitCode};

use crate::chains::{CASES, Case};
use crate::measure::{Result, measure, median};

const USAGE: &str = "usage: shadowgraph-peers [--passes 10,100,1000] [--frames N] [--repetitions N] [--only PART]...";

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<()> {
    let mut passes = vec![10, 100, 1000];
    let (mut frames, mut repetitions) = (59, 5);
    let mut only: Vec<String> = Vec::new();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let value = arguments.next().ok_or(USAGE)?;
        match argument.as_str() {
            "--passes" => passes = value.split(',').map(str::parse).collect::<std::result::Result<_, _>>()?,
            "--frames" => frames = value.parse()?,
            "--repetitions" => repetitions = value.parse()?,
            "--only" => only.push(value),
            "--case" => return run_case(&value, passes[0], frames),
            _ => return Err(USAGE.into()),
        }
    }
    let wanted = |case: &&Case| only.is_empty() || only.iter().any(|part| case.name.contains(part.as_str()));
    let cases: Vec<_> = CASES.iter().filter(wanted).collect();
    for &passes in &passes {
        compare(&cases, passes, frames, repetitions)?;
    }
    Ok(())
}

/// Runs every case in turn, so many times.
fn compare(cases: &[&Case], passes: u32, frames: u32, repetitions: u32) -> Result<()> {
    let mut found = vec![Vec::new(); cases.len()];
    for _ in 0..repetitions {
        for (case, found) in cases.iter().zip(&mut found) {
            found.push(in_own_process(case, passes, frames)?);
        }
    }
    for (case, found) in cases.iter().zip(found) {
        let of = |field: &str| -> Vec<f64> { found.iter().filter_map(|line| line[field].as_f64()).collect() };
        let tell = |metric: &str, value: f64, unit: &str| {
            let case = format!("{}, {passes}", case.name);
            println!(
                "{}",
                serde_json::json!({ "bench": "peers", "case": case, "metric": metric, "value": value, "unit": unit })
            );
        };
        let each = f64::from(passes);
        tell("cpu, thread", median(&of("thread")) / each, "us/pass");
        tell("cpu, thread, least", of("least").into_iter().fold(f64::INFINITY, f64::min) / each, "us/pass");
        tell("cpu, process", median(&of("process")) / each, "us/pass");
        if let Some(&bytes) = of("bytes").first() {
            tell("transient memory", bytes / 1024.0, "KiB");
        }
    }
    Ok(())
}

/// Runs this program for one case, and reads the line that it prints.
fn in_own_process(case: &Case, passes: u32, frames: u32) -> Result<serde_json::Value> {
    let arguments = ["--passes", &passes.to_string(), "--frames", &frames.to_string(), "--case", case.name];
    let output = Command::new(std::env::current_exe()?).args(arguments).output()?;
    if !output.status.success() {
        let why = String::from_utf8_lossy(&output.stderr);
        return Err(format!("{} of {passes} passes: {}: {why}", case.name, output.status).into());
    }
    let text = String::from_utf8(output.stdout)?;
    Ok(serde_json::from_str(text.lines().last().unwrap_or_default())?)
}

/// Measures one case, and prints one line.
fn run_case(name: &str, passes: u32, frames: u32) -> Result<()> {
    let case = CASES.iter().find(|case| case.name == name).ok_or("there is no such case")?;
    let mut chain = (case.open)(passes)?;
    let times = measure(chain.as_mut(), passes, frames)?;
    let least = times.thread.iter().copied().fold(f64::INFINITY, f64::min);
    let [thread, process] = [&times.thread, &times.process].map(|times| median(times));
    let bytes = chain.transient_bytes();
    println!("{}", serde_json::json!({ "thread": thread, "least": least, "process": process, "bytes": bytes }));
    Ok(())
}

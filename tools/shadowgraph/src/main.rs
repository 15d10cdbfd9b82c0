//! Captures frames of glTF scenes as multi-layer OpenEXR. See `shadowgraph --help`.
#![deny(unsafe_code)]

mod arguments;
mod bench;
mod cache;
mod capture;
mod cli;
mod debug;
mod failure;
mod graph;
mod info;
mod logger;
mod output;
mod phases;
mod session;
mod view;
mod voxelize;

use std::process::ExitCode;

use clap::Parser;

use cli::{Cli, Command};

fn main() -> ExitCode {
    let started = phases::Start::now();
    // 1. Before any thread starts: where the driver keeps compiled shaders.
    cache::set_driver_folder();
    // 2. What is wanted; bad usage ends here, with exit code 2.
    let cli = Cli::parse();
    logger::start(cli.verbose);
    // 3. Do it.
    let done = match &cli.command {
        Command::Capture(arguments) => capture::run(arguments, started),
        Command::Graph(arguments) => graph::run(arguments),
        Command::Voxelize(arguments) => voxelize::run(arguments),
        Command::Info(arguments) => info::run(arguments),
        Command::Bench(arguments) => bench::run(arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

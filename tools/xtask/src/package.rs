//! Packing the engine for dependants without a shader compiler.

use crate::failure::{Failure, Result};
use crate::workspace::Workspace;

/// How to pack.
#[derive(Debug, clap::Args)]
pub struct PackageOptions {
    /// Also build a program outside the workspace against the package, and run it.
    #[arg(long)]
    pub check: bool,
}

pub fn package(_workspace: &Workspace, _options: &PackageOptions) -> Result<()> {
    Err(Failure::Failed("not yet".to_owned()))
}

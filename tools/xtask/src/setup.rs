//! Making a machine ready to build and test.

use crate::failure::Result;
use crate::workspace::Workspace;
use crate::{archive, packages};

/// Installs what is missing; after it a plain `cargo build` works.
pub fn setup(workspace: &Workspace) -> Result<()> {
    install(workspace, packages::PACKAGES)
}

/// Installs what is missing for all that the gate checks.
pub fn setup_gate(workspace: &Workspace) -> Result<()> {
    install(workspace, &[packages::PACKAGES, packages::GATE_PACKAGES].concat())
}

fn install(workspace: &Workspace, wanted: &[&'static str]) -> Result<()> {
    if !packages::is_debian() {
        archive::print_alternatives();
        return Ok(());
    }
    let missing = packages::missing(wanted)?;
    if !missing.is_empty() {
        packages::install(&missing)?;
    }
    archive::merge(workspace)
}

//! Making a machine ready to build and test.

use crate::failure::Result;
use crate::workspace::Workspace;
use crate::{archive, packages};

/// Installs what is missing; after it a plain `cargo build` works.
pub fn setup(workspace: &Workspace) -> Result<()> {
    if !packages::is_debian() {
        archive::print_alternatives();
        return Ok(());
    }
    let missing = packages::missing(packages::PACKAGES)?;
    if !missing.is_empty() {
        packages::install(&missing)?;
    }
    archive::merge(workspace)
}

//! Making a new technique.

use crate::failure::{Failure, Result};
use crate::workspace::Workspace;

/// The name of a technique.
#[derive(Debug, clap::Args)]
pub struct TechniqueName {
    /// The family: shadow, transparency, voxel, …
    pub family: String,
    /// The technique's name in its family, in `snake_case`.
    pub name: String,
}

pub fn new_technique(_workspace: &Workspace, _name: &TechniqueName) -> Result<()> {
    Err(Failure::Failed("not yet".to_owned()))
}

//! Scenes made in code: no files, the same bytes on every run.

mod cornell;
pub mod shapes;

use crate::{
    error::{Error, Result},
    scene::Scene,
};

pub use cornell::cornell;

/// Names that [`Scene::builtin`] knows.
pub const NAMES: [&str; 1] = ["cornell"];

impl Scene {
    /// A scene made in code, by its name (one of [`NAMES`]).
    ///
    /// # Errors
    /// [`Error::Invalid`] for another name; it lists the names that are there.
    pub fn builtin(name: &str) -> Result<Self> {
        match name {
            "cornell" => Ok(cornell()),
            _ => Err(Error::invalid(
                format!("built-in scene {name:?}"),
                format!("there is none of this name; there are {}", NAMES.join(", ")),
            )),
        }
    }
}

//! Scenes made in code: no files, the same bytes on every run.

mod cornell;
mod courtyard;
mod paint;
mod random;
mod shapes;

use crate::{
    error::{Error, Result},
    scene::Scene,
};

pub use cornell::cornell;
pub use courtyard::courtyard;

/// Names that [`Scene::builtin`] knows.
pub const NAMES: [&str; 2] = ["cornell", "courtyard"];

impl Scene {
    /// A scene made in code, by its name (one of [`NAMES`]).
    ///
    /// # Errors
    /// [`Error::Invalid`] for another name; it lists the names that are there.
    pub fn builtin(name: &str) -> Result<Self> {
        match name {
            "cornell" => Ok(cornell()),
            "courtyard" => Ok(courtyard()),
            _ => Err(Error::invalid(
                format!("built-in scene {name:?}"),
                format!("there is none of this name; there are {}", NAMES.join(", ")),
            )),
        }
    }
}

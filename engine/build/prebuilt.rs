//! The prebuilt set: `shaders.rs`, `spv/**` and `manifest.txt`, as a build with `compile-shaders` leaves them.
//!
//! The manifest's first line is `sources HASH`, the hash of the GLSL tree; then a line `HASH PATH` a shader.

use std::collections::BTreeSet;
use std::path::Path;

use crate::files;
use crate::source::{ROOT, Tree};

/// Rust that names every shader.
pub const CODE: &str = "shaders.rs";
/// Folder of SPIR-V.
pub const SPIRV: &str = "spv";
/// List of what is there.
pub const MANIFEST: &str = "manifest.txt";

/// Copies a set from one folder to another; files of an older set that are no longer in it go.
pub fn copy(from: &Path, to: &Path) -> Result<(), String> {
    let spirv: BTreeSet<String> = files::list(&from.join(SPIRV))?.into_iter().collect();
    for file in &spirv {
        files::write_if_changed(&to.join(SPIRV).join(file), &files::read(&from.join(SPIRV).join(file))?)?;
    }
    files::keep_only(&to.join(SPIRV), &spirv)?;
    for file in [CODE, MANIFEST] {
        files::write_if_changed(&to.join(file), &files::read(&from.join(file))?)?;
    }
    Ok(())
}

/// Puts a prebuilt set in place of compilation. Where `sources` is there as well, it must be what the set was made of.
pub fn restore(prebuilt: &Path, sources: &Path, out: &Path) -> Result<(), Vec<String>> {
    let Ok(manifest) = std::fs::read_to_string(prebuilt.join(MANIFEST)) else {
        return Err(vec![if sources.is_dir() {
            "no compiled shaders: build with `--features compile-shaders` (in a checkout, `cargo xtask setup` installs \
             what that needs)"
                .into()
        } else {
            format!(
                "no compiled shaders in {} and no GLSL in {}: use a published package, or a whole checkout with \
                 `--features compile-shaders`",
                prebuilt.display(),
                sources.display()
            )
        }]);
    };
    if sources.is_dir() {
        let made_of = manifest.lines().next().and_then(|line| line.strip_prefix("sources "));
        if made_of != Some(Tree::read(sources)?.hash().as_str()) {
            return Err(vec![format!(
                "{ROOT}/ has changed since {} was made: build with `--features compile-shaders`, or make that folder anew \
                 or remove it",
                prebuilt.display()
            )]);
        }
    }
    copy(prebuilt, out).map_err(|problem| vec![problem])
}

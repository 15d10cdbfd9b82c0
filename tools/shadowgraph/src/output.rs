//! Standard output, and files to write.

use std::io::{self, Write};
use std::path::Path;

use crate::failure::{Failure, Result};

/// Prints a text and a line feed. A reader that has gone away (`| head`) is no failure.
pub fn print(text: impl std::fmt::Display) -> Result<()> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(Failure::failed),
    }
}

/// Refuses, before any work is done, the name of a file that would mislead, or one in a folder that is not there.
pub fn check_name(option: &str, path: &Path, ends: &[&str]) -> Result<()> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    if !ends.iter().any(|end| name.ends_with(end) && name != *end) {
        let ends = ends.join(", ");
        return Err(Failure::input(format!("{option} {}: the name must end in {ends}", path.display())));
    }
    check_folder(option, path)
}

/// Refuses, before any work is done, a file in a folder that is not there.
pub fn check_folder(option: &str, path: &Path) -> Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(Failure::input(format!("{option} {}: there is no such folder", path.display())));
    }
    Ok(())
}

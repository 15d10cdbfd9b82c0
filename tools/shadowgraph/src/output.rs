//! Standard output.

use std::io::{self, Write};

use crate::failure::{Failure, Result};

/// Prints a text and a line feed. A reader that has gone away (`| head`) is no failure.
pub fn print(text: impl std::fmt::Display) -> Result<()> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(Failure::failed),
    }
}

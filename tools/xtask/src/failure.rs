//! Why a task stopped, and the exit code that says so.

use std::fmt;
use std::path::Path;

/// A task that stopped.
#[derive(Debug)]
pub enum Failure {
    /// Something that ran has failed: exit code 1.
    Failed(String),
    /// The user has to do something first, or asked for something that cannot be: exit code 2.
    Usage(String),
}

/// What a task gives.
pub type Result<T> = std::result::Result<T, Failure>;

impl Failure {
    /// A failure to do `what` with the file or folder at `path`.
    pub fn io(what: &str, path: &Path, error: &std::io::Error) -> Self {
        Self::Failed(format!("cannot {what} {}: {error}", path.display()))
    }

    /// 1 for a failure, 2 for bad usage.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Failed(_) => 1,
            Self::Usage(_) => 2,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Failed(text) | Self::Usage(text) => formatter.write_str(text),
        }
    }
}

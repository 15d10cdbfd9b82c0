//! One error type for the whole engine. Every variant names the thing that failed and what would work.

use std::path::PathBuf;

use ash::vk;

/// Result of everything in this crate that can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What failed, where, and what would work.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No Vulkan loader, or no device that fits.
    #[error("no usable Vulkan device: {why}; {hint}")]
    NoDevice {
        /// What was looked for and what was found.
        why: String,
        /// What would help.
        hint: String,
    },

    /// The device lacks features that the engine needs.
    #[error("{device} lacks what {who} needs: {}", missing.join(", "))]
    Missing {
        /// Device name and driver.
        device: String,
        /// The engine, or the technique that asked.
        who: String,
        /// Every missing feature, extension or limit.
        missing: Vec<String>,
    },

    /// A Vulkan call failed.
    #[error("{call} failed for {object}: {result}")]
    Vulkan {
        /// Name of the Vulkan command.
        call: &'static str,
        /// Debug name of the object it was called for.
        object: String,
        /// What Vulkan answered.
        result: vk::Result,
    },

    /// The device was lost.
    #[error("the device was lost; the last pass that began is {last_pass:?}")]
    DeviceLost {
        /// Name of the last pass that began, where one did.
        last_pass: Option<String>,
    },

    /// Memory for a resource could not be had.
    #[error("no memory for {object} ({bytes} bytes): {why}")]
    OutOfMemory {
        /// Debug name of the resource.
        object: String,
        /// Bytes asked for.
        bytes: u64,
        /// What the allocator said.
        why: String,
    },

    /// The render graph is wrong; all its errors at once.
    #[error("{0}")]
    Graph(#[from] crate::graph::GraphErrors),

    /// A scene file is wrong or asks for what is not supported.
    #[error("{}: {place}: {what}", file.display())]
    Scene {
        /// The file.
        file: PathBuf,
        /// Where in it (a JSON path, or the name of a mesh, material, …).
        place: String,
        /// What is wrong and what is allowed.
        what: String,
    },

    /// A file could not be read or written.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// `read`, `write`, `create`, …
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },

    /// A value given by the caller does not fit.
    #[error("{what}: {why}")]
    Invalid {
        /// The argument or setting.
        what: String,
        /// What is wrong and what is allowed.
        why: String,
    },
}

impl Error {
    /// An [`Error::Invalid`].
    pub fn invalid(what: impl Into<String>, why: impl Into<String>) -> Self {
        Self::Invalid { what: what.into(), why: why.into() }
    }

    /// An [`Error::Io`].
    pub fn io(action: &'static str, path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::Io { action, path: path.into(), source }
    }
}

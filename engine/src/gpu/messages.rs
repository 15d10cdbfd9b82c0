//! Where validation messages go.

use std::sync::Mutex;

/// How grave a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Output of `debugPrintfEXT` in shaders.
    Info,
    /// Likely a mistake.
    Warning,
    /// Against the specification.
    Error,
}

/// One message of the validation layer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// How grave it is.
    pub severity: Severity,
    /// Its identifier: `VUID-…` or `SYNC-HAZARD-…`.
    pub id_name: String,
    /// The layer's own words.
    pub text: String,
    /// Debug names of the objects concerned, with their kinds; the handle in hexadecimal where one has no name.
    pub objects: Vec<String>,
    /// Names of the passes concerned (command buffer labels), innermost first.
    pub labels: Vec<String>,
}

/// Collects validation messages; they are logged too.
#[derive(Debug, Default)]
pub struct Messages {
    list: Mutex<Vec<Message>>,
}

impl Messages {
    /// All messages since the last call, in order.
    pub fn take(&self) -> Vec<Message> {
        unimplemented!()
    }

    /// How many wait to be taken.
    pub fn len(&self) -> usize {
        unimplemented!()
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

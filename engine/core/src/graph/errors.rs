//! What can be wrong with a description.

use std::fmt;

/// All that is wrong with a graph, found in one go. Printed one error a line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct GraphErrors {
    /// Name of the graph.
    pub graph: String,
    /// At least one.
    pub errors: Vec<GraphError>,
}

/// One thing that is wrong: where, what, and what is allowed.
#[derive(Clone, Debug, PartialEq)]
pub struct GraphError {
    /// Its kind.
    pub kind: ErrorKind,
    /// Name of the pass.
    pub pass: Option<String>,
    /// What the pass calls the resource.
    pub slot: Option<String>,
    /// Name of the resource.
    pub resource: Option<String>,
    /// What is wrong.
    pub wrong: String,
    /// What is allowed.
    pub allowed: String,
}

/// Kind of a graph error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// An id that the description does not have, or that belongs to another resource or pass.
    UnknownId,
    /// Two passes or two resources of one name.
    DuplicateName,
    /// An extent, size or count that cannot be.
    BadShape,
    /// A range outside its resource, empty, or of the wrong kind.
    BadRange,
    /// A resource whose initial version is missing, doubled or not whole.
    BadInitial,
    /// A version made from one recorded later, or whose range does not follow from its source.
    BadVersion,
    /// A pass that neither uses anything nor has a side effect.
    EmptyPass,
    /// Contents that matter but that nobody wrote.
    ReadBeforeWrite,
    /// A version replaced by two passes.
    TwoWriters,
    /// Parts of one version that overlap and are both written.
    OverlappingSplits,
    /// Parts put together that leave a gap, or hold the same part twice.
    BadJoin,
    /// Unordered writers that are read before they are joined, or that write by other means than storage accesses.
    BadFork,
    /// A use that writes without making a version, or makes one without writing.
    WriteMismatch,
    /// A use that the format, the kind of resource or the device does not allow.
    WrongUsage,
    /// A use that the pass's queue cannot do.
    WrongQueue,
    /// Two uses in one pass that do not go together.
    ConflictingUses,
    /// A state that an imported resource cannot arrive or be left in.
    BadImport,
    /// A root that nobody writes.
    EmptyRoot,
    /// A root that is to be kept but written over.
    OverwrittenRoot,
    /// Passes that wait for one another in a circle.
    Cycle,
    /// A checkpoint that cuts through a pass, or that somebody would have to look behind.
    BadCheckpoint,
    /// A history that is declared twice, written where it is to be read, or written in part.
    History,
    /// What a technique was asked for and cannot do: of these inputs, or on this device.
    Refused,
    /// A binding or an attachment that a shader lacks or that was left out, or a handle of another graph.
    Binding,
}

impl fmt::Display for GraphErrors {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let count = self.errors.len();
        write!(f, "graph `{}` has {count} error{}:", self.graph, if count == 1 { "" } else { "s" })?;
        self.errors.iter().try_for_each(|error| write!(f, "\n  {error}"))
    }
}

impl fmt::Display for GraphError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let places = [("pass", &self.pass), ("slot", &self.slot), ("resource", &self.resource)];
        let places = places.iter().filter_map(|(what, name)| name.as_ref().map(|name| format!("{what} `{name}`")));
        let places = places.collect::<Vec<_>>().join(", ");
        write!(f, "{places}{}{}; {}", if places.is_empty() { "" } else { ": " }, self.wrong, self.allowed)
    }
}

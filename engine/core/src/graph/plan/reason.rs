//! Why a barrier stands, and why a pass does not run.

use super::Work;
use crate::graph::description::{Description, PassId, ResourceId};

/// Why a barrier stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reason {
    /// What would go wrong without it.
    pub hazard: Hazard,
    /// The resource it is for.
    pub resource: Option<ResourceId>,
    /// The last user before it; `None`: what came before the frame.
    pub before: Option<Work>,
    /// The first user after it; `None`: what comes after the frame.
    pub after: Option<Work>,
}

/// What a barrier prevents or does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Hazard {
    /// A read sees the write before it.
    ReadAfterWrite,
    /// A write waits for the reads before it.
    WriteAfterRead,
    /// A write comes after the write before it.
    WriteAfterWrite,
    /// A read in another layout than the reads before it.
    Layout,
    /// First use of undefined contents: an image gets a layout.
    First,
    /// The memory had another tenant before.
    Alias {
        /// The other tenant.
        old: ResourceId,
    },
    /// Given to or taken from another queue family.
    Ownership,
    /// An imported resource gets its final state.
    Final,
    /// The host reads what was copied to it.
    Host,
}

/// Why a pass does not run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CullReason {
    /// It writes nothing and has no side effect.
    WritesNothing,
    /// Nobody reads what it writes, and no root needs it.
    Unread {
        /// What it writes.
        resources: Vec<ResourceId>,
    },
    /// Another pass writes over it before anybody reads it.
    Overwritten {
        /// What it writes.
        resource: ResourceId,
        /// The other pass.
        by: PassId,
    },
    /// Only passes that do not run either read what it writes.
    OnlyCulledRead {
        /// What it writes.
        resource: ResourceId,
        /// One that reads it.
        reader: PassId,
    },
}

impl Reason {
    /// In words.
    pub fn explain(&self, description: &Description) -> String {
        let resource = self.resource.map_or_else(String::new, |id| quoted_resource(description, id));
        let before = self.before.map_or("what came before the frame".into(), |work| work.describe(description));
        let after = self.after.map_or("what comes after the frame".into(), |work| work.describe(description));
        match self.hazard {
            Hazard::ReadAfterWrite => format!("read after write: {after} reads {resource}, written by {before}"),
            Hazard::WriteAfterRead => format!("write after read: {after} writes {resource}, read by {before}"),
            Hazard::WriteAfterWrite => format!("write after write: {after} writes {resource}, written by {before}"),
            Hazard::Layout => format!("layout: {after} reads {resource} in another layout than {before}"),
            Hazard::First => format!("first use: {after} gives {resource} a layout, its contents do not matter"),
            Hazard::Alias { old } => {
                let old = quoted_resource(description, old);
                format!("alias: {after} begins {resource} in memory of {old}, last used by {before}")
            }
            Hazard::Ownership => format!("ownership: {resource} goes from the queue of {before} to that of {after}"),
            Hazard::Final => format!("final state: {resource}, last used by {before}, is left as its owner wants it"),
            Hazard::Host => format!("host: {after} reads what {before} copied"),
        }
    }
}

impl CullReason {
    /// In words.
    pub fn explain(&self, description: &Description) -> String {
        match self {
            CullReason::WritesNothing => "it writes nothing and has no side effect".into(),
            CullReason::Unread { resources } => {
                let names: Vec<_> = resources.iter().map(|&id| quoted_resource(description, id)).collect();
                format!("nothing reads {}, which it writes; no root needs it", names.join(", "))
            }
            CullReason::Overwritten { resource, by } => format!(
                "{} writes over {} before anything reads it",
                quoted_pass(description, *by),
                quoted_resource(description, *resource)
            ),
            CullReason::OnlyCulledRead { resource, reader } => format!(
                "only culled passes read {}, which it writes: {}",
                quoted_resource(description, *resource),
                quoted_pass(description, *reader)
            ),
        }
    }
}

impl Work {
    /// In words.
    pub fn describe(&self, description: &Description) -> String {
        match self {
            Work::Pass(pass) => quoted_pass(description, *pass),
            Work::ReadBack(root) => {
                let name = description.roots.get(*root).map_or("?", |root| &root.name);
                format!("the read-back of `{name}`")
            }
        }
    }
}

fn quoted_resource(description: &Description, id: ResourceId) -> String {
    format!("`{}`", description.resources.get(id.0 as usize).map_or("?", |resource| &resource.name))
}

fn quoted_pass(description: &Description, id: PassId) -> String {
    format!("`{}`", description.passes.get(id.0 as usize).map_or("?", |pass| &pass.name))
}

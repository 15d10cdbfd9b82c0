//! Why two resources do not share memory.

use super::{Plan, Work};
use crate::graph::description::{Description, Origin, ResourceId, VersionId};

/// Why two resources do not share memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Apart {
    /// One of them is not the frame's to place.
    NotTransient {
        /// Which.
        resource: ResourceId,
    },
    /// No step uses one of them, so it has no memory.
    Unused {
        /// Which.
        resource: ResourceId,
    },
    /// No memory type suits both.
    MemoryTypes,
    /// Both are in use from one step to another.
    Overlap {
        /// The first step in which both are.
        first: Work,
        /// The last one.
        last: Work,
    },
    /// One of them is kept to the end of the frame by a root.
    Kept {
        /// Which.
        resource: ResourceId,
    },
    /// They are used at different times, on queues that do not wait for one another.
    Queues,
    /// They could, but lie better elsewhere.
    Elsewhere,
}

/// Why two resources of a plan do not share memory; `None` where they do.
pub fn apart(description: &Description, plan: &Plan, a: ResourceId, b: ResourceId) -> Option<Apart> {
    let transient = |id: &ResourceId| description.resources[id.0 as usize].origin == Origin::Transient;
    if let Some(resource) = [a, b].into_iter().find(|id| !transient(id)) {
        return Some(Apart::NotTransient { resource });
    }
    let (Some(one), Some(other)) = (plan.placement(a), plan.placement(b)) else {
        let resource = if plan.placement(a).is_none() { a } else { b };
        return Some(Apart::Unused { resource });
    };
    if one.heap != other.heap {
        return Some(Apart::MemoryTypes);
    }
    let (first, last) = (one.steps[0].max(other.steps[0]), one.steps[1].min(other.steps[1]));
    if first <= last {
        // A root lives on behind its last use.
        let used = |id| {
            let is_of = |(version, _): (VersionId, _)| description.versions[version.0 as usize].resource == id;
            plan.steps.iter().rposition(|step| step.work.uses(description).any(is_of))
        };
        let kept = [a, b].into_iter().find(|&id| used(id).is_some_and(|end| end < first));
        return Some(match kept {
            Some(resource) => Apart::Kept { resource },
            None => Apart::Overlap { first: plan.steps[first].work, last: plan.steps[last].work },
        });
    }
    let share = one.offset < other.offset + other.size && other.offset < one.offset + one.size;
    match (share, plan.is_single_queue()) {
        (true, _) => None,
        (false, true) => Some(Apart::Elsewhere),
        (false, false) => Some(Apart::Queues),
    }
}

impl Apart {
    /// In words.
    pub fn explain(&self, description: &Description) -> String {
        let name = |id: &ResourceId| description.resources.get(id.0 as usize).map_or("?", |resource| &resource.name);
        match self {
            Apart::NotTransient { resource } => format!("`{}` does not belong to the frame alone", name(resource)),
            Apart::Unused { resource } => format!("no step uses `{}`", name(resource)),
            Apart::MemoryTypes => "no memory type suits both".into(),
            Apart::Overlap { first, last } if first == last => {
                format!("both are in use in {}", first.describe(description))
            }
            Apart::Overlap { first, last } => {
                format!("both are in use from {} to {}", first.describe(description), last.describe(description))
            }
            Apart::Kept { resource } => format!("`{}` is kept to the end of the frame", name(resource)),
            Apart::Queues => "they are used on queues that do not wait for one another, or lie better elsewhere".into(),
            Apart::Elsewhere => "they could share, but lie better elsewhere".into(),
        }
    }
}

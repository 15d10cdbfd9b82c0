//! The rules themselves: what a barrier does to a record, and which accesses may not follow one another.

use ash::vk::{AccessFlags2 as Mask, PipelineStageFlags2 as Stages};
use shadowgraph::graph::description::{Queue, Use, VersionId};
use shadowgraph::graph::plan::Ownership;

use super::record::{Kind, Record, Scopes, each};

/// Which memory a barrier is for: all, or a range of a resource, whose transition or transfer it may be.
pub struct Effect {
    pub scopes: Scopes,
    pub atoms: Option<Vec<usize>>,
    pub ownership: Option<Ownership>,
    pub who: String,
}

/// What one barrier call does to a record: ordering by all of its barriers, memory by those for its memory.
pub fn apply<'a>(record: &mut Record, old: &Record, memory: impl Iterator<Item = &'a Effect>, all: &[Effect]) {
    for effect in all.iter().filter(|effect| old.in_first_scope(&effect.scopes)) {
        record.second_scope(&effect.scopes);
        if old.writes() && old.is_available_to(&effect.scopes) {
            record.make_available(&effect.scopes);
        }
    }
    for effect in memory.filter(|effect| old.writes() && old.in_first_scope(&effect.scopes)) {
        if old.in_first_access_scope(&effect.scopes) {
            record.make_available(&effect.scopes);
            record.second_access_scope(&effect.scopes);
        } else if old.is_available_to(&effect.scopes) {
            record.second_access_scope(&effect.scopes);
        }
    }
}

/// Why a use may not follow a record of the same memory. `read`: somebody read it since it was written, which made the
/// write available; else a write asks for a memory dependency of its own.
pub fn conflict(
    record: &Record,
    used: &Use,
    fork: Option<VersionId>,
    queue: Queue,
    stage: u64,
    read: bool,
) -> Option<String> {
    if record.fork.is_some() && record.fork == fork {
        return None;
    }
    let writes = !used.access.writes().is_empty();
    if (record.writes() || writes) && !record.is_before(queue, stage) {
        return Some(format!("does not wait for {} of {}", kind(record), record.who));
    }
    if record.writes() && writes && !record.is_available(queue, stage) {
        let stages = [record.stage, stage].map(Stages::from_raw);
        return Some(format!("is written before what {} wrote is available ({stages:?})", record.who));
    }
    let reads = if used.reads || used.makes.is_none() { used.access.reads() } else { Mask::NONE };
    let needed = reads | if read { Mask::NONE } else { used.access.writes() };
    let unseen = each(needed.as_raw()).find(|&bit| !record.is_visible(queue, stage, Mask::from_raw(bit)));
    let unseen = unseen.filter(|_| record.writes());
    unseen.map(|bit| format!("does not see what {} wrote ({:?})", record.who, Mask::from_raw(bit)))
}

/// Why a use may not follow a record of another resource in the same memory. `next`: it is the write that comes next
/// after the record's, which asks for a memory dependency between the two (Vulkan, "Execution and Memory
/// Dependencies"); else a read or another write stands between them, be it a layout transition.
pub fn foreign_conflict(record: &Record, used: &Use, queue: Queue, stage: u64, next: bool) -> Option<String> {
    if record.writes() || !used.access.writes().is_empty() {
        if !record.is_before(queue, stage) {
            return Some(format!("shares memory, and does not wait for {} of {}", kind(record), record.who));
        }
        if record.writes() && !record.is_available(queue, stage) {
            return Some(format!("shares memory, and comes before what {} wrote is available", record.who));
        }
        let seen = record.is_visible(queue, stage, used.access.writes());
        if record.writes() && next && !seen {
            return Some(format!("shares memory, and writes over what {} wrote without seeing it", record.who));
        }
    }
    None
}

pub fn kind(record: &Record) -> &'static str {
    match record.kind {
        Kind::Read => "the read",
        Kind::Write => "the write",
        Kind::Transition => "the transition",
    }
}

//! Checkpoints cut between passes.

use super::{Errors, Place};
use crate::graph::errors::ErrorKind;

/// What is before a checkpoint is made of what is before it alone.
pub(super) fn check(errors: &mut Errors) {
    let description = errors.description;
    let mut last = (0, 0, 0);
    for checkpoint in &description.checkpoints {
        let (passes, versions, resources) = (checkpoint.passes, checkpoint.versions, checkpoint.resources);
        let name = &checkpoint.name;
        let mut add = |wrong: String, allowed: &str| {
            errors.add(ErrorKind::BadCheckpoint, Place::default(), format!("checkpoint `{name}` {wrong}"), allowed);
        };
        let all = (description.passes.len(), description.versions.len(), description.resources.len());
        let ascending = last.0 <= passes && last.1 <= versions && last.2 <= resources;
        if !ascending || passes > all.0 || versions > all.1 || resources > all.2 {
            let wrong = format!("stands behind {passes} passes, {versions} versions and {resources} resources");
            add(wrong, "checkpoints stand one behind the other, within the description");
            continue;
        }
        last = (passes, versions, resources);
        let root = checkpoint.root.map(|root| description.roots.get(root));
        let is_before = root.is_none_or(|root| root.is_some_and(|r| r.read_back && (r.version.0 as usize) < versions));
        if !is_before {
            add("does not read anything made before it".into(), "it reads a root that is read back");
        }
        let cut = description.passes.iter().enumerate().find(|(index, pass)| {
            description.uses_of(pass).iter().any(|used| {
                let made = used.makes.map(|made| made.0 as usize);
                match *index < passes {
                    true => (used.version.0 as usize) >= versions || made.is_some_and(|made| made >= versions),
                    false => made.is_some_and(|made| made < versions),
                }
            })
        });
        if let Some((_, pass)) = cut {
            add(format!("cuts through pass `{}`", pass.name), "a pass is recorded whole before it or whole after it");
        }
        if description.versions[..versions].iter().any(|version| version.resource.0 as usize >= resources) {
            add("comes before a resource that was used before it".into(), "a resource is made before its versions");
        }
    }
}

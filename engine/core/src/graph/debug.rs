//! Looking into a frame: passes switched off, contents of any moment read back.

use super::builder::Graph;
use super::description::{Access, Description, PassId, Queue, ResourceId, Root, Source, VersionId};
use super::pass::Work;
use crate::{Error, Result};

impl Graph<'_> {
    /// Switches a pass off. What it would have written anew is zero (depth 0, far away), what it would have written
    /// over stays as it was, what it counts is 0, and it reads nothing.
    ///
    /// # Errors
    /// [`Error::Invalid`] where no pass has that name, with the names that there are.
    pub fn switch_off(&mut self, pass: &str) -> Result<()> {
        let index = find_pass(&self.description, pass)?;
        self.known_fingerprint.set(None);
        let description = &mut self.description;
        description.retain_uses(PassId(index as u32), |used| used.makes.is_some());
        let Description { passes, uses, versions, .. } = description;
        let pass = &mut passes[index];
        let mut zero = Vec::new();
        for used in &mut uses[pass.uses.start as usize..pass.uses.end as usize] {
            let version = &versions[used.version.0 as usize];
            // One of several unordered writers writes nothing, and leaves the others' alone.
            if !used.reads && !matches!(version.source, Source::Fork { .. }) {
                zero.push((version.resource, version.range));
                used.access = Access::transfer_write();
            }
        }
        pass.queue = Queue::Graphics;
        pass.side_effect = Some("it is switched off".into());
        self.work[index] = Work::Zero(zero);
        Ok(())
    }

    /// Reads back what a resource holds right after a pass, as recorded so far, as a capture of the name that this
    /// gives: `PASS:RESOURCE`.
    ///
    /// # Errors
    /// [`Error::Invalid`] where there is no such pass or resource, with the names that there are, and where nobody has
    /// written the resource by then.
    pub fn capture_after(&mut self, pass: &str, resource: &str) -> Result<String> {
        let index = find_pass(&self.description, pass)?;
        let description = &self.description;
        let mut known = description.resources.iter();
        let id = known.position(|known| known.name == resource).map(|id| ResourceId(id as u32)).ok_or_else(|| {
            let names: Vec<_> = description.resources.iter().map(|known| known.name.as_str()).collect();
            Error::invalid(format!("resource `{resource}`"), format!("there are {}", names.join(", ")))
        })?;
        let name = format!("{pass}:{resource}");
        let nobody = || Error::invalid(&name, "nobody has written it by then");
        let version = version_after(description, index, id).ok_or_else(nobody)?;
        self.description.roots.push(Root { name: name.clone(), version, read_back: true });
        Ok(name)
    }
}

fn find_pass(description: &Description, pass: &str) -> Result<usize> {
    description.passes.iter().position(|known| known.name == pass).ok_or_else(|| {
        let names: Vec<_> = description.passes.iter().map(|known| known.name.as_str()).collect();
        Error::invalid(format!("pass `{pass}`"), format!("there are {}", names.join(", ")))
    })
}

/// The version of a resource that a pass makes or uses, else the last one that is made before it.
fn version_after(description: &Description, pass: usize, resource: ResourceId) -> Option<VersionId> {
    let of = |version: &VersionId| description.versions[version.0 as usize].resource == resource;
    let uses = description.uses_of(&description.passes[pass]);
    let made = uses.iter().filter_map(|used| used.makes).find(of);
    let used = || uses.iter().map(|used| used.version).find(of);
    let before = || {
        let is_before = |id: &VersionId| match description.versions[id.0 as usize].source {
            Source::Pass { pass: PassId(by), .. } => (by as usize) < pass,
            _ => false,
        };
        (0..description.versions.len() as u32).map(VersionId).rfind(|id| of(id) && is_before(id))
    };
    made.or_else(used).or_else(before)
}

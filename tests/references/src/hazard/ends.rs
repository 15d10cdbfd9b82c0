//! What must hold when a frame is over.

use ash::vk::{AccessFlags2 as Mask, PipelineStageFlags2 as Stages};
use shadowgraph::graph::description::{Origin, Queue, ResourceId, Shape, Use, Version, VersionId};

use super::contents::{Contents, contents, last_versions};
use super::record::{Kind, each, single};
use super::replay::Replay;
use super::rules::conflict;

impl Replay<'_> {
    /// The state after the frame.
    pub(super) fn end(&mut self) {
        let description = self.description;
        let mut wrong = Vec::new();
        for (index, resource) in description.resources.iter().enumerate() {
            let after = match resource.origin {
                Origin::Transient => continue,
                Origin::Imported { after, .. } | Origin::Kept { after, .. } => after,
            };
            let name = &resource.name;
            for part in self.atoms.all(ResourceId(index as u32)).map(|atom| &self.parts[atom]) {
                if part.released.is_some() || part.owner.is_some_and(|o| Some(o) != self.device.family(Queue::Graphics))
                {
                    wrong.push(format!("`{name}` is not given back to graphics"));
                }
                let Some(after) = after else { continue };
                let unused = part.records.is_empty() && part.contents == Contents::Nothing;
                if unused && matches!(resource.origin, Origin::Kept { .. }) {
                    continue;
                }
                if matches!(resource.shape, Shape::Image(_)) && part.layout != after.layout {
                    wrong.push(format!("`{name}` is left in layout {:?}, not {:?}", part.layout, after.layout));
                }
                let used = Use { slot: "".into(), version: VersionId(0), makes: None, reads: true, access: after };
                let read = part.records.iter().any(|record| record.kind == Kind::Read);
                for stage in each(single(after.stages)) {
                    let records = part.records.iter();
                    let what = records.filter_map(|record| conflict(record, &used, None, Queue::Graphics, stage, read));
                    wrong.extend(what.map(|what| format!("`{name}` after the frame: {what}")));
                }
            }
        }
        for (index, resource) in description.resources.iter().enumerate() {
            if !matches!(resource.origin, Origin::Kept { needed: true, .. }) {
                continue;
            }
            for version in last_versions(description, ResourceId(index as u32)) {
                for atom in self.atoms.of(ResourceId(index as u32), &description.versions[version.0 as usize].range) {
                    let part = &self.parts[atom];
                    if part.contents != contents(description, &self.atoms, version, atom) {
                        wrong.push(format!("what is needed of `{}` is gone: {:?}", resource.name, part.contents));
                    }
                }
            }
        }
        for root in description.roots.iter().filter(|root| !root.read_back) {
            let Version { resource, range, .. } = description.versions[root.version.0 as usize];
            for atom in self.atoms.of(resource, &range) {
                if !self.holds(&self.parts[atom], root.version, atom, None) {
                    wrong.push(format!("root `{}` is gone: {:?}", root.name, self.parts[atom].contents));
                }
            }
        }
        self.errors.extend(wrong);
    }

    /// The host reads what was copied for it, and nothing still runs.
    pub(super) fn settle(&mut self) {
        let mut wrong = Vec::new();
        for copy in self.copies.iter().flatten() {
            if !copy.is_before(Queue::Graphics, Stages::HOST.as_raw())
                || !copy.is_visible(Queue::Graphics, Stages::HOST.as_raw(), Mask::HOST_READ)
            {
                wrong.push(format!("{} is not visible to the host", copy.who));
            }
        }
        for record in self.parts.iter().flat_map(|part| &part.records) {
            if !record.is_known(Queue::Graphics) {
                wrong.push(format!("the frame ends before {} does", record.who));
            }
        }
        self.errors.extend(wrong);
    }
}

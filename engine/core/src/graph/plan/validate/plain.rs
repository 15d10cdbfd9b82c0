//! A quick look at frames that use whole resources, each version as the one before left it, in the order in which they
//! are recorded: one walk over their uses tells that nothing is wrong, and finds what the checks of any frame find.

use super::uses::is_fine;
use crate::graph::description::{Description, Origin, PassId, Shape, Source, VersionId};
use crate::graph::plan::DeviceModel;
use crate::graph::plan::cells::Cells;
use crate::graph::plan::dependencies::{Dependencies, Event, Events, Node};
use crate::graph::plan::memo::Memo;
use crate::graph::plan::versions::{Versions, wholes};

/// A resource, up to the pass that is looked at.
#[derive(Clone)]
struct State {
    /// Its last version; none yet where that is no version.
    now: VersionId,
    /// The last pass that used it.
    user: Option<Node>,
}

/// What [`super::validate`] finds, but for roots; nothing where anything is unusual, be it right or wrong. Names and
/// resources are right.
pub(super) fn look(description: &Description, device: &dyn DeviceModel) -> Option<(Versions, Events, Dependencies)> {
    let Description { resources, versions, passes, uses, roots, checkpoints, .. } = description;
    if !checkpoints.is_empty() {
        return None;
    }
    let wholes = wholes(description);

    // 1. Each resource begins with one version.
    let none = VersionId(u32::MAX);
    let mut states = vec![State { now: none, user: None }; resources.len()];
    let (mut epoch, mut defined) = (vec![0; versions.len()], vec![false; versions.len()]);
    let mut unmade = 0;
    for (index, version) in versions.iter().enumerate() {
        let resource = version.resource.0 as usize;
        if *wholes.get(resource)? != version.range {
            return None;
        }
        match version.source {
            Source::Initial if states[resource].now == none => {
                states[resource].now = VersionId(index as u32);
                defined[index] = match resources[resource].origin {
                    Origin::Transient => false,
                    Origin::Imported { before, .. } => before.has_contents(&resources[resource].shape),
                    Origin::Kept { .. } => return None,
                };
            }
            Source::Pass { .. } => unmade += 1,
            _ => return None,
        }
    }
    if versions.len() - unmade != resources.len() {
        return None;
    }

    // 2. Each use names the last version of its resource, once a pass, and makes the next one.
    let mut allowed = Memo::new();
    let mut events = Vec::with_capacity(uses.len() + roots.len());
    for (node, pass) in (0..).zip(passes) {
        let uses = description.uses_of(pass);
        if uses.is_empty() && pass.side_effect.is_none() {
            return None;
        }
        for (place, used) in (pass.uses.start..).zip(uses) {
            let from = used.version.0 as usize;
            let resource = versions.get(from)?.resource;
            let state = &mut states[resource.0 as usize];
            let is_last = state.now == used.version && state.user != Some(node);
            let reads = used.reads || used.makes.is_none();
            let image = match &resources[resource.0 as usize].shape {
                Shape::Image(shape) => {
                    let usages = allowed.get(shape.format, || (device.image_usages(shape.format), true));
                    Some((shape.aspects(), usages))
                }
                Shape::Buffer { .. } => None,
            };
            if !is_last || (reads && !defined[from]) || !is_fine(used, pass.queue, image) {
                return None;
            }
            let writes = used.makes.is_some();
            let time = 2 * epoch[from] + u32::from(writes);
            events.push((resource.0, Event { time, node, used: place }));
            state.user = Some(node);
            if let Some(made) = used.makes {
                let version = versions.get(made.0 as usize)?;
                let source = Source::Pass { pass: PassId(node), from: used.version };
                if made < used.version || version.resource != resource || version.source != source {
                    return None;
                }
                state.now = made;
                epoch[made.0 as usize] = epoch[from] + 1;
                defined[made.0 as usize] = true;
                unmade -= 1;
            }
        }
    }
    if unmade > 0 {
        return None;
    }

    // 3. What is read back is a last version.
    for (node, root) in (passes.len() as Node..).zip(roots) {
        let version = root.version.0 as usize;
        let resource = versions.get(version)?.resource;
        if root.read_back {
            if states[resource.0 as usize].now != root.version {
                return None;
            }
            events.push((resource.0, Event { time: 2 * epoch[version], node, used: 0 }));
        }
    }
    let events = Events::by_cell(resources.len(), &events);
    let dependencies = Dependencies::new(&events, passes.len() + roots.len());
    Some((Versions::plain(Cells::uncut(description, wholes), epoch, defined), events, dependencies))
}

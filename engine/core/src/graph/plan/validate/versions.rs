//! Joins, forks and roots.

use super::ids::describe;
use super::{Errors, Place};
use crate::graph::description::{Source, VersionId};
use crate::graph::errors::ErrorKind;
use crate::graph::plan::versions::Versions;

/// The parts of a joined version cover it, none of them twice, unless they are forks of one version.
pub(super) fn joins(errors: &mut Errors, versions: &Versions) {
    let description = errors.description;
    for (index, version) in description.versions.iter().enumerate() {
        let Source::Join { of } = &version.source else { continue };
        if versions.broken[index] {
            continue;
        }
        let place = Place::resource(version.resource);
        let forks: Vec<_> = of.iter().map(|part| versions.fork(*part)).collect();
        if forks.iter().any(|fork| *fork != forks[0]) {
            let wrong = "unordered versions are joined with others";
            errors.add(ErrorKind::BadJoin, place, wrong, "forks of one version are joined with one another");
            continue;
        }
        let forked = forks.first().is_some_and(|fork| fork.is_some());
        let mut holders = versions.cells.slots(index).map(|slot| {
            let cell = versions.cells.cell(slot);
            of.iter().filter(|part| versions.cells.slot(part.0 as usize, cell).is_some()).count()
        });
        let wrong = match holders.find(|&count| count == 0 || (count > 1 && !forked)) {
            Some(0) => "leave a gap",
            Some(_) => "overlap",
            None => continue,
        };
        let parts: Vec<_> = of.iter().map(|part| describe(&description.versions[part.0 as usize].range)).collect();
        let wrong = format!("the joined parts ({}) {wrong}", parts.join("; "));
        let allowed = format!("together they hold {} exactly once", describe(&version.range));
        errors.add(ErrorKind::BadJoin, place, wrong, allowed);
    }
}

/// A forked version is written once, and then joined.
pub(super) fn forks(errors: &mut Errors, versions: &Versions) {
    if !versions.are_forked() {
        return;
    }
    let description = errors.description;
    let allowed = "join the unordered writers before anything else is done with what they write";
    for (index, version) in description.versions.iter().enumerate().filter(|(index, _)| !versions.broken[*index]) {
        let place = Place::resource(version.resource);
        let is_fork = |of: VersionId| versions.fork(of).is_some();
        match version.source {
            Source::Split { of } | Source::Fork { of } if is_fork(of) => {
                errors.add(ErrorKind::BadFork, place, "a version of one unordered writer is split or forked", allowed);
            }
            Source::Pass { from, pass } if is_fork(from) => {
                let again = matches!(description.versions[from.0 as usize].source, Source::Pass { .. });
                let pass = &description.passes[pass.0 as usize];
                let made = Some(VersionId(index as u32));
                let used = description.uses_of(pass).iter().find(|used| used.makes == made);
                let place = Place { pass: Some(pass), slot: used.map(|used| &*used.slot), ..place };
                if again {
                    errors.add(ErrorKind::BadFork, place, "writes over what one unordered writer wrote", allowed);
                }
                let storage = ash::vk::AccessFlags2::SHADER_STORAGE_WRITE;
                if let Some(used) = used.filter(|used| used.access.writes() != storage) {
                    let wrong = format!("is an unordered writer by {:?}", used.access.writes());
                    let allowed = "unordered writers write storage buffers and storage images, by atomics";
                    errors.add(ErrorKind::BadFork, place, wrong, allowed);
                }
            }
            _ => {}
        }
    }
}

/// Roots exist.
pub(super) fn roots(errors: &mut Errors, versions: &Versions) {
    let description = errors.description;
    for root in &description.roots {
        let name = &root.name;
        let Some(version) = description.versions.get(root.version.0 as usize) else {
            let wrong = format!("root `{name}` is version {}, which there is not", root.version.0);
            let allowed = format!("the description has {} versions", description.versions.len());
            errors.add(ErrorKind::UnknownId, Place::default(), wrong, allowed);
            continue;
        };
        if !versions.is_known(root.version) {
            continue;
        }
        let place = Place::resource(version.resource);
        if !versions.is_defined(root.version) {
            let wrong = format!("nobody writes what root `{name}` asks for");
            errors.add(ErrorKind::EmptyRoot, place, wrong, "a root is written by a pass, or imported");
        }
        if versions.fork(root.version).is_some() {
            let wrong = format!("root `{name}` is a version of one unordered writer");
            errors.add(ErrorKind::BadFork, place, wrong, "join the unordered writers first");
        }
        let shape = &description.resources[version.resource.0 as usize].shape;
        if let crate::graph::description::Shape::Image(shape) = shape
            && root.read_back
            && shape.samples > 1
        {
            let wrong = format!("root `{name}` has {} samples a texel", shape.samples);
            errors.add(ErrorKind::WrongUsage, place, wrong, "only images with 1 sample are read back: resolve it");
        }
    }
}

//! Writers that replace the same contents, and circles.

use super::ids::describe;
use super::{Errors, Place};
use crate::graph::description::{PassId, Source, VersionId};
use crate::graph::errors::ErrorKind;
use crate::graph::plan::Work;
use crate::graph::plan::dependencies::{Dependencies, Event, Events, Node};
use crate::graph::plan::versions::Versions;

/// Each epoch has one writer, or unordered ones of one fork; nobody waits for itself.
pub(super) fn check(errors: &mut Errors, versions: &Versions) -> (Events, Dependencies) {
    let description = errors.description;
    let events = Events::new(description, versions);
    let makes = |event: &Event| {
        description.passes.get(event.node as usize)?;
        description.uses[event.used as usize].makes.filter(|&made| versions.is_known(made))
    };
    let before = errors.list.len();
    let mut seen: Vec<(VersionId, VersionId)> = Vec::new();
    for cell in 0..events.cells() {
        let several = |pair: &[Event]| pair[0].time == pair[1].time && pair[0].time % 2 == 1;
        if !events.of(cell).windows(2).any(several) {
            continue;
        }
        // Writes have odd times.
        let writes = events.of(cell).chunk_by(|a, b| a.time == b.time).filter(|set| set[0].time % 2 == 1);
        for set in writes.filter(|set| set.len() > 1) {
            for (index, a) in set.iter().enumerate() {
                let rivals = set[..index].iter().filter_map(|b| makes(a).zip(makes(b)));
                for (a, b) in
                    rivals.filter(|&(a, b)| versions.fork(a).is_none() || versions.fork(a) != versions.fork(b))
                {
                    if !seen.contains(&(a, b)) {
                        seen.push((a, b));
                        rivals_error(errors, a, b);
                    }
                }
            }
        }
    }
    let dependencies = Dependencies::new(&events, description.passes.len() + description.roots.len());
    // With two writers for one version any order is a circle.
    if errors.list.len() == before {
        circle(errors, versions, &dependencies);
    }
    (events, dependencies)
}

fn rivals_error(errors: &mut Errors, a: VersionId, b: VersionId) {
    let description = errors.description;
    let part = |made: VersionId| {
        let mut version = made;
        loop {
            match description.versions[version.0 as usize].source {
                Source::Split { of } => return Some((of, description.versions[version.0 as usize].range)),
                Source::Pass { from, .. } => version = from,
                Source::Fork { of } => version = of,
                Source::Initial | Source::Join { .. } => return None,
            }
        }
    };
    let maker = |made: VersionId| {
        let Source::Pass { pass, .. } = description.versions[made.0 as usize].source else { return None };
        let pass = description.passes.get(pass.0 as usize)?;
        Some((pass, description.uses_of(pass).iter().find(|used| used.makes == Some(made))?))
    };
    let (Some((pass, used)), Some((other, _))) = (maker(a), maker(b)) else { return };
    let resource = Some(description.versions[a.0 as usize].resource);
    let place = Place { pass: Some(pass), slot: Some(&used.slot), resource };
    let other = &other.name;
    match (part(a), part(b)) {
        (Some((whole, first)), Some((same, second))) if whole == same && first != second => {
            let wrong = format!(
                "writes a part ({}) that overlaps one that `{other}` writes ({})",
                describe(&first),
                describe(&second)
            );
            errors.add(
                ErrorKind::OverlappingSplits,
                place,
                wrong,
                "parts of one version that are written are disjoint",
            );
        }
        _ => {
            let wrong = format!("writes over contents that `{other}` writes over too");
            let allowed = "each version is replaced once: write over the other's result, or split or fork before";
            errors.add(ErrorKind::TwoWriters, place, wrong, allowed);
        }
    }
}

fn circle(errors: &mut Errors, versions: &Versions, dependencies: &Dependencies) {
    let description = errors.description;
    let passes = description.passes.len();
    let Some(circle) = dependencies.cycle() else { return };
    let name = |node: Node| match node as usize {
        index if index < passes => Work::Pass(PassId(node)).describe(description),
        index => Work::ReadBack(index - passes).describe(description),
    };
    let steps: Vec<_> = circle
        .iter()
        .enumerate()
        .map(|(index, &(node, cell))| {
            let next = circle[(index + 1) % circle.len()].0;
            let resource = &description.resources[versions.cells.resource(cell).0 as usize].name;
            format!("{} waits for {} because of `{resource}`", name(next), name(node))
        })
        .collect();
    let allowed = "a pass reads versions that can all be there at once";
    errors.add(ErrorKind::Cycle, Place::default(), steps.join(", "), allowed);
}

//! Names, shapes, ids and ranges.

use std::collections::BTreeMap;

use ash::vk;

use super::{Errors, Place};
use crate::graph::description::{
    Description, Origin, PassId, Range, Resource, ResourceId, Shape, Source, Version, VersionId,
};
use crate::graph::errors::ErrorKind;
use crate::graph::name::are_distinct;

/// Names are unique among passes, among resources and among read-backs.
pub(super) fn names(errors: &mut Errors) {
    let description = errors.description;
    let (passes, resources) = (description.passes.iter(), description.resources.iter());
    if !are_distinct(passes.clone().map(|pass| &pass.name)) {
        doubled(errors, "passes", passes.map(|pass| pass.name.as_str()));
    }
    if !are_distinct(resources.clone().map(|resource| &resource.name)) {
        doubled(errors, "resources", resources.map(|resource| resource.name.as_str()));
    }
    doubled(errors, "captures", description.roots.iter().filter(|root| root.read_back).map(|root| root.name.as_str()));
}

/// Tells each name that several have.
fn doubled<'a>(errors: &mut Errors, what: &str, names: impl Iterator<Item = &'a str>) {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    names.for_each(|name| *counts.entry(name).or_default() += 1);
    for (name, count) in counts.into_iter().filter(|(_, count)| *count > 1) {
        let wrong = format!("{count} {what} are named `{name}`");
        errors.add(ErrorKind::DuplicateName, Place::default(), wrong, "each needs a name of its own");
    }
}

/// Sizes and states.
pub(super) fn resources(errors: &mut Errors) {
    let description = errors.description;
    for (index, resource) in description.resources.iter().enumerate() {
        let place = Place::resource(ResourceId(index as u32));
        match &resource.shape {
            Shape::Buffer { size: 0 } => {
                errors.add(ErrorKind::BadShape, place, "a buffer of 0 bytes", "a buffer has at least one");
            }
            Shape::Buffer { .. } => {}
            Shape::Image(shape) => {
                let [width, height, depth] = shape.extent;
                if [width, height, depth, shape.layers].contains(&0) {
                    let wrong = format!("an image of {width}x{height}x{depth} texels and {} layers", shape.layers);
                    errors.add(ErrorKind::BadShape, place, wrong, "each is at least 1");
                }
                let most = u32::BITS - width.max(height).max(depth).leading_zeros();
                if shape.mips == 0 || shape.mips > most.max(1) {
                    let wrong = format!("{} mip levels for {width}x{height}x{depth} texels", shape.mips);
                    errors.add(ErrorKind::BadShape, place, wrong, format!("1 to {} are allowed", most.max(1)));
                }
                if depth > 1 && shape.layers > 1 {
                    let wrong = format!("{} layers of a 3D image", shape.layers);
                    errors.add(ErrorKind::BadShape, place, wrong, "a 3D image has 1");
                }
                if !shape.samples.is_power_of_two() || shape.samples > 64 {
                    let wrong = format!("{} samples a texel", shape.samples);
                    errors.add(ErrorKind::BadShape, place, wrong, "1, 2, 4, 8, 16, 32 or 64 are allowed");
                }
                if shape.format == vk::Format::UNDEFINED {
                    errors.add(ErrorKind::BadShape, place, "an image without a format", "give it one");
                }
            }
        }
        states(errors, place, resource);
    }
}

/// States that resources from outside of the frame can arrive and be left in.
fn states(errors: &mut Errors, place: Place, resource: &Resource) {
    let is_image = matches!(resource.shape, Shape::Image(_));
    let undefined = [vk::ImageLayout::UNDEFINED, vk::ImageLayout::PREINITIALIZED];
    if let Origin::Imported { after: Some(after), .. } | Origin::Kept { after: Some(after), .. } = &resource.origin
        && is_image
        && undefined.contains(&after.layout)
    {
        let wrong = format!("is to be left in layout {:?}", after.layout);
        errors.add(ErrorKind::BadImport, place, wrong, "any layout but UNDEFINED and PREINITIALIZED is allowed");
    }
    let Origin::Kept { before, .. } = &resource.origin else { return };
    let whole = resource.shape.whole();
    for (index, state) in before.iter().enumerate() {
        if !state.range.lies_in(&whole) {
            let wrong = format!("arrives in a state of {}, which is not a part of it", describe(&state.range));
            errors.add(ErrorKind::BadImport, place, wrong, format!("it has {}", describe(&whole)));
        }
        if let Some(other) = before[..index].iter().find(|other| other.range.overlaps(&state.range)) {
            let wrong = format!("arrives in two states of {} and {}", describe(&other.range), describe(&state.range));
            errors.add(ErrorKind::BadImport, place, wrong, "each part arrives in one state");
        }
        if is_image && state.holds && undefined.contains(&state.access.layout) {
            let wrong = format!("holds something in layout {:?}", state.access.layout);
            errors.add(ErrorKind::BadImport, place, wrong, "what holds something has another layout");
        }
    }
}

/// Ids, order and ranges of versions. Gives those that fail, or that are made from one that fails. `wholes`: by resource,
/// all of it.
pub(super) fn versions(errors: &mut Errors, wholes: &[Range]) -> Vec<bool> {
    let description = errors.description;
    let mut broken = vec![false; description.versions.len()];
    let mut initial = vec![0; description.resources.len()];
    let makers = makers(description);
    // A shape that holds nothing was told before.
    let shapes_are_right = errors.list.is_empty();
    for (index, version) in description.versions.iter().enumerate() {
        let count = errors.list.len();
        let resource = version.resource.0 as usize;
        if let Some(whole) = wholes.get(resource) {
            let is_whole = version.range == *whole;
            if !(is_whole && shapes_are_right) {
                range(errors, version, whole);
            }
            if version.source == Source::Initial {
                initial[resource] += 1;
                if !is_whole && errors.list.len() == count {
                    let wrong = format!("its first version covers {}", describe(&version.range));
                    let allowed = format!("it covers all: {}", describe(whole));
                    errors.add(ErrorKind::BadInitial, Place::resource(version.resource), wrong, allowed);
                }
            }
        } else {
            let wrong = format!("version {index} is of resource {}, which there is not", version.resource.0);
            let allowed = format!("the description has {} resources", description.resources.len());
            errors.add(ErrorKind::UnknownId, Place::default(), wrong, allowed);
        }
        let sources = version.source.versions();
        for &source in sources {
            let from = description.versions[..index].get(source.0 as usize);
            if from.is_none_or(|from| from.resource != version.resource || from.range != version.range) {
                made_from(errors, index, version, source);
            }
        }
        if let Source::Pass { pass, from } = version.source
            && makers[index] != 1
        {
            made_by(errors, index, version, (pass, from), makers[index]);
        }
        broken[index] = errors.list.len() > count || sources.iter().any(|source| broken[source.0 as usize]);
    }
    for (index, &count) in initial.iter().enumerate().filter(|(_, count)| **count != 1) {
        let place = Place::resource(ResourceId(index as u32));
        errors.add(ErrorKind::BadInitial, place, format!("has {count} first versions"), "it has exactly one");
    }
    broken
}

/// By version: how many uses of the pass that it says makes it do so, from the version that it says.
fn makers(description: &Description) -> Vec<u32> {
    let mut makers = vec![0; description.versions.len()];
    for (index, pass) in description.passes.iter().enumerate() {
        for (used, made) in description.uses_of(pass).iter().filter_map(|used| Some((used, used.makes?.0 as usize))) {
            if let Some(Version { source: Source::Pass { pass, from }, .. }) = description.versions.get(made)
                && (pass.0 as usize, *from) == (index, used.version)
            {
                makers[made] += 1;
            }
        }
    }
    makers
}

/// A range lies in its resource and holds something.
fn range(errors: &mut Errors, version: &Version, whole: &Range) {
    if !version.range.lies_in(whole) {
        let wrong = format!("{} is not a part of it", describe(&version.range));
        let allowed = format!("it has {}", describe(whole));
        errors.add(ErrorKind::BadRange, Place::resource(version.resource), wrong, allowed);
    }
}

/// What a version is made from comes before it, is of the same resource, and holds its range.
fn made_from(errors: &mut Errors, index: usize, version: &Version, source: VersionId) {
    let place = Place::resource(version.resource);
    let Some(from) = errors.description.versions.get(source.0 as usize) else {
        let wrong = format!("version {index} is made from version {}, which there is not", source.0);
        let allowed = format!("the description has {} versions", errors.description.versions.len());
        return errors.add(ErrorKind::UnknownId, place, wrong, allowed);
    };
    if source.0 as usize >= index {
        let wrong = format!("version {index} is made from version {}", source.0);
        return errors.add(ErrorKind::BadVersion, place, wrong, "a version is made from versions recorded before it");
    }
    if from.resource != version.resource {
        let other = &errors.description.resources.get(from.resource.0 as usize).map_or("?", |known| &known.name);
        let wrong = format!("version {index} is made from version {} of `{other}`", source.0);
        return errors.add(ErrorKind::BadVersion, place, wrong, "a version is made from versions of its own resource");
    }
    if version.range == from.range {
        return;
    }
    let (wrong, allowed) = match version.source {
        Source::Pass { .. } | Source::Fork { .. } => {
            ("does not cover", "a written or forked version covers what it is made from")
        }
        Source::Split { .. } if !holds(&from.range, &version.range) => ("is split from", "a part lies in its whole"),
        Source::Join { .. } if !holds(&version.range, &from.range) => {
            ("leaves out some of", "a joined version holds all of its parts")
        }
        _ => return,
    };
    let wrong = format!("{} {wrong} {}", describe(&version.range), describe(&from.range));
    errors.add(ErrorKind::BadVersion, place, wrong, allowed);
}

/// A version is made by the use that says so: not by `count` of them.
fn made_by(errors: &mut Errors, index: usize, version: &Version, (pass, from): (PassId, VersionId), count: u32) {
    let place = Place::resource(version.resource);
    let Some(pass) = errors.description.passes.get(pass.0 as usize) else {
        let wrong = format!("version {index} is made by pass {}, which there is not", pass.0);
        let allowed = format!("the description has {} passes", errors.description.passes.len());
        return errors.add(ErrorKind::UnknownId, place, wrong, allowed);
    };
    let wrong = format!("{count} of its uses make version {index} from version {}", from.0);
    let place = Place { pass: Some(pass), ..place };
    errors.add(ErrorKind::BadVersion, place, wrong, "exactly one use makes it");
}

fn holds(whole: &Range, part: &Range) -> bool {
    whole.hull(*part) == *whole
}

/// A range in words.
pub(super) fn describe(range: &Range) -> String {
    match range {
        Range::Image { aspects, mips: [m, mips], layers: [l, layers] } => {
            format!("mips {m}..{mips}, layers {l}..{layers}, aspects {aspects:?}")
        }
        Range::Buffer([first, end]) => format!("bytes {first}..{end}"),
    }
}

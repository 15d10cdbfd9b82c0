//! Uses of passes: each by itself, and two of one pass together.

use ash::vk::{self, AccessFlags2 as Mask, PipelineStageFlags2 as Stages};

use super::{Errors, Place};
use crate::graph::description::{Description, ImageShape, Pass, Queue, Range, Shape, Source, Use};
use crate::graph::errors::ErrorKind;
use crate::graph::plan::Usage;
use crate::graph::plan::usage::{self, COMPUTE_STAGES, KINDS, ON_BUFFERS, ON_IMAGES, TRANSFER_STAGES, usage_of};
use crate::graph::plan::versions::Versions;

/// A pass does something, and each of its uses can be.
pub(super) fn pass(errors: &mut Errors, versions: &Versions, pass: &Pass, allowed: &[vk::ImageUsageFlags]) {
    let uses = errors.description.uses_of(pass);
    if uses.is_empty() && pass.side_effect.is_none() {
        let allowed = "it reads or writes something, or has a side effect";
        errors.add(ErrorKind::EmptyPass, Place::pass(pass), "uses nothing", allowed);
    }
    for used in uses {
        let place = |resource| Place { pass: Some(pass), slot: Some(&used.slot), resource };
        if let Err((kind, wrong, allowed)) = ids(errors.description, pass, used) {
            errors.add(kind, place(None), wrong, allowed);
            continue;
        }
        if !versions.is_known(used.version) {
            continue;
        }
        let version = &errors.description.versions[used.version.0 as usize];
        let place = || place(Some(version.resource));
        let reads = used.reads || used.makes.is_none();
        if reads && !versions.is_defined(used.version) {
            let allowed = "write it first, or say that its earlier contents do not matter";
            errors.add(ErrorKind::ReadBeforeWrite, place(), "reads what nobody has written", allowed);
        }
        if used.makes.is_none() && versions.fork(used.version).is_some() {
            let allowed = "join the unordered writers first";
            errors.add(ErrorKind::BadFork, place(), "reads the version of one unordered writer", allowed);
        }
        let allowed = allowed[version.resource.0 as usize];
        let image_of = match (&errors.description.resources[version.resource.0 as usize].shape, version.range) {
            (Shape::Image(shape), Range::Image { aspects, .. }) => Some((shape, aspects)),
            _ => None,
        };
        if is_fine(used, pass.queue, image_of.map(|(_, aspects)| (aspects, allowed))) {
            continue;
        }
        let place = place();
        makes(errors, place, used);
        match image_of {
            Some((shape, aspects)) => on_image(errors, place, shape, aspects, used, allowed),
            None => buffer(errors, place, used),
        }
        stages(errors, place, used);
        queue(errors, place, pass.queue, used);
    }
}

/// Whether none of the checks below finds anything wrong with an access. `image`: its aspects, and what the device allows;
/// `None`: of a buffer.
pub(super) fn is_fine(used: &Use, queue: Queue, image: Option<(vk::ImageAspectFlags, vk::ImageUsageFlags)>) -> bool {
    let access = &used.access;
    let all = if image.is_some() { ON_IMAGES } else { ON_BUFFERS };
    let can_be = |kind: &usage::Kind| {
        kind.stages.intersects(access.stages)
            && image.is_none_or(|(aspects, allowed)| {
                kind.aspects.contains(aspects)
                    && kind.layouts.contains(&access.layout)
                    && allowed.contains(kind.usage())
            })
    };
    used.makes.is_some() != access.writes().is_empty()
        && !access.mask.is_empty()
        && all.contains(access.mask)
        && usage::kinds(access.mask).all(can_be)
        && stages_of(queue).contains(access.stages)
}

/// All stages that a queue has.
fn stages_of(queue: Queue) -> Stages {
    match queue {
        Queue::Graphics => Stages::from_raw(!0),
        Queue::Compute => COMPUTE_STAGES,
        Queue::Transfer => TRANSFER_STAGES,
    }
}

/// There is the version that a use names, and the one it makes, which says so itself; else what is wrong, and what is
/// allowed.
fn ids(description: &Description, pass: &Pass, used: &Use) -> Result<(), (ErrorKind, String, String)> {
    let count = description.versions.len();
    for id in std::iter::once(used.version).chain(used.makes) {
        if id.0 as usize >= count {
            let wrong = format!("uses version {}, which there is not", id.0);
            return Err((ErrorKind::UnknownId, wrong, format!("the description has {count} versions")));
        }
    }
    let Some(made) = used.makes else { return Ok(()) };
    let maker = match description.versions[made.0 as usize].source {
        Source::Pass { pass, .. } => description.passes.get(pass.0 as usize),
        _ => None,
    };
    if maker.is_none_or(|maker| !std::ptr::eq(maker, pass)) {
        let wrong = format!("makes version {}, which is not of its making", made.0);
        return Err((ErrorKind::BadVersion, wrong, "a use makes a version whose source is its pass".into()));
    }
    Ok(())
}

/// Whoever writes makes a version, and the other way round.
fn makes(errors: &mut Errors, place: Place, used: &Use) {
    let writes = used.access.writes();
    if used.makes.is_none() && !writes.is_empty() {
        let wrong = format!("writes ({writes:?}) but makes no version");
        errors.add(ErrorKind::WriteMismatch, place, wrong, "a use that writes makes the next version");
    }
    if used.makes.is_some() && writes.is_empty() {
        let wrong = format!("makes a version but does not write ({:?})", used.access.mask);
        errors.add(ErrorKind::WriteMismatch, place, wrong, "a use that only reads makes no version");
    }
}

fn on_image(
    errors: &mut Errors,
    place: Place,
    shape: &ImageShape,
    aspects: vk::ImageAspectFlags,
    used: &Use,
    allowed: vk::ImageUsageFlags,
) {
    let format = shape.format;
    for kind in kinds(errors, place, used, ON_IMAGES, "an image") {
        if !kind.aspects.contains(aspects) {
            let wrong = format!("{:?} on aspects {aspects:?} of format {format:?}", kind.mask);
            errors.add(ErrorKind::WrongUsage, place, wrong, format!("it works on {:?}", kind.aspects));
        }
        if !kind.layouts.contains(&used.access.layout) {
            let wrong = format!("{:?} in layout {:?}", kind.mask, used.access.layout);
            errors.add(ErrorKind::WrongUsage, place, wrong, format!("it works in {:?}", kind.layouts));
        }
        if let Usage::Image(usage) = usage_of(&Shape::Image(*shape), used.access.mask)
            && let usage = usage & kind.usage()
            && !allowed.contains(usage)
        {
            let wrong = format!("the device does not allow {usage:?} for format {format:?}");
            errors.add(ErrorKind::WrongUsage, place, wrong, format!("it allows {allowed:?}"));
        }
    }
}

fn buffer(errors: &mut Errors, place: Place, used: &Use) {
    let _ = kinds(errors, place, used, ON_BUFFERS, "a buffer");
}

/// What the mask asks for, where the kind of resource allows it: `all`.
fn kinds(
    errors: &mut Errors,
    place: Place,
    used: &Use,
    all: Mask,
    what: &str,
) -> impl Iterator<Item = &'static usage::Kind> + use<> {
    let mask = used.access.mask;
    let odd = mask & !all;
    if !odd.is_empty() || mask.is_empty() {
        let wrong = if odd.is_empty() { "uses nothing of".into() } else { format!("{odd:?} on") };
        errors.add(ErrorKind::WrongUsage, place, format!("{wrong} {what}"), format!("allowed are {all:?}"));
    }
    KINDS.iter().filter(move |kind| (mask & all).contains(kind.mask))
}

/// Each access has a stage that can do it.
fn stages(errors: &mut Errors, place: Place, used: &Use) {
    for kind in KINDS.iter().filter(|kind| used.access.mask.contains(kind.mask)) {
        if !kind.stages.intersects(used.access.stages) {
            let wrong = format!("{:?} by stages {:?}", kind.mask, used.access.stages);
            errors.add(ErrorKind::WrongUsage, place, wrong, format!("it is done by {:?}", kind.stages));
        }
    }
}

/// The queue that a pass asks for has the stages it uses.
fn queue(errors: &mut Errors, place: Place, queue: Queue, used: &Use) {
    let allowed = stages_of(queue);
    let odd: Stages = used.access.stages & !allowed;
    if !odd.is_empty() {
        let wrong = format!("stages {odd:?} on the {queue:?} queue");
        errors.add(ErrorKind::WrongQueue, place, wrong, format!("it has {allowed:?}; the Graphics queue has all"));
    }
}

/// Two uses of one pass that share a cell: both read one version in one layout.
pub(super) fn pairs(errors: &mut Errors, versions: &Versions, pass: &Pass) {
    let description = errors.description;
    let resource = |used: &Use| description.versions.get(used.version.0 as usize).map(|version| version.resource);
    let uses = description.uses_of(pass);
    for (index, a) in uses.iter().enumerate().skip(1) {
        let mine = resource(a);
        for b in uses[..index].iter().filter(|b| resource(b) == mine) {
            let are_known = versions.is_known(a.version) && versions.is_known(b.version);
            if !are_known || !versions.overlap(a.version, b.version) {
                continue;
            }
            let version = &description.versions[a.version.0 as usize];
            let place = Place { slot: Some(&a.slot), resource: Some(version.resource), ..Place::pass(pass) };
            let shape = &errors.description.resources[version.resource.0 as usize].shape;
            let slot = &b.slot;
            if a.makes.is_some() || b.makes.is_some() {
                let wrong = format!("is also used by slot `{slot}`, and one of them writes");
                let allowed = "what a pass writes it uses once; a storage access can read and write";
                errors.add(ErrorKind::ConflictingUses, place, wrong, allowed);
            } else if versions.epochs_differ(a.version, b.version) {
                let wrong = format!("slot `{slot}` reads other contents of the same memory");
                errors.add(ErrorKind::ConflictingUses, place, wrong, "a pass sees one version of a resource");
            } else if matches!(shape, Shape::Image(_)) && a.access.layout != b.access.layout {
                let wrong =
                    format!("needs layout {:?} where slot `{slot}` needs {:?}", a.access.layout, b.access.layout);
                errors.add(ErrorKind::ConflictingUses, place, wrong, "a pass sees an image in one layout");
            }
        }
    }
}

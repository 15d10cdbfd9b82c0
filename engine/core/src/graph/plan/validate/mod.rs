//! Finds all that is wrong with a description.

mod checkpoints;
mod ids;
mod order;
mod plain;
mod uses;
mod versions;

use ash::vk::ImageUsageFlags;

use super::DeviceModel;
use super::dependencies::{Dependencies, Events};
use super::memo::Memo;
use super::versions::{Versions, wholes};
use crate::graph::description::{Description, Pass, ResourceId, Shape};
use crate::graph::errors::{ErrorKind, GraphError, GraphErrors};

/// Checks everything; what depends on a wrong thing is not checked further. Gives what follows from how versions are
/// made, what happens to each cell if every pass runs, and who waits for whom then.
pub(super) fn validate(
    description: &Description,
    device: &dyn DeviceModel,
) -> Result<(Versions, Events, Dependencies), GraphErrors> {
    let mut errors = Errors { description, list: Vec::new() };

    // 1. Names, shapes, states of imported resources.
    ids::names(&mut errors);
    ids::resources(&mut errors);

    // 2. Of most frames it is plain to see that nothing else can be wrong but roots.
    let plain = if errors.list.is_empty() { plain::look(description, device) } else { None };
    if let Some((versions, events, dependencies)) = plain {
        versions::roots(&mut errors, &versions);
        return errors.finish((versions, events, dependencies));
    }

    // 3. Ids and ranges. A version that fails is left out of what follows.
    let wholes = wholes(description);
    let broken = ids::versions(&mut errors, &wholes);
    let versions = Versions::new(description, wholes, broken);

    // 4. How versions are made: splits, joins, forks.
    versions::joins(&mut errors, &versions);
    versions::forks(&mut errors, &versions);

    // 5. Passes, use by use and two by two.
    let allowed = allowed(description, device);
    for pass in &description.passes {
        uses::pass(&mut errors, &versions, pass, &allowed);
        uses::pairs(&mut errors, &versions, pass);
    }

    // 6. Roots and checkpoints.
    versions::roots(&mut errors, &versions);

    checkpoints::check(&mut errors);

    // 7. Writers of one version, and circles.
    let (events, dependencies) = order::check(&mut errors, &versions);

    errors.finish((versions, events, dependencies))
}

/// Whether the shapes of all resources can be.
pub(super) fn shapes_are_right(description: &Description) -> bool {
    let mut errors = Errors { description, list: Vec::new() };
    ids::resources(&mut errors);
    errors.list.is_empty()
}

/// By resource: what the device allows its format to be used for; each format is asked for once.
fn allowed(description: &Description, device: &dyn DeviceModel) -> Vec<ImageUsageFlags> {
    let mut known = Memo::new();
    let resources = description.resources.iter();
    let usages = resources.map(|resource| match &resource.shape {
        Shape::Image(shape) => known.get(shape.format, || (device.image_usages(shape.format), true)),
        Shape::Buffer { .. } => ImageUsageFlags::empty(),
    });
    usages.collect()
}

/// Errors so far.
struct Errors<'a> {
    description: &'a Description,
    list: Vec<GraphError>,
}

/// Where an error is.
#[derive(Clone, Copy, Default)]
struct Place<'a> {
    pass: Option<&'a Pass>,
    slot: Option<&'a str>,
    resource: Option<ResourceId>,
}

impl<'a> Place<'a> {
    fn resource(resource: ResourceId) -> Self {
        Place { resource: Some(resource), ..Place::default() }
    }

    fn pass(pass: &'a Pass) -> Self {
        Place { pass: Some(pass), ..Place::default() }
    }
}

impl<'a> Errors<'a> {
    fn add(&mut self, kind: ErrorKind, place: Place, wrong: impl Into<String>, allowed: impl Into<String>) {
        let resource = place.resource.and_then(|id| self.description.resources.get(id.0 as usize));
        self.list.push(GraphError {
            kind,
            pass: place.pass.map(|pass| pass.name.to_string()),
            slot: place.slot.map(Into::into),
            resource: resource.map(|resource| resource.name.to_string()),
            wrong: wrong.into(),
            allowed: allowed.into(),
        });
    }

    fn finish<T>(self, value: T) -> Result<T, GraphErrors> {
        if self.list.is_empty() {
            return Ok(value);
        }
        Err(GraphErrors { graph: self.description.name.clone(), errors: self.list })
    }
}

//! A short way to write descriptions in tests.

use ash::vk;
use shadowgraph::graph::ImageShape;
use shadowgraph::graph::description::{
    Access, Checkpoint, Description, Origin, PassId, Queue, Range, Resource, ResourceId, Root, Shape, Source, Use,
    Version, VersionId,
};

/// A description being written.
#[derive(Clone, Debug, Default)]
pub struct Draft {
    /// So far.
    pub description: Description,
}

/// A pass being written.
pub struct PassDraft<'a> {
    description: &'a mut Description,
    pass: PassId,
    uses: Vec<Use>,
}

impl Draft {
    /// An empty one.
    pub fn new(name: &str) -> Self {
        Self { description: Description { name: name.into(), ..Description::default() } }
    }

    /// A resource; gives its first version.
    pub fn resource(&mut self, name: &str, shape: Shape, origin: Origin) -> VersionId {
        let resource = ResourceId(self.description.resources.len() as u32);
        let range = shape.whole();
        self.description.resources.push(Resource { name: name.into(), shape, origin });
        self.version(resource, range, Source::Initial)
    }

    /// A transient colour image of so many texels.
    pub fn image(&mut self, name: &str, size: [u32; 2]) -> VersionId {
        let shape = ImageShape::new_2d(vk::Format::R8G8B8A8_UNORM, size);
        self.resource(name, Shape::Image(shape), Origin::Transient)
    }

    /// A transient depth image.
    pub fn depth(&mut self, name: &str, size: [u32; 2]) -> VersionId {
        let shape = ImageShape::new_2d(vk::Format::D32_SFLOAT, size);
        self.resource(name, Shape::Image(shape), Origin::Transient)
    }

    /// A transient buffer.
    pub fn buffer(&mut self, name: &str, size: u64) -> VersionId {
        self.resource(name, Shape::Buffer { size }, Origin::Transient)
    }

    /// A version of any source.
    pub fn version(&mut self, resource: ResourceId, range: Range, source: Source) -> VersionId {
        let id = VersionId(self.description.versions.len() as u32);
        self.description.versions.push(Version { resource, range, source });
        id
    }

    /// A part of a version.
    pub fn split(&mut self, of: VersionId, range: Range) -> VersionId {
        self.version(self.resource_of(of), range, Source::Split { of })
    }

    /// Parts put together again.
    pub fn join(&mut self, of: &[VersionId]) -> VersionId {
        let ranges = of.iter().map(|part| self.description.versions[part.0 as usize].range);
        let range = ranges.reduce(Range::hull).unwrap_or(Range::Buffer([0, 0]));
        self.version(self.resource_of(of[0]), range, Source::Join { of: of.to_vec() })
    }

    /// Versions for so many unordered writers.
    pub fn fork(&mut self, of: VersionId, count: usize) -> Vec<VersionId> {
        let Version { resource, range, .. } = self.description.versions[of.0 as usize];
        (0..count).map(|_| self.version(resource, range, Source::Fork { of })).collect()
    }

    /// A pass.
    pub fn pass<R>(&mut self, name: &str, queue: Queue, uses: impl FnOnce(&mut PassDraft) -> R) -> R {
        let pass = PassId(self.description.passes.len() as u32);
        let mut draft = PassDraft { description: &mut self.description, pass, uses: Vec::new() };
        let result = uses(&mut draft);
        let uses = draft.uses;
        self.description.add_pass(name, queue, uses);
        result
    }

    /// A root whose bytes are copied to the host.
    pub fn capture(&mut self, name: &str, version: VersionId) {
        self.description.roots.push(Root { name: name.into(), version, read_back: true });
    }

    /// The host reads a version before anything that is written from here on.
    pub fn checkpoint(&mut self, name: &str, version: VersionId) {
        let root = self.description.roots.len();
        self.capture(&format!("checkpoint {name}"), version);
        self.description.checkpoints.push(Checkpoint {
            name: name.into(),
            root: Some(root),
            passes: self.description.passes.len(),
            versions: self.description.versions.len(),
            resources: self.description.resources.len(),
        });
    }

    /// A root that stays where it is.
    pub fn keep(&mut self, name: &str, version: VersionId) {
        self.description.roots.push(Root { name: name.into(), version, read_back: false });
    }

    fn resource_of(&self, version: VersionId) -> ResourceId {
        self.description.versions[version.0 as usize].resource
    }
}

impl PassDraft<'_> {
    /// Reads a version.
    pub fn read(&mut self, slot: &str, version: VersionId, access: Access) {
        self.uses.push(Use { slot: slot.to_owned().into(), version, makes: None, reads: true, access });
    }

    /// Writes over a version of which something remains; gives the next one.
    pub fn write(&mut self, slot: &str, version: VersionId, access: Access) -> VersionId {
        self.add(slot, version, access, true)
    }

    /// Writes over all of a version.
    pub fn overwrite(&mut self, slot: &str, version: VersionId, access: Access) -> VersionId {
        self.add(slot, version, access, false)
    }

    fn add(&mut self, slot: &str, from: VersionId, access: Access, reads: bool) -> VersionId {
        let made = VersionId(self.description.versions.len() as u32);
        let Version { resource, range, .. } = self.description.versions[from.0 as usize];
        let source = Source::Pass { pass: self.pass, from };
        self.description.versions.push(Version { resource, range, source });
        self.uses.push(Use { slot: slot.to_owned().into(), version: from, makes: Some(made), reads, access });
        made
    }
}

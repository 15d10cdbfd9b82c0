//! Describing a frame: resources, passes, roots. Touches no device.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use ash::vk;

use super::checkpoint::Later;
use super::description::{
    Access, Description, ImageShape, Origin, Pass, PassId, Queue, Range, Resource, ResourceId, Root, Shape, Source,
    Use, Version, VersionId,
};
use super::errors::{ErrorKind, GraphError, GraphErrors};
use super::execute::Asked;
use super::handle::{BufferHandle, Handle, ImageHandle};
use super::history::{Declared, KeptHistories};
use super::name::Name;
use super::pass::{Bound, ComputePass, RasterPass, Work};
use super::plan::{DeviceModel, Plan, Planned, plan};
use crate::gpu::{Buffer, Caps, Image};
use crate::shader::{Program, Shader};

/// A frame being described. Passes may borrow what lives for `'f`.
pub struct Graph<'f> {
    pub(super) id: u64,
    pub(super) caps: &'f Caps,
    pub(super) description: Description,
    /// What each pass does, in the order of `description.passes`.
    pub(super) work: Vec<Work<'f>>,
    /// What lies behind the bindings of all passes.
    pub(super) bound: Vec<Bound>,
    /// Memory of imported resources, in the order of `description.resources`.
    pub(super) external: Vec<Option<External>>,
    /// Bytes for uniform and constant bindings of this frame.
    pub(super) arena: Arena,
    /// Mistakes that the typed layer saw.
    pub(super) mistakes: Vec<GraphError>,
    /// What the executor keeps from the last frame.
    pub(super) kept: Arc<KeptHistories>,
    pub(super) histories: Vec<Declared>,
    /// Whether histories begin anew.
    pub(super) cut: bool,
    /// What follows from what checkpoints read.
    pub(super) later: Vec<Later<'f>>,
    /// What passes ask the device to count.
    pub(super) queries: Vec<Asked>,
    /// Of the description when it had these counts.
    pub(super) known_fingerprint: Cell<Option<([usize; 5], u64)>>,
}

/// An imported resource.
#[derive(Clone)]
pub(super) enum External {
    Image(Image),
    Buffer(Buffer),
}

/// Bytes that the host gives the frame's shaders.
#[derive(Default)]
pub(super) struct Arena {
    pub(super) bytes: Vec<u8>,
}

/// Largest offset alignment that Vulkan lets a device ask for.
const ARENA_ALIGNMENT: usize = 256;

impl Arena {
    fn push(&mut self, bytes: &[u8]) -> Data {
        self.bytes.resize(self.bytes.len().next_multiple_of(ARENA_ALIGNMENT), 0);
        let offset = self.bytes.len() as u64;
        self.bytes.extend_from_slice(bytes);
        // No binding is empty.
        if bytes.is_empty() {
            self.bytes.extend_from_slice(&[0; 16]);
        }
        Data { offset, size: (self.bytes.len() as u64) - offset }
    }
}

/// Bytes in the frame's arena: read-only for its shaders, free of hazards.
#[derive(Clone, Copy, Debug)]
pub struct Data {
    pub(super) offset: u64,
    pub(super) size: u64,
}

static NEXT_GRAPH: AtomicU64 = AtomicU64::new(0);

impl<'f> Graph<'f> {
    /// An empty frame for devices with these capabilities.
    pub fn new(name: &str, caps: &'f Caps) -> Self {
        Self {
            id: NEXT_GRAPH.fetch_add(1, Ordering::Relaxed),
            caps,
            description: Description { name: name.into(), ..Description::default() },
            work: Vec::new(),
            bound: Vec::new(),
            external: Vec::new(),
            arena: Arena::default(),
            mistakes: Vec::new(),
            kept: Arc::default(),
            histories: Vec::new(),
            cut: false,
            later: Vec::new(),
            queries: Vec::new(),
            known_fingerprint: Cell::new(None),
        }
    }

    /// What the device can do, for techniques that choose between paths.
    pub fn caps(&self) -> &'f Caps {
        self.caps
    }

    /// The untyped description so far.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// A new image of this frame. Its contents are undefined.
    pub fn image(&mut self, name: impl Into<Name>, shape: ImageShape) -> ImageHandle {
        self.new_image(name.into(), shape, Origin::Transient, None)
    }

    /// A new buffer of this frame. Its contents are undefined.
    pub fn buffer(&mut self, name: impl Into<Name>, size: u64) -> BufferHandle {
        self.new_buffer(name.into(), size, Origin::Transient, None)
    }

    /// An image that outlives the frame. It arrives in the state `before` and is left in `after` (or as its last use
    /// leaves it).
    pub fn import_image(&mut self, image: &Image, before: Access, after: Option<Access>) -> ImageHandle {
        let info = image.info();
        let shape = ImageShape {
            format: info.format,
            extent: info.extent,
            mips: info.mips,
            layers: info.layers,
            samples: info.samples,
        };
        let external = External::Image(image.clone());
        self.new_image(image.name().into(), shape, Origin::Imported { before, after }, Some(external))
    }

    /// A buffer that outlives the frame; as [`Graph::import_image`].
    pub fn import_buffer(&mut self, buffer: &Buffer, before: Access, after: Option<Access>) -> BufferHandle {
        let external = External::Buffer(buffer.clone());
        self.new_buffer(buffer.name().into(), buffer.size(), Origin::Imported { before, after }, Some(external))
    }

    /// Copies values into the frame's arena, for `constant` bindings of its passes.
    pub fn data<T: bytemuck::Pod>(&mut self, values: &[T]) -> Data {
        self.arena.push(bytemuck::cast_slice(values))
    }

    /// A compute pass of one dispatch. Its name is unique in the frame.
    pub fn compute(&mut self, name: impl Into<Name>, shader: &'static Shader) -> ComputePass<'_, 'f> {
        ComputePass::new(self, name.into(), shader)
    }

    /// A pass of draws with these programs. Its name is unique in the frame.
    pub fn raster(&mut self, name: impl Into<Name>, programs: Vec<Program>) -> RasterPass<'_, 'f> {
        RasterPass::new(self, name.into(), programs)
    }

    /// Fills a buffer with a 32-bit value.
    pub fn fill(&mut self, name: impl Into<Name>, buffer: BufferHandle, value: u32) -> BufferHandle {
        let pass = self.begin_pass();
        let next = self.written(pass, "destination", buffer, false, Access::transfer_write());
        let work = Work::Fill { resource: next.resource, range: next.range, value };
        self.push_pass(name.into(), Queue::Transfer, work);
        next
    }

    /// Clears a colour image.
    pub fn clear(&mut self, name: impl Into<Name>, image: ImageHandle, value: vk::ClearColorValue) -> ImageHandle {
        let pass = self.begin_pass();
        let next = self.written(pass, "destination", image, false, Access::transfer_write());
        let work = Work::Clear { resource: next.resource, range: next.range, value };
        self.push_pass(name.into(), Queue::Graphics, work);
        next
    }

    /// Plans the frame for a device, up to its first checkpoint; the executor plans on.
    ///
    /// # Errors
    /// All that is wrong with it, at once.
    pub fn compile(&self, device: &dyn DeviceModel) -> Result<Plan, GraphErrors> {
        let plan = plan(&self.description, device).map(|plan| Plan { fingerprint: self.fingerprint(), ..plan });
        self.checked(plan, |plan| plan)
    }

    /// As [`Graph::compile`], going on from the plan of a frame that is like it but for sizes, where there is one.
    pub(super) fn compile_like<'k>(
        &self,
        mut known: impl Iterator<Item = &'k (Description, Planned)>,
        device: &dyn DeviceModel,
    ) -> Result<Planned, GraphErrors> {
        let resized = known.find_map(|(description, planned)| planned.resized(description, &self.description, device));
        let planned = resized.map_or_else(|| Planned::new(&self.description, device), Ok);
        self.checked(planned.map(|planned| planned.with_fingerprint(self.fingerprint())), |planned| &planned.plan)
    }

    /// What was planned, if the typed layer saw nothing wrong either.
    fn checked<T>(&self, planned: Result<T, GraphErrors>, plan: impl Fn(&T) -> &Plan) -> Result<T, GraphErrors> {
        let partly = planned.as_ref().map_or_else(|_| Vec::new(), |planned| self.written_in_part(plan(planned)));
        if self.mistakes.is_empty() && partly.is_empty() {
            return planned;
        }
        let mut errors = [self.mistakes.clone(), partly].concat();
        errors.extend(planned.err().map(|more| more.errors).unwrap_or_default());
        Err(GraphErrors { graph: self.description.name.clone(), errors })
    }

    /// Of the description so far; found once for so many resources, versions, passes and roots.
    pub(super) fn fingerprint(&self) -> u64 {
        let counts = self.description.counts();
        let known = self.known_fingerprint.get().filter(|(known, _)| *known == counts);
        let fingerprint = known.map_or_else(|| self.description.fingerprint(), |(_, fingerprint)| fingerprint);
        self.known_fingerprint.set(Some((counts, fingerprint)));
        fingerprint
    }

    /// The description is that of a plan.
    pub(super) fn is_as_planned(&self, plan: &Plan) {
        self.known_fingerprint.set(Some((self.description.counts(), plan.fingerprint)));
    }

    /// Whether the typed layer saw nothing wrong.
    pub(super) fn is_without_mistakes(&self) -> bool {
        self.mistakes.is_empty()
    }

    /// Marks contents to be read back at the end of the frame, under a name. They are neither culled nor aliased
    /// away; where a later pass writes over them, a copy is made before.
    pub fn capture(&mut self, name: impl Into<String>, handle: &impl Handle) {
        let name = name.into();
        self.check_owner(&name, handle);
        self.description.roots.push(Root { name, version: handle.version(), read_back: true });
    }

    /// Marks contents that somebody needs after the frame: an imported image that is shown.
    pub fn keep(&mut self, name: impl Into<String>, handle: &impl Handle) {
        let name = name.into();
        self.check_owner(&name, handle);
        self.description.roots.push(Root { name, version: handle.version(), read_back: false });
    }

    pub(super) fn new_image(
        &mut self,
        name: Name,
        shape: ImageShape,
        origin: Origin,
        external: Option<External>,
    ) -> ImageHandle {
        let range = Range::whole_image(&shape);
        let (resource, version) = self.new_resource(name, Shape::Image(shape), range, origin, external);
        ImageHandle { graph: self.id, resource, version, shape, range }
    }

    pub(super) fn new_buffer(
        &mut self,
        name: Name,
        size: u64,
        origin: Origin,
        external: Option<External>,
    ) -> BufferHandle {
        let range = Range::Buffer([0, size]);
        let (resource, version) = self.new_resource(name, Shape::Buffer { size }, range, origin, external);
        BufferHandle { graph: self.id, resource, version, range }
    }

    fn new_resource(
        &mut self,
        name: Name,
        shape: Shape,
        range: Range,
        origin: Origin,
        external: Option<External>,
    ) -> (ResourceId, VersionId) {
        let resource = ResourceId(self.description.resources.len() as u32);
        self.description.resources.push(Resource { name, shape, origin });
        self.external.push(external);
        (resource, self.version(resource, range, Source::Initial))
    }

    pub(super) fn version(&mut self, resource: ResourceId, range: Range, source: Source) -> VersionId {
        let id = VersionId(self.description.versions.len() as u32);
        self.description.versions.push(Version { resource, range, source });
        id
    }

    /// The id that the next pushed pass gets. Uses of one that was begun and never pushed go.
    pub(super) fn begin_pass(&mut self) -> PassId {
        let first = self.first_use();
        self.description.uses.truncate(first as usize);
        PassId(self.description.passes.len() as u32)
    }

    /// Where the uses of the pass begin that is being described.
    fn first_use(&self) -> u32 {
        self.description.passes.last().map_or(0, |last| last.uses.end)
    }

    /// The pass that was begun, with the uses that were added since.
    pub(super) fn push_pass(&mut self, name: Name, queue: Queue, work: Work<'f>) {
        let description = &self.description;
        let counts = self.queries.last().is_some_and(|asked| asked.pass.0 as usize == description.passes.len());
        let side_effect = counts.then(|| "the device counts over it".into());
        let uses = self.first_use()..description.uses.len() as u32;
        self.description.passes.push(Pass { name, queue, uses, side_effect });
        self.work.push(work);
    }

    /// The pass being described reads.
    pub(super) fn used(&mut self, slot: &'static str, handle: &impl Handle, access: Access) {
        self.check_owner(slot, handle);
        let version = handle.version();
        self.description.uses.push(Use { slot: slot.into(), version, makes: None, reads: true, access });
    }

    /// The pass being described writes: `reads` where the contents before it matter. Undefined contents never do.
    pub(super) fn written<H: Handle>(
        &mut self,
        pass: PassId,
        slot: &'static str,
        handle: H,
        reads: bool,
        access: Access,
    ) -> H {
        self.check_previous(slot, &handle);
        self.replaced(pass, slot, handle, reads, access)
    }

    /// As [`Graph::written`], of any resource.
    pub(super) fn replaced<H: Handle>(
        &mut self,
        pass: PassId,
        slot: &'static str,
        handle: H,
        reads: bool,
        access: Access,
    ) -> H {
        self.check_owner(slot, &handle);
        let version = handle.version();
        let makes = self.version(handle.resource(), handle.range(), Source::Pass { pass, from: version });
        self.description.uses.push(Use { slot: slot.into(), version, makes: Some(makes), reads, access });
        handle.next(makes)
    }

    /// Whether a version still is as its resource began, undefined.
    pub(super) fn is_undefined(&self, handle: &impl Handle) -> bool {
        if handle.graph() != self.id {
            return false;
        }
        let mut version = handle.version();
        loop {
            match &self.description.versions[version.0 as usize].source {
                Source::Initial => {
                    return match &self.description.resources[handle.resource().0 as usize].origin {
                        Origin::Transient => true,
                        Origin::Imported { .. } => false,
                        Origin::Kept { before, .. } => {
                            !before.iter().any(|state| state.holds && state.range.overlaps(&handle.range()))
                        }
                    };
                }
                Source::Split { of } | Source::Fork { of } => version = *of,
                Source::Pass { .. } | Source::Join { .. } => return false,
            }
        }
    }

    pub(super) fn check_owner(&mut self, slot: &str, handle: &impl Handle) {
        if handle.graph() != self.id {
            let allowed = format!("handles that `{}` gave", self.description.name);
            self.mistake(None, Some(slot), "is a handle of another graph".into(), allowed);
        }
    }

    /// Says that a technique cannot do what it was asked for: [`Graph::compile`] will fail with this. `slot`: which of
    /// its inputs or settings.
    pub fn refuse(&mut self, technique: &str, slot: &str, wrong: String, allowed: String) {
        let (pass, slot) = (Some(technique.into()), Some(slot.into()));
        self.mistakes.push(GraphError { kind: ErrorKind::Refused, pass, slot, resource: None, wrong, allowed });
    }

    /// Notes something wrong, to be told by [`Graph::compile`].
    pub(super) fn mistake(&mut self, pass: Option<&str>, slot: Option<&str>, wrong: String, allowed: String) {
        let (pass, slot) = (pass.map(Into::into), slot.map(Into::into));
        self.mistakes.push(GraphError { kind: ErrorKind::Binding, pass, slot, resource: None, wrong, allowed });
    }
}

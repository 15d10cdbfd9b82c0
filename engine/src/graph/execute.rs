//! Running a planned frame on a device.

use std::time::{Duration, Instant};

use ash::vk;

use super::builder::{External, Graph};
use super::description::{Description, PassId, Queue, Range, ResourceId, Shape};
use super::pass::{Attachment, Attachments, Bound, DrawFn, Groups, What, Work};
use super::plan::{self, Barriers, DeviceModel, Plan, Usage, Work as Step};
use super::record::{self, Batch, Ready, Recorder};
use crate::gpu::{
    Buffer, BufferInfo, Commands, Descriptor, DescriptorArena, Feature, FormatInfo, Gpu, Heap, Image, ImageInfo,
    Memory, QueryKind, QueryPool, Requirements, ViewInfo,
};
use crate::shader::{Binding, BindingKind, Pipelines};
use crate::{Error, Result};

/// Runs frames on a device, and keeps from frame to frame what they can share: pipelines, descriptor pools, memory.
///
/// `Send`; one thread uses it at a time. It keeps its device alive.
pub struct Executor<'g> {
    gpu: &'g Gpu,
    pipelines: Pipelines,
    descriptors: DescriptorArena,
    heaps: Vec<(Requirements, Heap)>,
}

/// A frame that has run.
pub struct Executed {
    /// Captured contents, in the order they were captured.
    pub captures: Vec<Capture>,
    /// Time of each pass on the device, in the order of the plan; empty where the device has no timestamps.
    pub passes: Vec<PassTime>,
    /// Time from the start of the call to submission, on the host.
    pub recording: Duration,
    /// Time from submission until the device was done.
    pub running: Duration,
}

/// How long a pass took.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// Name of the pass.
    pub name: String,
    /// Seconds on the device.
    pub seconds: f64,
}

/// Contents read back.
pub struct Capture {
    /// Name given to [`Graph::capture`].
    pub name: String,
    /// Image (of the captured mips and layers) or buffer.
    pub shape: Shape,
    buffer: Buffer,
    /// Where each mip of each layer begins: layers of a mip lie side by side.
    mips: Vec<u64>,
    layer_sizes: Vec<u64>,
}

impl Capture {
    /// Looks at all bytes: mips one after the other, in each its layers, rows from the top, tightly packed.
    ///
    /// # Errors
    /// [`Error::Vulkan`] where the memory cannot be read.
    pub fn bytes<R>(&self, look: impl FnOnce(&[u8]) -> R) -> Result<R> {
        self.buffer.read_with(look)
    }

    /// All bytes as values of one type: `f32` four times a texel for `R32G32B32A32_SFLOAT`.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the bytes are not a whole number of values; [`Error::Vulkan`] where the memory cannot
    /// be read.
    pub fn texels<T: bytemuck::Pod>(&self) -> Result<Vec<T>> {
        self.bytes(|bytes| {
            let whole = size_of::<T>() > 0 && bytes.len() % size_of::<T>() == 0;
            let wrong = || format!("has {} bytes, no whole number of {}", bytes.len(), std::any::type_name::<T>());
            whole.then(|| bytemuck::pod_collect_to_vec(bytes)).ok_or_else(|| Error::invalid(&self.name, wrong()))
        })?
    }

    /// Looks at the texels of one layer of the first mip.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a layer it does not have; [`Error::Vulkan`] where the memory cannot be read.
    pub fn layer<R>(&self, layer: u32, look: impl FnOnce(&[u8]) -> R) -> Result<R> {
        let (Some(&start), Some(&size)) = (self.mips.first(), self.layer_sizes.first()) else {
            return Err(Error::invalid(&self.name, "is a buffer, which has no layers"));
        };
        let first = (start + size * u64::from(layer)) as usize;
        let end = first + size as usize;
        self.buffer.read_with(|bytes| bytes.get(first..end).map(look))?.ok_or_else(|| {
            Error::invalid(format!("layer {layer} of `{}`", self.name), "is not among the captured layers")
        })
    }
}

impl Executed {
    /// A capture by name.
    ///
    /// # Errors
    /// [`Error::Invalid`] listing what was captured.
    pub fn capture(&self, name: &str) -> Result<&Capture> {
        self.captures.iter().find(|capture| capture.name == name).ok_or_else(|| {
            let known: Vec<_> = self.captures.iter().map(|capture| capture.name.as_str()).collect();
            Error::invalid(format!("capture `{name}`"), format!("was not made; there are {}", known.join(", ")))
        })
    }
}

impl<'g> Executor<'g> {
    /// An executor without anything kept yet.
    pub fn new(gpu: &'g Gpu) -> Self {
        let descriptors = gpu.descriptor_arena("passes");
        Self { gpu, pipelines: Pipelines::default(), descriptors, heaps: Vec::new() }
    }

    /// Runs a frame and waits until the device is done.
    ///
    /// # Errors
    /// [`Error::Missing`] where a shader asks for what the device lacks; [`Error::OutOfMemory`] naming the heap;
    /// [`Error::DeviceLost`] naming the last pass that began; what a pass's closure returns.
    pub fn execute(&mut self, plan: &Plan, graph: Graph) -> Result<Executed> {
        let start = Instant::now();
        let Graph { description, mut work, external, arena, .. } = graph;
        let mut work: Vec<Option<Work>> = work.drain(..).map(Some).collect();

        // 1. Memory: what the plan placed, what the frame imports, what the host hands over, what it reads back.
        let memory = self.memory(plan, &description, external)?;
        let arena = self.arena(&arena.bytes)?;
        let captures = self.capture_buffers(&description)?;

        // 2. Pipelines and descriptor sets.
        self.descriptors.reset();
        let mut ready = Vec::with_capacity(work.len());
        for step in &plan.steps {
            if let Step::Pass(PassId(pass)) = step.work {
                let name = &description.passes[pass as usize].name;
                if let Some(work) = &work[pass as usize] {
                    ready.push((pass, self.prepare(name, work, &memory, arena.as_ref())?));
                }
            }
        }

        // 3. Commands, in the order of the plan.
        let device = self.gpu.raw();
        let mut commands = self.gpu.commands(&description.name)?;
        let timer = Timer::new(self.gpu, plan.steps.len())?;
        let mut ready = ready.into_iter();
        let mut names = Vec::with_capacity(plan.steps.len());
        for (index, step) in plan.steps.iter().enumerate() {
            batch(&step.barriers, &memory).record(device, &commands);
            timer.mark(device, &commands, 2 * index);
            match step.work {
                Step::Pass(PassId(pass)) => {
                    let name = &description.passes[pass as usize].name;
                    commands.begin_pass(name);
                    if let (Some(work), Some((_, programs))) = (work[pass as usize].take(), ready.next()) {
                        run(device, &commands, work, &programs, &memory)?;
                    }
                    commands.end_pass();
                    names.push(name.clone());
                }
                Step::ReadBack(root) => {
                    let name = &description.roots[root].name;
                    commands.begin_pass(&format!("read back {name}"));
                    read_back(device, &commands, &description, root, &memory, captures[root].as_ref());
                    commands.end_pass();
                    names.push(format!("read back {name}"));
                }
            }
            timer.mark(device, &commands, 2 * index + 1);
        }
        batch(&plan.finally, &memory).record(device, &commands);

        // 4. Run, and wait.
        let recording = start.elapsed();
        let submitted = Instant::now();
        let token = self.gpu.submit(commands)?;
        self.gpu.wait(token)?;
        let running = submitted.elapsed();
        let passes = timer.times(names)?;
        Ok(Executed { captures: captures.into_iter().flatten().collect(), passes, recording, running })
    }

    /// Images and buffers of the frame, by resource.
    fn memory(&mut self, plan: &Plan, description: &Description, external: Vec<Option<External>>) -> Result<Resources> {
        let mut heaps = Vec::with_capacity(plan.heaps.len());
        for (index, heap) in plan.heaps.iter().enumerate() {
            let wanted = Requirements { size: heap.size, alignment: heap.alignment, type_bits: heap.type_bits };
            heaps.push(self.heap(index, wanted)?);
        }
        let mut resources = Resources(external);
        for placement in &plan.placements {
            let resource = &description.resources[placement.resource.0 as usize];
            let heap = &heaps[placement.heap];
            let made = match (&resource.shape, plan.usages[placement.resource.0 as usize]) {
                (Shape::Image(shape), Some(Usage::Image(usage))) => {
                    let info = image_info(&resource.name, shape, usage);
                    External::Image(self.gpu.place_image(heap, placement.offset, &info)?)
                }
                (&Shape::Buffer { size }, Some(Usage::Buffer(usage))) => {
                    let info = BufferInfo { name: &resource.name, size, usage, memory: Memory::Device };
                    External::Buffer(self.gpu.place_buffer(heap, placement.offset, &info)?)
                }
                _ => continue,
            };
            resources.0[placement.resource.0 as usize] = Some(made);
        }
        Ok(resources)
    }

    /// The heap kept for this place where it fits, else a new one.
    fn heap(&mut self, index: usize, wanted: Requirements) -> Result<Heap> {
        let fits = |kept: &Requirements| {
            kept.size >= wanted.size && kept.alignment >= wanted.alignment && kept.type_bits == wanted.type_bits
        };
        if let Some((_, heap)) = self.heaps.get(index).filter(|(kept, _)| fits(kept)) {
            return Ok(heap.clone());
        }
        self.heaps.truncate(index);
        let heap = self.gpu.create_heap(&format!("transients {index}"), wanted, Memory::Device)?;
        self.heaps.push((wanted, heap.clone()));
        Ok(heap)
    }

    fn arena(&self, bytes: &[u8]) -> Result<Option<Buffer>> {
        if bytes.is_empty() {
            return Ok(None);
        }
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::STORAGE_BUFFER;
        let size = bytes.len() as u64;
        let buffer = self.gpu.create_buffer(&BufferInfo { name: "frame data", size, usage, memory: Memory::Upload })?;
        buffer.write(0, bytes)?;
        Ok(Some(buffer))
    }

    /// A host buffer for each root that is read back.
    fn capture_buffers(&self, description: &Description) -> Result<Vec<Option<Capture>>> {
        let capture = |root: &super::description::Root| {
            let version = &description.versions[root.version.0 as usize];
            let resource = &description.resources[version.resource.0 as usize];
            let (shape, mips, layer_sizes, size) = captured_layout(&resource.shape, version.range);
            let name = format!("capture {}", root.name);
            let usage = vk::BufferUsageFlags::TRANSFER_DST;
            let memory = Memory::Readback;
            let buffer = self.gpu.create_buffer(&BufferInfo { name: &name, size, usage, memory })?;
            Ok(Capture { name: root.name.clone(), shape, buffer, mips, layer_sizes })
        };
        description.roots.iter().map(|root| root.read_back.then(|| capture(root)).transpose()).collect()
    }

    /// Pipelines of a pass's programs, each with its set 0.
    fn prepare(&mut self, pass: &str, work: &Work, memory: &Resources, arena: Option<&Buffer>) -> Result<Vec<Ready>> {
        let (pipelines, bound) = match work {
            Work::Compute { shader, constants, bound, .. } => {
                (vec![self.pipelines.compute(self.gpu, shader, constants)?], bound)
            }
            Work::Raster { programs, targets, bound, .. } => {
                let make = |program| self.pipelines.graphics(self.gpu, program, targets);
                (programs.iter().map(make).collect::<Result<Vec<_>>>()?, bound)
            }
            Work::Fill { .. } | Work::Clear { .. } => return Ok(Vec::new()),
        };
        let mut ready = Vec::with_capacity(pipelines.len());
        for pipeline in pipelines {
            let mut descriptors = Vec::new();
            for wanted in pipeline.bindings().iter().filter(|wanted| wanted.binding.set == 0) {
                let number = wanted.binding.binding;
                let Some(found) = bound.iter().find(|b| b.binding.binding == number) else { continue };
                descriptors.push((number, self.descriptor(pass, found, &wanted.binding, memory, arena)?));
            }
            let set = match descriptors.is_empty() {
                true => vk::DescriptorSet::null(),
                false => self.descriptors.set(&pipeline, 0, &descriptors)?,
            };
            ready.push(Ready { pipeline, set });
        }
        Ok(ready)
    }

    fn descriptor(
        &self,
        pass: &str,
        bound: &Bound,
        binding: &Binding,
        memory: &Resources,
        arena: Option<&Buffer>,
    ) -> Result<Descriptor> {
        let missing = || Error::invalid(format!("`{}` of pass `{pass}`", binding.name), "has no memory behind it");
        let kind = binding.image.map_or(vk::ImageViewType::TYPE_2D, |image| image.view);
        match &bound.what {
            What::Data(data) => {
                let buffer = arena.ok_or_else(missing)?.clone();
                Ok(Descriptor::Buffer { buffer, offset: data.offset, size: data.size })
            }
            What::Buffer(buffer) => Ok(Descriptor::buffer(buffer)),
            What::Image(image, sampler) => {
                let view = image.whole().kind(kind);
                let layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
                self.image_descriptor(binding, image.clone(), view, layout, sampler)
            }
            What::Resource { resource, range, layout, sampler } => {
                match (memory.0[resource.0 as usize].as_ref().ok_or_else(missing)?, *range) {
                    (External::Image(image), Range::Image { aspects, mips, layers }) => {
                        // A sampled depth-stencil image shows its depth.
                        let depth = vk::ImageAspectFlags::DEPTH;
                        let aspects = if aspects.contains(depth) { depth } else { aspects };
                        let view = ViewInfo { kind, mips, layers, aspects, ..image.whole() };
                        self.image_descriptor(binding, image.clone(), view, *layout, sampler)
                    }
                    (External::Buffer(buffer), Range::Buffer([first, end])) => {
                        Ok(Descriptor::Buffer { buffer: buffer.clone(), offset: first, size: end - first })
                    }
                    _ => Err(missing()),
                }
            }
        }
    }

    fn image_descriptor(
        &self,
        binding: &Binding,
        image: Image,
        view: ViewInfo,
        layout: vk::ImageLayout,
        sampler: &crate::gpu::SamplerInfo,
    ) -> Result<Descriptor> {
        Ok(match binding.kind {
            BindingKind::CombinedImageSampler => {
                Descriptor::Sampled { image, view, layout, sampler: self.gpu.sampler(sampler)? }
            }
            _ => Descriptor::Image { image, view, layout },
        })
    }
}

/// Memory of a frame's resources, by their number.
struct Resources(Vec<Option<External>>);

impl Resources {
    fn image(&self, resource: ResourceId) -> Option<&Image> {
        match self.0.get(resource.0 as usize) {
            Some(Some(External::Image(image))) => Some(image),
            _ => None,
        }
    }

    fn buffer(&self, resource: ResourceId) -> Option<&Buffer> {
        match self.0.get(resource.0 as usize) {
            Some(Some(External::Buffer(buffer))) => Some(buffer),
            _ => None,
        }
    }
}

fn image_info<'a>(name: &'a str, shape: &super::ImageShape, usage: vk::ImageUsageFlags) -> ImageInfo<'a> {
    ImageInfo {
        name,
        format: shape.format,
        extent: shape.extent,
        mips: shape.mips,
        layers: shape.layers,
        samples: shape.samples,
        usage,
        ..ImageInfo::default()
    }
}

/// What the planner asks of a device.
impl DeviceModel for Gpu {
    /// One queue does everything: a second one pays off only where the device has it, and no software driver does.
    fn family(&self, queue: Queue) -> Option<u32> {
        (queue == Queue::Graphics).then_some(self.caps().queue_family)
    }

    fn requirements(&self, shape: &Shape, usage: Usage) -> plan::Requirements {
        let asked = match (shape, usage) {
            (Shape::Image(shape), Usage::Image(usage)) => self.image_requirements(&image_info("", shape, usage)),
            (&Shape::Buffer { size }, Usage::Buffer(usage)) => {
                self.buffer_requirements(&BufferInfo { name: "", size, usage, memory: Memory::Device })
            }
            _ => return plan::Requirements { size: 0, alignment: 1, type_bits: 0 },
        };
        // What the device cannot make at all is found again, with its name, where the frame makes it.
        let none = Requirements { size: 0, alignment: 1, type_bits: 0 };
        let Requirements { size, alignment, type_bits } = asked.unwrap_or(none);
        plan::Requirements { size, alignment, type_bits }
    }

    fn granularity(&self) -> u64 {
        self.caps().limits.buffer_image_granularity.max(1)
    }
}

/// What a pass does.
fn run(device: &ash::Device, commands: &Commands, work: Work, programs: &[Ready], memory: &Resources) -> Result<()> {
    match work {
        Work::Compute { push, groups, .. } => {
            let Some(ready) = programs.first() else { return Ok(()) };
            match groups {
                Groups::Direct(groups) => record::dispatch(device, commands, ready, &push, groups, None),
                Groups::Indirect(resource, offset) => {
                    let indirect = memory.buffer(resource).map(|buffer| (buffer, offset));
                    record::dispatch(device, commands, ready, &push, [0; 3], indirect);
                }
            }
            Ok(())
        }
        Work::Raster { targets, attachments, draw, .. } => {
            render(device, commands, &attachments, targets.view_mask, programs, draw, memory)
        }
        Work::Fill { resource, range: Range::Buffer(range), value } => {
            if let Some(buffer) = memory.buffer(resource) {
                record::fill(device, commands, buffer, range, value);
            }
            Ok(())
        }
        Work::Clear { resource, range, value } => {
            if let (Some(image), Some(range)) = (memory.image(resource), subresources(range)) {
                record::clear(device, commands, image, range, value);
            }
            Ok(())
        }
        Work::Fill { .. } => Ok(()),
    }
}

fn render(
    device: &ash::Device,
    commands: &Commands,
    attachments: &Attachments,
    view_mask: u32,
    programs: &[Ready],
    draw: DrawFn,
    memory: &Resources,
) -> Result<()> {
    let info = |attachment: &Attachment| -> Result<vk::RenderingAttachmentInfo<'static>> {
        let image = memory.image(attachment.resource);
        let image = image.ok_or_else(|| Error::invalid("an attachment", "has no image behind it"))?;
        let Range::Image { aspects, mips, layers } = attachment.range else {
            return Err(Error::invalid("an attachment", "is a buffer"));
        };
        let array = layers[1] - layers[0] > 1;
        let kind = if array { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D };
        let view = image.view(&ViewInfo { kind, aspects, mips, layers, ..image.whole() })?;
        Ok(vk::RenderingAttachmentInfo::default()
            .image_view(view)
            .image_layout(attachment.layout)
            .load_op(attachment.load)
            .store_op(attachment.store)
            .clear_value(attachment.clear))
    };
    let color = attachments.color.iter().flatten().map(info).collect::<Result<Vec<_>>>()?;
    let depth = attachments.depth.as_ref().map(info).transpose()?;
    let Attachments { size, layers, .. } = *attachments;
    record::begin_rendering(device, commands, &color, depth.as_ref(), None, size, layers, view_mask);
    let drawn = draw(&mut Recorder::new(device, commands, programs));
    record::end_rendering(device, commands);
    drawn
}

/// Copies a root to its host buffer.
fn read_back(
    device: &ash::Device,
    commands: &Commands,
    description: &Description,
    root: usize,
    memory: &Resources,
    capture: Option<&Capture>,
) {
    let version = &description.versions[description.roots[root].version.0 as usize];
    let (Some(capture), resource) = (capture, version.resource) else { return };
    match version.range {
        Range::Buffer([first, end]) => {
            if let Some(buffer) = memory.buffer(resource) {
                let region = vk::BufferCopy { src_offset: first, dst_offset: 0, size: end - first };
                record::copy_buffer(device, commands, buffer, &capture.buffer, region);
            }
        }
        Range::Image { aspects, mips, layers } => {
            let (Some(image), Shape::Image(shape)) = (memory.image(resource), &capture.shape) else { return };
            let depth = vk::ImageAspectFlags::DEPTH;
            let aspect_mask = if aspects.contains(depth) { depth } else { aspects };
            let regions: Vec<_> = (mips[0]..mips[1])
                .zip(&capture.mips)
                .enumerate()
                .map(|(i, (mip_level, &buffer_offset))| vk::BufferImageCopy {
                    buffer_offset,
                    image_subresource: vk::ImageSubresourceLayers {
                        aspect_mask,
                        mip_level,
                        base_array_layer: layers[0],
                        layer_count: layers[1] - layers[0],
                    },
                    image_extent: extent(shape.extent.map(|size| (size >> i).max(1))),
                    ..vk::BufferImageCopy::default()
                })
                .collect();
            record::copy_image(device, commands, image, &capture.buffer, &regions);
        }
    }
}

fn extent([width, height, depth]: [u32; 3]) -> vk::Extent3D {
    vk::Extent3D { width, height, depth }
}

/// Shape of what is captured, offset of each mip, bytes of a layer of each mip, bytes in all.
fn captured_layout(shape: &Shape, range: Range) -> (Shape, Vec<u64>, Vec<u64>, u64) {
    match (shape, range) {
        (Shape::Image(shape), Range::Image { mips, layers, .. }) => {
            let at_mip = |mip: u32| shape.extent.map(|size| (size >> mip).max(1));
            let count = layers[1] - layers[0];
            let texel = FormatInfo::of(shape.format).map_or(16, |info| u64::from(info.block_bytes));
            let (mut offsets, mut sizes, mut size) = (Vec::new(), Vec::new(), 0);
            for mip in mips[0]..mips[1] {
                let layer = at_mip(mip).iter().map(|&s| u64::from(s)).product::<u64>() * texel;
                offsets.push(size);
                sizes.push(layer);
                size += layer * u64::from(count);
            }
            let captured =
                super::ImageShape { extent: at_mip(mips[0]), mips: mips[1] - mips[0], layers: count, ..*shape };
            (Shape::Image(captured), offsets, sizes, size)
        }
        (_, Range::Buffer([first, end])) => (Shape::Buffer { size: end - first }, Vec::new(), Vec::new(), end - first),
        (shape, Range::Image { .. }) => (shape.clone(), Vec::new(), Vec::new(), 0),
    }
}

/// Vulkan's barriers from the plan's.
fn batch(barriers: &Barriers, memory: &Resources) -> Batch {
    let mut batch = Batch::default();
    for barrier in &barriers.memory {
        batch.memory.push(
            vk::MemoryBarrier2::default()
                .src_stage_mask(barrier.from.stages)
                .src_access_mask(barrier.from.mask)
                .dst_stage_mask(barrier.to.stages)
                .dst_access_mask(barrier.to.mask),
        );
    }
    for barrier in &barriers.images {
        let (Some(image), Some(range)) = (memory.image(barrier.resource), subresources(barrier.range)) else {
            continue;
        };
        batch.images.push(
            vk::ImageMemoryBarrier2::default()
                .src_stage_mask(barrier.from.stages)
                .src_access_mask(barrier.from.mask)
                .dst_stage_mask(barrier.to.stages)
                .dst_access_mask(barrier.to.mask)
                .old_layout(barrier.from.layout)
                .new_layout(barrier.to.layout)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .image(image.raw())
                .subresource_range(range),
        );
    }
    for barrier in &barriers.buffers {
        let (Some(buffer), Range::Buffer([first, end])) = (memory.buffer(barrier.resource), barrier.range) else {
            continue;
        };
        batch.buffers.push(
            vk::BufferMemoryBarrier2::default()
                .src_stage_mask(barrier.from.stages)
                .src_access_mask(barrier.from.mask)
                .dst_stage_mask(barrier.to.stages)
                .dst_access_mask(barrier.to.mask)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .buffer(buffer.raw())
                .offset(first)
                .size(end - first),
        );
    }
    batch
}

fn subresources(range: Range) -> Option<vk::ImageSubresourceRange> {
    let Range::Image { aspects, mips, layers } = range else { return None };
    Some(vk::ImageSubresourceRange {
        aspect_mask: aspects,
        base_mip_level: mips[0],
        level_count: mips[1] - mips[0],
        base_array_layer: layers[0],
        layer_count: layers[1] - layers[0],
    })
}

/// Two timestamps a step, where the device has them.
struct Timer {
    pool: Option<QueryPool>,
}

impl Timer {
    fn new(gpu: &Gpu, steps: usize) -> Result<Self> {
        if steps == 0 || !gpu.caps().has(Feature::Timestamps) {
            return Ok(Self { pool: None });
        }
        let pool = gpu.query_pool("pass times", QueryKind::Timestamp, 2 * steps as u32)?;
        pool.reset();
        Ok(Self { pool: Some(pool) })
    }

    fn mark(&self, device: &ash::Device, commands: &Commands, index: usize) {
        if let Some(pool) = &self.pool {
            record::timestamp(device, commands, pool, index as u32);
        }
    }

    fn times(&self, names: Vec<String>) -> Result<Vec<PassTime>> {
        let Some(pool) = &self.pool else { return Ok(Vec::new()) };
        let marks = pool.nanoseconds()?;
        let time = |(i, name): (usize, String)| {
            let (start, end) = (marks.get(2 * i).copied().flatten()?, marks.get(2 * i + 1).copied().flatten()?);
            Some(PassTime { name, seconds: (end - start).max(0.0) * 1e-9 })
        };
        Ok(names.into_iter().enumerate().filter_map(time).collect())
    }
}

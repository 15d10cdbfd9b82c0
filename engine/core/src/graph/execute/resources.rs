//! The images and buffers of a frame, and what planning asks of the device about them.

use ash::vk;

use crate::gpu::{Buffer, BufferInfo, Gpu, Image, ImageInfo, Memory, Requirements};
use crate::graph::builder::{External, Graph};
use crate::graph::description::{Description, ImageShape, Origin, Queue, Resource, ResourceId, Shape};
use crate::graph::plan::{self, DeviceModel, End, Plan, Usage};
use crate::{Error, Result};

/// Memory of a frame's resources, by their number.
#[derive(Clone, Default)]
pub(super) struct Resources(pub(super) Vec<Option<External>>);

impl Resources {
    pub(super) fn image(&self, resource: ResourceId) -> Option<&Image> {
        match self.0.get(resource.0 as usize) {
            Some(Some(External::Image(image))) => Some(image),
            _ => None,
        }
    }

    pub(super) fn buffer(&self, resource: ResourceId) -> Option<&Buffer> {
        match self.0.get(resource.0 as usize) {
            Some(Some(External::Buffer(buffer))) => Some(buffer),
            _ => None,
        }
    }
}

/// A resource in memory of its own.
pub(super) fn alone(gpu: &Gpu, resource: &Resource, usage: Usage) -> Result<External> {
    let name = &resource.name;
    match (&resource.shape, usage) {
        (Shape::Image(shape), Usage::Image(usage)) => {
            Ok(External::Image(gpu.create_image(&image_info(name, shape, usage))?))
        }
        (&Shape::Buffer { size }, Usage::Buffer(usage)) => {
            Ok(External::Buffer(gpu.create_buffer(&BufferInfo { name, size, usage, memory: Memory::Device })?))
        }
        _ => Err(Error::invalid(name.as_str(), format!("is used as {usage:?}, which it is not"))),
    }
}

pub(super) fn image_info<'a>(name: &'a str, shape: &ImageShape, usage: vk::ImageUsageFlags) -> ImageInfo<'a> {
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

/// Whether imported images and buffers were made for what passes do to them, on this device.
pub(super) fn check_imports(gpu: &Gpu, plan: &Plan, graph: &Graph) -> Result<()> {
    for (index, external) in graph.external.iter().enumerate() {
        let Some(external) = external else { continue };
        let name = &graph.description.resources[index].name;
        let is_ours = match external {
            External::Image(image) => image.is_from(gpu),
            External::Buffer(buffer) => buffer.is_from(gpu),
        };
        if !is_ours {
            return Err(Error::invalid(format!("import `{name}`"), "is of another device"));
        }
        let has = match external {
            External::Image(image) => Usage::Image(image.info().usage),
            External::Buffer(buffer) => Usage::Buffer(buffer.usage()),
        };
        let lacks = match (has, plan.usages[index]) {
            (Usage::Image(has), Some(Usage::Image(needed))) if !has.contains(needed) => format!("{:?}", needed & !has),
            (Usage::Buffer(has), Some(Usage::Buffer(needed))) if !has.contains(needed) => {
                format!("{:?}", needed & !has)
            }
            _ => continue,
        };
        let why = format!("is used as {lacks}, which it was not made for: add that to its usage");
        return Err(Error::invalid(format!("import `{name}`"), why));
    }
    Ok(())
}

/// Whether a frame that runs again and again finds its imported images as it left them.
pub(super) fn check_turns(plan: &Plan, description: &Description) -> Result<()> {
    for End { resource, state } in &plan.ends {
        let Resource { name, shape: Shape::Image(_), origin: Origin::Imported { before, .. } } =
            &description.resources[resource.0 as usize]
        else {
            continue;
        };
        let [arrives, left] = [before.layout, state.access.layout];
        if arrives != vk::ImageLayout::UNDEFINED && arrives != left {
            let why = format!("arrives as {arrives:?} and is left as {left:?}: import it with `after` as it arrives");
            return Err(Error::invalid(format!("import `{name}` of a prepared frame"), why));
        }
    }
    Ok(())
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

    fn image_usages(&self, format: vk::Format) -> vk::ImageUsageFlags {
        Gpu::image_usages(self, format)
    }

    fn most_at_once(&self) -> u64 {
        self.caps().limits.max_allocation_size
    }

    fn granularity(&self) -> u64 {
        self.caps().limits.buffer_image_granularity.max(1)
    }
}

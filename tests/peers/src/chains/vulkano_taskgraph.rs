//! `vulkano-taskgraph`: images are made and the order is given by hand; barriers come from the graph. Compiled once and
//! executed each frame, or built and compiled each frame as well.

use std::sync::Arc;

use vulkano::buffer::{BufferCreateInfo, BufferUsage};
use vulkano::descriptor_set::allocator::{StandardDescriptorSetAllocator, StandardDescriptorSetAllocatorCreateInfo};
use vulkano::descriptor_set::{DescriptorSet, WriteDescriptorSet};
use vulkano::device::{Device, DeviceCreateInfo, DeviceFeatures, Queue, QueueCreateInfo, QueueFlags};
use vulkano::format::Format;
use vulkano::image::view::ImageView;
use vulkano::image::{Image, ImageAspects, ImageCreateInfo, ImageLayout, ImageSubresourceLayers, ImageUsage};
use vulkano::instance::{Instance, InstanceCreateInfo};
use vulkano::memory::allocator::{AllocationCreateInfo, DeviceLayout, MemoryTypeFilter};
use vulkano::pipeline::compute::ComputePipelineCreateInfo;
use vulkano::pipeline::layout::PipelineDescriptorSetLayoutCreateInfo;
use vulkano::pipeline::{ComputePipeline, Pipeline, PipelineBindPoint, PipelineLayout, PipelineShaderStageCreateInfo};
use vulkano::shader::{ShaderModule, ShaderModuleCreateInfo};
use vulkano::{Version, VulkanLibrary};
use vulkano_taskgraph::command_buffer::{
    BufferImageCopy, ClearColorImageInfo, CopyImageToBufferInfo, RecordingCommandBuffer,
};
use vulkano_taskgraph::graph::{CompileInfo, ExecutableTaskGraph, ResourceMap, TaskGraph};
use vulkano_taskgraph::resource::{
    AccessTypes, Flight, HostAccessType, ImageLayoutType, Resources, ResourcesCreateInfo,
};
use vulkano_taskgraph::{Id, QueueFamilyType, Task, TaskContext, TaskResult};

use crate::measure::{Chain, Result};
use crate::shader::{self, GROUPS, SIZE};

/// A chain in `vulkano-taskgraph`.
pub struct VulkanoTaskgraph {
    world: World,
    resources: Arc<Resources>,
    queue: Arc<Queue>,
    flight: Id<Flight>,
    /// Kept where it is not rebuilt.
    compiled: Option<ExecutableTaskGraph<World>>,
    texel: [u8; 4],
}

/// What tasks see.
struct World {
    pipeline: Arc<ComputePipeline>,
    images: Vec<Id<Image>>,
    sets: Vec<Arc<DescriptorSet>>,
    read_back: Id<vulkano::buffer::Buffer>,
    frame: u32,
}

struct Clear;
struct Pass(usize);
struct ReadBack;

impl Task for Clear {
    type World = World;

    unsafe fn execute(
        &self,
        commands: &mut RecordingCommandBuffer<'_>,
        _: &mut TaskContext<'_>,
        world: &World,
    ) -> TaskResult {
        let info = ClearColorImageInfo { image: world.images[0], ..ClearColorImageInfo::default() };
        // SAFETY: the graph knows of the access.
        unsafe { commands.clear_color_image(&info) }?;
        Ok(())
    }
}

impl Task for Pass {
    type World = World;

    unsafe fn execute(
        &self,
        commands: &mut RecordingCommandBuffer<'_>,
        _: &mut TaskContext<'_>,
        world: &World,
    ) -> TaskResult {
        let layout = world.pipeline.layout();
        // SAFETY: the graph knows of the accesses. Its commands bind no sets: those below them do.
        unsafe {
            commands.bind_pipeline_compute(&world.pipeline)?;
            let sets = [world.sets[self.0].as_raw()];
            commands.as_raw().bind_descriptor_sets_unchecked(PipelineBindPoint::Compute, layout, 0, &sets, &[]);
            commands.push_constants(layout, 0, &shader::push(world.frame, self.0 as u32 + 1))?;
            commands.dispatch([GROUPS, GROUPS, 1])?;
        }
        Ok(())
    }
}

impl Task for ReadBack {
    type World = World;

    unsafe fn execute(
        &self,
        commands: &mut RecordingCommandBuffer<'_>,
        _: &mut TaskContext<'_>,
        world: &World,
    ) -> TaskResult {
        let layers = ImageSubresourceLayers { aspects: ImageAspects::COLOR, mip_level: 0, array_layers: 0..1 };
        let region =
            BufferImageCopy { image_subresource: layers, image_extent: [1, 1, 1], ..BufferImageCopy::default() };
        let info = CopyImageToBufferInfo {
            src_image: world.images[world.sets.len()],
            dst_buffer: world.read_back,
            regions: &[region],
            ..CopyImageToBufferInfo::default()
        };
        // SAFETY: the graph knows of the accesses.
        unsafe { commands.copy_image_to_buffer(&info) }?;
        Ok(())
    }
}

impl VulkanoTaskgraph {
    pub fn new(passes: u32, rebuilt: bool) -> Result<Self> {
        // 1. A device.
        let info = InstanceCreateInfo { max_api_version: Some(Version::V1_3), ..InstanceCreateInfo::default() };
        let instance = Instance::new(VulkanLibrary::new()?, info)?;
        let physical = instance.enumerate_physical_devices()?.next().ok_or("there is no device")?;
        let wanted = QueueFlags::GRAPHICS | QueueFlags::COMPUTE;
        let able = |family: &vulkano::device::QueueFamilyProperties| family.queue_flags.contains(wanted);
        let family = physical.queue_family_properties().iter().position(able).ok_or("there is no queue")? as u32;
        let info = DeviceCreateInfo {
            queue_create_infos: vec![QueueCreateInfo { queue_family_index: family, ..QueueCreateInfo::default() }],
            enabled_features: DeviceFeatures {
                synchronization2: true,
                vulkan_memory_model: true,
                ..DeviceFeatures::empty()
            },
            ..DeviceCreateInfo::default()
        };
        let (device, mut queues) = Device::new(physical, info)?;
        let queue = queues.next().ok_or("there is no queue")?;

        // 2. The pipeline.
        let code = shader::spirv()?;
        // SAFETY: `naga` has validated it.
        let module = unsafe { ShaderModule::new(device.clone(), ShaderModuleCreateInfo::new(&code)) }?;
        let stage = PipelineShaderStageCreateInfo::new(module.entry_point("main").ok_or("there is no `main`")?);
        let layout = PipelineDescriptorSetLayoutCreateInfo::from_stages([&stage]);
        let layout = PipelineLayout::new(device.clone(), layout.into_pipeline_layout_create_info(device.clone())?)?;
        let info = ComputePipelineCreateInfo::stage_layout(stage, layout.clone());
        let pipeline = ComputePipeline::new(device.clone(), None, info)?;

        // 3. Images, sets, and the texel that is read back.
        let resources = Resources::new(&device, &ResourcesCreateInfo::default());
        let flight = resources.create_flight(1)?;
        let info = ImageCreateInfo {
            format: Format::R8G8B8A8_UNORM,
            extent: [SIZE, SIZE, 1],
            usage: ImageUsage::SAMPLED | ImageUsage::STORAGE | ImageUsage::TRANSFER_SRC | ImageUsage::TRANSFER_DST,
            ..ImageCreateInfo::default()
        };
        let image = || resources.create_image(info.clone(), AllocationCreateInfo::default());
        let images = (0..=passes).map(|_| image()).collect::<std::result::Result<Vec<_>, _>>()?;
        let view = |&id: &Id<Image>| Ok(ImageView::new_default(resources.image(id)?.image().clone())?);
        let views = images.iter().map(view).collect::<Result<Vec<_>>>()?;
        let info = StandardDescriptorSetAllocatorCreateInfo::default();
        let allocator = Arc::new(StandardDescriptorSetAllocator::new(device.clone(), info));
        let set = |views: &[Arc<ImageView>]| {
            let writes = [
                WriteDescriptorSet::image_view_with_layout(
                    0,
                    vulkano::descriptor_set::DescriptorImageViewInfo {
                        image_view: views[0].clone(),
                        image_layout: ImageLayout::ShaderReadOnlyOptimal,
                    },
                ),
                WriteDescriptorSet::image_view(1, views[1].clone()),
            ];
            DescriptorSet::new(allocator.clone(), layout.set_layouts()[0].clone(), writes, [])
        };
        let sets = views.windows(2).map(set).collect::<std::result::Result<Vec<_>, _>>()?;
        let info = BufferCreateInfo { usage: BufferUsage::TRANSFER_DST, ..BufferCreateInfo::default() };
        let memory = AllocationCreateInfo {
            memory_type_filter: MemoryTypeFilter::PREFER_HOST | MemoryTypeFilter::HOST_RANDOM_ACCESS,
            ..AllocationCreateInfo::default()
        };
        let texel = DeviceLayout::from_size_alignment(4, 4).ok_or("a texel has no layout")?;
        let read_back = resources.create_buffer(info, memory, texel)?;
        let world = World { pipeline, images, sets, read_back, frame: 0 };
        let mut chain = Self { world, resources, queue, flight, compiled: None, texel: [0; 4] };
        if !rebuilt {
            chain.compiled = Some(chain.compile()?);
        }
        Ok(chain)
    }

    fn compile(&self) -> Result<ExecutableTaskGraph<World>> {
        let images = &self.world.images;
        let count = images.len() as u32;
        let mut graph = TaskGraph::new(&self.resources, count + 8, count + 8);
        graph.add_host_buffer_access(self.world.read_back, HostAccessType::Read);
        let layout = ImageLayoutType::Optimal;
        let mut last = graph
            .create_task_node("clear", QueueFamilyType::Graphics, Clear)
            .image_access(images[0], AccessTypes::CLEAR_TRANSFER_WRITE, layout)
            .build();
        for pass in 0..self.world.sets.len() {
            let node = graph
                .create_task_node("pass", QueueFamilyType::Graphics, Pass(pass))
                .image_access(images[pass], AccessTypes::COMPUTE_SHADER_SAMPLED_READ, layout)
                .image_access(images[pass + 1], AccessTypes::COMPUTE_SHADER_STORAGE_WRITE, layout)
                .build();
            graph.add_edge(last, node)?;
            last = node;
        }
        let node = graph
            .create_task_node("read back", QueueFamilyType::Graphics, ReadBack)
            .image_access(images[self.world.sets.len()], AccessTypes::COPY_TRANSFER_READ, layout)
            .buffer_access(self.world.read_back, AccessTypes::COPY_TRANSFER_WRITE)
            .build();
        graph.add_edge(last, node)?;
        let info = CompileInfo { queues: &[&self.queue], flight_id: self.flight, ..CompileInfo::default() };
        // SAFETY: every access suits a queue with graphics, compute and transfer.
        Ok(unsafe { graph.compile(&info) }.map_err(|error| error.to_string())?)
    }
}

impl Chain for VulkanoTaskgraph {
    fn frame(&mut self, frame: u32) -> Result<()> {
        self.world.frame = frame;
        let rebuilt = if self.compiled.is_none() { Some(self.compile()?) } else { None };
        let graph = rebuilt.as_ref().or(self.compiled.as_ref()).ok_or("there is no graph")?;
        let resources = ResourceMap::new(graph)?;
        // SAFETY: the device is done with the last frame, and no other graph uses these resources.
        unsafe { graph.execute(resources, &self.world, || {}) }?;
        self.resources.flight(self.flight)?.wait(None)?;
        Ok(())
    }

    fn texel(&mut self) -> Result<[u8; 4]> {
        let buffer = self.resources.buffer(self.world.read_back)?.buffer().clone();
        let texel = vulkano::buffer::Subbuffer::new(buffer).cast_aligned::<u8>();
        self.texel.copy_from_slice(&texel.read()?[..4]);
        Ok(self.texel)
    }

    /// Of the images that the user makes.
    fn transient_bytes(&self) -> Option<u64> {
        let bytes =
            |&id: &Id<Image>| Some(self.resources.image(id).ok()?.image().memory_requirements()[0].layout.size());
        self.world.images.iter().map(bytes).sum()
    }
}

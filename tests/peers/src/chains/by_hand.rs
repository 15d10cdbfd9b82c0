//! By hand with `ash`: what a program that knows the whole chain would do. No graph is expected to be cheaper.
//!
//! Why its `unsafe` is sound: handles come from live objects of one device that live as long as the process, structures
//! are as Vulkan asks, and the device is done with a frame before the next one begins.

use ash::vk;

use crate::measure::{Chain, Result};
use crate::shader::{self, GROUPS, SIZE};

const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;
const COLOR: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// A chain by hand.
pub struct ByHand {
    device: ash::Device,
    queue: vk::Queue,
    fence: vk::Fence,
    command_pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    images: Vec<vk::Image>,
    views: Vec<vk::ImageView>,
    bytes: u64,
    pipeline: vk::Pipeline,
    layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
    descriptor_pool: vk::DescriptorPool,
    sets: Vec<vk::DescriptorSet>,
    sets_each_frame: bool,
    read_back: vk::Buffer,
    texel: *const [u8; 4],
    _entry: ash::Entry,
}

impl ByHand {
    pub fn new(passes: u32, sets_each_frame: bool) -> Result<Self> {
        // SAFETY: see the module.
        unsafe { open(passes, sets_each_frame) }
    }

    /// SAFETY: see the module.
    unsafe fn write_sets(&mut self) -> Result<()> {
        let passes = self.images.len() - 1;
        let layouts = vec![self.set_layout; passes];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.descriptor_pool).set_layouts(&layouts);
        self.sets = unsafe { self.device.allocate_descriptor_sets(&info)? };
        let image = |index: usize, image_layout| vk::DescriptorImageInfo {
            image_view: self.views[index],
            image_layout,
            ..vk::DescriptorImageInfo::default()
        };
        let infos: Vec<_> = (0..passes)
            .map(|pass| {
                let from = image(pass, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
                [[from], [image(pass + 1, vk::ImageLayout::GENERAL)]]
            })
            .collect();
        let kinds = [vk::DescriptorType::SAMPLED_IMAGE, vk::DescriptorType::STORAGE_IMAGE];
        let write = |(&set, infos): (&vk::DescriptorSet, _)| {
            let infos: &[[vk::DescriptorImageInfo; 1]; 2] = infos;
            [0, 1].map(|binding| {
                vk::WriteDescriptorSet::default()
                    .dst_set(set)
                    .dst_binding(binding as u32)
                    .descriptor_type(kinds[binding])
                    .image_info(&infos[binding])
            })
        };
        let writes: Vec<_> = self.sets.iter().zip(&infos).flat_map(write).collect();
        unsafe { self.device.update_descriptor_sets(&writes, &[]) };
        Ok(())
    }

    /// SAFETY: see the module.
    unsafe fn record(&self, frame: u32) -> Result<()> {
        let (device, commands) = (&self.device, self.commands);
        use vk::{AccessFlags2 as Mask, ImageLayout as Layout, PipelineStageFlags2 as Stages};
        let undefined = (Stages::NONE, Mask::NONE, Layout::UNDEFINED);
        let cleared = (Stages::CLEAR, Mask::TRANSFER_WRITE, Layout::TRANSFER_DST_OPTIMAL);
        let sampled = (Stages::COMPUTE_SHADER, Mask::SHADER_SAMPLED_READ, Layout::SHADER_READ_ONLY_OPTIMAL);
        let stored = (Stages::COMPUTE_SHADER, Mask::SHADER_STORAGE_WRITE, Layout::GENERAL);
        let copied = (Stages::COPY, Mask::TRANSFER_READ, Layout::TRANSFER_SRC_OPTIMAL);
        unsafe {
            device.reset_command_pool(self.command_pool, vk::CommandPoolResetFlags::empty())?;
            let once = vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT;
            device.begin_command_buffer(commands, &vk::CommandBufferBeginInfo::default().flags(once))?;
            self.barriers(&[barrier(self.images[0], undefined, cleared)]);
            let zero = vk::ClearColorValue::default();
            device.cmd_clear_color_image(commands, self.images[0], cleared.2, &zero, &[COLOR]);
            device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::COMPUTE, self.pipeline);
            let mut last = cleared;
            for (pass, &set) in self.sets.iter().enumerate() {
                let push = shader::push(frame, pass as u32 + 1).to_ne_bytes();
                self.barriers(&[
                    barrier(self.images[pass], last, sampled),
                    barrier(self.images[pass + 1], undefined, stored),
                ]);
                let compute = vk::PipelineBindPoint::COMPUTE;
                device.cmd_bind_descriptor_sets(commands, compute, self.layout, 0, &[set], &[]);
                device.cmd_push_constants(commands, self.layout, vk::ShaderStageFlags::COMPUTE, 0, &push);
                device.cmd_dispatch(commands, GROUPS, GROUPS, 1);
                last = stored;
            }
            let result = self.images[self.sets.len()];
            self.barriers(&[barrier(result, last, copied)]);
            let layers = vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                layer_count: 1,
                ..vk::ImageSubresourceLayers::default()
            };
            let one = vk::Extent3D { width: 1, height: 1, depth: 1 };
            let region = vk::BufferImageCopy::default().image_subresource(layers).image_extent(one);
            device.cmd_copy_image_to_buffer(commands, result, copied.2, self.read_back, &[region]);
            let host = [vk::MemoryBarrier2::default()
                .src_stage_mask(Stages::COPY)
                .src_access_mask(Mask::TRANSFER_WRITE)
                .dst_stage_mask(Stages::HOST)
                .dst_access_mask(Mask::HOST_READ)];
            device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().memory_barriers(&host));
            device.end_command_buffer(commands)?;
        }
        Ok(())
    }

    /// SAFETY: see the module.
    unsafe fn barriers(&self, barriers: &[vk::ImageMemoryBarrier2]) {
        let dependency = vk::DependencyInfo::default().image_memory_barriers(barriers);
        unsafe { self.device.cmd_pipeline_barrier2(self.commands, &dependency) }
    }
}

type State = (vk::PipelineStageFlags2, vk::AccessFlags2, vk::ImageLayout);

fn barrier(image: vk::Image, from: State, to: State) -> vk::ImageMemoryBarrier2<'static> {
    vk::ImageMemoryBarrier2::default()
        .src_stage_mask(from.0)
        .src_access_mask(from.1)
        .old_layout(from.2)
        .dst_stage_mask(to.0)
        .dst_access_mask(to.1)
        .new_layout(to.2)
        .image(image)
        .subresource_range(COLOR)
}

impl Chain for ByHand {
    fn frame(&mut self, frame: u32) -> Result<()> {
        // SAFETY: see the module.
        unsafe {
            if self.sets_each_frame {
                let none = vk::DescriptorPoolResetFlags::empty();
                self.device.reset_descriptor_pool(self.descriptor_pool, none)?;
                self.write_sets()?;
            }
            self.record(frame)?;
            let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(self.commands)];
            let submit = vk::SubmitInfo2::default().command_buffer_infos(&commands);
            self.device.queue_submit2(self.queue, &[submit], self.fence)?;
            self.device.wait_for_fences(&[self.fence], true, u64::MAX)?;
            self.device.reset_fences(&[self.fence])?;
        }
        Ok(())
    }

    fn texel(&mut self) -> Result<[u8; 4]> {
        // SAFETY: mapped memory of the read-back buffer, which the device has written.
        Ok(unsafe { self.texel.read_volatile() })
    }

    fn transient_bytes(&self) -> Option<u64> {
        Some(self.bytes)
    }
}

/// SAFETY: see the module.
unsafe fn open(passes: u32, sets_each_frame: bool) -> Result<ByHand> {
    unsafe {
        // 1. A device with one queue that does everything.
        let entry = ash::Entry::load()?;
        let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let info = vk::InstanceCreateInfo::default().application_info(&application);
        let instance = entry.create_instance(&info, None)?;
        let physical = *instance.enumerate_physical_devices()?.first().ok_or("there is no device")?;
        let families = instance.get_physical_device_queue_family_properties(physical);
        let able = |family: &vk::QueueFamilyProperties| {
            family.queue_flags.contains(vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE)
        };
        let family = families.iter().position(able).ok_or("there is no queue")? as u32;
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let mut features = vk::PhysicalDeviceVulkan13Features::default().synchronization2(true);
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).push_next(&mut features);
        let device = instance.create_device(physical, &info, None)?;
        let queue = device.get_device_queue(family, 0);
        let fence = device.create_fence(&vk::FenceCreateInfo::default(), None)?;
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(family);
        let command_pool = device.create_command_pool(&info, None)?;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(command_pool).command_buffer_count(1);
        let commands = device.allocate_command_buffers(&info)?[0];

        // 2. Images side by side in one block of memory.
        let memory = instance.get_physical_device_memory_properties(physical);
        let memory_type = |bits: u32, wanted: vk::MemoryPropertyFlags| {
            let types = memory.memory_types_as_slice().iter().enumerate();
            let mut fits = types.filter(|(i, ty)| bits & (1 << i) != 0 && ty.property_flags.contains(wanted));
            fits.next().map(|(i, _)| i as u32).ok_or("there is no such memory")
        };
        let usage = vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::STORAGE
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(FORMAT)
            .extent(vk::Extent3D { width: SIZE, height: SIZE, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        let count = u64::from(passes) + 1;
        let images =
            (0..count).map(|_| device.create_image(&info, None)).collect::<std::result::Result<Vec<_>, _>>()?;
        let needs = device.get_image_memory_requirements(images[0]);
        let each = needs.size.next_multiple_of(needs.alignment);
        let kind = memory_type(needs.memory_type_bits, vk::MemoryPropertyFlags::DEVICE_LOCAL)?;
        let info = vk::MemoryAllocateInfo::default().allocation_size(each * count).memory_type_index(kind);
        let block = device.allocate_memory(&info, None)?;
        let mut views = Vec::new();
        for (&image, offset) in images.iter().zip((0..).step_by(each as usize)) {
            device.bind_image_memory(image, block, offset)?;
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(FORMAT)
                .subresource_range(COLOR);
            views.push(device.create_image_view(&info, None)?);
        }

        // 3. The texel that is read back.
        let info = vk::BufferCreateInfo::default().size(4).usage(vk::BufferUsageFlags::TRANSFER_DST);
        let read_back = device.create_buffer(&info, None)?;
        let needs_buffer = device.get_buffer_memory_requirements(read_back);
        let host = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let info = vk::MemoryAllocateInfo::default()
            .allocation_size(needs_buffer.size)
            .memory_type_index(memory_type(needs_buffer.memory_type_bits, host)?);
        let host_memory = device.allocate_memory(&info, None)?;
        device.bind_buffer_memory(read_back, host_memory, 0)?;
        let texel = device.map_memory(host_memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty())?;

        // 4. The pipeline.
        let binding = |number, kind| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(number)
                .descriptor_type(kind)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
        };
        let kinds = [vk::DescriptorType::SAMPLED_IMAGE, vk::DescriptorType::STORAGE_IMAGE];
        let bindings = [binding(0, kinds[0]), binding(1, kinds[1])];
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        let set_layout = device.create_descriptor_set_layout(&info, None)?;
        let push = [vk::PushConstantRange { stage_flags: vk::ShaderStageFlags::COMPUTE, offset: 0, size: 4 }];
        let set_layouts = [set_layout];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts).push_constant_ranges(&push);
        let layout = device.create_pipeline_layout(&info, None)?;
        let code = shader::spirv()?;
        let module = device.create_shader_module(&vk::ShaderModuleCreateInfo::default().code(&code), None)?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main");
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout)];
        let pipelines = device.create_compute_pipelines(vk::PipelineCache::null(), &info, None);
        let pipeline = pipelines.map_err(|(_, error)| error)?[0];

        // 5. Its sets.
        let sizes = kinds.map(|ty| vk::DescriptorPoolSize { ty, descriptor_count: passes });
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(passes).pool_sizes(&sizes);
        let descriptor_pool = device.create_descriptor_pool(&info, None)?;
        let mut chain = ByHand {
            device,
            queue,
            fence,
            command_pool,
            commands,
            images,
            views,
            bytes: each * count,
            pipeline,
            layout,
            set_layout,
            descriptor_pool,
            sets: Vec::new(),
            sets_each_frame,
            read_back,
            texel: texel.cast(),
            _entry: entry,
        };
        chain.write_sets()?;
        Ok(chain)
    }
}

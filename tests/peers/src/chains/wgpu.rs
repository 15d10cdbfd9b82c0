//! `wgpu`: no graph. The order is the user's; barriers come from its tracking. Textures and bind groups are cached, the
//! encoder is recorded each frame: as one compute pass with all dispatches, or as a compute pass each.

use wgpu::{BindGroup, Buffer, ComputePipeline, Device, Queue, Texture};

use crate::measure::{Chain, Result};
use crate::shader::{self, GROUPS, SIZE};

/// Copies to buffers have rows of at least so many bytes.
const ROW: u64 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as u64;

/// A chain in `wgpu`.
pub struct Wgpu {
    device: Device,
    queue: Queue,
    pipeline: ComputePipeline,
    textures: Vec<Texture>,
    groups: Vec<BindGroup>,
    read_back: Buffer,
    one_pass: bool,
}

impl Wgpu {
    pub fn new(passes: u32, one_pass: bool) -> Result<Self> {
        // 1. A device, without debug checks.
        let mut info = wgpu::InstanceDescriptor::new_without_display_handle();
        info.backends = wgpu::Backends::VULKAN;
        info.flags = wgpu::InstanceFlags::empty();
        let instance = wgpu::Instance::new(info);
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
        let info = wgpu::DeviceDescriptor {
            required_features: wgpu::Features::IMMEDIATES | wgpu::Features::CLEAR_TEXTURE,
            required_limits: wgpu::Limits { max_immediate_size: 4, ..wgpu::Limits::default() },
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&info))?;

        // 2. The pipeline.
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        };
        let sampled = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let stored = wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format: wgpu::TextureFormat::Rgba8Unorm,
            view_dimension: wgpu::TextureViewDimension::D2,
        };
        let group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &[entry(0, sampled), entry(1, stored)],
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&group_layout)],
            immediate_size: 4,
        });
        let source = wgpu::ShaderSource::Wgsl(shader::WGSL.into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: Some(&layout),
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });

        // 3. Textures and bind groups.
        let texture = || {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::TEXTURE_BINDING
                    | wgpu::TextureUsages::STORAGE_BINDING
                    | wgpu::TextureUsages::COPY_SRC
                    | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            })
        };
        let textures: Vec<_> = (0..=passes).map(|_| texture()).collect();
        let view = |texture: &Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let views: Vec<_> = textures.iter().map(view).collect();
        let group = |pair: &[wgpu::TextureView]| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &group_layout,
                entries: &[bound(0, &pair[0]), bound(1, &pair[1])],
            })
        };
        let groups = views.windows(2).map(group).collect();
        let read_back = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: ROW,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Ok(Self { device, queue, pipeline, textures, groups, read_back, one_pass })
    }
}

fn bound(binding: u32, view: &wgpu::TextureView) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) }
}

impl Chain for Wgpu {
    fn frame(&mut self, frame: u32) -> Result<()> {
        let mut pushes = (1..).map(|pass| shader::push(frame, pass).to_ne_bytes());
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.clear_texture(&self.textures[0], &wgpu::ImageSubresourceRange::default());
        let each = if self.one_pass { self.groups.len() } else { 1 };
        for groups in self.groups.chunks(each) {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            for group in groups {
                pass.set_bind_group(0, group, &[]);
                pass.set_immediates(0, &pushes.next().unwrap_or_default());
                pass.dispatch_workgroups(GROUPS, GROUPS, 1);
            }
        }
        encoder.copy_texture_to_buffer(
            self.textures[self.groups.len()].as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &self.read_back, layout: wgpu::TexelCopyBufferLayout::default() },
            wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
        );
        self.queue.submit([encoder.finish()]);
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(())
    }

    fn texel(&mut self) -> Result<[u8; 4]> {
        self.read_back.map_async(wgpu::MapMode::Read, .., |_| {});
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        let texel = self.read_back.get_mapped_range(..)?.first_chunk().copied();
        self.read_back.unmap();
        Ok(texel.ok_or("the buffer is empty")?)
    }

    fn transient_bytes(&self) -> Option<u64> {
        Some(self.device.generate_allocator_report()?.total_allocated_bytes)
    }
}

//! `vk-graph`: the whole graph is made each frame; pools keep what is on the device.
//!
//! A pool keeps 16 images of a kind unless it is told otherwise, and makes the others again each frame: it gets room for
//! all. The other mode has two images, which the user says are to take turns.

use std::sync::Arc;

use vk_graph::Graph;
use vk_graph::driver::ash::vk;
use vk_graph::driver::buffer::{Buffer, BufferInfo};
use vk_graph::driver::compute::{ComputePipeline, ComputePipelineInfo};
use vk_graph::driver::device::{Device, DeviceInfo};
use vk_graph::driver::image::ImageInfo;
use vk_graph::driver::shader::Shader;
use vk_graph::driver::sync::AccessType;
use vk_graph::node::AnyImageNode;
use vk_graph::pool::Pool as _;
use vk_graph::pool::cache::Cache;
use vk_graph::pool::hash::HashPool;

use crate::measure::{Chain, Result};
use crate::shader::{self, GROUPS, SIZE};

/// A chain in `vk-graph`.
pub struct VkGraph {
    pool: Cache<HashPool, u32>,
    pipeline: ComputePipeline,
    read_back: Arc<Buffer>,
    passes: u32,
    alias: bool,
}

impl VkGraph {
    pub fn new(passes: u32, alias: bool) -> Result<Self> {
        let device = Device::create(DeviceInfo::default())?;
        let pool = Cache::new(HashPool::with_capacity(&device, passes as usize + 8));
        let code = shader::spirv()?;
        let pipeline =
            ComputePipeline::create(&device, ComputePipelineInfo::default(), Shader::new_compute(code.as_slice()))?;
        let size = u64::from(4 * SIZE * SIZE);
        let info = BufferInfo::host_mem(size, vk::BufferUsageFlags::TRANSFER_DST);
        let read_back = Arc::new(Buffer::create(&device, info)?);
        Ok(Self { pool, pipeline, read_back, passes, alias })
    }

    fn image(&mut self, graph: &mut Graph, number: u32) -> Result<AnyImageNode> {
        let usage = vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::STORAGE
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let info = ImageInfo::image_2d(SIZE, SIZE, vk::Format::R8G8B8A8_UNORM, usage);
        Ok(match self.alias {
            true => graph.bind_resource(self.pool.tag(number % 2).resource(info)?).into(),
            false => graph.bind_resource(self.pool.resource(info)?).into(),
        })
    }
}

impl Chain for VkGraph {
    fn frame(&mut self, frame: u32) -> Result<()> {
        let mut graph = Graph::default();
        let mut last = self.image(&mut graph, 0)?;
        graph.clear_color_image(last, [0.0; 4]);
        for number in 1..=self.passes {
            let push = shader::push(frame, number).to_ne_bytes();
            let next = self.image(&mut graph, number)?;
            graph
                .begin_cmd()
                .bind_pipeline(&self.pipeline)
                .shader_resource_access(0, last, AccessType::ComputeShaderReadSampledImageOrUniformTexelBuffer)
                .shader_resource_access(1, next, AccessType::ComputeShaderWrite)
                .record_cmd(move |cmd| {
                    cmd.push_constants(0, &push).dispatch(GROUPS, GROUPS, 1);
                });
            last = next;
        }
        let read_back = graph.bind_resource(&self.read_back);
        graph.copy_image_to_buffer(last, read_back);
        graph.finalize().queue_submit(&mut *self.pool, 0, 0)?.wait()?;
        Ok(())
    }

    fn texel(&mut self) -> Result<[u8; 4]> {
        Ok(Buffer::mapped_slice(&self.read_back).first_chunk().copied().ok_or("the buffer is empty")?)
    }

    /// It does not say.
    fn transient_bytes(&self) -> Option<u64> {
        None
    }
}

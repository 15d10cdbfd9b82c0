//! Shadowgraph: a frame that is prepared once and recorded again, and a frame that is made anew each time.

use std::cell::Cell;
use std::sync::Arc;

use ash::vk;
use shadowgraph::gpu::{Gpu, GpuOptions};
use shadowgraph::graph::{Executed, Executor, Graph, ImageShape, Prepared as Ready};
use shadowgraph::shader::{
    Binding, BindingKind, ImageSlot, ImageType, Push, SampledSlot, Shader, ShaderAccess, Stage, Write,
};

use crate::measure::{Chain, Result};
use crate::shader::{self, SIZE};

/// What both modes have. Lives as long as the process.
struct Setup {
    gpu: Gpu,
    from: SampledSlot,
    to: ImageSlot<Write>,
    shader: &'static Shader,
    frame: Cell<u32>,
    passes: u32,
}

impl Setup {
    fn new(passes: u32) -> Result<&'static Self> {
        let gpu = Gpu::headless(GpuOptions::default())?;
        let image = |binding, name, kind, access, format| Binding {
            set: 0,
            binding,
            name,
            kind,
            access,
            count: 1,
            size: 0,
            image: Some(ImageType { view: vk::ImageViewType::TYPE_2D, multisampled: false, comparison: false, format }),
        };
        let bindings = [
            image(0, "from", BindingKind::SampledImage, ShaderAccess::Read, vk::Format::UNDEFINED),
            image(1, "to", BindingKind::StorageImage, ShaderAccess::Write, vk::Format::R8G8B8A8_UNORM),
        ];
        let shader = Box::leak(Box::new(Shader {
            file: "peers/chain.wgsl",
            stage: Stage::Compute,
            spirv: bytemuck::cast_slice(shader::spirv()?.leak()),
            bindings: Box::leak(Box::new(bindings)),
            push: Some(Push { name: "Push", size: 4 }),
            inputs: &[],
            outputs: &[],
            workgroup: [8, 8, 1],
            capabilities: &[],
        }));
        let (from, to) = (SampledSlot::new(bindings[0], shader), ImageSlot::new(bindings[1], shader));
        Ok(Box::leak(Box::new(Self { gpu, from, to, shader, frame: Cell::new(0), passes })))
    }

    /// Describes the frame. `again`: it is recorded several times, and asked for its push constants each time.
    fn describe(&'static self, mut graph: Graph<'static>, again: bool) -> Graph<'static> {
        let shape = ImageShape::new_2d(vk::Format::R8G8B8A8_UNORM, [SIZE, SIZE]);
        let image = graph.image(("image", 0), shape);
        let mut last = graph.clear("clear", image, vk::ClearColorValue::default());
        for number in 1..=self.passes {
            let next = graph.image(("image", number), shape);
            let mut pass = graph.compute(("pass", number), self.shader);
            pass.read(self.from, &last);
            match again {
                true => pass.push_with(move || shader::push(self.frame.get(), number)),
                false => pass.push(&shader::push(self.frame.get(), number)),
            };
            last = pass.write(self.to, next);
            pass.dispatch([SIZE, SIZE, 1]);
        }
        graph.capture("last", &last);
        graph
    }
}

/// Prepared once: pipelines, sets, memory and barriers are kept, commands are recorded each frame.
pub struct Prepared {
    setup: &'static Setup,
    executor: Executor<'static>,
    ready: Ready<'static>,
    executed: Executed,
    bytes: u64,
}

impl Prepared {
    pub fn new(passes: u32) -> Result<Self> {
        let setup = Setup::new(passes)?;
        let mut executor = executor(setup);
        let graph = setup.describe(executor.graph("chain"), true);
        let plan = graph.compile(&setup.gpu)?;
        let bytes = plan.statistics.heap_bytes;
        let ready = executor.prepare(&plan, graph)?;
        Ok(Self { setup, executor, ready, executed: Executed::default(), bytes })
    }
}

impl Chain for Prepared {
    fn frame(&mut self, frame: u32) -> Result<()> {
        self.setup.frame.set(frame);
        self.executed = self.executor.run(&mut self.ready)?;
        Ok(())
    }

    fn texel(&mut self) -> Result<[u8; 4]> {
        texel(&self.executed)
    }

    fn transient_bytes(&self) -> Option<u64> {
        Some(self.bytes)
    }
}

/// Described and made ready anew each frame; objects on the device are kept by the executor. The plan is that of the
/// last frame, which was described alike, or made anew as well.
pub struct Rebuilt {
    setup: &'static Setup,
    executor: Executor<'static>,
    executed: Executed,
    replan: bool,
    bytes: u64,
}

impl Rebuilt {
    pub fn new(passes: u32, replan: bool) -> Result<Self> {
        let setup = Setup::new(passes)?;
        Ok(Self { setup, executor: executor(setup), executed: Executed::default(), replan, bytes: 0 })
    }
}

impl Chain for Rebuilt {
    fn frame(&mut self, frame: u32) -> Result<()> {
        self.setup.frame.set(frame);
        let graph = self.setup.describe(self.executor.graph("chain"), false);
        let plan = match self.replan {
            true => Arc::new(graph.compile(&self.setup.gpu)?),
            false => self.executor.plan(&graph)?,
        };
        self.executed = self.executor.execute(&plan, graph)?;
        self.bytes = plan.statistics.heap_bytes;
        Ok(())
    }

    fn texel(&mut self) -> Result<[u8; 4]> {
        texel(&self.executed)
    }

    fn transient_bytes(&self) -> Option<u64> {
        Some(self.bytes)
    }
}

/// Without timestamps and labels, which none of the others records.
fn executor(setup: &'static Setup) -> Executor<'static> {
    let mut executor = Executor::new(&setup.gpu);
    executor.instruments(false);
    executor
}

fn texel(executed: &Executed) -> Result<[u8; 4]> {
    let texel = executed.capture("last")?.bytes(|bytes| bytes.first_chunk().copied())?;
    Ok(texel.ok_or("the capture is empty")?)
}

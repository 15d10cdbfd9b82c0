//! Compute and graphics pipelines, for dynamic rendering.

use std::sync::Arc;

use ash::vk;

use super::device::{Device, Garbage};
use super::layout::{Layout, pipeline_layout, stage_flag};
use super::pipeline_checks::{check_inputs, check_outputs, check_shader, check_stage, check_state, check_tests};
use super::pipeline_state::create_graphics;
use super::{Gpu, GraphicsPipelineInfo, SetLayout};
use crate::Result;
use crate::shader::{Binding, Shader, Stage, specialized};

/// Value of a specialisation constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Constant {
    /// `bool`.
    Bool(bool),
    /// `uint`.
    U32(u32),
    /// `int`.
    I32(i32),
    /// `float`.
    F32(f32),
}

macro_rules! constant_from {
    ($($type:ty => $kind:ident),*) => {$(
        impl From<$type> for Constant {
            fn from(value: $type) -> Self {
                Self::$kind(value)
            }
        }
    )*};
}

constant_from!(bool => Bool, u32 => U32, i32 => I32, f32 => F32);

impl Constant {
    /// As the 32 bits that Vulkan takes.
    fn bits(self) -> u32 {
        match self {
            Constant::Bool(b) => b.into(),
            Constant::U32(u) => u,
            Constant::I32(i) => i as u32,
            Constant::F32(f) => f.to_bits(),
        }
    }
}

/// One binding of a pipeline, over all its stages.
#[derive(Clone, Debug, PartialEq)]
pub struct PipelineBinding {
    /// Set, number, name, kind; the access is that of all stages together.
    pub binding: Binding,
    /// Stages whose shaders have it.
    pub stages: vk::ShaderStageFlags,
    /// Their files.
    pub files: Vec<&'static str>,
}

/// A pipeline with its layout.
#[derive(Clone)]
pub struct Pipeline(Arc<Inner>);

struct Inner {
    device: Arc<Device>,
    id: u64,
    name: String,
    pipeline: vk::Pipeline,
    layout: Layout,
    bind_point: vk::PipelineBindPoint,
    shaders: Vec<&'static Shader>,
    constants: Vec<(u32, Constant)>,
}

impl Pipeline {
    fn new(
        device: &Arc<Device>,
        name: &str,
        pipeline: vk::Pipeline,
        layout: Layout,
        shaders: &[&'static Shader],
        constants: &[(u32, Constant)],
    ) -> Self {
        device.name(pipeline, name);
        let compute = shaders.iter().any(|s| s.stage == Stage::Compute);
        Self(Arc::new(Inner {
            id: device.register("pipeline", name),
            device: device.clone(),
            name: name.into(),
            pipeline,
            layout,
            bind_point: if compute { vk::PipelineBindPoint::COMPUTE } else { vk::PipelineBindPoint::GRAPHICS },
            shaders: shaders.to_vec(),
            constants: constants.to_vec(),
        }))
    }

    /// A number that no other object of its device ever has.
    pub(super) fn id(&self) -> u64 {
        self.0.id
    }

    /// The Vulkan handle.
    pub fn raw(&self) -> vk::Pipeline {
        self.0.pipeline
    }

    /// Debug name.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Its layout.
    pub fn layout(&self) -> vk::PipelineLayout {
        self.0.layout.raw
    }

    /// Graphics or compute.
    pub fn bind_point(&self) -> vk::PipelineBindPoint {
        self.0.bind_point
    }

    /// Bindings of all stages, by set and number.
    pub fn bindings(&self) -> &[PipelineBinding] {
        &self.0.layout.bindings
    }

    /// Layout of a set, where the pipeline has it (possibly empty, where a later set is used).
    pub fn set_layout(&self, set: u32) -> Option<&SetLayout> {
        self.0.layout.sets.get(set as usize)
    }

    /// The push constants: stages and bytes, from offset 0; `None` where no stage has some.
    pub fn push(&self) -> Option<(vk::ShaderStageFlags, u32)> {
        self.0.layout.push
    }

    /// Shaders, in the order of the stages.
    pub fn shaders(&self) -> &[&'static Shader] {
        &self.0.shaders
    }

    /// Values of specialisation constants it was made with.
    pub fn constants(&self) -> &[(u32, Constant)] {
        &self.0.constants
    }

    /// Workgroup size; `[0; 3]` for graphics.
    pub fn workgroup(&self) -> [u32; 3] {
        self.0.shaders.first().map_or([0; 3], |s| s.workgroup)
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        self.device.forget(self.id);
        self.device.defer(Garbage::Pipeline(self.pipeline, self.layout.raw));
    }
}

impl std::fmt::Debug for Pipeline {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let files: Vec<_> = self.0.shaders.iter().map(|s| s.file).collect();
        write!(f, "Pipeline({:?}, {})", self.0.name, files.join(", "))
    }
}

impl Gpu {
    /// Makes a compute pipeline. `constants` are specialisation constants by `constant_id`.
    ///
    /// # Errors
    /// [`crate::Error::Missing`] for capabilities and limits that the device lacks;
    /// [`crate::Error::Invalid`] for a shader of another stage; [`crate::Error::Vulkan`].
    pub fn compute_pipeline(
        &self,
        name: &str,
        shader: &'static Shader,
        constants: &[(u32, Constant)],
    ) -> Result<Pipeline> {
        let device = &self.device;
        // 1. What the shader wants.
        check_stage(name, shader, Stage::Compute)?;
        check_shader(device, name, shader)?;
        let layout = pipeline_layout(device, name, &[shader], &[])?;

        // 2. The pipeline.
        let modules = Modules::new(device, name, &[shader], constants, layout)?;
        let info = vk::ComputePipelineCreateInfo::default().stage(modules.stages()[0]).layout(modules.layout.raw);
        // SAFETY: a valid structure; what it points at lives.
        let made = unsafe { device.raw.create_compute_pipelines(device.pipeline_cache.cache, &[info], None) };
        let pipeline = made.map_err(|e| device.error("vkCreateComputePipelines", name, e.1))?[0];
        Ok(Pipeline::new(device, name, pipeline, modules.finish(), &[shader], constants))
    }

    /// Makes a graphics pipeline.
    ///
    /// # Errors
    /// As [`Gpu::compute_pipeline`]; also [`crate::Error::Invalid`] naming both files where two stages disagree
    /// about a binding or the push constants, where a fragment output has no attachment of its kind, or where a set
    /// layout lacks a binding.
    pub fn graphics_pipeline(&self, info: &GraphicsPipelineInfo) -> Result<Pipeline> {
        let device = &self.device;
        let name = info.name;
        // 1. What the shaders want.
        let mut shaders = vec![info.vertex];
        check_stage(name, info.vertex, Stage::Vertex)?;
        for (shader, stage) in [(info.geometry, Stage::Geometry), (info.fragment, Stage::Fragment)] {
            if let Some(shader) = shader {
                check_stage(name, shader, stage)?;
                shaders.push(shader);
            }
        }
        for shader in &shaders {
            check_shader(device, name, shader)?;
        }
        check_state(device, info)?;
        check_inputs(info)?;
        check_outputs(info)?;
        check_tests(info)?;
        let layout = pipeline_layout(device, name, &shaders, info.set_layouts)?;

        // 2. The pipeline.
        let modules = Modules::new(device, name, &shaders, info.constants, layout)?;
        let pipeline = create_graphics(device, info, &modules.stages(), modules.layout.raw)?;
        Ok(Pipeline::new(device, name, pipeline, modules.finish(), &shaders, info.constants))
    }
}

/// Shader modules and a layout, destroyed together where the pipeline fails.
struct Modules<'a> {
    device: &'a Device,
    modules: Vec<(vk::ShaderStageFlags, vk::ShaderModule)>,
    layout: Layout,
    finished: bool,
}

impl<'a> Modules<'a> {
    fn new(
        device: &'a Device,
        name: &str,
        shaders: &[&'static Shader],
        constants: &[(u32, Constant)],
        layout: Layout,
    ) -> Result<Self> {
        let mut made = Modules { device, modules: Vec::new(), layout, finished: false };
        let constants: Vec<_> = constants.iter().map(|&(id, value)| (id, value.bits())).collect();
        for shader in shaders {
            let code = specialized(&shader.words(), &constants);
            let info = vk::ShaderModuleCreateInfo::default().code(&code);
            // SAFETY: the build script's compiler made the code; what was put in place of constants is as valid.
            let module = unsafe { device.raw.create_shader_module(&info, None) };
            let object = format!("{} of pipeline {name:?}", shader.file);
            let module = module.map_err(|e| device.error("vkCreateShaderModule", &object, e))?;
            device.name(module, shader.file);
            made.modules.push((stage_flag(shader.stage), module));
        }
        Ok(made)
    }

    fn stages(&self) -> Vec<vk::PipelineShaderStageCreateInfo<'_>> {
        let stage = |&(stage, module): &(vk::ShaderStageFlags, vk::ShaderModule)| {
            vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module).name(c"main")
        };
        self.modules.iter().map(stage).collect()
    }

    /// The layout goes to the pipeline; the modules are not needed any more.
    fn finish(mut self) -> Layout {
        self.finished = true;
        let empty = Layout { raw: vk::PipelineLayout::null(), sets: Vec::new(), bindings: Vec::new(), push: None };
        std::mem::replace(&mut self.layout, empty)
    }
}

impl Drop for Modules<'_> {
    fn drop(&mut self) {
        // SAFETY: made by us; a pipeline does not need its modules, and the layout goes only where no pipeline has it.
        unsafe {
            self.modules.iter().for_each(|m| self.device.raw.destroy_shader_module(m.1, None));
            if !self.finished {
                self.device.raw.destroy_pipeline_layout(self.layout.raw, None);
            }
        }
    }
}

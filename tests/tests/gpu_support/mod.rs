//! What the tests of the GPU floor share.
#![allow(dead_code, missing_docs, clippy::unwrap_used)]

use ash::vk;
use shadowgraph::gpu::{Buffer, BufferInfo, Commands, Gpu, GpuOptions, Image, Memory, Validation};
use shadowgraph::graph::{Executed, Executor, Graph};
use shadowgraph::shader::{Binding, BindingKind, Output, OutputScalar, Shader, ShaderAccess, Stage};

pub fn options() -> GpuOptions {
    GpuOptions { validation: Validation::On, ..Default::default() }
}

/// A device with validation on.
pub fn gpu() -> Gpu {
    Gpu::headless(options()).unwrap()
}

/// Ends a test: nothing leaks, and the validation layer has nothing to say, up to the instance's end.
pub fn finish(gpu: Gpu) {
    let messages = gpu.messages().clone();
    gpu.close().unwrap();
    let said: Vec<String> = messages.take().iter().map(ToString::to_string).collect();
    assert!(said.is_empty(), "validation messages:\n{}", said.join("\n"));
}

/// Compiles GLSL. The bindings are the test's own, as reflection would give them.
pub fn shader(
    stage: Stage,
    file: &'static str,
    source: &str,
    bindings: &'static [Binding],
    outputs: &'static [Output],
    workgroup: [u32; 3],
) -> &'static Shader {
    let compiler = shaderc::Compiler::new().unwrap();
    let mut options = shaderc::CompileOptions::new().unwrap();
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
    let kind = match stage {
        Stage::Vertex => shaderc::ShaderKind::Vertex,
        Stage::Geometry => shaderc::ShaderKind::Geometry,
        Stage::Fragment => shaderc::ShaderKind::Fragment,
        Stage::Compute => shaderc::ShaderKind::Compute,
        #[allow(unreachable_patterns)]
        other => panic!("{other:?}"),
    };
    let code = compiler.compile_into_spirv(source, kind, file, "main", Some(&options)).unwrap();
    let spirv = code.as_binary_u8().to_vec().leak();
    Box::leak(Box::new(Shader {
        file,
        stage,
        spirv,
        bindings,
        push: None,
        inputs: &[],
        outputs,
        workgroup,
        capabilities: &[],
    }))
}

pub const fn binding(binding: u32, name: &'static str, kind: BindingKind, access: ShaderAccess) -> Binding {
    Binding { set: 0, binding, name, kind, access, count: 1, size: 0, image: None }
}

pub const fn output(location: u32, name: &'static str) -> Output {
    Output { location, name, scalar: OutputScalar::Float, components: 4 }
}

/// Plans and runs a frame.
pub fn run(executor: &mut Executor, gpu: &Gpu, graph: Graph) -> Executed {
    let plan = graph.compile(gpu).unwrap_or_else(|errors| panic!("{errors}"));
    executor.execute(&plan, graph).unwrap()
}

pub fn buffer(gpu: &Gpu, name: &str, size: u64, usage: vk::BufferUsageFlags, memory: Memory) -> Buffer {
    gpu.create_buffer(&BufferInfo { name, size, usage, memory }).unwrap()
}

/// Everything before happens before everything after.
pub fn full_barrier(commands: &Commands) {
    let barrier = [vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)];
    let dependency = vk::DependencyInfo::default().memory_barriers(&barrier);
    // SAFETY: recorded outside of rendering.
    unsafe { commands.device().cmd_pipeline_barrier2(commands.raw(), &dependency) };
}

/// Changes the whole image's layout, after everything and before everything.
pub fn transition(commands: &Commands, image: &Image, from: vk::ImageLayout, to: vk::ImageLayout) {
    let barrier = [vk::ImageMemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
        .old_layout(from)
        .new_layout(to)
        .image(image.raw())
        .subresource_range(image.range())];
    let dependency = vk::DependencyInfo::default().image_memory_barriers(&barrier);
    // SAFETY: recorded outside of rendering, of a live image.
    unsafe { commands.device().cmd_pipeline_barrier2(commands.raw(), &dependency) };
}

/// Bytes of one level of one layer of an image that is in `layout`, which it is left in as a transfer source.
pub fn read_image(gpu: &Gpu, image: &Image, mip: u32, layer: u32, layout: vk::ImageLayout) -> Vec<u8> {
    let extent = image.mip_extent(mip);
    let bytes = shadowgraph::gpu::FormatInfo::of(image.info().format).unwrap().bytes(extent);
    let target = buffer(gpu, "readback", bytes, vk::BufferUsageFlags::TRANSFER_DST, Memory::Readback);
    let commands = gpu.commands("read").unwrap();
    transition(&commands, image, layout, vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
    let region = [vk::BufferImageCopy::default()
        .image_subresource(vk::ImageSubresourceLayers {
            aspect_mask: image.aspects(),
            mip_level: mip,
            base_array_layer: layer,
            layer_count: 1,
        })
        .image_extent(vk::Extent3D { width: extent[0], height: extent[1], depth: extent[2] })];
    // SAFETY: live objects, the layout just made.
    unsafe {
        let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        commands.device().cmd_copy_image_to_buffer(commands.raw(), image.raw(), layout, target.raw(), &region);
    }
    gpu.wait(gpu.submit(commands).unwrap()).unwrap();
    target.read().unwrap()
}

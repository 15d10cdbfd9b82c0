//! Pipelines, descriptors, queries.
#![allow(missing_docs, clippy::unwrap_used)]

mod gpu_support;

use ash::vk;
use gpu_support::{binding, buffer, finish, full_barrier, gpu, output, read_image, shader, transition};
use shadowgraph::gpu::{
    Buffer, ColorTarget, Commands, Constant, DepthState, Descriptor, Feature, Gpu, GpuOptions, GraphicsPipelineInfo,
    Image, ImageInfo, Memory, Pipeline, Points, QueryKind, SamplerInfo, VertexAttribute, VertexBuffer, blend,
};
use shadowgraph::shader::{Binding, BindingKind, ImageType, Input, Output, OutputScalar, Shader, ShaderAccess, Stage};

const STORAGE: vk::BufferUsageFlags = vk::BufferUsageFlags::STORAGE_BUFFER;

/// `out[i] = in[i] * factor + i`, over 64 numbers.
fn scale() -> &'static Shader {
    static BINDINGS: [Binding; 2] = [
        binding(0, "source", BindingKind::StorageBuffer, ShaderAccess::Read),
        binding(3, "target", BindingKind::StorageBuffer, ShaderAccess::Write),
    ];
    let source = "#version 460
        layout(local_size_x = 64) in;
        layout(constant_id = 5) const uint factor = 1;
        layout(constant_id = 6) const bool negate = false;
        layout(set = 0, binding = 0, std430) readonly buffer Source { int source[]; };
        layout(set = 0, binding = 3, std430) writeonly buffer Target { int target[]; };
        void main() {
            uint i = gl_GlobalInvocationID.x;
            int v = source[i] * int(factor) + int(i);
            target[i] = negate ? -v : v;
        }";
    shader(Stage::Compute, "scale.comp", source, &BINDINGS, &[], [64, 1, 1])
}

/// Binds a pipeline and its set 0.
fn bind(commands: &Commands, pipeline: &Pipeline, set: vk::DescriptorSet) {
    // SAFETY: live objects that fit together.
    unsafe {
        commands.device().cmd_bind_pipeline(commands.raw(), pipeline.bind_point(), pipeline.raw());
        commands.device().cmd_bind_descriptor_sets(
            commands.raw(),
            pipeline.bind_point(),
            pipeline.layout(),
            0,
            &[set],
            &[],
        );
    }
}

#[test]
fn a_compute_pipeline_computes() {
    let gpu = gpu();
    let constants = [(6, Constant::Bool(true)), (5, Constant::U32(3))];
    let pipeline = gpu.compute_pipeline("scale", scale(), &constants).unwrap();
    assert_eq!(pipeline.workgroup(), [64, 1, 1]);
    assert_eq!(pipeline.constants(), constants);
    assert_eq!(pipeline.bindings().len(), 2);
    assert_eq!(pipeline.push(), None);
    let source = buffer(&gpu, "source", 256, STORAGE, Memory::Upload);
    let target = buffer(&gpu, "target", 256, STORAGE, Memory::Readback);
    let numbers: Vec<i32> = (0..64).map(|i| 1000 - 7 * i).collect();
    source.write(0, bytemuck::cast_slice(&numbers)).unwrap();
    let descriptors = [(0, Descriptor::buffer(&source)), (3, Descriptor::buffer(&target))];
    let set = gpu.descriptor_set("numbers", &pipeline, 0, &descriptors).unwrap();
    let mut arena = gpu.descriptor_arena("frame");
    for round in 0..3 {
        target.write(0, &[0; 256]).unwrap();
        arena.reset();
        let raw = if round == 0 { set.raw() } else { arena.set(&pipeline, 0, &descriptors).unwrap() };
        let commands = gpu.commands("compute").unwrap();
        bind(&commands, &pipeline, raw);
        // SAFETY: a pipeline and its set are bound.
        unsafe { gpu.raw().cmd_dispatch(commands.raw(), 1, 1, 1) };
        gpu.wait(gpu.submit(commands).unwrap()).unwrap();
        let got: Vec<i32> = bytemuck::pod_collect_to_vec(&target.read().unwrap());
        let want: Vec<i32> = numbers.iter().zip(0..).map(|(n, i)| -(n * 3 + i)).collect();
        assert_eq!(got, want, "round {round}");
    }
    // More sets than one pool of an arena holds.
    let sets: Vec<_> = (0..1000).map(|_| arena.set(&pipeline, 0, &descriptors).unwrap()).collect();
    assert_eq!(sets.iter().collect::<std::collections::HashSet<_>>().len(), 1000);
    // Sets keep alive what they point at.
    drop((source, target, descriptors));
    assert_eq!(gpu.live_objects().iter().filter(|o| o.starts_with("buffer")).count(), 2);
    drop((set, arena, pipeline));
    finish(gpu);
}

/// A source and a target.
fn holds<'a>(
    source: &'a Buffer,
    target: &'a Buffer,
) -> impl Iterator<Item = shadowgraph::Result<(u32, Points<'a>)>> + Clone {
    [(0, Points::buffer(source)), (3, Points::buffer(target))].into_iter().map(Ok)
}

#[test]
fn sets_are_kept_by_what_they_hold() {
    // Without validation, whose handles never come again.
    let gpu = Gpu::headless(GpuOptions::default()).unwrap();
    let pipeline = gpu.compute_pipeline("scale", scale(), &[(5, Constant::U32(2))]).unwrap();
    let target = buffer(&gpu, "target", 256, STORAGE, Memory::Readback);
    let make = |value: i32| {
        let source = buffer(&gpu, "source", 256, STORAGE, Memory::Upload);
        source.write(0, bytemuck::cast_slice(&[value; 64])).unwrap();
        source
    };
    let mut cache = gpu.descriptor_cache("frames");
    let first = make(1);
    cache.begin_frame();
    let set = cache.set(&pipeline, 0, holds(&first, &target)).unwrap();
    let second = make(2);
    assert_ne!(cache.set(&pipeline, 0, holds(&second, &target)).unwrap(), set);
    assert_eq!(cache.set(&pipeline, 0, holds(&first, &target)).unwrap(), set);
    cache.begin_frame();
    assert_eq!(cache.set(&pipeline, 0, holds(&first, &target)).unwrap(), set);

    // It is no set of another pipeline, which may ask for more: this one reads more than there is.
    static LARGE: [Binding; 2] = [
        Binding { size: 4096, ..binding(0, "source", BindingKind::StorageBuffer, ShaderAccess::Read) },
        binding(3, "target", BindingKind::StorageBuffer, ShaderAccess::Write),
    ];
    let large: &'static Shader = Box::leak(Box::new(Shader { bindings: &LARGE, ..*scale() }));
    let other = gpu.compute_pipeline("large", large, &[]).unwrap();
    let text = cache.set(&other, 0, holds(&first, &target)).unwrap_err().to_string();
    assert!(text.contains("fewer than the shader's 4096"), "{text}");

    // Vulkan's handles come again; what has another object behind it is found anew.
    let handle = first.raw();
    drop(first);
    let (mut again, mut last) = (0, set);
    for round in 3..30 {
        let source = make(round);
        again += u32::from(source.raw() == handle);
        cache.begin_frame();
        let set = cache.set(&pipeline, 0, holds(&source, &target)).unwrap();
        assert_ne!(std::mem::replace(&mut last, set), set, "round {round} found the set of a buffer that is gone");
        let commands = gpu.commands("compute").unwrap();
        bind(&commands, &pipeline, set);
        // SAFETY: a pipeline and its set are bound.
        unsafe { gpu.raw().cmd_dispatch(commands.raw(), 1, 1, 1) };
        gpu.wait(gpu.submit(commands).unwrap()).unwrap();
        let got: Vec<i32> = bytemuck::pod_collect_to_vec(&target.read().unwrap());
        assert_eq!(got, (0..64).map(|i| round * 2 + i).collect::<Vec<_>>());
    }
    println!("{again} of 27 buffers had the handle of one that was gone");

    // Sets that were not used for some frames are used for others.
    for _ in 0..10 {
        cache.begin_frame();
    }
    let sets: Vec<_> = (0..4).map(|value| cache.set(&pipeline, 0, holds(&make(value), &target)).unwrap()).collect();
    assert!(sets.contains(&set), "{set:?} is not among {sets:?}");
    drop((second, target, cache, pipeline, other));
    finish(gpu);
}

#[test]
fn incomplete_sets_are_errors() {
    let gpu = gpu();
    let pipeline = gpu.compute_pipeline("scale", scale(), &[]).unwrap();
    let good = buffer(&gpu, "good", 1024, STORAGE, Memory::Device);
    let vertex = buffer(&gpu, "vertices", 256, vk::BufferUsageFlags::VERTEX_BUFFER, Memory::Device);
    let sampler = gpu.sampler(&SamplerInfo::default()).unwrap();
    let whole = || Descriptor::buffer(&good);
    let part = |offset, size| Descriptor::Buffer { buffer: good.clone(), offset, size };
    let cases: Vec<(Vec<(u32, Descriptor)>, &str)> = vec![
        (vec![(0, whole())], "\"target\""),
        (vec![(0, whole()), (3, whole()), (4, whole())], "no binding 4"),
        (vec![(0, whole()), (3, whole()), (3, whole())], "takes 1, given are 2"),
        (vec![(0, whole()), (3, Descriptor::Sampler(sampler))], "a sampler"),
        (vec![(0, whole()), (3, Descriptor::buffer(&vertex))], "STORAGE_BUFFER"),
        (vec![(0, whole()), (3, part(1, 16))], "multiple"),
        (vec![(0, whole()), (3, part(0, 2000))], "not in its 1024"),
        (vec![(0, whole()), (3, part(1024, vk::WHOLE_SIZE))], "not in its 1024"),
    ];
    let mut arena = gpu.descriptor_arena("arena");
    for (descriptors, part) in &cases {
        let text = gpu.descriptor_set("broken", &pipeline, 0, descriptors).err().unwrap().to_string();
        assert!(text.contains("\"broken\"") && text.contains(part), "{text}");
        let text = arena.set(&pipeline, 0, descriptors).unwrap_err().to_string();
        assert!(text.contains("\"scale\"") && text.contains(part), "{text}");
    }
    assert!(gpu.descriptor_set("none", &pipeline, 1, &[]).err().unwrap().to_string().contains("no set 1"));
    drop((cases, good, vertex, arena, pipeline));
    finish(gpu);
}

#[test]
fn an_image_is_what_the_shader_takes_it_for() {
    const PICTURE: Binding = Binding {
        image: Some(ImageType {
            view: vk::ImageViewType::TYPE_2D_ARRAY,
            multisampled: false,
            comparison: false,
            format: vk::Format::R32_UINT,
        }),
        ..binding(0, "picture", BindingKind::StorageImage, ShaderAccess::Write)
    };
    static BINDINGS: [Binding; 1] = [PICTURE];
    let source = "#version 460
        layout(local_size_x = 4, local_size_y = 4) in;
        layout(set = 0, binding = 0, r32ui) writeonly uniform uimage2DArray picture;
        void main() {
            uvec3 at = gl_GlobalInvocationID;
            imageStore(picture, ivec3(at), uvec4(at.x + 10 * at.y + 100 * at.z));
        }";
    let gpu = gpu();
    let shader = shader(Stage::Compute, "store.comp", source, &BINDINGS, &[], [4, 4, 1]);
    let pipeline = gpu.compute_pipeline("store", shader, &[]).unwrap();
    let image = |format, usage| {
        let usage = usage | vk::ImageUsageFlags::TRANSFER_SRC;
        let info = ImageInfo { name: "picture", format, extent: [4, 4, 1], layers: 2, usage, ..Default::default() };
        gpu.create_image(&info).unwrap()
    };
    let good = image(vk::Format::R32_UINT, vk::ImageUsageFlags::STORAGE);
    let float = image(vk::Format::R32_SFLOAT, vk::ImageUsageFlags::STORAGE);
    let sampled = image(vk::Format::R32_UINT, vk::ImageUsageFlags::SAMPLED);
    let layout = vk::ImageLayout::GENERAL;
    let layer = Descriptor::Image { image: good.clone(), view: good.whole().layer(0), layout };
    for (bad, part) in [
        (layer, "TYPE_2D_ARRAY"),
        (Descriptor::storage(&float), "R32_SFLOAT"),
        (Descriptor::storage(&sampled), "STORAGE"),
    ] {
        let text = gpu.descriptor_set("set", &pipeline, 0, &[(0, bad)]).err().unwrap().to_string();
        assert!(text.contains("\"picture\"") && text.contains(part), "{text}");
    }
    let set = gpu.descriptor_set("set", &pipeline, 0, &[(0, Descriptor::storage(&good))]).unwrap();
    let commands = gpu.commands("store").unwrap();
    transition(&commands, &good, vk::ImageLayout::UNDEFINED, layout);
    bind(&commands, &pipeline, set.raw());
    // SAFETY: a pipeline and its set are bound.
    unsafe { gpu.raw().cmd_dispatch(commands.raw(), 1, 1, 2) };
    gpu.submit(commands).unwrap();
    let texels: Vec<u32> = bytemuck::pod_collect_to_vec(&read_image(&gpu, &good, 0, 1, layout));
    assert_eq!(texels, (0..16).map(|i| 100 + i % 4 + 10 * (i / 4)).collect::<Vec<_>>());
    drop((set, good, float, sampled, pipeline));
    finish(gpu);
}

/// A triangle of positions and a colour from a uniform block, textured by one texel.
fn triangle_shaders() -> [&'static Shader; 2] {
    static VERTEX: [Binding; 1] = [binding(0, "tint", BindingKind::UniformBuffer, ShaderAccess::Read)];
    static FRAGMENT: [Binding; 2] = [
        binding(0, "tint", BindingKind::UniformBuffer, ShaderAccess::Read),
        binding(1, "picture", BindingKind::CombinedImageSampler, ShaderAccess::Read),
    ];
    static OUTPUTS: [Output; 1] = [output(0, "color")];
    let vertex = "#version 460
        layout(location = 0) in vec3 position;
        layout(set = 0, binding = 0) uniform Tint { vec4 color; float depth; } tint;
        void main() { gl_Position = vec4(position.xy, position.z + tint.depth, 1.0); }";
    let fragment = "#version 460
        layout(set = 0, binding = 0) uniform Tint { vec4 color; float depth; } tint;
        layout(set = 0, binding = 1) uniform sampler2D picture;
        layout(location = 0) out vec4 color;
        void main() { color = tint.color * texture(picture, vec2(0.5)); }";
    [
        shader(Stage::Vertex, "triangle.vert", vertex, &VERTEX, &[], [0; 3]),
        shader(Stage::Fragment, "triangle.frag", fragment, &FRAGMENT, &OUTPUTS, [0; 3]),
    ]
}

const POSITIONS: &[VertexBuffer<'static>] = &[VertexBuffer {
    stride: 12,
    per_instance: false,
    attributes: &[VertexAttribute { location: 0, format: vk::Format::R32G32B32_SFLOAT, offset: 0 }],
}];

fn triangle_info(shaders: [&'static Shader; 2]) -> GraphicsPipelineInfo<'static> {
    static COLOR: std::sync::OnceLock<[ColorTarget; 1]> = std::sync::OnceLock::new();
    GraphicsPipelineInfo {
        fragment: Some(shaders[1]),
        vertex_buffers: POSITIONS,
        color: COLOR.get_or_init(|| [ColorTarget::new(vk::Format::R8G8B8A8_UNORM)]),
        depth: Some(DepthState { format: vk::Format::D32_SFLOAT, compare: vk::CompareOp::LESS, write: true }),
        ..GraphicsPipelineInfo::new("triangle", shaders[0])
    }
}

/// Targets of 8 × 8 pixels, and the lower left half of them as a triangle.
struct Scene {
    color: Image,
    depth: Image,
    vertices: shadowgraph::gpu::Buffer,
    set: shadowgraph::gpu::DescriptorSet,
}

impl Scene {
    fn new(gpu: &Gpu, pipeline: &Pipeline) -> Scene {
        let image = |name, format, extent, usage| {
            gpu.create_image(&ImageInfo { name, format, extent, usage, ..Default::default() }).unwrap()
        };
        let source = vk::ImageUsageFlags::TRANSFER_SRC;
        let color =
            image("color", vk::Format::R8G8B8A8_UNORM, [8, 8, 1], source | vk::ImageUsageFlags::COLOR_ATTACHMENT);
        let depth = image("depth", vk::Format::D32_SFLOAT, [8, 8, 1], vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT);
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let picture = image("picture", vk::Format::R8G8B8A8_UNORM, [1, 1, 1], usage);
        gpu.upload_image(&picture, &[255, 255, 51, 255]).unwrap();
        let vertices = buffer(gpu, "vertices", 36, vk::BufferUsageFlags::VERTEX_BUFFER, Memory::Upload);
        // Its long side runs a quarter of a pixel off the pixels' centres.
        let corners: [[f32; 3]; 3] = [[-1.0, -1.0625, 0.0], [-1.0, 1.0, 0.0], [1.0625, 1.0, 0.0]];
        vertices.write(0, bytemuck::cast_slice(&corners)).unwrap();
        let tint = buffer(gpu, "tint", 20, vk::BufferUsageFlags::UNIFORM_BUFFER, Memory::Upload);
        tint.write(0, bytemuck::cast_slice(&[1.0f32, 0.2, 1.0, 1.0, 0.5])).unwrap();
        let descriptors = [
            (0, Descriptor::buffer(&tint)),
            (1, Descriptor::texture(&picture, gpu.sampler(&SamplerInfo::default()).unwrap())),
        ];
        let set = gpu.descriptor_set("triangle", pipeline, 0, &descriptors).unwrap();
        Scene { color, depth, vertices, set }
    }

    /// Draws the triangle; `around` is called before and after the draw.
    fn draw(&self, gpu: &Gpu, pipeline: &Pipeline, mut around: impl FnMut(&Commands, bool)) {
        use vk::ImageLayout as L;
        let mut commands = gpu.commands("frame").unwrap();
        commands.begin_pass("triangle");
        transition(&commands, &self.color, L::UNDEFINED, L::COLOR_ATTACHMENT_OPTIMAL);
        transition(&commands, &self.depth, L::UNDEFINED, L::DEPTH_ATTACHMENT_OPTIMAL);
        let attachment = |image: &Image, layout, clear| {
            vk::RenderingAttachmentInfo::default()
                .image_view(image.view(&image.whole()).unwrap())
                .image_layout(layout)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(vk::AttachmentStoreOp::STORE)
                .clear_value(clear)
        };
        let color = [attachment(&self.color, L::COLOR_ATTACHMENT_OPTIMAL, vk::ClearValue::default())];
        let far = vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: 1.0, stencil: 0 } };
        let depth = attachment(&self.depth, L::DEPTH_ATTACHMENT_OPTIMAL, far);
        let area = vk::Rect2D { extent: vk::Extent2D { width: 8, height: 8 }, ..Default::default() };
        let info = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&color)
            .depth_attachment(&depth);
        let viewport = vk::Viewport { width: 8.0, height: 8.0, max_depth: 1.0, ..Default::default() };
        // SAFETY: live objects that fit together, in the layouts just made.
        unsafe {
            let device = gpu.raw();
            let raw = commands.raw();
            device.cmd_begin_rendering(raw, &info);
            bind(&commands, pipeline, self.set.raw());
            device.cmd_bind_vertex_buffers(raw, 0, &[self.vertices.raw()], &[0]);
            device.cmd_set_viewport(raw, 0, &[viewport]);
            device.cmd_set_scissor(raw, 0, &[area]);
            device.cmd_set_cull_mode(raw, vk::CullModeFlags::NONE);
            device.cmd_set_front_face(raw, vk::FrontFace::COUNTER_CLOCKWISE);
            around(&commands, true);
            device.cmd_draw(raw, 3, 1, 0, 0);
            around(&commands, false);
            device.cmd_end_rendering(raw);
        }
        commands.end_pass();
        gpu.wait(gpu.submit(commands).unwrap()).unwrap();
    }
}

/// Whether the triangle covers a pixel's centre.
fn covered(x: usize, y: usize) -> bool {
    x <= y
}

#[test]
fn a_graphics_pipeline_draws() {
    let gpu = gpu();
    let pipeline = gpu.graphics_pipeline(&triangle_info(triangle_shaders())).unwrap();
    let both = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
    assert_eq!(pipeline.bindings()[0].stages, both);
    assert_eq!(pipeline.bindings()[0].files, ["triangle.vert", "triangle.frag"]);
    let scene = Scene::new(&gpu, &pipeline);
    scene.draw(&gpu, &pipeline, |_, _| {});
    let pixels = read_image(&gpu, &scene.color, 0, 0, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
    for (i, pixel) in pixels.chunks_exact(4).enumerate() {
        let want = if covered(i % 8, i / 8) { [255, 51, 51, 255] } else { [0; 4] };
        assert_eq!(pixel, want, "pixel {} {}", i % 8, i / 8);
    }
    drop((scene, pipeline));
    finish(gpu);
}

#[test]
fn queries_count() {
    let gpu = gpu();
    let pipeline = gpu.graphics_pipeline(&triangle_info(triangle_shaders())).unwrap();
    let scene = Scene::new(&gpu, &pipeline);
    let occlusion = gpu.query_pool("occlusion", QueryKind::Occlusion, 2).unwrap();
    let times = gpu.query_pool("times", QueryKind::Timestamp, 3).unwrap();
    let counters = vk::QueryPipelineStatisticFlags::INPUT_ASSEMBLY_VERTICES
        | vk::QueryPipelineStatisticFlags::CLIPPING_INVOCATIONS;
    let statistics = gpu.query_pool("statistics", QueryKind::Statistics(counters), 1);
    assert_eq!(statistics.is_ok(), gpu.caps().has(Feature::PipelineStatistics));
    let statistics = statistics.ok();
    let precise = gpu.caps().has(Feature::OcclusionQueryPrecise);
    assert_eq!(times.nanoseconds().unwrap(), [None, None, None]);
    for round in 0..2 {
        occlusion.reset();
        times.reset();
        statistics.iter().for_each(|s| s.reset());
        scene.draw(&gpu, &pipeline, |commands, before| {
            let (device, raw) = (commands.device(), commands.raw());
            let flags = if precise { vk::QueryControlFlags::PRECISE } else { vk::QueryControlFlags::empty() };
            // SAFETY: queries of live pools that were reset.
            unsafe {
                let stage = vk::PipelineStageFlags2::ALL_COMMANDS;
                device.cmd_write_timestamp2(raw, stage, times.raw(), u32::from(!before));
                if before {
                    device.cmd_begin_query(raw, occlusion.raw(), 1, flags);
                    statistics.iter().for_each(|s| {
                        device.cmd_begin_query(raw, s.raw(), 0, vk::QueryControlFlags::empty());
                    });
                } else {
                    device.cmd_end_query(raw, occlusion.raw(), 1);
                    statistics.iter().for_each(|s| device.cmd_end_query(raw, s.raw(), 0));
                }
            }
        });
        let results = occlusion.results().unwrap();
        assert_eq!(results[0], None, "round {round}");
        let samples = results[1].as_ref().unwrap()[0];
        let want = (0..64).filter(|i| covered(i % 8, i / 8)).count() as u64;
        assert!(if precise { samples == want } else { samples > 0 }, "{samples}, not {want}");
        let ns = times.nanoseconds().unwrap();
        assert!(ns[0].unwrap() <= ns[1].unwrap() && ns[2].is_none(), "{ns:?}");
        if let Some(statistics) = &statistics {
            assert_eq!(statistics.values(), 2);
            assert_eq!(statistics.results().unwrap(), [Some(vec![3, 1])]);
        }
    }
    assert!(occlusion.nanoseconds().unwrap_err().to_string().contains("\"occlusion\""));
    assert!(gpu.query_pool("none", QueryKind::Occlusion, 0).is_err());
    drop((scene, pipeline, occlusion, times, statistics));
    finish(gpu);
}

#[test]
fn wrong_pipelines_are_errors() {
    let gpu = gpu();
    let shaders = triangle_shaders();
    let good = triangle_info(shaders);
    static OTHER: [Binding; 1] = [binding(0, "tint", BindingKind::StorageBuffer, ShaderAccess::Read)];
    static UINT: [Output; 1] = [Output { location: 0, name: "color", scalar: OutputScalar::Uint, components: 4 }];
    static FAR: [Output; 2] = [output(0, "color"), output(2, "extra")];
    let with = |change: &dyn Fn(&mut Shader)| -> &'static Shader {
        let mut shader = *shaders[1];
        shader.file = "other.frag";
        change(&mut shader);
        Box::leak(Box::new(shader))
    };
    static INPUTS: [Input; 1] = [Input { location: 4, name: "corner", scalar: OutputScalar::Float, components: 3 }];
    let mut far_vertex = *shaders[0];
    far_vertex.inputs = &INPUTS;
    let far_vertex: &'static Shader = Box::leak(Box::new(far_vertex));
    let short = [VertexBuffer { stride: 8, ..POSITIONS[0] }];
    let masked = [ColorTarget { blend: blend::none(), ..ColorTarget::new(vk::Format::R8G8B8A8_UNORM) }];
    let cases: Vec<(GraphicsPipelineInfo, &[&str])> = vec![
        (
            GraphicsPipelineInfo { fragment: Some(with(&|s| s.bindings = &OTHER)), ..good },
            &["triangle.vert", "other.frag", "set 0 binding 0"],
        ),
        (
            GraphicsPipelineInfo { fragment: Some(with(&|s| s.outputs = &UINT)), ..good },
            &["other.frag", "R8G8B8A8_UNORM"],
        ),
        (GraphicsPipelineInfo { fragment: Some(with(&|s| s.outputs = &FAR)), ..good }, &["\"extra\"", "location 2"]),
        (GraphicsPipelineInfo { vertex: far_vertex, ..good }, &["triangle.vert", "\"corner\"", "location 4"]),
        (GraphicsPipelineInfo { vertex_buffers: &short, ..good }, &["stride of 8"]),
        (GraphicsPipelineInfo { fragment: None, ..good }, &["does not write attachment 0"]),
        (GraphicsPipelineInfo { fragment: Some(shaders[0]), ..good }, &["triangle.vert", "Fragment"]),
        (GraphicsPipelineInfo { view_mask: 1 << 31, ..good }, &["multiview of 32 views"]),
        (GraphicsPipelineInfo { samples: 64, ..good }, &["64 samples"]),
        (
            GraphicsPipelineInfo {
                fragment: Some(with(&|s| s.capabilities = &["FragmentShaderPixelInterlockEXT"])),
                ..good
            },
            &["FragmentShaderInterlock"],
        ),
    ];
    for (info, parts) in &cases {
        if parts[0] == "FragmentShaderInterlock" && gpu.caps().has(Feature::FragmentShaderInterlock) {
            continue;
        }
        let text = gpu.graphics_pipeline(info).unwrap_err().to_string();
        assert!(parts.iter().all(|p| text.contains(p)), "{text}");
    }
    // Without a fragment shader the attachment can be masked out.
    gpu.graphics_pipeline(&GraphicsPipelineInfo { fragment: None, color: &masked, ..good }).unwrap();
    let text = gpu.compute_pipeline("stage", shaders[0], &[]).unwrap_err().to_string();
    assert!(text.contains("triangle.vert") && text.contains("Compute"), "{text}");
    let mut large = *scale();
    large.workgroup = [1 << 16, 1, 1];
    let text = gpu.compute_pipeline("large", Box::leak(Box::new(large)), &[]).unwrap_err().to_string();
    assert!(text.contains("65536 invocations") && text.contains("\"large\""), "{text}");
    finish(gpu);
}

#[test]
fn every_state_makes_a_valid_pipeline() {
    let gpu = gpu();
    let good = triangle_info(triangle_shaders());
    let over = [ColorTarget { blend: blend::over(), ..ColorTarget::new(vk::Format::R16G16B16A16_SFLOAT) }];
    let stencil = vk::StencilOpState {
        fail_op: vk::StencilOp::KEEP,
        pass_op: vk::StencilOp::INCREMENT_AND_WRAP,
        depth_fail_op: vk::StencilOp::KEEP,
        compare_op: vk::CompareOp::ALWAYS,
        compare_mask: 0xff,
        write_mask: 0xff,
        reference: 0,
    };
    let format = vk::Format::D32_SFLOAT_S8_UINT;
    let mut states = vec![
        GraphicsPipelineInfo { color: &over, ..good },
        GraphicsPipelineInfo { depth: None, ..good },
        GraphicsPipelineInfo { depth_bias: true, view_mask: 0b1111, ..good },
        GraphicsPipelineInfo { samples: 4, topology: vk::PrimitiveTopology::TRIANGLE_STRIP, ..good },
        GraphicsPipelineInfo {
            depth: good.depth.map(|d| DepthState { format, ..d }),
            stencil: Some(shadowgraph::gpu::StencilState { format, front: stencil, back: stencil }),
            ..good
        },
    ];
    if gpu.caps().has(Feature::DepthClamp) {
        states.push(GraphicsPipelineInfo { depth_clamp: true, ..good });
    }
    for state in &states {
        gpu.graphics_pipeline(state).unwrap();
    }
    let logic = GraphicsPipelineInfo { logic_op: Some(vk::LogicOp::XOR), ..good };
    assert_eq!(gpu.graphics_pipeline(&logic).is_ok(), gpu.caps().has(Feature::LogicOp));
    finish(gpu);
}

#[test]
fn pipelines_share_a_set() {
    let gpu = gpu();
    let [vertex, fragment] = triangle_shaders();
    // Set 0 as both shaders together have it, also for the pipeline of the vertex shader alone.
    let shared = gpu.set_layout(0, &[vertex, fragment]).unwrap();
    assert_eq!(shared.bindings().len(), 2);
    let alone = GraphicsPipelineInfo { fragment: None, color: &[], ..triangle_info([vertex, fragment]) };
    let narrow = gpu.graphics_pipeline(&alone).unwrap();
    let wide = gpu.graphics_pipeline(&GraphicsPipelineInfo { set_layouts: &[(0, &shared)], ..alone }).unwrap();
    let full = gpu.graphics_pipeline(&triangle_info([vertex, fragment])).unwrap();
    assert_eq!(full.set_layout(0).unwrap().raw(), shared.raw());
    assert_eq!(wide.set_layout(0).unwrap().raw(), shared.raw());
    assert_ne!(narrow.set_layout(0).unwrap().raw(), shared.raw());
    assert_eq!(wide.bindings().len(), 1);
    // One that lacks what a shader has is refused.
    let small = gpu.set_layout(0, &[vertex]).unwrap();
    let layouts = [(0, &small)];
    let info = GraphicsPipelineInfo { set_layouts: &layouts, ..triangle_info([vertex, fragment]) };
    let text = gpu.graphics_pipeline(&info).unwrap_err().to_string();
    assert!(text.contains("\"picture\"") && text.contains("triangle.frag"), "{text}");
    drop((narrow, wide, full));
    finish(gpu);
}

#[test]
fn a_pass_after_another_sees_its_writes() {
    // Two dispatches in one submission with a barrier, the second by a set that was written while the first is
    // recorded.
    let gpu = gpu();
    let pipeline = gpu.compute_pipeline("scale", scale(), &[(5, Constant::U32(2))]).unwrap();
    let [a, b] = ["a", "b"].map(|n| buffer(&gpu, n, 256, STORAGE, Memory::Readback));
    a.write(0, bytemuck::cast_slice(&[1i32; 64])).unwrap();
    let mut arena = gpu.descriptor_arena("frame");
    let mut commands = gpu.commands("frame").unwrap();
    for (from, to) in [(&a, &b), (&b, &a)] {
        let set = arena.set(&pipeline, 0, &[(0, Descriptor::buffer(from)), (3, Descriptor::buffer(to))]).unwrap();
        commands.begin_pass(from.name());
        bind(&commands, &pipeline, set);
        // SAFETY: a pipeline and its set are bound.
        unsafe { gpu.raw().cmd_dispatch(commands.raw(), 1, 1, 1) };
        full_barrier(&commands);
        commands.end_pass();
    }
    commands.keep((arena, pipeline, b));
    gpu.wait(gpu.submit(commands).unwrap()).unwrap();
    let got: Vec<i32> = bytemuck::pod_collect_to_vec(&a.read().unwrap());
    assert_eq!(got, (0..64).map(|i| (2 + i) * 2 + i).collect::<Vec<_>>());
    assert_eq!(gpu.live_objects(), ["buffer \"a\""]);
    drop(a);
    finish(gpu);
}

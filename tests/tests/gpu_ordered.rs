//! Fragments that read the attachment that they write, in the order of primitives.
#![allow(missing_docs, clippy::unwrap_used)]

mod gpu_support;

use ash::vk;
use gpu_support::{binding, finish, gpu, output, run, shader};
use shadowgraph::gpu::Feature;
use shadowgraph::graph::{Executor, Graph, ImageShape, Load};
use shadowgraph::shader::{
    Binding, BindingKind, ColorSlot, ImageType, InputSlot, Output, OutputScalar, Program, Shader, ShaderAccess, Stage,
};

const BEFORE: Binding = Binding {
    image: Some(ImageType {
        view: vk::ImageViewType::TYPE_2D,
        multisampled: false,
        comparison: false,
        format: vk::Format::UNDEFINED,
    }),
    ..binding(0, "before", BindingKind::InputAttachment, ShaderAccess::Read)
};
const AFTER: Output = Output { location: 0, name: "after", scalar: OutputScalar::Uint, components: 1 };

/// A triangle over the whole picture for each instance, and what each does to the number of its pixel: sums and products
/// do not commute.
fn shaders() -> [&'static Shader; 2] {
    let vertex = "#version 460
        layout(location = 0) flat out uint layer;
        void main() {
            vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 4.0 - 1.0;
            gl_Position = vec4(corner, 0.5, 1.0);
            layer = uint(gl_InstanceIndex);
        }";
    let fragment = "#version 460
        layout(location = 0) flat in uint layer;
        layout(input_attachment_index = 0, set = 0, binding = 0) uniform usubpassInput before;
        layout(location = 0) out uint after;
        void main() { after = subpassLoad(before).r * 3u + layer + uint(gl_FragCoord.x); }";
    static BINDINGS: [Binding; 1] = [BEFORE];
    static OUTPUTS: [Output; 1] = [AFTER];
    [
        shader(Stage::Vertex, "ordered.vert", vertex, &[], &[], [0; 3]),
        shader(Stage::Fragment, "ordered.frag", fragment, &BINDINGS, &OUTPUTS, [0; 3]),
    ]
}

#[test]
fn gpu_fragments_read_their_attachment_in_order() {
    let gpu = gpu();
    if !gpu.caps().has(Feature::OrderedAttachments) {
        println!("not there: {}", Feature::OrderedAttachments.describe());
        return finish(gpu);
    }
    const SIZE: [u32; 2] = [130, 70];
    const LAYERS: u32 = 19;
    let [vertex, fragment] = shaders();
    let mut executor = Executor::new(&gpu);
    let mut graph = Graph::new("ordered", gpu.caps());
    let numbers = graph.image("numbers", ImageShape::new_2d(vk::Format::R32_UINT, SIZE));
    let numbers = graph.clear("begin", numbers, vk::ClearColorValue { uint32: [7; 4] });
    let mut pass = graph.raster("ordered", vec![Program::new(vertex, Some(fragment))]);
    let numbers = pass.color_in_order(ColorSlot::new(AFTER, fragment), InputSlot::new(BEFORE, fragment), numbers);
    pass.draw(|recorder| {
        recorder.draw(0..3, 0..LAYERS);
        Ok(())
    });
    graph.capture("numbers", &numbers);
    let executed = run(&mut executor, &gpu, graph);
    let found: Vec<u32> = executed.capture("numbers").unwrap().texels().unwrap();
    let expected = |x: u32| (0..LAYERS).fold(7u32, |n, layer| n.wrapping_mul(3).wrapping_add(layer).wrapping_add(x));
    assert_eq!(found.len(), (SIZE[0] * SIZE[1]) as usize);
    for (i, number) in found.into_iter().enumerate() {
        assert_eq!(number, expected(i as u32 % SIZE[0]), "pixel {i}");
    }
    drop((executed, executor));
    finish(gpu);
}

#[test]
fn gpu_ordered_attachments_stand_alone() {
    let gpu = gpu();
    let [vertex, fragment] = shaders();
    let mut graph = Graph::new("ordered", gpu.caps());
    let mut image = |name: &str, format| graph.image(name.to_owned(), ImageShape::new_2d(format, [8; 2]));
    let (numbers, other) = (image("numbers", vk::Format::R32_UINT), image("other", vk::Format::R32G32B32A32_SFLOAT));
    let numbers = graph.clear("begin", numbers, vk::ClearColorValue::default());
    let mut pass = graph.raster("ordered", vec![Program::new(vertex, Some(fragment))]);
    let numbers = pass.color_in_order(ColorSlot::new(AFTER, fragment), InputSlot::new(BEFORE, fragment), numbers);
    let _ = pass.color(ColorSlot::new(output(1, "other"), fragment), other, Load::Clear([0.0; 4]));
    pass.draw(|_| Ok(()));
    graph.keep("numbers", &numbers);
    let said = graph.compile(&gpu).unwrap_err().to_string();
    assert!(said.contains("pass `ordered`: reads a colour attachment in order beside others"), "{said}");
    drop(graph);
    finish(gpu);
}

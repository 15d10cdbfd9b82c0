//! Stencil attachments: counted per face, with and without depth, sampled and read back.
#![allow(missing_docs, clippy::unwrap_used)]

mod gpu_support;

use ash::vk;
use gpu_support::{binding, run, shader};
use shadowgraph::gpu::{Gpu, stencil};
use shadowgraph::graph::{Executor, Graph, ImageHandle, ImageShape, Load};
use shadowgraph::shader::{
    Binding, BindingKind, ImageType, Program, SampledSlot, Shader, ShaderAccess, Stage, StorageSlot, Write,
};
use shadowgraph_tests::device::isolated_device;

const SIZE: [u32; 2] = [8, 8];

/// Instance `i` covers the columns from `i` on, at depth `i / 8`; odd ones face back.
fn strips() -> &'static Shader {
    let source = "#version 460
        void main() {
            int i = gl_InstanceIndex;
            int corner = i % 2 == 0 ? gl_VertexIndex : 2 - gl_VertexIndex;
            float left = float(i) / 4.0 - 1.0;
            vec2 p = corner == 0 ? vec2(left, -1.0) : corner == 1 ? vec2(left, 9.0) : vec2(left + 10.0, -1.0);
            gl_Position = vec4(p, float(i) / 8.0, 1.0);
        }";
    shader(Stage::Vertex, "strips.vert", source, &[], &[], [0; 3])
}

fn count() -> Program {
    let (up, down) = (vk::StencilOp::INCREMENT_AND_WRAP, vk::StencilOp::DECREMENT_AND_WRAP);
    Program::new(strips(), None).stencil(stencil::on_pass(up), stencil::on_pass(down))
}

/// Draws instances over the attachments of a pass that was begun.
macro_rules! draw {
    ($pass:ident, $instances:expr) => {
        $pass.draw(|recorder| {
            recorder.draw(0..3, $instances);
            Ok(())
        })
    };
}

/// Columns of the rows of one layer, which are all alike.
fn columns(bytes: &[u8]) -> [u8; 8] {
    let rows: Vec<[u8; 8]> = bytes.chunks(8).map(|row| row.try_into().unwrap()).collect();
    assert!(rows.len() == 8 && rows.iter().all(|row| row == &rows[0]), "{rows:?}");
    rows[0]
}

fn captured(executor: &mut Executor, gpu: &Gpu, mut graph: Graph, handle: &ImageHandle) -> [u8; 8] {
    graph.capture("stencil", handle);
    let executed = run(executor, gpu, graph);
    executed.capture("stencil").unwrap().layer(0, columns).unwrap()
}

#[test]
fn front_faces_count_up_and_back_faces_down() {
    isolated_device("front_faces_count_up_and_back_faces_down", |gpu| {
        let mut executor = Executor::new(gpu);
        let mut graph = Graph::new("count", gpu.caps());
        let image = graph.image("stencil", ImageShape::new_2d(vk::Format::S8_UINT, SIZE));
        // Instances 1, 3 and 4: down at column 1, down at 3, up at 4, from 1: below zero it wraps.
        let mut pass = graph.raster("first", vec![count()]);
        let image = pass.stencil(image, Load::Clear(1));
        draw!(pass, 1..2);
        let mut pass = graph.raster("second", vec![count()]);
        let image = pass.stencil(image, Load::Keep);
        draw!(pass, 3..5);
        assert_eq!(captured(&mut executor, gpu, graph, &image), [1, 0, 0, 255, 0, 0, 0, 0]);
    });
}

#[test]
fn a_stencil_that_is_tested_is_not_written() {
    isolated_device("a_stencil_that_is_tested_is_not_written", |gpu| {
        let mut executor = Executor::new(gpu);
        let mut graph = Graph::new("test", gpu.caps());
        let image = graph.image("stencil", ImageShape::new_2d(vk::Format::S8_UINT, SIZE));
        let mut pass = graph.raster("mark", vec![count()]);
        let image = pass.stencil(image, Load::Clear(0));
        draw!(pass, 2..3);
        // What is not 0 lets all of the 8×8 pixels' fragments pass that are marked: columns 2 to 7.
        let equal = vk::StencilOpState { compare_op: vk::CompareOp::EQUAL, compare_mask: 0xff, ..stencil::keep() };
        let mut pass = graph.raster("look", vec![Program::new(strips(), None).stencil(equal, equal)]);
        pass.stencil_test(&image).count_samples();
        pass.draw(|recorder| {
            recorder.stencil_reference(1);
            recorder.draw(0..3, 0..1);
            Ok(())
        });
        graph.capture("stencil", &image);
        let executed = run(&mut executor, gpu, graph);
        assert_eq!(executed.samples("look").unwrap(), 6 * 8);
        assert_eq!(executed.capture("stencil").unwrap().layer(0, columns).unwrap(), [0, 0, 1, 1, 1, 1, 1, 1]);
    });
}

#[test]
fn depth_and_stencil_of_one_image_serve_one_pass() {
    isolated_device("depth_and_stencil_of_one_image_serve_one_pass", |gpu| {
        let mut executor = Executor::new(gpu);
        let mut graph = Graph::new("both", gpu.caps());
        let both = graph.image("both", ImageShape::new_2d(vk::Format::D32_SFLOAT_S8_UINT, SIZE));
        let [depth, stencil] = graph.split_aspects(both).try_into().unwrap();
        // Instance 4 lies behind instance 2 and fails; instance 0 lies before and passes.
        let mut pass = graph.raster("count", vec![count().depth(vk::CompareOp::LESS, true)]);
        let depth = pass.depth(depth, Load::Clear(1.0));
        let stencil = pass.stencil(stencil, Load::Clear(0));
        pass.draw(|recorder| {
            [2, 4, 0].into_iter().for_each(|i| recorder.draw(0..3, i..i + 1));
            Ok(())
        });
        // The stencil as a shader sees it.
        static BINDINGS: [Binding; 2] = [
            Binding {
                image: Some(ImageType {
                    view: vk::ImageViewType::TYPE_2D,
                    multisampled: false,
                    comparison: false,
                    format: vk::Format::UNDEFINED,
                }),
                ..binding(0, "stencil", BindingKind::SampledImage, ShaderAccess::Read)
            },
            binding(1, "words", BindingKind::StorageBuffer, ShaderAccess::Write),
        ];
        let source = "#version 460
            #extension GL_EXT_samplerless_texture_functions : require
            layout(local_size_x = 8, local_size_y = 8) in;
            layout(set = 0, binding = 0) uniform utexture2D stencil;
            layout(set = 0, binding = 1, std430) writeonly buffer Words { uint words[]; };
            void main() {
                ivec2 p = ivec2(gl_GlobalInvocationID.xy);
                words[8 * p.y + p.x] = texelFetch(stencil, p, 0).r;
            }";
        let look = shader(Stage::Compute, "look.comp", source, &BINDINGS, &[], [8, 8, 1]);
        let words = graph.buffer("words", 4 * 64);
        let mut pass = graph.compute("look", look);
        pass.read(SampledSlot::new(BINDINGS[0], look), &stencil);
        let words = pass.write(StorageSlot::<u32, Write>::new(BINDINGS[1], look), words);
        pass.dispatch([8, 8, 1]);
        graph.capture("words", &words);
        graph.capture("stencil", &stencil);
        graph.capture("depth", &depth);
        let executed = run(&mut executor, gpu, graph);

        let expected = [1, 1, 2, 2, 2, 2, 2, 2];
        assert_eq!(executed.capture("stencil").unwrap().layer(0, columns).unwrap(), expected);
        let words: Vec<u32> = executed.capture("words").unwrap().texels().unwrap();
        assert_eq!(columns(&words.iter().map(|&word| word as u8).collect::<Vec<_>>()), expected);
        let depth: Vec<f32> = executed.capture("depth").unwrap().texels().unwrap();
        assert_eq!(depth, [0.0; 64]);
    });
}

#[test]
fn what_no_stencil_can_be_is_refused() {
    isolated_device("what_no_stencil_can_be_is_refused", |gpu| {
        let refused = |describe: &dyn Fn(&mut Graph)| {
            let mut graph = Graph::new("wrong", gpu.caps());
            describe(&mut graph);
            graph.compile(gpu).unwrap_err().to_string()
        };
        let kept = |graph: &mut Graph, image: ImageHandle| graph.capture("image", &image);
        // A format without the aspect.
        for (format, aspect) in [(vk::Format::D32_SFLOAT, "STENCIL"), (vk::Format::R8_UINT, "STENCIL")] {
            let text = refused(&|graph| {
                let image = graph.image("image", ImageShape::new_2d(format, SIZE));
                let mut pass = graph.raster("count", vec![count()]);
                let image = pass.stencil(image, Load::Clear(0));
                draw!(pass, 0..1);
                kept(graph, image);
            });
            assert!(text.contains(&format!("{format:?}")) && text.contains(aspect), "{text}");
        }
        let text = refused(&|graph| {
            let image = graph.image("image", ImageShape::new_2d(vk::Format::S8_UINT, SIZE));
            let mut pass = graph.raster("draw", vec![Program::new(strips(), None)]);
            let image = pass.depth(image, Load::Clear(0.0));
            draw!(pass, 0..1);
            kept(graph, image);
        });
        assert!(text.contains("S8_UINT") && text.contains("DEPTH"), "{text}");
        // Two images for one pass.
        let text = refused(&|graph| {
            let [a, b] =
                ["a", "b"].map(|name| graph.image(name, ImageShape::new_2d(vk::Format::D32_SFLOAT_S8_UINT, SIZE)));
            let mut pass = graph.raster("count", vec![count()]);
            let a = pass.depth(a, Load::Clear(0.0));
            let b = pass.stencil(b, Load::Clear(0));
            draw!(pass, 0..1);
            graph.capture("a", &a);
            graph.capture("b", &b);
        });
        assert!(text.contains("another image") && text.contains("stencil"), "{text}");
        // A test without an attachment.
        let text = refused(&|graph| {
            let image = graph.image("image", ImageShape::new_2d(vk::Format::D32_SFLOAT, SIZE));
            let mut pass = graph.raster("count", vec![count()]);
            let image = pass.depth(image, Load::Clear(0.0));
            draw!(pass, 0..1);
            kept(graph, image);
        });
        assert!(text.contains("`stencil`") && text.contains("strips.vert"), "{text}");
    });
}

#[test]
fn pipelines_of_two_formats_are_refused() {
    isolated_device("pipelines_of_two_formats_are_refused", |gpu| {
        use shadowgraph::gpu::{DepthState, GraphicsPipelineInfo, StencilState};
        let pipeline = |depth: vk::Format, stencil: vk::Format| {
            let keep = stencil::keep();
            gpu.graphics_pipeline(&GraphicsPipelineInfo {
                depth: Some(DepthState { format: depth, compare: vk::CompareOp::LESS, write: true }),
                stencil: Some(StencilState { format: stencil, front: keep, back: keep }),
                ..GraphicsPipelineInfo::new("two", strips())
            })
            .map_err(|error| error.to_string())
        };
        let text = pipeline(vk::Format::D32_SFLOAT, vk::Format::S8_UINT).err().unwrap();
        assert!(text.contains("both are of one image") && text.contains("S8_UINT"), "{text}");
        let text = pipeline(vk::Format::D32_SFLOAT, vk::Format::D32_SFLOAT).err().unwrap();
        assert!(text.contains("D32_SFLOAT has no STENCIL"), "{text}");
        pipeline(vk::Format::D32_SFLOAT_S8_UINT, vk::Format::D32_SFLOAT_S8_UINT).unwrap();
    });
}

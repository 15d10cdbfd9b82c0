//! What compiles and must not be run: plans, imports, dispatches and draws that do not fit, each named in its error.
#![allow(missing_docs, clippy::unwrap_used)]

mod gpu_support;

use ash::vk;
use gpu_support::shader;
use shadowgraph::gpu::{BufferInfo, Gpu, Image, ImageInfo, Memory};
use shadowgraph::graph::description::Access;
use shadowgraph::graph::{Executor, Graph, ImageShape, Load};
use shadowgraph::shader::generated::bench::chain_comp as chain;
use shadowgraph::shader::{Program, Stage};
use shadowgraph_tests::device::isolated_device;

fn shape(side: u32) -> ImageShape {
    ImageShape::new_2d(vk::Format::R32_UINT, [side; 2])
}

/// An image cleared, and read back.
fn describe(graph: &mut Graph, side: u32) {
    let image = graph.image("image", shape(side));
    let image = graph.clear("clear", image, vk::ClearColorValue { uint32: [7, 0, 0, 0] });
    graph.capture("image", &image);
}

fn image(gpu: &Gpu, usage: vk::ImageUsageFlags) -> Image {
    let info =
        ImageInfo { name: "mine", format: vk::Format::R32_UINT, extent: [16, 16, 1], usage, ..Default::default() };
    gpu.create_image(&info).unwrap()
}

#[test]
fn a_plan_serves_no_other_graph() {
    isolated_device("a_plan_serves_no_other_graph", |gpu| {
        let mut executor = Executor::new(gpu);
        let mut small = Graph::new("small", gpu.caps());
        describe(&mut small, 16);
        let plan = small.compile(gpu).unwrap();
        let mut large = Graph::new("large", gpu.caps());
        describe(&mut large, 64);
        let error = executor.execute(&plan, large).err().unwrap().to_string();
        assert!(error.contains("`large`") && error.contains("was compiled from another graph"), "{error}");
        let mut more = Graph::new("more", gpu.caps());
        describe(&mut more, 16);
        let other = more.image("other", shape(16));
        let other = more.clear("clear other", other, vk::ClearColorValue::default());
        more.capture("other", &other);
        let error = executor.prepare(&plan, more).err().unwrap().to_string();
        assert!(error.contains("was compiled from another graph"), "{error}");
        // Names do not matter.
        let mut renamed = Graph::new("renamed", gpu.caps());
        describe(&mut renamed, 16);
        executor.execute(&plan, renamed).unwrap();
    });
}

#[test]
fn imports_are_used_as_they_were_made() {
    isolated_device("imports_are_used_as_they_were_made", |gpu| {
        let mut executor = Executor::new(gpu);
        let sampled = image(gpu, vk::ImageUsageFlags::SAMPLED);
        let mut graph = Graph::new("frame", gpu.caps());
        let mine = graph.import_image(&sampled, Access::NONE, None);
        let mine = graph.clear("clear", mine, vk::ClearColorValue::default());
        graph.keep("mine", &mine);
        let plan = graph.compile(gpu).unwrap();
        let error = executor.execute(&plan, graph).err().unwrap().to_string();
        assert!(error.contains("import `mine`") && error.contains("TRANSFER_DST"), "{error}");
    });
}

#[test]
fn a_prepared_frame_leaves_imports_as_they_arrive() {
    isolated_device("a_prepared_frame_leaves_imports_as_they_arrive", |gpu| {
        let mut executor = Executor::new(gpu);
        let target = image(gpu, vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::SAMPLED);
        let shown = Access {
            stages: vk::PipelineStageFlags2::FRAGMENT_SHADER,
            mask: vk::AccessFlags2::SHADER_SAMPLED_READ,
            layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        };
        let mut prepare = |before: Access, after: Option<Access>| {
            let mut graph = Graph::new("frame", gpu.caps());
            let mine = graph.import_image(&target, before, after);
            let mine = graph.clear("clear", mine, vk::ClearColorValue::default());
            graph.keep("mine", &mine);
            let plan = graph.compile(gpu).unwrap();
            let mut prepared = executor.prepare(&plan, graph)?;
            executor.run(&mut prepared)?;
            executor.run(&mut prepared).map(|_| ())
        };
        // What was there does not matter; it is given back as it came; it is not.
        prepare(Access::NONE, None).unwrap();
        prepare(Access::NONE, Some(shown)).unwrap();
        prepare(shown, Some(shown)).unwrap();
        let error = prepare(shown, None).unwrap_err().to_string();
        assert!(error.contains("`mine`") && error.contains("is left as TRANSFER_DST_OPTIMAL"), "{error}");
    });
}

#[test]
fn dispatches_beyond_the_device_are_errors() {
    isolated_device("dispatches_beyond_the_device_are_errors", |gpu| {
        let [most, ..] = gpu.caps().limits.max_compute_workgroup_count;
        let mut graph = Graph::new("frame", gpu.caps());
        let from = graph.image("from", shape(16));
        let from = graph.clear("clear", from, vk::ClearColorValue::default());
        let to = graph.image("to", shape(16));
        let mut pass = graph.compute("far", &chain::SHADER);
        pass.read(chain::FROM, &from).push(&1_u32);
        let to = pass.write(chain::TO, to);
        pass.dispatch([most.saturating_mul(chain::SHADER.workgroup[0]).saturating_add(1), 1, 1]);
        graph.capture("to", &to);
        if u64::from(most) * u64::from(chain::SHADER.workgroup[0]) < u64::from(u32::MAX) {
            let error = graph.compile(gpu).unwrap_err().to_string();
            assert!(error.contains("workgroups are dispatched") && error.contains("`far`"), "{error}");
        }

        let usage = vk::BufferUsageFlags::INDIRECT_BUFFER;
        let groups = BufferInfo { name: "groups", size: 16, usage, memory: Memory::Device };
        let groups = gpu.create_buffer(&groups).unwrap();
        for (offset, is_right) in [(0, true), (4, true), (2, false), (8, false), (u64::MAX - 3, false)] {
            let mut graph = Graph::new("frame", gpu.caps());
            let groups = graph.import_buffer(&groups, Access::NONE, None);
            let from = graph.image("from", shape(16));
            let from = graph.clear("clear", from, vk::ClearColorValue::default());
            let to = graph.image("to", shape(16));
            let mut pass = graph.compute("indirect", &chain::SHADER);
            pass.read(chain::FROM, &from).push(&1_u32);
            let to = pass.write(chain::TO, to);
            pass.dispatch_indirect(&groups, offset);
            graph.capture("to", &to);
            let found = graph.compile(gpu).map_err(|errors| errors.to_string());
            assert_eq!(found.is_ok(), is_right, "{offset}: {:?}", found.err());
        }
    });
}

#[test]
fn draws_beyond_the_index_buffer_are_errors() {
    isolated_device("draws_beyond_the_index_buffer_are_errors", |gpu| {
        let source = "#version 460
            void main() { gl_Position = vec4(0.0, 0.0, 0.5, 1.0); }";
        let vertex = shader(Stage::Vertex, "still.vert", source, &[], &[], [0; 3]);
        let usage = vk::BufferUsageFlags::INDEX_BUFFER;
        let indices =
            gpu.create_buffer(&BufferInfo { name: "indices", size: 12, usage, memory: Memory::Upload }).unwrap();
        indices.write(0, &[0; 12]).unwrap();
        let draw = |drawn: std::ops::Range<u32>, bound: bool| {
            let indices = indices.clone();
            let mut graph = Graph::new("frame", gpu.caps());
            let depth = graph.image("depth", ImageShape::new_2d(vk::Format::D32_SFLOAT, [16; 2]));
            let mut pass = graph.raster("draw", vec![Program::new(vertex, None)]);
            let depth = pass.depth(depth, Load::Clear(0.0));
            pass.draw(move |recorder| {
                if bound {
                    recorder.index_buffer(&indices);
                }
                recorder.draw_indexed(drawn.clone(), 0, 0..1);
                Ok(())
            });
            graph.capture("depth", &depth);
            let plan = graph.compile(gpu).unwrap();
            Executor::new(gpu).execute(&plan, graph).map(|_| ()).map_err(|error| error.to_string())
        };
        draw(0..3, true).unwrap();
        let error = draw(0..4, true).unwrap_err();
        assert!(error.contains("indices 0..4 are drawn of 3 that are bound"), "{error}");
        assert!(draw(0..3, false).unwrap_err().contains("of 0 that are bound"));
    });
}

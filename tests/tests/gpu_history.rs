//! Resources of the last frame on a device.
#![allow(missing_docs, clippy::unwrap_used)]

mod gpu_support;

use ash::vk;
use gpu_support::{binding, run, shader};
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executor, First, Graph, History, ImageHandle, ImageShape};
use shadowgraph::shader::{Binding, BindingKind, ImageSlot, Read, Shader, ShaderAccess, Stage, StorageSlot, Write};
use shadowgraph_tests::device::isolated_device;

const BINDINGS: [Binding; 2] = [
    binding(0, "previous", BindingKind::StorageImage, ShaderAccess::Read),
    binding(1, "next", BindingKind::StorageImage, ShaderAccess::Write),
];

/// Each texel becomes the last frame's and its own number more.
struct Accumulate {
    shader: &'static Shader,
    previous: ImageSlot<Read>,
    next: ImageSlot<Write>,
}

impl Accumulate {
    fn new() -> Self {
        static ALL: [Binding; 2] = BINDINGS;
        let source = "#version 460
            layout(local_size_x = 8, local_size_y = 8) in;
            layout(set = 0, binding = 0, r32ui) readonly uniform uimage2D previous;
            layout(set = 0, binding = 1, r32ui) writeonly uniform uimage2D next;
            void main() {
                ivec2 p = ivec2(gl_GlobalInvocationID.xy);
                ivec2 size = imageSize(next);
                if (any(greaterThanEqual(p, size))) return;
                uint value = imageLoad(previous, p).r + uint(p.y * size.x + p.x);
                imageStore(next, p, uvec4(value, 0, 0, 0));
            }";
        let shader = shader(Stage::Compute, "accumulate.comp", source, &ALL, &[], [8, 8, 1]);
        Self { shader, previous: ImageSlot::new(ALL[0], shader), next: ImageSlot::new(ALL[1], shader) }
    }

    fn record(&self, graph: &mut Graph, name: &str, previous: &ImageHandle, next: ImageHandle) -> ImageHandle {
        let [width, height] = next.size();
        let mut pass = graph.compute(name, self.shader);
        pass.read(self.previous, previous);
        let next = pass.write(self.next, next);
        pass.dispatch([width, height, 1]);
        next
    }
}

fn shape(size: [u32; 2]) -> ImageShape {
    ImageShape::new_2d(vk::Format::R32_UINT, size)
}

fn ten() -> First {
    First::Color(vk::ClearColorValue { uint32: [10, 0, 0, 0] })
}

/// What `count` frames since the first make of it.
fn expected(size: [u32; 2], count: u32) -> Vec<u32> {
    (0..size[0] * size[1]).map(|texel| 10 + count * texel).collect()
}

#[test]
fn frames_accumulate_until_a_cut_or_another_size() {
    isolated_device("frames_accumulate_until_a_cut_or_another_size", |gpu| {
        let accumulate = Accumulate::new();
        let mut executor = Executor::new(gpu);
        // Size, whether the view is cut, whether the frame writes, and how many frames since the first have written.
        let frames = [
            ([8, 8], false, true, 1),
            ([8, 8], false, true, 2),
            ([8, 8], false, true, 3),
            ([8, 8], false, false, 3),
            ([8, 8], false, true, 4),
            ([16, 5], false, true, 1),
            ([16, 5], false, true, 2),
            ([16, 5], true, true, 1),
            ([16, 5], false, true, 2),
            ([16, 5], true, false, 0),
            ([16, 5], false, false, 0),
            ([16, 5], false, true, 1),
        ];
        for (index, (size, cut, writes, count)) in frames.into_iter().enumerate() {
            let mut graph = executor.graph("frame");
            if cut {
                graph.cut();
            }
            let History { previous, next, is_first } = graph.history_image("sum", shape(size), ten());
            assert_eq!(is_first, index == 0 || cut || index == 5, "frame {index}");
            if writes {
                let next = accumulate.record(&mut graph, "accumulate", &previous, next);
                graph.capture("sum", &next);
            } else {
                graph.capture("sum", &previous);
            }
            let executed = run(&mut executor, gpu, graph);
            let found: Vec<u32> = executed.capture("sum").unwrap().texels().unwrap();
            assert_eq!(found, expected(size, count), "frame {index}");
        }
    });
}

#[test]
fn nobody_has_to_read_a_history_for_it_to_go_on() {
    isolated_device("nobody_has_to_read_a_history_for_it_to_go_on", |gpu| {
        let accumulate = Accumulate::new();
        let mut executor = Executor::new(gpu);
        for frame in 1..=4 {
            let mut graph = executor.graph("frame");
            let sum = graph.history_image("sum", shape([8, 8]), ten());
            let next = accumulate.record(&mut graph, "accumulate", &sum.previous, sum.next);
            if frame == 4 {
                graph.capture("sum", &next);
            }
            let executed = run(&mut executor, gpu, graph);
            if frame == 4 {
                assert_eq!(executed.capture("sum").unwrap().texels::<u32>().unwrap(), expected([8, 8], 4));
            }
        }
        assert!(executor.forget_history("sum") && !executor.forget_history("sum"));
        assert!(executor.graph("frame").history_image("sum", shape([8, 8]), ten()).is_first);
    });
}

/// The layers are written by passes of their own, and one of them is read again: they end in states of their own.
#[test]
fn parts_are_left_in_states_of_their_own() {
    isolated_device("parts_are_left_in_states_of_their_own", |gpu| {
        let accumulate = Accumulate::new();
        let mut executor = Executor::new(gpu);
        for frame in 1..=5 {
            let mut graph = executor.graph("frame");
            let layered = graph.history_image("sum", shape([8, 8]).layers(2), ten());
            let previous = graph.split_layers(layered.previous);
            let next = graph.split_layers(layered.next);
            let mut made = Vec::new();
            for (layer, (previous, next)) in previous.iter().zip(next).enumerate() {
                made.push(accumulate.record(&mut graph, &format!("layer {layer}"), previous, next));
            }
            graph.capture("one", &made[1]);
            let copy = graph.image("copy", shape([8, 8]));
            let copy = accumulate.record(&mut graph, "copy", &made[0], copy);
            graph.capture("copy", &copy);
            let executed = run(&mut executor, gpu, graph);
            assert_eq!(executed.capture("one").unwrap().texels::<u32>().unwrap(), expected([8, 8], frame));
            assert_eq!(executed.capture("copy").unwrap().texels::<u32>().unwrap(), expected([8, 8], frame + 1));
        }
    });
}

#[test]
fn buffers_and_depth_have_histories() {
    isolated_device("buffers_and_depth_have_histories", |gpu| {
        static ALL: [Binding; 2] = [
            binding(0, "previous", BindingKind::StorageBuffer, ShaderAccess::Read),
            binding(1, "next", BindingKind::StorageBuffer, ShaderAccess::Write),
        ];
        let source = "#version 460
            layout(local_size_x = 64) in;
            layout(set = 0, binding = 0, std430) readonly buffer Previous { uint previous[]; };
            layout(set = 0, binding = 1, std430) writeonly buffer Next { uint next[]; };
            void main() {
                uint i = gl_GlobalInvocationID.x;
                next[i] = previous[63 - i] * 2 + i;
            }";
        let shader = shader(Stage::Compute, "turn.comp", source, &ALL, &[], [64, 1, 1]);
        let (previous, next) =
            (StorageSlot::<u32, Read>::new(ALL[0], shader), StorageSlot::<u32, Write>::new(ALL[1], shader));
        let mut executor = Executor::new(gpu);
        let mut want = vec![7; 64];
        for frame in 0..4 {
            let mut graph = executor.graph("frame");
            let numbers = graph.history_buffer("numbers", 256, First::Fill(7));
            let depth =
                graph.history_image("depth", ImageShape::new_2d(vk::Format::D32_SFLOAT, [4, 4]), First::Depth(0.25));
            let mut pass = graph.compute("turn", shader);
            pass.read(previous, &numbers.previous);
            let numbers = pass.write(next, numbers.next);
            pass.dispatch([64, 1, 1]);
            graph.capture("numbers", &numbers);
            graph.capture("depth", &depth.previous);
            let executed = run(&mut executor, gpu, graph);
            want = (0..64).map(|i| want[63 - i] * 2 + i as u32).collect();
            assert_eq!(executed.capture("numbers").unwrap().texels::<u32>().unwrap(), want, "frame {frame}");
            assert_eq!(executed.capture("depth").unwrap().texels::<f32>().unwrap(), [0.25; 16], "frame {frame}");
        }
    });
}

/// What compiling a graph says, one error a line.
fn errors(graph: &Graph, gpu: &Gpu) -> Vec<String> {
    graph.compile(gpu).unwrap_err().errors.iter().map(ToString::to_string).collect()
}

#[test]
fn misused_histories_are_errors() {
    isolated_device("misused_histories_are_errors", |gpu| {
        let accumulate = Accumulate::new();
        let mut executor = Executor::new(gpu);

        let mut graph = executor.graph("twice");
        let one = graph.history_image("sum", shape([8, 8]), ten());
        let _other = graph.history_image("sum", shape([4, 8]), ten());
        graph.capture("sum", &one.previous);
        assert_eq!(
            errors(&graph, gpu)[0],
            "resource `sum`: is declared twice in a frame, as 8x8x1 texels of R32_UINT, 1 mips, 1 layers and as 4x8x1 \
             texels of R32_UINT, 1 mips, 1 layers; once: hand the handles on"
        );

        let mut graph = executor.graph("backwards");
        let sum = graph.history_image("sum", shape([8, 8]), ten());
        let _previous = accumulate.record(&mut graph, "forth", &sum.previous, sum.next);
        let sum = graph.history_image("other", shape([8, 8]), ten());
        let _next = graph.clear("back", sum.previous, vk::ClearColorValue::default());
        assert_eq!(
            errors(&graph, gpu),
            ["resource `other`: slot `destination` writes what the last frame left; write `next`; `previous` is read"]
        );

        let mut graph = executor.graph("a circle");
        let sum = graph.history_image("sum", shape([8, 8]), First::Nothing);
        let image = graph.image("image", shape([8, 8]));
        let image = accumulate.record(&mut graph, "ahead of time", &sum.next, image);
        let _next = accumulate.record(&mut graph, "accumulate", &image, sum.next);
        assert_eq!(
            errors(&graph, gpu),
            [
                "pass `ahead of time`, slot `previous`, resource `sum`: reads what nobody has written; write it first, or \
              say that its earlier contents do not matter"
            ]
        );

        let mut graph = executor.graph("the first has nothing");
        let sum = graph.history_image("sum", shape([8, 8]), First::Nothing);
        let _next = accumulate.record(&mut graph, "accumulate", &sum.previous, sum.next);
        assert_eq!(
            errors(&graph, gpu),
            [
                "pass `accumulate`, slot `previous`, resource `sum of the last frame`: reads what nobody has written; write \
              it first, or say that its earlier contents do not matter"
            ]
        );

        let mut graph = executor.graph("a gap");
        let sum = graph.history_image("sum", shape([8, 8]).layers(2), ten());
        let (previous, next) = (graph.split_layers(sum.previous), graph.split_layers(sum.next));
        for next in next.into_iter().take(1) {
            let _next = accumulate.record(&mut graph, "accumulate", &previous[0], next);
        }
        assert_eq!(
            errors(&graph, gpu),
            ["resource `sum`: is written in part: the next frame would find a gap; write all of `next`, or nothing"]
        );

        let mut graph = executor.graph("another value");
        let _sum = graph.history_image("sum", shape([8, 8]), First::Depth(1.0));
        let _buffer = graph.history_buffer("numbers", 16, ten());
        assert_eq!(
            errors(&graph, gpu),
            [
                "resource `sum`: begins with a value that format R32_UINT does not take; Color for colours, Depth for depth, \
              Nothing for all",
                "resource `numbers`: begins with a value that no buffer takes; Fill or Nothing"
            ]
        );

        // Two graphs begun from one frame: the second does not know what the first one left.
        let begin =
            |executor: &Executor<'_>| executor.graph("frame").history_image("sum", shape([8, 8]), ten()).is_first;
        assert!(begin(&executor));
        let late = {
            let mut graph = executor.graph("late");
            let sum = graph.history_image("sum", shape([8, 8]), ten());
            let next = accumulate.record(&mut graph, "accumulate", &sum.previous, sum.next);
            graph.capture("sum", &next);
            graph
        };
        let mut graph = executor.graph("frame");
        let sum = graph.history_image("sum", shape([8, 8]), ten());
        let next = accumulate.record(&mut graph, "accumulate", &sum.previous, sum.next);
        graph.capture("sum", &next);
        run(&mut executor, gpu, graph);
        let plan = late.compile(gpu).unwrap();
        let said = executor.execute(&plan, late).err().unwrap().to_string();
        assert!(said.starts_with("history `sum`: has gone on since the graph was begun"), "{said}");
        assert!(!begin(&executor), "an error before anything ran forgets nothing");
    });
}

//! Frames that size themselves by what the host reads in between.
#![allow(missing_docs, clippy::unwrap_used)]

mod gpu_support;

use ash::vk;
use gpu_support::{binding, run, shader};
use shadowgraph::graph::{Executor, First, ImageShape};
use shadowgraph::shader::{
    Binding, BindingKind, Read, ReadWrite, Shader, ShaderAccess, Stage, StorageSlot, UniformSlot, Write,
};
use shadowgraph_tests::device::isolated_device;

const STORAGE: BindingKind = BindingKind::StorageBuffer;
const PIXELS: u32 = 1000;

fn compute(file: &'static str, source: &str, bindings: &'static [Binding]) -> &'static Shader {
    shader(Stage::Compute, file, source, bindings, &[], [64, 1, 1])
}

/// How many layers lie over a pixel, and how bright each of them is.
fn layers(seed: u32) -> Vec<Vec<u32>> {
    let mut state = seed;
    let mut next = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 16
    };
    (0..PIXELS).map(|_| (0..next() % 5).map(|_| next()).collect()).collect()
}

/// An A-buffer: count the layers, make a buffer of so many nodes, link them, resolve the lists.
#[test]
fn a_buffer_is_as_large_as_a_pass_has_counted() {
    isolated_device("a_buffer_is_as_large_as_a_pass_has_counted", |gpu| {
        static COUNT: [Binding; 2] = [
            binding(0, "offsets", STORAGE, ShaderAccess::Read),
            binding(1, "counter", STORAGE, ShaderAccess::ReadWrite),
        ];
        let count = compute(
            "count.comp",
            "#version 460
            layout(local_size_x = 64) in;
            layout(set = 0, binding = 0, std430) readonly buffer Offsets { uint offsets[]; };
            layout(set = 0, binding = 1, std430) buffer Counter { uint counter; };
            void main() {
                uint i = gl_GlobalInvocationID.x;
                if (i < 1000) atomicAdd(counter, offsets[i + 1] - offsets[i]);
            }",
            &COUNT,
        );
        static BUILD: [Binding; 5] = [
            binding(0, "offsets", STORAGE, ShaderAccess::Read),
            binding(1, "values", STORAGE, ShaderAccess::Read),
            binding(2, "counter", STORAGE, ShaderAccess::ReadWrite),
            binding(3, "heads", STORAGE, ShaderAccess::ReadWrite),
            binding(4, "nodes", STORAGE, ShaderAccess::Write),
        ];
        let build = compute(
            "build.comp",
            "#version 460
            layout(local_size_x = 64) in;
            layout(set = 0, binding = 0, std430) readonly buffer Offsets { uint offsets[]; };
            layout(set = 0, binding = 1, std430) readonly buffer Values { uint values[]; };
            layout(set = 0, binding = 2, std430) buffer Counter { uint counter; };
            layout(set = 0, binding = 3, std430) buffer Heads { uint heads[]; };
            layout(set = 0, binding = 4, std430) writeonly buffer Nodes { uvec2 nodes[]; };
            void main() {
                uint i = gl_GlobalInvocationID.x;
                if (i >= 1000) return;
                for (uint j = offsets[i]; j < offsets[i + 1]; ++j) {
                    uint node = atomicAdd(counter, uint(-1)) - 1;
                    if (node < nodes.length()) nodes[node] = uvec2(values[j], atomicExchange(heads[i], node));
                }
            }",
            &BUILD,
        );
        static RESOLVE: [Binding; 3] = [
            binding(0, "heads", STORAGE, ShaderAccess::Read),
            binding(1, "nodes", STORAGE, ShaderAccess::Read),
            binding(2, "sums", STORAGE, ShaderAccess::Write),
        ];
        let resolve = compute(
            "resolve.comp",
            "#version 460
            layout(local_size_x = 64) in;
            layout(set = 0, binding = 0, std430) readonly buffer Heads { uint heads[]; };
            layout(set = 0, binding = 1, std430) readonly buffer Nodes { uvec2 nodes[]; };
            layout(set = 0, binding = 2, std430) writeonly buffer Sums { uint sums[]; };
            void main() {
                uint i = gl_GlobalInvocationID.x;
                if (i >= 1000) return;
                uint sum = 0;
                for (uint node = heads[i]; node != 0xffffffffu; node = nodes[node].y) sum += nodes[node].x + 1;
                sums[i] = sum;
            }",
            &RESOLVE,
        );
        let mut executor = Executor::new(gpu);
        for seed in 0..4 {
            let layers = if seed == 3 { vec![Vec::new(); PIXELS as usize] } else { layers(seed) };
            let mut offsets = vec![0];
            offsets.extend(layers.iter().scan(0, |sum, own| {
                *sum += own.len() as u32;
                Some(*sum)
            }));
            let values: Vec<u32> = layers.concat();
            let total = values.len() as u64;

            // The whole frame is described at once.
            let mut graph = executor.graph("a-buffer");
            let (offsets, values) = (graph.data(&offsets), graph.data(&values));
            let counter = graph.buffer("counter", 4);
            let heads = graph.buffer("heads", u64::from(PIXELS) * 4);
            let counter = graph.fill("begin", counter, 0);
            let heads = graph.fill("begin lists", heads, u32::MAX);
            let mut pass = graph.compute("count", count);
            pass.constant(StorageSlot::<u32, Read>::new(COUNT[0], count), offsets);
            let counter = pass.write(StorageSlot::<u32, ReadWrite>::new(COUNT[1], count), counter);
            pass.dispatch([PIXELS, 1, 1]);
            let counted = graph.checkpoint::<u32>("layers", &counter);
            assert!(counted.values().is_err());
            let nodes = graph.buffer_after(&counted, "nodes", |count| 8 * u64::from(count[0]));
            let mut pass = graph.compute("build", build);
            pass.constant(StorageSlot::<u32, Read>::new(BUILD[0], build), offsets);
            pass.constant(StorageSlot::<u32, Read>::new(BUILD[1], build), values);
            let counter = pass.write(StorageSlot::<u32, ReadWrite>::new(BUILD[2], build), counter);
            let heads = pass.write(StorageSlot::<u32, ReadWrite>::new(BUILD[3], build), heads);
            let nodes = pass.write(StorageSlot::<u32, Write>::new(BUILD[4], build), nodes);
            pass.dispatch([PIXELS, 1, 1]);
            let sums = graph.buffer("sums", u64::from(PIXELS) * 4);
            let mut pass = graph.compute("resolve", resolve);
            pass.read(StorageSlot::<u32, Read>::new(RESOLVE[0], resolve), &heads);
            pass.read(StorageSlot::<u32, Read>::new(RESOLVE[1], resolve), &nodes);
            let sums = pass.write(StorageSlot::<u32, Write>::new(RESOLVE[2], resolve), sums);
            pass.dispatch([PIXELS, 1, 1]);
            graph.capture("left", &counter);
            graph.capture("nodes", &nodes);
            graph.capture("sums", &sums);

            let executed = run(&mut executor, gpu, graph);
            assert_eq!(counted.values().unwrap(), [total as u32]);
            assert_eq!(executed.later.len(), 1);
            let passes = &executed.later[0].description.passes;
            assert!(passes.iter().any(|pass| pass.name.as_str() == "resolve"), "{} passes", passes.len());
            let names: Vec<_> = executed.captures.iter().map(|capture| capture.name.as_str()).collect();
            assert_eq!(names, ["left", "nodes", "sums"]);
            // What was counted once is used up to the last node.
            assert_eq!(executed.capture("left").unwrap().texels::<u32>().unwrap(), [0]);
            let nodes: Vec<u32> = executed.capture("nodes").unwrap().texels().unwrap();
            assert_eq!(nodes.len() as u64, (2 * total).max(1), "as large as counted, and at least a word");
            let mut stored: Vec<u32> = nodes.chunks_exact(2).map(|node| node[0]).collect();
            let mut wanted = layers.concat();
            stored.sort_unstable();
            wanted.sort_unstable();
            assert_eq!(stored, wanted);
            let sums: Vec<u32> = executed.capture("sums").unwrap().texels().unwrap();
            let wanted: Vec<u32> = layers.iter().map(|own| own.iter().map(|value| value + 1).sum()).collect();
            assert_eq!(sums, wanted);
        }
    });
}

/// Values are fitted to the range that a pass finds, in two checkpoints, over a history.
#[test]
fn blocks_follow_from_checkpoints_and_histories_go_through_them() {
    isolated_device("blocks_follow_from_checkpoints_and_histories_go_through_them", |gpu| {
        static ADD: [Binding; 3] = [
            binding(0, "step_block", BindingKind::UniformBuffer, ShaderAccess::Read),
            binding(1, "previous", STORAGE, ShaderAccess::Read),
            binding(2, "next", STORAGE, ShaderAccess::Write),
        ];
        let add = compute(
            "add.comp",
            "#version 460
            layout(local_size_x = 64) in;
            layout(set = 0, binding = 0, std140) uniform Step { uint step_block; };
            layout(set = 0, binding = 1, std430) readonly buffer Previous { uint previous[]; };
            layout(set = 0, binding = 2, std430) writeonly buffer Next { uint next[]; };
            void main() {
                uint i = gl_GlobalInvocationID.x;
                if (i < next.length()) next[i] = previous[i % previous.length()] + step_block;
            }",
            &ADD,
        );
        let step = UniformSlot::<u32>::new(ADD[0], add);
        let (from, to) = (StorageSlot::<u32, Read>::new(ADD[1], add), StorageSlot::<u32, Write>::new(ADD[2], add));
        let mut executor = Executor::new(gpu);
        let mut want = 1;
        for frame in 0..4 {
            let mut graph = executor.graph("frame");
            let value = graph.history_buffer("value", 4, First::Fill(1));
            let one = graph.buffer("one", 4);
            let mut pass = graph.compute("one", add);
            pass.uniform(step, &5);
            pass.read(from, &value.previous);
            let one = pass.write(to, one);
            pass.dispatch([1, 1, 1]);
            // As much again as the first one is.
            let first = graph.checkpoint::<u32>("first", &one);
            let doubled = graph.data_after(&first, |values| values[0]);
            let two = graph.buffer("two", 4);
            let mut pass = graph.compute("two", add);
            pass.uniform_data(step, doubled);
            pass.read(from, &one);
            let two = pass.write(to, two);
            pass.dispatch([1, 1, 1]);
            // So many words, each a thousand and that more than it says.
            let second = graph.checkpoint::<u32>("second", &two);
            let thousand = graph.data_after(&second, |values| 1000 + values[0]);
            let many = graph.buffer_after(&second, "many", |values| 4 * u64::from(values[0]));
            let mut pass = graph.compute("many", add);
            pass.uniform_data(step, thousand);
            pass.read(from, &two);
            let many = pass.write(to, many);
            pass.dispatch([1024, 1, 1]);
            let mut pass = graph.compute("next", add);
            pass.uniform(step, &3);
            pass.read(from, &value.previous);
            let next = pass.write(to, value.next);
            pass.dispatch([1, 1, 1]);
            graph.capture("many", &many);
            graph.capture("next", &next);
            let executed = run(&mut executor, gpu, graph);
            let two = 2 * (want + 5);
            assert_eq!(executed.capture("many").unwrap().texels::<u32>().unwrap(), vec![1000 + 2 * two; two as usize]);
            want += 3;
            assert_eq!(executed.capture("next").unwrap().texels::<u32>().unwrap(), [want], "frame {frame}");
            let ran: Vec<_> = executed.passes.iter().map(|pass| pass.name.as_str()).collect();
            let passes: Vec<_> = ran.into_iter().filter(|name| !name.starts_with("read back")).collect();
            let begin: &[&str] = if frame == 0 { &["begin value"] } else { &[] };
            // Those behind the second checkpoint depend on nothing of each other.
            assert_eq!(passes[..passes.len() - 2], [begin, &["one", "two"]].concat());
            assert_eq!(passes.len(), begin.len() + 4);
        }
    });
}

/// A history whose layers are written before and after a checkpoint; with one of them left out it has a gap.
#[test]
fn a_history_is_written_on_both_sides_of_a_checkpoint() {
    isolated_device("a_history_is_written_on_both_sides_of_a_checkpoint", |gpu| {
        let mut executor = Executor::new(gpu);
        let value = |value| vk::ClearColorValue { uint32: [value, 0, 0, 0] };
        for frame in 0..4 {
            let mut graph = executor.graph("frame");
            let shape = ImageShape::new_2d(vk::Format::R32_UINT, [4, 4]).layers(2);
            let image = graph.history_image("image", shape, First::Color(value(99)));
            let mut layers = graph.split_layers(image.next).into_iter();
            let bytes = graph.buffer("bytes", 4);
            let bytes = graph.fill("bytes", bytes, 5 + frame);
            let _before = graph.clear("before", layers.next().unwrap(), value(10 * frame));
            let read = graph.checkpoint::<u32>("read", &bytes);
            if frame < 3 {
                let _after = graph.clear("after", layers.next().unwrap(), value(10 * frame + 1));
            }
            graph.capture("previous", &image.previous);
            if frame == 3 {
                let said = graph.compile(gpu).unwrap_err().to_string();
                assert!(said.contains("resource `image`: is written in part"), "{said}");
                continue;
            }
            let executed = run(&mut executor, gpu, graph);
            assert_eq!(read.values().unwrap(), [5 + frame]);
            let found: Vec<u32> = executed.capture("previous").unwrap().texels().unwrap();
            let wanted = if frame == 0 { [99, 99] } else { [10 * frame - 10, 10 * frame - 9] };
            assert_eq!(found, wanted.map(|value| [value; 16]).concat(), "frame {frame}");
        }
    });
}

/// Workgroups that the host has read are not asked of the device: a dispatch of none goes, and no pipeline is made for it.
#[test]
fn dispatches_of_none_go_once_the_host_knows() {
    isolated_device("dispatches_of_none_go_once_the_host_knows", |gpu| {
        static SET: [Binding; 1] = [binding(0, "groups", STORAGE, ShaderAccess::ReadWrite)];
        let set = compute(
            "set.comp",
            "#version 460
            layout(local_size_x = 64) in;
            layout(set = 0, binding = 0, std430) buffer Groups { uint groups[6]; };
            void main() {
                uint i = gl_LocalInvocationIndex;
                if (i < 6) groups[i] += uint[](3, 2, 1, 0, 1, 1)[i];
            }",
            &SET,
        );
        static ADD: [Binding; 1] = [binding(0, "sum", STORAGE, ShaderAccess::ReadWrite)];
        let add = compute(
            "add.comp",
            "#version 460
            layout(local_size_x = 64) in;
            layout(set = 0, binding = 0, std430) buffer Sum { uint sum; };
            void main() { if (gl_LocalInvocationIndex == 0) atomicAdd(sum, 1); }",
            &ADD,
        );
        // No device makes a pipeline of it.
        let refused: &'static Shader = Box::leak(Box::new(Shader { workgroup: [1 << 20, 1, 1], ..*add }));
        // By what the second dispatch does: `offset` of its workgroups.
        let frame = |offset: u64| -> shadowgraph::Result<Vec<u32>> {
            let mut executor = Executor::new(gpu);
            let mut graph = executor.graph("frame");
            let groups = graph.buffer("groups", 24);
            let groups = graph.fill("no groups", groups, 0);
            let mut pass = graph.compute("set", set);
            let groups = pass.write(StorageSlot::<[u32; 6], ReadWrite>::new(SET[0], set), groups);
            pass.dispatch([6, 1, 1]);
            let _known = graph.checkpoint::<u32>("groups", &groups);
            let sum = graph.buffer("sum", 4);
            let mut sum = graph.fill("no sum", sum, 0);
            for (name, shader, offset) in [("first", add, 0), ("second", refused, offset)] {
                let mut pass = graph.compute(name, shader);
                sum = pass.write(StorageSlot::<u32, ReadWrite>::new(ADD[0], shader), sum);
                pass.dispatch_indirect(&groups, offset);
            }
            // What comes to stand there later is the device's to know.
            let mut pass = graph.compute("set again", set);
            let groups = pass.write(StorageSlot::<[u32; 6], ReadWrite>::new(SET[0], set), groups);
            pass.dispatch([6, 1, 1]);
            let mut pass = graph.compute("third", add);
            let sum = pass.write(StorageSlot::<u32, ReadWrite>::new(ADD[0], add), sum);
            pass.dispatch_indirect(&groups, 0);
            graph.capture("sum", &sum);
            let plan = graph.compile(gpu).unwrap();
            let executed = executor.execute(&plan, graph)?;
            executed.capture("sum")?.texels::<u32>()
        };
        assert_eq!(frame(12).unwrap(), [3 * 2 + 6 * 4 * 2]);
        let said = frame(0).unwrap_err().to_string();
        assert!(said.contains("1048576 invocations"), "{said}");
    });
}

#[test]
fn a_checkpoint_that_fails_says_so() {
    isolated_device("a_checkpoint_that_fails_says_so", |gpu| {
        let mut executor = Executor::new(gpu);
        let mut other = executor.graph("other");
        let bytes = other.buffer("bytes", 4);
        let bytes = other.fill("fill", bytes, 1);
        let foreign = other.checkpoint::<u32>("foreign", &bytes);
        let mut graph = executor.graph("frame");
        let buffer = graph.buffer_after(&foreign, "buffer", |_| 4);
        let buffer = graph.fill("fill", buffer, 1);
        graph.capture("buffer", &buffer);
        let said = graph.compile(gpu).unwrap_err().to_string();
        assert!(said.contains("checkpoint `foreign` is one of another graph"), "{said}");

        let mut graph = executor.graph("frame");
        let bytes = graph.buffer("bytes", 6);
        let bytes = graph.fill("fill", bytes, 1);
        let _checkpoint = graph.checkpoint::<u32>("odd", &bytes);
        let plan = graph.compile(gpu).unwrap();
        let said = executor.execute(&plan, graph).err().unwrap().to_string();
        assert!(said.contains("6 bytes"), "{said}");

        let mut graph = executor.graph("frame");
        let bytes = graph.buffer("bytes", 4);
        let bytes = graph.fill("fill", bytes, 1);
        let checkpoint = graph.checkpoint::<u32>("much", &bytes);
        let huge = graph.buffer_after(&checkpoint, "huge", |_| 1 << 50);
        let huge = graph.fill("fill huge", huge, 1);
        graph.capture("huge", &huge);
        let plan = graph.compile(gpu).unwrap();
        let said = executor.execute(&plan, graph).err().unwrap().to_string();
        assert!(said.contains("huge"), "{said}");
    });
}

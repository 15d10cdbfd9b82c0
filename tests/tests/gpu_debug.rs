//! Looking into frames: what passes count, passes switched off, contents of any moment, full barriers.
#![allow(missing_docs, clippy::unwrap_used)]

mod gpu_support;

use ash::vk::{self, QueryPipelineStatisticFlags as Counter};
use gpu_support::{binding, output, run, shader};
use shadowgraph::gpu::Feature;
use shadowgraph::graph::{BufferHandle, Data, Executed, Executor, Graph, ImageShape, Load};
use shadowgraph::shader::{
    Binding, BindingKind, ColorSlot, Output, Program, Read, Shader, ShaderAccess, Stage, StorageSlot, UniformSlot,
    Write,
};
use shadowgraph_tests::device::isolated_device;
use shadowgraph_tests::harness::skip;

const STORAGE: BindingKind = BindingKind::StorageBuffer;

/// A triangle over everything, of one colour.
fn triangle() -> (Program, ColorSlot) {
    static OUTPUTS: [Output; 1] = [output(0, "color")];
    let source = "#version 460
        void main() { gl_Position = vec4(gl_VertexIndex == 1 ? 3 : -1, gl_VertexIndex == 2 ? 3 : -1, 0, 1); }";
    let vertex = shader(Stage::Vertex, "triangle.vert", source, &[], &[], [1; 3]);
    let source = "#version 460
        layout(location = 0) out vec4 color;
        void main() { color = vec4(1, 0.5, 0.25, 1); }";
    let fragment = shader(Stage::Fragment, "triangle.frag", source, &[], &OUTPUTS, [1; 3]);
    (Program::new(vertex, Some(fragment)), ColorSlot::new(OUTPUTS[0], fragment))
}

/// `next[i] = previous[i] + step`.
struct Add {
    shader: &'static Shader,
    step: UniformSlot<u32>,
    previous: StorageSlot<u32, Read>,
    next: StorageSlot<u32, Write>,
}

impl Add {
    fn new() -> Self {
        static ALL: [Binding; 3] = [
            binding(0, "step_block", BindingKind::UniformBuffer, ShaderAccess::Read),
            binding(1, "previous", STORAGE, ShaderAccess::Read),
            binding(2, "next", STORAGE, ShaderAccess::Write),
        ];
        let source = "#version 460
            layout(local_size_x = 64) in;
            layout(set = 0, binding = 0, std140) uniform Step { uint step_block; };
            layout(set = 0, binding = 1, std430) readonly buffer Previous { uint previous[]; };
            layout(set = 0, binding = 2, std430) writeonly buffer Next { uint next[]; };
            void main() {
                uint i = gl_GlobalInvocationID.x;
                if (i < next.length()) next[i] = previous[i] + step_block;
            }";
        let shader = shader(Stage::Compute, "add.comp", source, &ALL, &[], [64, 1, 1]);
        let (step, previous) = (UniformSlot::new(ALL[0], shader), StorageSlot::new(ALL[1], shader));
        Self { shader, step, previous, next: StorageSlot::new(ALL[2], shader) }
    }

    fn record(&self, graph: &mut Graph, name: &str, from: &BufferHandle, to: BufferHandle, step: u32) -> BufferHandle {
        let mut pass = graph.compute(name, self.shader);
        pass.uniform(self.step, &step).read(self.previous, from);
        let to = pass.write(self.next, to);
        pass.dispatch([100, 1, 1]);
        to
    }

    /// Four hundred bytes of `value`, then 1 more, 10 more, 100 more, each in a buffer of its own.
    fn chain(&self, graph: &mut Graph) -> BufferHandle {
        let seed = graph.buffer("seed", 400);
        let mut last = graph.fill("fill", seed, 7);
        for (name, step) in [("ones", 1), ("tens", 10), ("hundreds", 100)] {
            let next = graph.buffer(name, 400);
            last = self.record(graph, &format!("add {name}"), &last, next, step);
        }
        last
    }
}

fn words(executed: &Executed, name: &str) -> u32 {
    let all: Vec<u32> = executed.capture(name).unwrap().texels().unwrap();
    assert_eq!(all, vec![all[0]; 100]);
    all[0]
}

#[test]
fn passes_count_samples_and_invocations() {
    isolated_device("passes_count_samples_and_invocations", |gpu| {
        if !gpu.caps().has(Feature::OcclusionQueryPrecise) || !gpu.caps().has(Feature::PipelineStatistics) {
            return skip(&format!("{} has no precise occlusion queries or no statistics", gpu.caps().device));
        }
        let (program, slot) = triangle();
        let add = Add::new();
        let mut executor = Executor::new(gpu);
        let mut graph = executor.graph("frame");
        let shape = ImageShape::new_2d(vk::Format::R8G8B8A8_UNORM, [16, 8]);
        for (name, draws) in [("twice", 2), ("never", 0)] {
            let target = graph.image(format!("target of {name}"), shape);
            let mut pass = graph.raster(name, vec![program.clone()]);
            pass.count_samples();
            pass.statistics(Counter::FRAGMENT_SHADER_INVOCATIONS | Counter::INPUT_ASSEMBLY_VERTICES);
            // Nobody reads it: it runs because it counts.
            let _target = pass.color(slot, target, Load::Clear([0.0; 4]));
            pass.draw(move |recorder| {
                (0..draws).for_each(|_| recorder.draw(0..3, 0..1));
                Ok(())
            });
        }
        // A buffer of as many words as samples were drawn.
        let drawn = graph.checkpoint_samples("drawn", "twice");
        let sized = graph.buffer_after(&drawn, "sized", |samples| 4 * samples[0]);
        let sized = graph.fill("fill sized", sized, 9);
        graph.capture("sized", &sized);
        let (from, to) = (graph.buffer("from", 400), graph.buffer("to", 400));
        let from = graph.fill("fill", from, 0);
        let counter = graph.checkpoint::<u32>("between", &from);
        let mut pass = graph.compute("add", add.shader);
        pass.statistics(Counter::COMPUTE_SHADER_INVOCATIONS);
        pass.uniform(add.step, &1).read(add.previous, &from);
        let _to = pass.write(add.next, to);
        pass.dispatch([100, 1, 1]);
        let executed = run(&mut executor, gpu, graph);
        assert_eq!(counter.values().unwrap().len(), 100);
        assert_eq!(drawn.values().unwrap(), [2 * 16 * 8]);
        assert_eq!(executed.capture("sized").unwrap().texels::<u32>().unwrap(), vec![9; 2 * 16 * 8]);
        assert_eq!(executed.samples("twice").unwrap(), 2 * 16 * 8);
        assert_eq!(executed.samples("never").unwrap(), 0);
        assert_eq!(executed.statistic("twice", Counter::INPUT_ASSEMBLY_VERTICES).unwrap(), 6);
        assert!(executed.statistic("twice", Counter::FRAGMENT_SHADER_INVOCATIONS).unwrap() >= 2 * 16 * 8);
        assert_eq!(executed.statistic("add", Counter::COMPUTE_SHADER_INVOCATIONS).unwrap(), 128);
        let mut graph = executor.graph("switched off");
        let target = graph.image("target", shape);
        let mut pass = graph.raster("draw", vec![program.clone()]);
        pass.count_samples();
        let _target = pass.color(slot, target, Load::Clear([0.0; 4]));
        pass.draw(|recorder| {
            recorder.draw(0..3, 0..1);
            Ok(())
        });
        graph.switch_off("draw").unwrap();
        assert_eq!(run(&mut executor, gpu, graph).samples("draw").unwrap(), 0);
        let mut graph = executor.graph("nobody counts");
        let _drawn = graph.checkpoint_samples("drawn", "never");
        let said = graph.compile(gpu).unwrap_err().to_string();
        assert!(said.contains("pass `never`: counts no samples, or is not recorded yet"), "{said}");
        let said = executed.samples("add").unwrap_err().to_string();
        assert!(said.contains("samples of pass `add`: were not counted; these count: twice"), "{said}");
    });
}

#[test]
fn a_pass_that_is_switched_off_leaves_zeros_or_what_was_there() {
    isolated_device("a_pass_that_is_switched_off_leaves_zeros_or_what_was_there", |gpu| {
        let add = Add::new();
        let mut executor = Executor::new(gpu);
        for (off, want) in [(None, 118), (Some("add tens"), 100), (Some("fill"), 111), (Some("add hundreds"), 0)] {
            let mut graph = executor.graph("frame");
            let last = add.chain(&mut graph);
            graph.capture("last", &last);
            off.into_iter().for_each(|pass| graph.switch_off(pass).unwrap());
            assert_eq!(words(&run(&mut executor, gpu, graph), "last"), want, "without {off:?}");
        }

        // What a pass only adds to stays; images become zero, depth far away.
        let (program, slot) = triangle();
        for off in [None, Some("draw"), Some("draw over")] {
            let mut graph = executor.graph("frame");
            let target = graph.image("target", ImageShape::new_2d(vk::Format::R8G8B8A8_UNORM, [4, 4]));
            let depth = graph.image("depth", ImageShape::new_2d(vk::Format::D32_SFLOAT, [4, 4]));
            let mut pass = graph.raster("draw", vec![program.clone()]);
            let target = pass.color(slot, target, Load::Clear([0.0, 1.0, 0.0, 1.0]));
            let depth = pass.depth(depth, Load::Clear(0.5));
            pass.draw(|_| Ok(()));
            let mut pass = graph.raster("draw over", vec![program.clone()]);
            let target = pass.color(slot, target, Load::Keep);
            pass.draw(|_| Ok(()));
            graph.capture("target", &target);
            graph.capture("depth", &depth);
            off.into_iter().for_each(|pass| graph.switch_off(pass).unwrap());
            let executed = run(&mut executor, gpu, graph);
            let green = if off == Some("draw") { [0, 0, 0, 0] } else { [0, 255, 0, 255] };
            let far = if off == Some("draw") { 0.0 } else { 0.5 };
            assert_eq!(executed.capture("target").unwrap().texels::<[u8; 4]>().unwrap(), [green; 16], "{off:?}");
            assert_eq!(executed.capture("depth").unwrap().texels::<f32>().unwrap(), [far; 16], "{off:?}");
        }

        let mut graph = executor.graph("frame");
        let _last = add.chain(&mut graph);
        let said = graph.switch_off("add one").unwrap_err().to_string();
        assert_eq!(said, "pass `add one`: there are fill, add ones, add tens, add hundreds");
    });
}

#[test]
fn contents_of_any_moment_are_read_back() {
    isolated_device("contents_of_any_moment_are_read_back", |gpu| {
        let add = Add::new();
        let mut executor = Executor::new(gpu);
        let mut graph = executor.graph("frame");
        let last = add.chain(&mut graph);
        // The same buffer, over and over.
        let seed = graph.buffer("again", 400);
        let again = graph.fill("three", seed, 3);
        let again = graph.fill("four", again, 4);
        let _again = graph.fill("five", again, 5);
        graph.capture("last", &last);
        let wanted = [
            ("fill", "seed", 7),
            ("add ones", "seed", 7),
            ("add ones", "ones", 8),
            ("add hundreds", "tens", 18),
            ("add hundreds", "ones", 8),
            ("three", "again", 3),
            ("four", "again", 4),
            ("five", "again", 5),
        ];
        let names: Vec<_> = wanted.iter().map(|(pass, of, _)| graph.capture_after(pass, of).unwrap()).collect();
        let said = graph.capture_after("fill", "ones").unwrap_err().to_string();
        assert_eq!(said, "fill:ones: nobody has written it by then");
        let said = graph.capture_after("fill", "twos").unwrap_err().to_string();
        assert_eq!(said, "resource `twos`: there are seed, ones, tens, hundreds, again");
        assert!(graph.capture_after("nobody", "ones").is_err());
        let executed = run(&mut executor, gpu, graph);
        for (name, (.., value)) in names.iter().zip(wanted) {
            assert_eq!(words(&executed, name), value, "{name}");
        }
    });
}

#[test]
fn full_barriers_change_nothing() {
    isolated_device("full_barriers_change_nothing", |gpu| {
        let add = Add::new();
        let mut executor = Executor::new(gpu);
        executor.serialize(true);
        for _ in 0..2 {
            let mut graph = executor.graph("frame");
            let last = add.chain(&mut graph);
            graph.capture("last", &last);
            assert_eq!(words(&run(&mut executor, gpu, graph), "last"), 118);
        }
    });
}

/// Mistakes of the typed layer: handles, bindings, attachments.
#[test]
fn misused_passes_are_errors() {
    isolated_device("misused_passes_are_errors", |gpu| {
        let add = Add::new();
        let (program, slot) = triangle();
        let errors = |graph: &Graph| -> Vec<String> {
            graph.compile(gpu).unwrap_err().errors.iter().map(ToString::to_string).collect()
        };
        let executor = Executor::new(gpu);

        let mut other = executor.graph("other");
        let (foreign, data) = (other.buffer("foreign", 400), other.data(&[0u32]));
        let _: (&BufferHandle, Data) = (&foreign, data);
        let mut graph = executor.graph("handles of others");
        let seed = graph.buffer("seed", 400);
        let seed = graph.fill("fill", seed, 0);
        graph.capture("foreign", &foreign);
        let to = add.record(&mut graph, "add", &seed, foreign, 1);
        graph.capture("to", &to);
        let said = errors(&graph);
        let wanted = "is a handle of another graph; handles that `handles of others` gave";
        assert_eq!(said.iter().filter(|line| line.ends_with(wanted)).count(), 3, "{said:#?}");

        let mut graph = executor.graph("bindings");
        let seed = graph.buffer("seed", 400);
        let seed = graph.fill("fill", seed, 0);
        let mut pass = graph.compute("add", add.shader);
        pass.read(add.previous, &seed);
        pass.push(&1u32);
        pass.dispatch([1, 1, 1]);
        let mut pass = graph.compute("twice", add.shader);
        pass.uniform(add.step, &1).uniform(add.step, &2).read(add.previous, &seed);
        let next = pass.write(add.next, seed);
        pass.dispatch([1, 1, 1]);
        graph.capture("next", &next);
        let said = errors(&graph);
        for line in [
            "pass `add`, slot `push constants`: 4 bytes are pushed; 0 bytes, as add.comp takes",
            "pass `add`, slot `step_block`: is bound 0 times; add.comp has it; once",
            "pass `add`, slot `next`: is bound 0 times; add.comp has it; once",
            "pass `twice`, slot `step_block`: is bound 2 times; add.comp has it; once",
            "pass `twice`, slot `next`, resource `seed`: is also used by slot `previous`, and one of them writes; what a \
             pass writes it uses once; a storage access can read and write",
        ] {
            assert!(said.iter().any(|known| known == line), "{line}\n{said:#?}");
        }

        let mut graph = executor.graph("attachments");
        graph.raster("none", vec![program.clone()]).draw(|_| Ok(()));
        let target = graph.image("target", ImageShape::new_2d(vk::Format::R8G8B8A8_UNORM, [4, 4]));
        let depth = graph.image("depth", ImageShape::new_2d(vk::Format::D32_SFLOAT, [8, 4]));
        let mut pass = graph.raster("sizes", vec![program.clone()]);
        let target = pass.color(slot, target, Load::Clear([0.0; 4]));
        let _depth = pass.depth(depth, Load::Clear(0.0));
        // A slot of a shader that the pass does not have.
        pass.constant(add.previous, data);
        pass.draw(|_| Ok(()));
        let buffered = graph.image("float", ImageShape::new_2d(vk::Format::D32_SFLOAT, [4, 4]));
        let mut pass = graph.raster("wrong format", vec![program]);
        let buffered = pass.color(slot, buffered, Load::Clear([0.0; 4]));
        pass.draw(|_| Ok(()));
        graph.capture("target", &target);
        graph.capture("float", &buffered);
        let said = errors(&graph);
        for line in [
            "pass `none`: has no attachment; colour, depth or stencil, or an area",
            "pass `none`, slot `color`: has no attachment; triangle.frag writes it; location 0",
            "pass `sizes`, slot `depth`: is 8×4 with 1 layers; 4×4 with 1 layers, as the attachment before",
            "pass `sizes`, slot `previous`: is bound, but the pass's shaders do not have it; ",
        ] {
            assert!(said.iter().any(|known| known == line), "{line}\n{said:#?}");
        }
        assert!(said.iter().any(|known| known.starts_with("pass `wrong format`, slot `color`, resource `float`: ")));

        // What the device does not do with a format.
        let format = vk::Format::E5B9G9R9_UFLOAT_PACK32;
        if gpu.image_usages(format).contains(vk::ImageUsageFlags::COLOR_ATTACHMENT) {
            return skip(&format!("{} draws to every format", gpu.caps().device));
        }
        let mut graph = executor.graph("formats");
        let target = graph.image("target", ImageShape::new_2d(format, [4, 4]));
        let mut pass = graph.raster("draw", vec![triangle().0]);
        let target = pass.color(slot, target, Load::Clear([0.0; 4]));
        pass.draw(|_| Ok(()));
        graph.capture("target", &target);
        let said = errors(&graph);
        let wanted = "pass `draw`, slot `color`, resource `target`: the device does not allow COLOR_ATTACHMENT for format \
                      E5B9G9R9_UFLOAT_PACK32; it allows ";
        assert!(said.iter().any(|known| known.starts_with(wanted)), "{said:#?}");
    });
}

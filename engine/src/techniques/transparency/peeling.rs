//! What both kinds of depth peeling share: rounds, as many as there are layers, and what they gather.

use ash::vk;

use super::fragments::{Draw, Fragments, Step, count, fragment_pass};
use crate::Error;
use crate::graph::{BufferHandle, Checkpoint, Graph, ImageHandle, ImageShape};
use crate::shader::generated::blocks;
use crate::shader::generated::transparency::depth_peeling::peel_frag;
use crate::shader::generated::transparency::{most_layers_comp, over_opaque_comp, peel_rounds_comp};
use crate::shader::{ImageSlot, ReadWrite, Shader};

/// Pixels of an invocation that counts: `most_layers.comp`.
const CHUNK: u32 = 256;
/// Rounds before the first layer is known: `peeling.glsl`.
const AHEAD: u32 = 2;

/// Most layers that can be asked for: each round is two passes of the frame.
const MOST_LAYERS: u32 = 4096;

/// Rounds of peeling, as many as may be needed.
struct Rounds {
    name: &'static str,
    /// Layers of each pixel.
    count: ImageHandle,
    told: Checkpoint<blocks::MostLayers>,
    /// Workgroups of each round over the picture; none of those that are not needed.
    groups: BufferHandle,
    /// Layers that are peeled at most, and layers a round.
    layers: u32,
    layers_a_round: u32,
}

impl Rounds {
    /// Counts the layers; the host reads how many rounds that makes.
    fn new<'f>(
        graph: &mut Graph<'f>,
        name: &'static str,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        layers: u32,
        layers_a_round: u32,
    ) -> Self {
        let (size, layers) = (depth.size(), layers.min(MOST_LAYERS));
        let count = count(graph, name, depth, fragments);
        let most = graph.buffer(format!("{name}.most"), size_of::<blocks::MostLayers>() as u64);
        let most = graph.fill(format!("{name}.most.begin"), most, 0);
        let mut pass = graph.compute(format!("{name}.most"), &most_layers_comp::SHADER);
        pass.read(most_layers_comp::COUNTS, &count).push(&layers);
        let most = pass.write(most_layers_comp::LAYERS, most);
        pass.dispatch([(size[0] * size[1]).div_ceil(CHUNK), 1, 1]);

        let told = graph.checkpoint(format!("{name}.most"), &most);
        let rounds = layers.div_ceil(layers_a_round) + AHEAD;
        let groups = graph.buffer(format!("{name}.rounds"), 12 * u64::from(rounds));
        let mut pass = graph.compute(format!("{name}.rounds"), &peel_rounds_comp::SHADER);
        let whole = size.map(|side| side.div_ceil(8));
        pass.read(peel_rounds_comp::LAYERS, &most).push(&[whole[0], whole[1], layers_a_round]);
        let groups = pass.write(peel_rounds_comp::ROUNDS, groups);
        pass.dispatch([rounds, 1, 1]);
        Self { name, count, told, groups, layers, layers_a_round }
    }

    /// The numbers of all rounds.
    fn all(&self) -> std::ops::Range<u32> {
        0..self.layers.div_ceil(self.layers_a_round) + AHEAD
    }

    /// Workgroups of a round: a buffer and an offset.
    fn groups(&self, round: u32) -> (&BufferHandle, u64) {
        (&self.groups, 12 * u64::from(round))
    }

    /// `draw`, where the round is needed. Fails where no number of rounds is enough.
    fn draw<'f>(&self, round: u32, mut draw: Draw<'f>) -> Draw<'f> {
        let (told, name, layers, layers_a_round) = (self.told.clone(), self.name, self.layers, self.layers_a_round);
        Box::new(move |recorder| {
            let blocks::MostLayers { most, too_deep } = told.values()?[0];
            if most > layers {
                let wrong = format!(
                    "a pixel has {most} layers; {layers} are peeled, and {too_deep} fragments behind them would be lost"
                );
                return Err(Error::invalid(name, wrong));
            }
            let needed = most > 0 && round < most.div_ceil(layers_a_round) + AHEAD;
            if needed { draw(recorder) } else { Ok(()) }
        })
    }

    /// Puts `front` over `color`, where there are layers.
    fn over(&self, graph: &mut Graph, front: &ImageHandle, tints: bool, color: ImageHandle) -> ImageHandle {
        let size = color.size();
        let mut pass = graph.compute(format!("{}.over", self.name), &over_opaque_comp::SHADER);
        pass.read(over_opaque_comp::COUNTS, &self.count)
            .read(over_opaque_comp::FRONT, front)
            .specialize(over_opaque_comp::TINTED, tints)
            .specialize(over_opaque_comp::BOTH_ENDS, self.layers_a_round == 2);
        let color = pass.write(over_opaque_comp::COLOR, color);
        pass.dispatch([size[0], size[1], 1]);
        color
    }
}

/// What rounds hand on.
struct Peeled {
    /// States: a layer an end.
    state: ImageHandle,
    /// Results of searches: three layers an end.
    found: ImageHandle,
    /// What was gathered: `gathered.glsl`.
    front: ImageHandle,
}

impl Peeled {
    /// Nothing is peeled yet, from one end or from both.
    fn nothing(graph: &mut Graph, name: &str, size: [u32; 2], ends: u32, tints: bool) -> Self {
        let mut cleared = |what: &str, format, layers, value| {
            let image = graph.image(format!("{name}.{what}"), ImageShape::new_2d(format, size).layers(layers));
            graph.clear(format!("{name}.{what}.begin"), image, value)
        };
        let begin = vk::ClearColorValue { uint32: [u32::MAX; 4] };
        Self {
            state: cleared("peeled", vk::Format::R32G32B32A32_UINT, ends, begin),
            found: cleared("found", vk::Format::R32_UINT, 3 * ends, vk::ClearColorValue::default()),
            front: gathered(graph, name, size, if tints { 1 + ends } else { 1 }),
        }
    }
}

/// Nothing is gathered: no light, and all is let through. `gathered.glsl` says what its layers hold.
fn gathered(graph: &mut Graph, name: &str, size: [u32; 2], layers: u32) -> ImageHandle {
    let shape = ImageShape::new_2d(vk::Format::R32G32B32A32_SFLOAT, size).layers(layers);
    let image = graph.image(format!("{name}.front"), shape);
    let counts = if layers == 1 { vec![1] } else { vec![1, layers - 1] };
    let parts = graph.split_layer_blocks(image, &counts);
    let values = [[0.0, 0.0, 0.0, 1.0], [1.0; 4]];
    let names = ["front", "through"].map(|what| format!("{name}.{what}.begin"));
    let cleared = |((part, float32), name)| graph.clear(name, part, vk::ClearColorValue { float32 });
    let parts: Vec<_> = parts.into_iter().zip(values).zip(names).map(cleared).collect();
    graph.join(parts).expect("an image has layers")
}

/// A kind of depth peeling: its step, and where its shaders have what.
pub(super) struct Peeling {
    pub(super) name: &'static str,
    pub(super) step: Step,
    pub(super) state: ImageSlot<ReadWrite>,
    pub(super) found: ImageSlot<ReadWrite>,
    pub(super) front: ImageSlot<ReadWrite>,
    /// What is opaque, where layers are peeled from the back as well.
    pub(super) back: Option<ImageSlot<ReadWrite>>,
    pub(super) advance: &'static Shader,
    pub(super) advance_state: ImageSlot<ReadWrite>,
    pub(super) advance_found: ImageSlot<ReadWrite>,
}

impl Peeling {
    /// Peels up to `layers` layers of each pixel and composites them over `color`.
    pub(super) fn composite<'f>(
        &self,
        graph: &mut Graph<'f>,
        depth: &ImageHandle,
        fragments: &dyn Fragments<'f>,
        layers: u32,
        mut color: ImageHandle,
    ) -> ImageHandle {
        let Self { name, step, .. } = *self;
        let ends = if self.back.is_some() { 2 } else { 1 };
        let tints = fragments.tints();
        // 1. How many rounds are needed.
        let rounds = Rounds::new(graph, name, depth, fragments, layers, ends);
        let Peeled { mut state, mut found, mut front } = Peeled::nothing(graph, name, depth.size(), ends, tints);
        for round in rounds.all() {
            // 2. Each pixel's layer of this round is put behind those before, and the farthest that is left over what is
            //    opaque, where the step does that; the next are found.
            let mut pass = fragment_pass(graph, format!("{name}.peel.{round}"), depth, (fragments, step), |program| {
                program.constant(peel_frag::TINTED, tints)
            });
            state = pass.write(self.state, state);
            found = pass.write(self.found, found);
            front = pass.write(self.front, front);
            if let Some(back) = self.back {
                color = pass.write(back, color);
            }
            pass.draw(rounds.draw(round, fragments.draw(step)));

            // 3. On to these.
            let mut pass = graph.compute(format!("{name}.advance.{round}"), self.advance);
            state = pass.write(self.advance_state, state);
            found = pass.write(self.advance_found, found);
            let (groups, offset) = rounds.groups(round);
            pass.dispatch_indirect(groups, offset);
        }
        // 4. What was gathered from the front over all behind.
        rounds.over(graph, &front, tints, color)
    }
}

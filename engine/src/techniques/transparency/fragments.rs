//! Where fragments come from.

use ash::vk;

use super::forward::ForwardLights;
use crate::Result;
use crate::gpu::{Feature, blend};
use crate::graph::{Graph, ImageHandle, ImageShape, Load, RasterPass, Recorder};
use crate::scene::{DrawClass, Faces, GpuScene, POSITIONS, SHADED, View, ViewSet, depth};
use crate::shader::generated::transparency::abuffer::{array_frag, array_pulled_frag, list_frag, list_pulled_frag};
use crate::shader::generated::transparency::{self as shaders, count_frag, count_vert};
use crate::shader::{Program, Shader};

/// What is drawn, each time it is needed: the same fragments in every step.
pub trait Fragments<'f> {
    /// Programs of a step. Depth test and blending are set by the technique.
    fn programs(&self, step: Step) -> Vec<Program>;
    /// Binds what these programs read, but for the technique's own slots.
    fn bind(&self, pass: &mut RasterPass<'_, 'f>, step: Step);
    /// Draws with them.
    fn draw(&self, step: Step) -> Draw<'f>;
}

/// Records draws.
pub type Draw<'f> = Box<dyn FnMut(&mut Recorder) -> Result<()> + 'f>;

/// What is done with fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Counted over the whole picture: no fragment shader is needed.
    Samples,
    /// Counted in each pixel: a fragment shader that gives 1.
    Count,
    /// Appended to arrays, by `abuffer/array_append.glsl`.
    Arrays,
    /// Appended to linked lists, by `abuffer/list_append.glsl`.
    Lists,
    /// The nearest that is left is composited, by `depth_peeling/peel.glsl`.
    Peel,
    /// The nearest and the farthest that are left are composited, by `dual_depth_peeling/peel.glsl`.
    PeelBothEnds,
    /// Summed up with weights, by `weighted/weigh.glsl`.
    Weigh,
}

impl Step {
    /// Shaders of blended materials: with the triangle's number from the hardware, and with vertices pulled.
    fn shaders(self) -> [&'static Shader; 2] {
        match self {
            Self::Samples | Self::Count => [&count_frag::SHADER; 2],
            Self::Arrays => [&array_frag::SHADER, &array_pulled_frag::SHADER],
            Self::Lists => [&list_frag::SHADER, &list_pulled_frag::SHADER],
            Self::Peel => {
                [&shaders::depth_peeling::peel_frag::SHADER, &shaders::depth_peeling::peel_pulled_frag::SHADER]
            }
            Self::PeelBothEnds => {
                use shaders::dual_depth_peeling::{peel_frag, peel_pulled_frag};
                [&peel_frag::SHADER, &peel_pulled_frag::SHADER]
            }
            Self::Weigh => [&shaders::weighted::weigh_frag::SHADER; 2],
        }
    }
}

/// Fragments before the opaque depth, of each pixel, by blending: R32 float.
pub(super) fn count<'f>(
    graph: &mut Graph<'f>,
    name: &str,
    depth: &ImageHandle,
    fragments: &dyn Fragments<'f>,
) -> ImageHandle {
    let name = format!("{name}.count");
    let count = graph.image(name.clone(), ImageShape::new_2d(vk::Format::R32_SFLOAT, depth.size()));
    let programs = fragments.programs(Step::Count).into_iter();
    let programs = programs.map(|program| program.depth(depth::CLOSER, false).blend(blend::add()));
    let mut pass = graph.raster(name, programs.collect());
    fragments.bind(&mut pass, Step::Count);
    pass.depth_test(depth);
    let count = pass.color(count_frag::COUNT, count, Load::Clear([0.0; 4]));
    pass.draw(fragments.draw(Step::Count));
    count
}

/// The blended materials of a scene, shaded forward.
pub struct Blended<'s, 'f> {
    /// The scene.
    pub scene: &'f GpuScene,
    /// The camera.
    pub view: View,
    /// What they are shaded with.
    pub lights: &'s ForwardLights<'s>,
    /// Fetches vertices by hand even where the device has geometry shaders and need not.
    pub pull_vertices: bool,
}

impl<'s, 'f> Blended<'s, 'f> {
    /// Of a scene, as a device likes it best.
    pub fn new(graph: &Graph, scene: &'f GpuScene, view: View, lights: &'s ForwardLights<'s>) -> Self {
        // A fragment shader's triangle number asks for geometry shaders.
        let pull_vertices = !graph.caps().has(Feature::GeometryShader);
        Self { scene, view, lights, pull_vertices }
    }

    /// Triangles that nodes have to be told apart by.
    pub fn triangles(&self) -> u64 {
        let blended = self.scene.draws.draws().iter().filter(|draw| draw.class == DrawClass::Blend);
        blended.map(|draw| draw.indices.len() as u64 / 3 * draw.instances.len() as u64).sum()
    }

    fn texture_sets(&self) -> Vec<u32> {
        self.scene.draws.texture_sets(&[DrawClass::Blend])
    }
}

impl<'f> Fragments<'f> for Blended<'_, 'f> {
    fn programs(&self, step: Step) -> Vec<Program> {
        let fragment = step.shaders()[usize::from(self.pull_vertices)];
        let vertex = match (step, self.pull_vertices) {
            (Step::Samples, _) => return vec![Program::new(&count_vert::SHADER, None).vertex_buffers(POSITIONS)],
            (Step::Count, _) => {
                return vec![Program::new(&count_vert::SHADER, Some(fragment)).vertex_buffers(POSITIONS)];
            }
            (_, false) => &shaders::surface_vert::SHADER,
            (_, true) => &shaders::surface_pulled_vert::SHADER,
        };
        let mut program = Program::new(vertex, Some(fragment));
        if !self.pull_vertices {
            program = program.vertex_buffers(SHADED);
        }
        self.lights.programs(&program, self.scene, &self.texture_sets())
    }

    fn bind(&self, pass: &mut RasterPass<'_, 'f>, step: Step) {
        let views = ViewSet::from(self.view);
        if matches!(step, Step::Samples | Step::Count) {
            pass.uniform(count_vert::VIEWS, &views.block()).constant(count_vert::INSTANCES, &self.scene.instances);
            return;
        }
        self.lights.bind(pass, self.scene, &views);
        if self.pull_vertices {
            self.scene.bind_pulled(pass);
        }
    }

    fn draw(&self, step: Step) -> Draw<'f> {
        let (scene, pull) = (self.scene, self.pull_vertices);
        let draws = scene.draws.visible(DrawClass::Blend, &ViewSet::from(self.view).frusta());
        if matches!(step, Step::Samples | Step::Count) {
            return Box::new(move |recorder| {
                recorder.push(&0u32);
                scene.draw(recorder, Faces::Material, &draws);
                Ok(())
            });
        }
        let texture_sets = self.texture_sets();
        Box::new(move |recorder| {
            scene.draw_by_textures(recorder, &texture_sets, &draws, pull);
            Ok(())
        })
    }
}

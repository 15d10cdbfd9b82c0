//! Where fragments come from.

use crate::Result;
use crate::gpu::Feature;
use crate::graph::{Graph, RasterPass, Recorder};
use crate::scene::{DrawClass, Faces, GpuScene, POSITIONS, SHADED, View, ViewSet};
use crate::shader::Program;
use crate::shader::generated::transparency::abuffer::{
    array_frag, array_pulled_frag, count_frag, count_vert, list_frag, list_pulled_frag, surface_pulled_vert,
    surface_vert,
};
use crate::techniques::transparency::forward::ForwardLights;

/// What is drawn, each time it is needed: the same fragments in every step.
pub trait Fragments<'f> {
    /// Programs of a step. Their depth test is set by the A-buffer.
    fn programs(&self, step: Step) -> Vec<Program>;
    /// Binds what these programs read, but for the A-buffer's own slots.
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
    /// Appended to arrays, by `array_append.glsl`.
    Arrays,
    /// Appended to linked lists, by `list_append.glsl`.
    Lists,
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
        let (vertex, fragment) = match (step, self.pull_vertices) {
            (Step::Samples, _) => return vec![Program::new(&count_vert::SHADER, None).vertex_buffers(POSITIONS)],
            (Step::Count, _) => {
                let program = Program::new(&count_vert::SHADER, Some(&count_frag::SHADER));
                return vec![program.vertex_buffers(POSITIONS)];
            }
            (Step::Arrays, false) => (&surface_vert::SHADER, &array_frag::SHADER),
            (Step::Arrays, true) => (&surface_pulled_vert::SHADER, &array_pulled_frag::SHADER),
            (Step::Lists, false) => (&surface_vert::SHADER, &list_frag::SHADER),
            (Step::Lists, true) => (&surface_pulled_vert::SHADER, &list_pulled_frag::SHADER),
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

//! Where fragments come from.

use ash::vk;

use super::forward::ForwardLights;
use crate::Result;
use crate::geometry::Aabb;
use crate::gpu::{Feature, blend};
use crate::graph::{Graph, ImageHandle, ImageShape, Load, Name, RasterPass, Recorder};
use crate::scene::{DrawClass, Faces, GpuScene, POSITIONS, SHADED, View, ViewSet, depth};
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
    /// Whether some multiply what passes through them channel by channel, so that techniques keep three numbers a layer and
    /// not one alpha.
    fn tints(&self) -> bool {
        false
    }
    /// Distances along the view axis that all fragments lie between, metres.
    fn distances(&self) -> [f32; 2];
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
    /// The same where the device runs a pixel's fragments in order: with `IN_ORDER` defined. Optional: without a program
    /// [`Step::Arrays`] is taken.
    ArraysInOrder,
    /// Appended to linked lists, by `abuffer/list_append.glsl`.
    Lists,
    /// The same with `BY_SUBGROUP` defined, where the device has [`Feature::FragmentBallot`].
    SubgroupLists,
    /// Counted in each pixel of several samples, by `abuffer/count_multisampled.frag`.
    CountMultisampled,
    /// As [`Step::Arrays`] where pixels have several samples: with `MULTISAMPLED` defined.
    ArraysMultisampled,
    /// As [`Step::Lists`] where pixels have several samples: with `MULTISAMPLED` defined.
    ListsMultisampled,
    /// The nearest that is left is composited, by `depth_peeling/peel.glsl`.
    Peel,
    /// The nearest and the farthest that are left are composited, by `dual_depth_peeling/peel.glsl`.
    PeelBothEnds,
    /// Summed up with weights, by `weighted/weigh.glsl`.
    Weigh,
    /// The nearest depths are kept, by `kbuffer/keep_depths.glsl`.
    KeepDepths,
    /// Which triangles have these, by `kbuffer/keep_tags.glsl`.
    KeepTags,
    /// Their colours are kept and all others summed up, by `kbuffer/keep_colors.glsl`.
    KeepColors,
    /// Their absorbance is summed up with its moments, by `moments/add_moments.glsl`.
    AddMoments,
    /// Summed up as visible as the moments tell, by `moments/add_colors.glsl`.
    AddByMoments,
    /// Samples keep the nearest depth, by `stochastic/sample_depths.glsl`.
    SampleDepths,
    /// Summed up as visible as the samples tell, by `stochastic/add_colors.glsl`.
    AddBySamples,
}

/// What shaders of a step read besides the technique's slots.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Needs {
    Positions,
    TriangleNumbers,
    /// The material's.
    Alpha,
    Shading,
}

impl Step {
    fn needs(self) -> Needs {
        match self {
            Self::Samples | Self::Count | Self::CountMultisampled | Self::KeepDepths => Needs::Positions,
            Self::KeepTags => Needs::TriangleNumbers,
            Self::AddMoments | Self::SampleDepths => Needs::Alpha,
            _ => Needs::Shading,
        }
    }

    /// Shaders of blended materials: with the triangle's number from the hardware, and with vertices pulled.
    fn shaders(self) -> Option<[&'static Shader; 2]> {
        use shaders::{abuffer, depth_peeling, dual_depth_peeling, kbuffer, moments, stochastic, weighted};
        Some(match self {
            Self::Samples => return None,
            Self::Count => [&count_frag::SHADER; 2],
            Self::Arrays => [&abuffer::array_frag::SHADER, &abuffer::array_pulled_frag::SHADER],
            Self::ArraysInOrder => [&abuffer::array_in_order_frag::SHADER; 2],
            Self::Lists => [&abuffer::list_frag::SHADER, &abuffer::list_pulled_frag::SHADER],
            Self::SubgroupLists => [&abuffer::list_subgroup_frag::SHADER, &abuffer::list_subgroup_pulled_frag::SHADER],
            Self::CountMultisampled => [&abuffer::count_multisampled_frag::SHADER; 2],
            Self::ArraysMultisampled => {
                [&abuffer::array_multisampled_frag::SHADER, &abuffer::array_multisampled_pulled_frag::SHADER]
            }
            Self::ListsMultisampled => {
                [&abuffer::list_multisampled_frag::SHADER, &abuffer::list_multisampled_pulled_frag::SHADER]
            }
            Self::Peel => [&depth_peeling::peel_frag::SHADER, &depth_peeling::peel_pulled_frag::SHADER],
            Self::PeelBothEnds => {
                [&dual_depth_peeling::peel_frag::SHADER, &dual_depth_peeling::peel_pulled_frag::SHADER]
            }
            Self::Weigh => [&weighted::weigh_frag::SHADER; 2],
            Self::KeepDepths => [&kbuffer::keep_depths_frag::SHADER; 2],
            Self::KeepTags => [&kbuffer::keep_tags_frag::SHADER, &kbuffer::keep_tags_pulled_frag::SHADER],
            Self::KeepColors => [&kbuffer::keep_colors_frag::SHADER, &kbuffer::keep_colors_pulled_frag::SHADER],
            Self::AddMoments => [&moments::add_moments_frag::SHADER; 2],
            Self::AddByMoments => [&moments::add_colors_frag::SHADER; 2],
            Self::SampleDepths => {
                [&stochastic::sample_depths_frag::SHADER, &stochastic::sample_depths_pulled_frag::SHADER]
            }
            Self::AddBySamples => [&stochastic::add_colors_frag::SHADER; 2],
        })
    }
}

/// A pass over the fragments before the opaque depth, to which the technique adds its own slots and
/// [`Fragments::draw`]. `change`: what the step's programs have besides.
pub(super) fn fragment_pass<'g, 'f>(
    graph: &'g mut Graph<'f>,
    name: impl Into<Name>,
    depth: &ImageHandle,
    (fragments, step): (&dyn Fragments<'f>, Step),
    change: impl Fn(Program) -> Program,
) -> RasterPass<'g, 'f> {
    let programs = fragments.programs(step).into_iter();
    let programs = programs.map(|program| change(program.depth(depth::CLOSER, false)));
    let mut pass = graph.raster(name, programs.collect());
    fragments.bind(&mut pass, step);
    pass.depth_test(depth);
    pass
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
    let mut pass = fragment_pass(graph, name, depth, (fragments, Step::Count), |program| program.blend(blend::add()));
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
    fn tints(&self) -> bool {
        self.scene.transmits()
    }

    fn programs(&self, step: Step) -> Vec<Program> {
        if step == Step::ArraysInOrder && self.pull_vertices {
            return Vec::new();
        }
        let fragment = step.shaders().map(|shaders| shaders[usize::from(self.pull_vertices)]);
        if step.needs() == Needs::Positions {
            return vec![Program::new(&count_vert::SHADER, fragment).vertex_buffers(POSITIONS)];
        }
        let program = match self.pull_vertices {
            true => Program::new(&shaders::surface_pulled_vert::SHADER, fragment),
            false => Program::new(&shaders::surface_vert::SHADER, fragment).vertex_buffers(SHADED),
        };
        match step.needs() {
            Needs::Alpha | Needs::Shading => self.lights.programs(&program, self.scene, &self.texture_sets()),
            Needs::Positions | Needs::TriangleNumbers => vec![program],
        }
    }

    fn bind(&self, pass: &mut RasterPass<'_, 'f>, step: Step) {
        let views = ViewSet::from(self.view);
        match step.needs() {
            Needs::Shading => self.lights.bind(pass, self.scene, &views),
            _ => {
                pass.uniform(count_vert::VIEWS, &views.block());
            }
        }
        if self.pull_vertices && step.needs() != Needs::Positions {
            self.scene.bind_pulled(pass);
        }
    }

    fn distances(&self) -> [f32; 2] {
        let blended = self.scene.draws.draws().iter().filter(|draw| draw.class == DrawClass::Blend);
        let Some(bounds) = blended.map(|draw| draw.bounds).reduce(Aabb::union) else { return [1.0; 2] };
        let distances = bounds.corners().map(|corner| -self.view.view_from_world.transform_point3(corner).z);
        let ends = distances.iter().fold([f32::INFINITY, 0.0], |[near, far], d| [d.min(near), d.max(far)]);
        // What is nearer than the near plane is not seen.
        let near_plane = self.view.distance(1.0);
        [ends[0].max(near_plane), ends[1].max(near_plane)]
    }

    fn draw(&self, step: Step) -> Draw<'f> {
        let (scene, pull) = (self.scene, self.pull_vertices);
        let draws = scene.draws.visible(DrawClass::Blend, &ViewSet::from(self.view).frusta());
        if step.needs() == Needs::Positions {
            return Box::new(move |recorder| {
                recorder.push(&0u32);
                scene.draw(recorder, Faces::Material, &draws);
                Ok(())
            });
        }
        // Without materials there is one program for all.
        let materials = matches!(step.needs(), Needs::Alpha | Needs::Shading);
        let texture_sets = if materials { self.texture_sets() } else { Vec::new() };
        Box::new(move |recorder| {
            scene.draw_by_textures(recorder, &texture_sets, &draws, pull, (0, Faces::Material));
            Ok(())
        })
    }
}

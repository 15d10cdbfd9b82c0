//! Blended surfaces as lights see them.

use glam::{Mat4, Vec3};

use super::fragments::{Draw, Fragments, Step};
use crate::Result;
use crate::gpu::Feature;
use crate::graph::{Graph, RasterPass};
use crate::scene::{DrawClass, Faces, GpuScene, POSITIONS, SHADED, View, ViewSet};
use crate::shader::Program;
use crate::shader::generated::transparency::abuffer::{array_passing_frag, array_passing_pulled_frag};
use crate::shader::generated::transparency::{count_frag, count_vert, surface_pulled_vert, surface_vert};

/// What the blended materials of a scene let through of the light of several views, side by side in one picture. Both
/// faces of every surface count. Only counted and appended to arrays: other steps have no program.
pub struct Casters<'f> {
    scene: &'f GpuScene,
    /// Square, of one size.
    views: ViewSet,
    /// The same, each moved to its place in the row.
    row: ViewSet,
    pull_vertices: bool,
}

impl<'f> Casters<'f> {
    /// As `views` see them: squares of one size, which stand in a row from the left.
    ///
    /// # Errors
    /// As [`ViewSet::new`].
    pub fn new(graph: &Graph, scene: &'f GpuScene, views: Vec<View>) -> Result<Self> {
        let row = in_a_row(&views)?;
        let pull_vertices = !graph.caps().has(Feature::GeometryShader);
        Ok(Self { scene, views: ViewSet::new(views)?, row, pull_vertices })
    }

    fn texture_sets(&self) -> Vec<u32> {
        self.scene.draws.texture_sets(&[DrawClass::Blend])
    }
}

fn in_a_row(views: &[View]) -> Result<ViewSet> {
    let count = views.len() as f32;
    let placed = views.iter().enumerate().map(|(index, view)| {
        let aside = (2.0 * index as f32 + 1.0) / count - 1.0;
        let place = Mat4::from_translation(Vec3::X * aside) * Mat4::from_scale(Vec3::new(1.0 / count, 1.0, 1.0));
        View { clip_from_view: place * view.clip_from_view, ..*view }
    });
    ViewSet::new(placed.collect())
}

impl<'f> Fragments<'f> for Casters<'f> {
    fn programs(&self, step: Step) -> Vec<Program> {
        match step {
            Step::Count => vec![Program::new(&count_vert::SHADER, Some(&count_frag::SHADER)).vertex_buffers(POSITIONS)],
            Step::Arrays => {
                let program = match self.pull_vertices {
                    true => Program::new(&surface_pulled_vert::SHADER, Some(&array_passing_pulled_frag::SHADER)),
                    false => {
                        let fragment = Some(&array_passing_frag::SHADER);
                        Program::new(&surface_vert::SHADER, fragment).vertex_buffers(SHADED)
                    }
                };
                let program = program.set_layout(1, &self.scene.material_layout);
                let of = |&set: &u32| program.clone().constant(array_passing_frag::TEXTURES, set);
                self.texture_sets().iter().map(of).collect()
            }
            _ => Vec::new(),
        }
    }

    fn bind(&self, pass: &mut RasterPass<'_, 'f>, step: Step) {
        pass.uniform(count_vert::VIEWS, &self.row.block());
        if self.pull_vertices && step == Step::Arrays {
            self.scene.bind_pulled(pass);
        }
    }

    fn draw(&self, step: Step) -> Draw<'f> {
        let (scene, pull) = (self.scene, self.pull_vertices);
        let frusta = self.views.frusta();
        let draws: Vec<_> =
            frusta.into_iter().map(|frustum| scene.draws.visible(DrawClass::Blend, &[frustum])).collect();
        let sizes: Vec<_> = self.views.views().iter().map(|view| view.size).collect();
        let texture_sets = self.texture_sets();
        Box::new(move |recorder| {
            for ((index, draws), size) in (0u32..).zip(&draws).zip(&sizes) {
                recorder.scissor([index * size[0], 0], *size);
                if step == Step::Count {
                    recorder.push(&index);
                    scene.draw(recorder, Faces::Both, draws);
                } else {
                    scene.draw_by_textures(recorder, &texture_sets, draws, pull, (index, Faces::Both));
                }
            }
            Ok(())
        })
    }

    fn distances(&self) -> [f32; 2] {
        [1.0; 2]
    }
}

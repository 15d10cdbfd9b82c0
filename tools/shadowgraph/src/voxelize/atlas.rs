//! An atlas as fine as is asked for.

use serde::Serialize;
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::GpuScene;
use shadowgraph::techniques::voxel::Grid;
use shadowgraph::techniques::voxel::atlas::{Atlas, Charts, Stretch};
use shadowgraph::techniques::voxel::six_separating::SixSeparating;

use crate::cli::VoxelizeArguments;
use crate::failure::Result;

/// How fine an atlas is, and what it leaves out.
#[derive(Clone, Copy, Serialize)]
pub(super) struct AtlasReport {
    /// Texels along a voxel's edge.
    pub(super) texels: f32,
    /// Voxels of the thin surface that hold no texel.
    pub(super) holes: u32,
    /// Voxels of the thin surface.
    pub(super) thin: u32,
}

/// An atlas as fine as asked for, or so fine that it leaves no hole, and what it leaves out.
pub(super) fn atlas(
    arguments: &VoxelizeArguments,
    gpu: &Gpu,
    scene: &GpuScene,
    grid: &Grid,
) -> Result<(Atlas, AtlasReport)> {
    let axis = arguments.axis.into();
    let stretch = arguments.second_uvs.then(|| Stretch::of(scene, grid)).transpose()?;
    let charts = |texels| stretch.map_or(Charts::ByAxis { per_voxel: texels }, |stretch| stretch.charts(texels));
    let mut executor = Executor::new(gpu);
    let mut look = |texels: f32| -> shadowgraph::Result<(Atlas, AtlasReport)> {
        let atlas = Atlas { axis, charts: charts(texels) };
        let mut graph = Graph::new("holes", gpu.caps());
        let thin = SixSeparating { axis, ..SixSeparating::default() }.record(&mut graph, scene, grid)?;
        let found = atlas.record(&mut graph, scene, grid)?;
        let holes = Atlas::holes(&mut graph, &thin, &found)?;
        graph.capture("holes", &holes);
        graph.capture("thin", &thin.bits);
        let plan = graph.compile(gpu).map_err(shadowgraph::Error::from)?;
        let executed = executor.execute(&plan, graph)?;
        let words = |name| executed.capture(name)?.texels::<u32>();
        let (holes, thin) = (words("holes")?.iter().sum(), words("thin")?.iter().map(|word| word.count_ones()).sum());
        Ok((atlas, AtlasReport { texels, holes, thin }))
    };
    let mut best = look(arguments.texels.unwrap_or(2.0))?;
    while arguments.close && best.1.holes > 0 {
        // What the device cannot draw ends the search.
        match look(2.0 * best.1.texels) {
            Ok(finer) => best = finer,
            Err(shadowgraph::Error::Invalid { .. }) => break,
            Err(error) => return Err(error.into()),
        }
    }
    Ok(best)
}

//! Where does the sun reach? One technique after the other, each from the handles of those before it.
//!
//! `cargo run --example capture [SCENE.glb]` writes `sun.npy`, one float a pixel: 1 is lit.

use shadowgraph::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gpu = Gpu::headless(GpuOptions::default())?;
    let scene = match std::env::args().nth(1) {
        Some(path) => Scene::load(path)?,
        None => Scene::builtin("courtyard")?,
    };
    let scene = scene.upload(&gpu)?;
    let view = scene.cameras.first().ok_or("the scene has no camera")?.view([1280, 720]);
    let sun = scene.sun().ok_or("the scene has no directional light")?;

    let mut graph = Graph::new("frame", gpu.caps());
    let depth = DepthPrepass.record(&mut graph, &scene, &view);
    let surfaces = GBuffer::default().record(&mut graph, &scene, &view, depth);
    let receivers = Receivers { view: &view, depth: &surfaces.depth, ids: &surfaces.ids };
    let mask = graph.image("sun.mask", ImageShape::new_2d(Format::R32_SFLOAT, view.size));
    let cascades = Cascaded { cascades: 4, splits: Splits::Practical(0.8), ..Cascaded::default() };
    let shadow = cascades.record(&mut graph, &scene, &receivers, sun, mask)?;
    graph.capture("sun", &shadow.mask);

    let plan = graph.compile(&gpu)?;
    let frame = Executor::new(&gpu).execute(&plan, graph)?;
    let lit: Vec<f32> = frame.capture("sun")?.texels()?;
    write_npy("sun.npy".as_ref(), &[720, 1280], &lit)?;
    println!("wrote sun.npy: {:.1} % of the pixels are lit", 100.0 * lit.iter().sum::<f32>() / lit.len() as f32);
    Ok(())
}

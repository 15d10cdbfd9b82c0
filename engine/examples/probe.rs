use shadowgraph::frame::FrameSettings;
use shadowgraph::gpu::{Gpu, GpuOptions, Validation};
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::{Camera, Scene};
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap();
    let gpu = Gpu::headless(GpuOptions { validation: Validation::On, ..Default::default() })?;
    let scene = if let Some(n) = name.strip_prefix("builtin:") { Scene::builtin(n)? } else { Scene::load(&name)? };
    let t = std::time::Instant::now();
    let scene = scene.upload(&gpu)?;
    println!("upload {:?}, {} draws", t.elapsed(), scene.draws.draws().len());
    let camera = scene.cameras.first().cloned().unwrap_or(Camera::look_at(
        glam::Vec3::new(3., 2., 4.),
        glam::Vec3::ZERO,
        glam::Vec3::Y,
        0.8,
        0.1,
    ));
    let view = camera.view([1280, 720]);
    let settings = FrameSettings { environment: glam::Vec3::splat(2000.0), ..FrameSettings::new(view) };
    let mut executor = Executor::new(&gpu);
    for _ in 0..3 {
        let t = std::time::Instant::now();
        let mut graph = Graph::new("frame", gpu.caps());
        let frame = settings.record(&mut graph, &scene);
        let plan = graph.compile(&gpu)?;
        println!("describe+plan {:?}", t.elapsed());
        let done = executor.execute(&plan, graph)?;
        println!("record {:?} run {:?}", done.recording, done.running);
        for p in &done.passes {
            println!("  {:8.2} ms {}", p.seconds * 1e3, p.name);
        }
        let color = done.capture("color")?;
        let px = color.bytes(|b| bytemuck::cast_slice::<u8, f32>(b).to_vec())?;
        let mut img = image::RgbImage::new(1280, 720);
        let mean = px.chunks(4).map(|p| p[1]).sum::<f32>() / (1280.0 * 720.0);
        for (o, p) in img.pixels_mut().zip(px.chunks(4)) {
            for c in 0..3 {
                let v = p[c] / mean * 0.4;
                let v = v / (1.0 + v) * 1.3;
                o.0[c] = (v.clamp(0., 1.).powf(1. / 2.2) * 255.0) as u8;
            }
        }
        img.save("/tmp/probe.png")?;
        println!("{:?} {:?}", frame.layers.len(), frame.warnings);
        for m in gpu.messages().take() {
            println!("MESSAGE {m:?}");
        }
    }
    Ok(())
}

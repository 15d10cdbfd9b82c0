//! Voxels of one sphere: milliseconds from triangles in memory to bits in memory, a line of JSON each.
//!
//! `--obj FILE` writes the sphere for the tools of `compare.py`, which runs this program too.

mod cpu;
mod sphere;

use std::time::Instant;

use glam::{DVec3, Mat4, Vec2, Vec3, Vec4};
use serde_json::json;
use shadowgraph::gpu::{Gpu, GpuOptions};
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::{GpuScene, Material, Mesh, Object, Primitive, Scene};
use shadowgraph::techniques::voxel::bitmask::Bitmask;
use shadowgraph::techniques::voxel::conservative::Conservative;
use shadowgraph::techniques::voxel::{Grid, VoxelBits, Voxels};

use self::cpu::Cube;
use self::sphere::Sphere;

type Failure = Box<dyn std::error::Error>;

/// Segments: 69 696 triangles.
const SEGMENTS: u32 = 264;

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let (mut runs, mut size) = (9, 256);
    let sphere = Sphere::new(SEGMENTS);
    while let Some(argument) = arguments.next() {
        let value = arguments.next().ok_or("an option lacks its value: --runs N, --size N or --obj FILE")?;
        match argument.as_str() {
            "--runs" => runs = value.parse()?,
            "--size" => size = value.parse()?,
            "--obj" => return Ok(std::fs::write(value, sphere.obj())?),
            other => return Err(format!("{other}: there are --runs N, --size N and --obj FILE").into()),
        }
    }
    let gpu = Gpu::headless(GpuOptions::default())?;
    measure(&gpu, &sphere, size, runs)?;
    Ok(gpu.close()?)
}

fn measure(gpu: &Gpu, sphere: &Sphere, size: u32, runs: usize) -> Result<(), Failure> {
    let scene = scene(sphere);
    let mut executor = Executor::new(gpu);
    let grid = Grid::around(&scene.bounds().ok_or("the sphere is empty")?, size)?;
    let [x, y, z] = grid.min().to_array().map(f64::from);
    let cube = Cube { min: DVec3::new(x, y, z), edge: grid.edge().into(), size: size as usize };
    let mut solid =
        || find(&mut executor, gpu, &scene, &grid, |graph, scene| Bitmask::default().record(graph, scene, &grid));
    tell("shadowgraph", "solid", runs, &mut solid)?;
    tell("processor", "solid", runs, &mut || Ok(cpu::solid(sphere, &cube).count()))?;
    let mut touched =
        || find(&mut executor, gpu, &scene, &grid, |graph, scene| Conservative::default().record(graph, scene, &grid));
    tell("shadowgraph", "conservative", runs, &mut touched)?;
    tell("processor", "conservative", runs, &mut || Ok(cpu::conservative(sphere, &cube).count()))
}

/// Prints the median; the first run, in which drivers compile, does not count.
fn tell(tool: &str, what: &str, runs: usize, once: &mut impl FnMut() -> Result<u64, Failure>) -> Result<(), Failure> {
    let mut set = once()?;
    let mut times = Vec::with_capacity(runs);
    for _ in 0..runs {
        let began = Instant::now();
        set = once()?;
        times.push(began.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    let median = times.get(runs / 2).copied().unwrap_or(f64::NAN);
    println!("{}", json!({ "tool": tool, "what": what, "milliseconds": median, "set": set }));
    Ok(())
}

/// Upload, voxels, read-back.
fn find(
    executor: &mut Executor,
    gpu: &Gpu,
    scene: &Scene,
    grid: &Grid,
    record: impl for<'f> Fn(&mut Graph<'f>, &'f GpuScene) -> shadowgraph::Result<VoxelBits>,
) -> Result<u64, Failure> {
    let scene = scene.clone().upload(gpu)?;
    let mut graph = Graph::new("voxels", gpu.caps());
    let VoxelBits { bits, axis, .. } = record(&mut graph, &scene)?;
    graph.capture("voxels", &bits);
    let plan = graph.compile(gpu)?;
    let executed = executor.execute(&plan, graph)?;
    Ok(Voxels::read(executed.capture("voxels")?, grid, axis)?.count())
}

fn scene(sphere: &Sphere) -> Scene {
    let count = sphere.corners.len();
    let positions: Vec<Vec3> = sphere.corners.iter().map(|&corner| corner.into()).collect();
    let primitive = Primitive {
        normals: positions.clone(),
        positions,
        tangents: vec![Vec4::ZERO; count],
        uvs: [vec![Vec2::ZERO; count], vec![Vec2::ZERO; count]],
        colors: vec![Vec4::ONE; count],
        indices: sphere.triangles.as_flattened().to_vec(),
        ..Primitive::default()
    };
    Scene {
        materials: vec![Material::default()],
        meshes: vec![Mesh { name: "sphere".into(), primitives: vec![primitive] }],
        objects: vec![Object { name: "sphere".into(), mesh: 0, world_from_object: Mat4::IDENTITY }],
        ..Scene::default()
    }
}

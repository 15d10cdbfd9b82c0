//! Voxels of spheres: from triangles in memory to bits in memory, uploads and read-back included; opening the device
//! and the driver's compilation, which the first run of each case takes, are not.

use std::f32::consts::{PI, TAU};
use std::time::Instant;

use glam::{Mat4, Vec2, Vec3, Vec4};
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::{GpuScene, Material, Mesh, Object, Primitive, Scene};
use shadowgraph::techniques::voxel::atlas::Atlas;
use shadowgraph::techniques::voxel::attributes::Attributes;
use shadowgraph::techniques::voxel::bitmask::{Bitmask, Combine};
use shadowgraph::techniques::voxel::bricks::Bricks;
use shadowgraph::techniques::voxel::conservative::{Conservative, Pipeline};
use shadowgraph::techniques::voxel::six_separating::SixSeparating;
use shadowgraph::techniques::voxel::stencil::Stencil;
use shadowgraph::techniques::voxel::vote::Vote;
use shadowgraph::techniques::voxel::winding::Winding;
use shadowgraph::techniques::voxel::{Axis, Grid, VoxelBits, Voxels};

use super::{Measurement, median, milliseconds, rays};
use crate::cli::{BenchArguments, DeviceArguments};
use crate::failure::Result;
use crate::session;

/// Segments of the sphere and voxels along an axis.
const CASES: [(u32, u32); 9] =
    [(3, 256), (40, 256), (264, 64), (264, 128), (264, 256), (264, 512), (264, 1024), (264, 2048), (1000, 256)];

#[derive(Clone, Copy)]
enum Method {
    Solid(Combine),
    Stencil,
    Winding,
    Vote,
    Conservative(Pipeline),
    SixSeparating,
    Atlas,
    Attributes,
    Bricks,
}

/// Most slices times triangles that are drawn one slice after the other.
const MOST_SLICED: usize = 80_000_000;

/// Most voxels an axis that are found as a whole.
const MOST_WHOLE: u32 = 1024;

const METHODS: [(&str, Method); 12] = [
    ("bitmask", Method::Solid(Combine::Bit)),
    ("bitmask, masks", Method::Solid(Combine::Masks)),
    ("bitmask, logic", Method::Solid(Combine::LogicOp)),
    ("winding", Method::Winding),
    ("stencil", Method::Stencil),
    ("vote", Method::Vote),
    ("conservative", Method::Conservative(Pipeline::Compute)),
    ("conservative, raster", Method::Conservative(Pipeline::Raster)),
    ("six-separating", Method::SixSeparating),
    ("atlas", Method::Atlas),
    ("attributes", Method::Attributes),
    ("bricks", Method::Bricks),
];

impl Method {
    fn record<'f>(self, graph: &mut Graph<'f>, scene: &'f GpuScene, grid: &Grid) -> shadowgraph::Result<VoxelBits> {
        match self {
            Self::Solid(combine) => Bitmask { combine, ..Bitmask::default() }.record(graph, scene, grid),
            Self::Stencil => Stencil::default().record(graph, scene, grid),
            Self::Winding => Winding::default().record(graph, scene, grid),
            Self::Vote => {
                let vote = Vote::default();
                let leaks = vote.leaks(graph, scene, grid);
                let along = [Axis::X, Axis::Y, Axis::Z]
                    .map(|axis| Winding { axis, ..Winding::default() }.record(graph, scene, grid));
                let [x, y, z] = along;
                vote.record(graph, [&x?, &y?, &z?], &leaks)
            }
            Self::SixSeparating => SixSeparating::default().record(graph, scene, grid),
            Self::Conservative(pipeline) => {
                Conservative { pipeline, ..Conservative::default() }.record(graph, scene, grid)
            }
            Self::Atlas => Atlas::default().record(graph, scene, grid),
            Self::Attributes => {
                let voxels = Conservative::default().record(graph, scene, grid)?;
                Attributes::default().record(graph, scene, &voxels)?.capture(graph);
                Ok(voxels)
            }
            Self::Bricks => {
                let bricks = Bricks::default().record(graph, scene, grid)?;
                bricks.capture(graph);
                Ok(bricks.coarse)
            }
        }
    }
}

/// Every method, over resolution and over triangles.
pub fn run(arguments: &BenchArguments, tell: &mut impl FnMut(Measurement) -> Result<()>) -> Result<()> {
    let gpu = session::open(&DeviceArguments::default())?;
    let mut all = Vec::new();
    let measured = CASES.iter().try_for_each(|&(segments, resolution)| {
        let scene = sphere(segments);
        let triangles = scene.meshes[0].primitives[0].indices.len() / 3;
        let fits = |method: Method| match method {
            Method::Stencil => triangles * resolution as usize <= MOST_SLICED,
            Method::Bricks => true,
            _ => resolution <= MOST_WHOLE,
        };
        for (name, method) in METHODS.into_iter().filter(|&(_, method)| fits(method)) {
            let case = format!("{name}, {triangles} triangles, {resolution}");
            if !arguments.wants(&case) {
                continue;
            }
            let (time, set) = measure(&gpu, &scene, method, resolution, arguments.runs as usize)?;
            all.push((name, triangles, resolution, time));
            let told = |metric: &str, value, unit| Measurement {
                bench: "voxelize",
                case: case.clone(),
                metric: metric.into(),
                value,
                unit,
            };
            tell(told("total", time, "ms"))?;
            tell(told("set", set, "voxels"))?;
        }
        Ok(())
    });
    let measured = measured.and_then(|()| growth(&all, tell));
    let measured = measured.and_then(|()| rays::run(&gpu, &sphere(264), arguments, tell));
    let closed = session::close(gpu);
    measured.and(closed)
}

/// How a method's time grows from case to case: its exponent of voxels an axis, and of triangles.
fn growth(all: &[(&str, usize, u32, f64)], tell: &mut impl FnMut(Measurement) -> Result<()>) -> Result<()> {
    for (name, _) in METHODS {
        let cases: Vec<_> = all.iter().filter(|case| case.0 == name).collect();
        for (index, &&(_, triangles, resolution, time)) in cases.iter().enumerate() {
            let mut exponent = |case: String, ratio: f64, times: f64| {
                let value = times.ln() / ratio.ln();
                tell(Measurement { bench: "voxelize", case, metric: "growth".into(), value, unit: "exponent" })
            };
            let behind = || cases[index + 1..].iter();
            if let Some(finer) = behind().find(|case| case.1 == triangles && case.2 > resolution) {
                let case = format!("{name}, {triangles} triangles, {resolution} to {}", finer.2);
                exponent(case, f64::from(finer.2) / f64::from(resolution), finer.3 / time)?;
            }
            if let Some(more) = behind().find(|case| case.2 == resolution && case.1 > triangles) {
                let case = format!("{name}, {triangles} to {} triangles, {resolution}", more.1);
                exponent(case, more.1 as f64 / triangles as f64, more.3 / time)?;
            }
        }
    }
    Ok(())
}

/// Median milliseconds, and how many voxels are set.
fn measure(gpu: &Gpu, scene: &Scene, method: Method, resolution: u32, runs: usize) -> Result<(f64, f64)> {
    let mut executor = Executor::new(gpu);
    let mut once = || -> Result<_> {
        let scene = scene.clone();
        let began = Instant::now();
        let scene = scene.upload(gpu)?;
        let grid = Grid::around(&scene.bounds, resolution)?;
        let set = find(&mut executor, gpu, |graph| method.record(graph, &scene, &grid))?;
        Ok((milliseconds(began.elapsed()), set as f64))
    };
    // The first run compiles shaders.
    let (_, set) = once()?;
    let times = (0..runs).map(|_| once().map(|(time, _)| time)).collect::<Result<_>>()?;
    Ok((median(times), set))
}

/// How many voxels a technique sets, of bricks how many bricks.
fn find<'f>(
    executor: &mut Executor,
    gpu: &'f Gpu,
    record: impl FnOnce(&mut Graph<'f>) -> shadowgraph::Result<VoxelBits>,
) -> Result<u64> {
    let mut graph = Graph::new("voxelize", gpu.caps());
    let VoxelBits { bits, axis, grid } = record(&mut graph)?;
    graph.capture("voxels", &bits);
    let plan = graph.compile(gpu).map_err(shadowgraph::Error::from)?;
    let executed = executor.execute(&plan, graph)?;
    Ok(Voxels::read(executed.capture("voxels")?, &grid, axis)?.count())
}

/// A unit sphere of about `segments`² triangles, at least 12.
fn sphere(segments: u32) -> Scene {
    let rings = (segments / 2 + 1).max(3);
    let mut primitive = Primitive::default();
    for ring in 0..=rings {
        for segment in 0..segments {
            let (theta, phi) = (PI * ring as f32 / rings as f32, TAU * segment as f32 / segments as f32);
            let around = if ring % rings == 0 { 0.0 } else { theta.sin() };
            primitive.positions.push(Vec3::new(around * phi.sin(), theta.cos(), around * phi.cos()));
        }
    }
    let at = |ring: u32, segment: u32| ring * segments + segment % segments;
    for (ring, segment) in (0..rings).flat_map(|ring| (0..segments).map(move |segment| (ring, segment))) {
        let [a, b] = [at(ring, segment), at(ring, segment + 1)];
        let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
        if ring > 0 {
            primitive.indices.extend([a, c, b]);
        }
        if ring + 1 < rings {
            primitive.indices.extend([b, c, d]);
        }
    }
    let vertices = primitive.positions.len();
    primitive.normals = primitive.positions.clone();
    primitive.tangents = vec![Vec4::ZERO; vertices];
    primitive.uvs = [vec![Vec2::ZERO; vertices], vec![Vec2::ZERO; vertices]];
    primitive.colors = vec![Vec4::ONE; vertices];
    Scene {
        name: "sphere".into(),
        materials: vec![Material::default()],
        meshes: vec![Mesh { name: "sphere".into(), primitives: vec![primitive] }],
        objects: vec![Object { name: "sphere".into(), mesh: 0, world_from_object: Mat4::IDENTITY }],
        ..Scene::default()
    }
}

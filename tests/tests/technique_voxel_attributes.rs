//! What voxels say of surfaces against averages over clipped triangles in double precision.
#![allow(missing_docs, clippy::unwrap_used)]

use std::collections::BTreeMap;

use glam::{DVec3, Mat4, Vec3, Vec4};
use shadowgraph::capture::{VoxelFormat, write_voxel_attributes};
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executor, Graph};
use shadowgraph::scene::{AlphaMode, Material, Scene};
use shadowgraph::techniques::voxel::attributes::{Attribute, Attributes, VoxelAttributes};
use shadowgraph::techniques::voxel::bricks::Bricks;
use shadowgraph::techniques::voxel::conservative::Conservative;
use shadowgraph::techniques::voxel::{Axis, Grid, Voxels};
use shadowgraph_tests::device::{shared, silent};
use shadowgraph_tests::figures::{self, Figure};
use shadowgraph_tests::solids::{awkward, bounds, soup, torus};
use shadowgraph_tests::soup::Random;
use shadowgraph_tests::twin::attributes::{Average, averages};
use shadowgraph_tests::twin::scene::Scene as Truth;
use shadowgraph_tests::{exr_file, harness, tiny, voxel_pictures};

/// What triangles that only touch a voxel add to its area, in squares of its edge: the least weight each.
const TOUCH: f64 = 1e-5;
/// Of opacity and albedo, and of emission by the greatest value: textures are filtered with 8 bits of
/// weight, within a level and between two, and what is mixed is up to 1 apart.
const VALUE: f64 = 4.0 / 255.0;
/// Of normals, which stand in normal maps as -1 to 1: twice that. Where filtering leaves a short vector, its error grows
/// when it is made one of unit length: so many voxels may be off.
const NORMAL: f64 = 2.0 * VALUE;
const NORMALS_OFF: f64 = 1e-3;
/// Voxels in which the parts' areas are known less well are left out.
const LEAST_KNOWN: f64 = 0.02;

/// Less than its margin off its place, so that no scene made of whole numbers lies on its planes.
fn off_planes(scene: &Scene, resolution: u32) -> Grid {
    let grid = Grid::around(&bounds(scene), resolution).unwrap();
    Grid::new(grid.min() + Vec3::new(0.137, -0.271, 0.193) * grid.edge(), grid.edge(), grid.size()).unwrap()
}

fn attributes(executor: &mut Executor, gpu: &Gpu, scene: &Scene, grid: &Grid, axis: Axis) -> VoxelAttributes {
    let mut find = || -> shadowgraph::Result<VoxelAttributes> {
        let scene = scene.clone().upload(gpu)?;
        let mut graph = Graph::new("attributes", gpu.caps());
        let voxels = Conservative { axis, ..Conservative::default() }.record(&mut graph, &scene, grid)?;
        let found = Attributes::default().record(&mut graph, &scene, &voxels)?;
        graph.capture("bits", &voxels.bits);
        found.capture(&mut graph);
        let plan = graph.compile(gpu)?;
        let executed = executor.execute(&plan, graph)?;
        VoxelAttributes::read(&executed, Voxels::read(executed.capture("bits")?, grid, axis)?)
    };
    find().unwrap_or_else(|error| panic!("{}: {error}", scene.name))
}

/// What a comparison found.
#[derive(Default)]
struct Found {
    compared: usize,
    left_out: usize,
    wrong: usize,
    normals_off: usize,
    /// Largest part of what is allowed, by attribute.
    worst: BTreeMap<&'static str, f64>,
}

fn compare(found: &VoxelAttributes, truth: &Scene) -> Found {
    let grid = found.voxels().grid();
    let mut truth = averages(&Truth::new(truth), grid);
    let greatest = truth.values().map(|average| average.emission.max_element()).fold(0.0, f64::max).max(1e-30);
    let mut result = Found::default();
    for voxel in grid.voxels() {
        let average = truth.remove(&voxel).unwrap_or_default();
        let Some(own) = found.get(voxel) else {
            assert!(average.area <= average.doubt, "{voxel:?} is not set");
            continue;
        };
        result.compare(own, &average, greatest);
    }
    result
}

impl Found {
    fn compare(&mut self, own: &Attribute, average: &Average, greatest: f64) {
        let unknown = average.doubt + TOUCH;
        let mut errors = vec![("area", (f64::from(own.area) - average.area).abs() / unknown)];
        if average.seen < unknown / LEAST_KNOWN {
            self.left_out += 1;
        } else {
            self.compared += 1;
            let allowed = VALUE + 2.0 * unknown / average.seen;
            let off = |a: Vec3, b: DVec3| (a.as_dvec3() - b).abs().max_element() / allowed;
            errors.push(("opacity", (f64::from(own.opacity) - average.opacity()).abs() / allowed));
            errors.push(("albedo", off(own.albedo, average.albedo)));
            let normal = (own.normal.as_dvec3() - average.normal).abs().max_element();
            self.normals_off += usize::from(normal > allowed - VALUE + NORMAL);
            errors.push(("emission", off(own.emission, average.emission) / greatest));
        }
        self.wrong += usize::from(errors.iter().any(|&(_, error)| error > 1.0 || error.is_nan()));
        for (name, error) in errors {
            let worst = self.worst.entry(name).or_default();
            *worst = worst.max(error);
        }
    }
}

/// Scenes of all kinds of material.
fn scenes() -> Vec<Scene> {
    let mut scenes = vec![painted("painted tetrahedra", soup(60)), painted("painted torus", torus(48, 24))];
    for file in [
        "Avocado/glTF/Avocado.gltf",
        "BoxVertexColors/BoxVertexColors.gltf",
        "ChainLinkFence/ChainLinkFence.gltf",
        "EmissiveStrengthTest/EmissiveStrengthTest.glb",
        "GlassTable/GlassTable.glb",
        "MultiUVTest/MultiUVTest.glb",
        "NegativeScaleTest/NegativeScaleTest.glb",
        "NormalTangentTest/NormalTangentTest.gltf",
        "TextureTransformMultiTest/TextureTransformMultiTest.glb",
    ] {
        if let Some(path) = harness::require_scene(file) {
            scenes.push(Scene::load(&path).unwrap());
        }
    }
    scenes
}

/// The primitive thrice, of an opaque, an emitting and a half transparent material.
fn painted(name: &str, primitive: shadowgraph::scene::Primitive) -> Scene {
    let colors = [[0.9, 0.1, 0.05, 1.0], [0.02, 0.6, 0.3, 0.3], [0.1, 0.2, 0.8, 0.4]];
    let parts = (0..3).map(|i| {
        let place = Mat4::from_translation(Vec3::new(0.3, 0.1, -0.2) * i as f32);
        (shadowgraph::scene::Primitive { material: i, ..primitive.clone() }, place * awkward())
    });
    let mut scene = tiny::one(name, parts.collect());
    scene.materials = colors.map(|color| Material { base_color: Vec4::from(color), ..Material::default() }).to_vec();
    scene.materials[1].emissive = Vec3::new(500.0, 20.0, 1.0);
    scene.materials[2].alpha_mode = AlphaMode::Blend;
    scene
}

#[test]
fn voxel_attributes_agrees_with_its_reference() {
    let gpu = shared();
    let executor = &mut Executor::new(gpu);
    let mut figures = Vec::new();
    for scene in scenes() {
        let mut sum = Found::default();
        for (resolution, axis) in [(24, Axis::X), (48, Axis::Y), (96, Axis::Z)] {
            let grid = off_planes(&scene, resolution);
            let found = compare(&attributes(executor, gpu, &scene, &grid, axis), &scene);
            println!(
                "{} at {resolution}: {} compared, {} left out, {} wrong, {} normals off, {:.2?}",
                scene.name, found.compared, found.left_out, found.wrong, found.normals_off, found.worst
            );
            sum.compared += found.compared;
            sum.left_out += found.left_out;
            sum.wrong += found.wrong;
            sum.normals_off += found.normals_off;
        }
        let name = &scene.name;
        assert!(sum.wrong == 0 && sum.compared > 0, "{name}: {} of {} are wrong", sum.wrong, sum.compared);
        let off = sum.normals_off as f64 / sum.compared as f64;
        assert!(off <= NORMALS_OFF, "{name}: {} normals are off", sum.normals_off);
        let share = 100.0 * sum.left_out as f64 / (sum.compared + sum.left_out) as f64;
        figures.push(Figure {
            what: format!("{name}: voxels at 24, 48, 96"),
            value: format!(
                "{} agree, {share:.1} % left out, normals of {}",
                sum.compared,
                sum.compared - sum.normals_off
            ),
            bound: "within 4/255 and what moving faces by 2e-5 voxel may change; 99.9 % of normals within 8/255".into(),
        });
    }
    silent(gpu);
    let picture = harness::require_scene("Avocado/glTF/Avocado.gltf").map(|path| {
        let scene = Scene::load(&path).unwrap();
        let grid = Grid::around(&bounds(&scene), 160).unwrap();
        voxel_pictures::attributes("An avocado", &attributes(executor, gpu, &scene, &grid, Axis::Z))
    });
    figures::publish(gpu, "voxel", "attributes", &figures, picture.as_ref());
}

#[test]
fn voxel_attributes_with_a_seeded_mistake_is_caught() {
    let gpu = shared();
    let executor = &mut Executor::new(gpu);
    let truth = painted("tetrahedra", soup(30));
    let grid = Grid::around(&bounds(&truth), 40).unwrap();
    let mut wrong = |change: &dyn Fn(&mut Scene)| {
        let mut scene = truth.clone();
        change(&mut scene);
        let found = compare(&attributes(executor, gpu, &scene, &grid, Axis::Z), &truth);
        found.wrong + found.normals_off
    };
    assert_eq!(wrong(&|_| {}), 0);
    // Colours a little off; one that emits more; one that lets more through; normals turned; a triangle lost.
    assert!(wrong(&|scene| scene.materials[0].base_color.x -= 0.03) > 0);
    assert!(wrong(&|scene| scene.materials[1].emissive *= 1.03) > 0);
    assert!(wrong(&|scene| scene.materials[2].base_color.w += 0.03) > 0);
    assert!(wrong(&|scene| scene.materials[1].alpha_mode = AlphaMode::Blend) > 0);
    assert!(wrong(&|scene| scene.meshes[0].primitives[0].normals.iter_mut().for_each(|n| *n = -*n)) > 0);
    assert!(wrong(&|scene| drop(scene.meshes[0].primitives[0].indices.drain(..3))) > 0);
    silent(gpu);
}

#[test]
fn a_hundred_orders_give_the_same_bytes() {
    let gpu = shared();
    let executor = &mut Executor::new(gpu);
    let scene = painted("tetrahedra", soup(80));
    let grid = Grid::around(&bounds(&scene), 56).unwrap();
    let bits = |found: &VoxelAttributes| -> Vec<[u32; 11]> {
        let of = |a: &Attribute| {
            let [r, g, b] = a.albedo.to_array();
            let [x, y, z] = a.normal.to_array();
            let [s, t, u] = a.emission.to_array();
            [r, g, b, a.opacity, x, y, z, a.area, s, t, u].map(f32::to_bits)
        };
        grid.voxels().filter_map(|voxel| found.get(voxel).map(of)).collect()
    };
    let first = bits(&attributes(executor, gpu, &scene, &grid, Axis::Z));
    assert!(first.len() > 3000, "{}", first.len());
    let mut random = Random::new(7);
    for order in 0..100 {
        let mut shuffled = scene.clone();
        random.shuffle(&mut shuffled.objects);
        for mesh in &mut shuffled.meshes {
            let mut triangles = mesh.primitives[0].indices.as_chunks::<3>().0.to_vec();
            random.shuffle(&mut triangles);
            mesh.primitives[0].indices = triangles.concat();
        }
        assert!(bits(&attributes(executor, gpu, &shuffled, &grid, Axis::Z)) == first, "order {order}");
    }
    silent(gpu);
}

#[test]
fn bricks_hold_what_the_whole_grid_does() {
    let gpu = shared();
    let executor = &mut Executor::new(gpu);
    let mut compared = 0;
    for scene in scenes() {
        for resolution in [21, 100] {
            let grid = off_planes(&scene, resolution);
            let whole = attributes(executor, gpu, &scene, &grid, Axis::Z);
            let uploaded = scene.clone().upload(gpu).unwrap();
            let mut graph = Graph::new("attributes of bricks", gpu.caps());
            let bricks = Bricks::default().record(&mut graph, &uploaded, &grid).unwrap();
            let found = Attributes::default().record(&mut graph, &uploaded, &bricks).unwrap();
            bricks.capture(&mut graph);
            found.capture(&mut graph);
            let plan = graph.compile(gpu).unwrap();
            let executed = executor.execute(&plan, graph).unwrap();
            let own = VoxelAttributes::read(&executed, Voxels::read_bricks(&executed, &grid).unwrap()).unwrap();
            assert_eq!(own.voxels().count(), whole.voxels().count(), "{} at {resolution}", scene.name);
            for voxel in whole.voxels().set() {
                assert_eq!(own.get(voxel), whole.get(voxel), "{} at {resolution}: {voxel:?}", scene.name);
                compared += usize::from(own.get(voxel).is_some());
            }
        }
    }
    assert!(compared > 50_000, "{compared}");
    silent(gpu);
}

#[test]
fn parts_make_up_the_surface() {
    let gpu = shared();
    let executor = &mut Executor::new(gpu);
    let scene = painted("torus", torus(64, 32));
    let area: f64 = Truth::new(&scene)
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.positions;
            0.5 * (b - a).cross(c - a).length()
        })
        .sum();
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        let around = Grid::around(&bounds(&scene), 60).unwrap();
        let grid = Grid::new(around.min() - 2.0 * around.edge(), around.edge(), [64, 70, 80]).unwrap();
        let found = attributes(executor, gpu, &scene, &grid, axis);
        let sum: f64 = grid.voxels().filter_map(|voxel| found.get(voxel)).map(|own| f64::from(own.area)).sum();
        let sum = sum * f64::from(grid.edge()).powi(2);
        assert!((sum / area - 1.0).abs() < 1e-5, "{sum} of {area}");
    }
    silent(gpu);
}

#[test]
fn portable_what_lies_on_a_plane_of_the_grid_is_on_both_sides() {
    let gpu = shared();
    let executor = &mut Executor::new(gpu);
    let quad = tiny::one(
        "quad",
        vec![(tiny::quad(Vec3::new(1.0, 1.0, 2.0), Vec3::X * 2.0, Vec3::Y * 2.0, 0), Mat4::IDENTITY)],
    );
    let grid = Grid::new(Vec3::ZERO, 1.0, [4; 3]).unwrap();
    let found = attributes(executor, gpu, &quad, &grid, Axis::Y);
    for voxel in grid.voxels() {
        let [x, y, z] = voxel.map(|i| i == 1 || i == 2);
        let own = found.get(voxel);
        assert_eq!(own.is_some(), z, "{voxel:?}");
        // Those beside the square only touch it, and have its colour all the same.
        if let Some(own) = own {
            assert!((own.area - if x && y { 1.0 } else { 0.0 }).abs() < 1e-5, "{voxel:?}: {own:?}");
            assert!(own.albedo == Vec3::ONE && own.normal == Vec3::Z && own.opacity == 1.0, "{voxel:?}: {own:?}");
        }
    }
    silent(gpu);
}

#[test]
fn portable_sums_of_many_parts_lose_nothing() {
    let gpu = shared();
    let executor = &mut Executor::new(gpu);
    // A square a thousand times, of a colour that sums hold exactly.
    let mut quad = tiny::quad(Vec3::new(0.25, 0.25, 0.5), Vec3::X * 0.7, Vec3::Y * 0.6, 0);
    quad.indices = quad.indices.repeat(1000);
    let mut scene = tiny::one("many", vec![(quad, Mat4::IDENTITY)]);
    let color = Vec3::new(12_345.0, 1.0, 65_534.0) / 65_535.0;
    scene.materials[0].base_color = color.extend(1.0);
    let found = attributes(executor, gpu, &scene, &Grid::new(Vec3::ZERO, 1.0, [1; 3]).unwrap(), Axis::Z);
    let own = found.get([0; 3]).unwrap();
    assert!((own.albedo - color).abs().max_element() < 1e-7 && (own.area / 420.0 - 1.0).abs() < 1e-5, "{own:?}");
    silent(gpu);
}

#[test]
fn nothing_has_no_attributes() {
    let gpu = shared();
    let executor = &mut Executor::new(gpu);
    let grid = Grid::new(Vec3::ZERO, 1.0, [4; 3]).unwrap();
    let beside = tiny::one("beside", vec![(tiny::quad(Vec3::splat(9.0), Vec3::X, Vec3::Y, 0), Mat4::IDENTITY)]);
    for scene in [tiny::empty(), beside] {
        let found = attributes(executor, gpu, &scene, &grid, Axis::Z);
        assert!(grid.voxels().all(|voxel| found.get(voxel).is_none()) && found.voxels().count() == 0);
    }
    silent(gpu);
}

/// A room of squares with a colour each, in a grid of 12³.
fn squares() -> (Scene, Grid) {
    let mut scene = tiny::one("squares", Vec::new());
    scene.materials.clear();
    for i in 0..4 {
        let base_color = Vec4::new(0.2 * i as f32, 1.0 - 0.3 * i as f32, 0.1, 0.5);
        scene.materials.push(Material { base_color, alpha_mode: AlphaMode::Blend, ..Material::default() });
        let corner = Vec3::new(2.2 * i as f32 + 1.1, 1.2, 3.3 * i as f32 + 0.4);
        tiny::add(&mut scene, tiny::quad(corner, Vec3::X * 2.0, Vec3::Y * 7.0, i), Mat4::IDENTITY);
    }
    (scene, Grid::new(Vec3::ZERO, 1.0, [12; 3]).unwrap())
}

#[test]
fn files_hold_attributes() {
    let gpu = shared();
    let (scene, grid) = squares();
    let found = attributes(&mut Executor::new(gpu), gpu, &scene, &grid, Axis::Z);
    let folder = tempfile::tempdir().unwrap();
    let written = |name: &str| {
        let path = folder.path().join(name);
        write_voxel_attributes(&path, &found, VoxelFormat::of(&path).unwrap()).map(|()| path)
    };

    // A slice a part, a channel a value.
    let image = exr_file::image(&written("v.exr").unwrap());
    let mut compared = 0;
    for (z, layer) in image.layer_data.iter().enumerate() {
        let channel = |name: &str| -> Vec<f32> {
            let channel = layer.channel_data.list.iter().find(|channel| channel.name.to_string() == name).unwrap();
            channel.sample_data.values_as_f32().collect()
        };
        let names = ["R", "G", "B", "A", "normal.X", "normal.Y", "normal.Z", "area"];
        let channels = names.map(channel);
        for voxel in grid.voxels().filter(|voxel| voxel[2] as usize == z) {
            let index = ((11 - voxel[1]) * 12 + voxel[0]) as usize;
            let own = found.get(voxel).map_or([0.0; 8], |own| {
                let (a, n) = (own.albedo, own.normal);
                [a.x, a.y, a.z, own.opacity, n.x, n.y, n.z, own.area]
            });
            assert_eq!(channels.each_ref().map(|values| values[index]), own, "{voxel:?}");
            compared += usize::from(own[3] > 0.0);
        }
    }
    assert!(compared > 50, "{compared}");

    // Few colours stay as they are: a place, and the index of a colour, from 1.
    let file = std::fs::read(written("v.vox").unwrap()).unwrap();
    let chunk = |name: &[u8; 4]| {
        let at = file.windows(4).position(|four| four == name).unwrap();
        let length = u32::from_le_bytes(file[at + 4..at + 8].try_into().unwrap()) as usize;
        file[at + 12..at + 12 + length].to_vec()
    };
    let (places, palette) = (chunk(b"XYZI"), chunk(b"RGBA"));
    let places = places[4..].as_chunks::<4>().0;
    assert_eq!(places.len() as u64, found.voxels().count());
    for &[x, y, z, index] in places {
        let own = found.get([x.into(), z.into(), 11 - u32::from(y)]).unwrap();
        let color = &palette[4 * (usize::from(index) - 1)..][..4];
        let linear = |byte: u8| shadowgraph_tests::twin::texture::decode_srgb(f64::from(byte) / 255.0);
        let near = own.albedo.to_array().iter().zip(color).all(|(&a, &b)| (f64::from(a) - linear(b)).abs() < 0.005);
        assert!(color[3] == 255 && if own.area > 0.0 { near } else { index == 1 }, "{own:?} as {color:?}");
    }
    let said = written("v.npy").unwrap_err().to_string();
    assert!(said.contains(".vox, .exr and .sparse.npy"), "{said}");
    silent(gpu);
}

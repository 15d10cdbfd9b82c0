//! Meshes: their attributes and triangles. glTF 2.0, section 3.7.

use std::collections::HashMap;

use ::gltf::json::{
    self,
    mesh::{Mode, Semantic},
    validation::Checked,
};
use glam::{DMat4, Vec2, Vec3, Vec4};

use super::{
    File,
    node::Placed,
    place, skin,
    tangents::{self, repaired},
};
use crate::{
    error::Result,
    parallel,
    scene::{Material, Mesh, Primitive},
};

/// Meshes of a scene.
pub struct Meshes {
    /// Those of the file in its order, then posed ones.
    pub meshes: Vec<Mesh>,
    /// Mesh of each node whose mesh is posed by a skin, by node.
    pub posed: HashMap<usize, usize>,
}

/// Builds all meshes on all cores, and appends the default material where one is needed.
pub fn load(
    file: &File,
    materials: &mut Vec<Material>,
    placed: &Placed,
    skins: &[Vec<DMat4>],
    warnings: &mut Vec<String>,
) -> Result<Meshes> {
    // 1. Which meshes are needed as they are, and which posed. One that is only used posed gives up its own place.
    let sources = &file.root.meshes;
    let mut jobs: Vec<(usize, Option<usize>)> = (0..sources.len()).map(|mesh| (mesh, None)).collect();
    let mut plain = vec![false; sources.len()];
    let users = || {
        placed.order.iter().filter_map(|&index| {
            let node = file.root.nodes.get(index)?;
            Some((index, node.mesh?.value(), node.skin.map(|skin| skin.value())))
        })
    };
    for (node, mesh, skin) in users() {
        let Some(plain) = plain.get_mut(mesh) else {
            return Err(
                file.error(format!("node {node}"), format!("uses mesh {mesh}, but there are {}", sources.len()))
            );
        };
        *plain |= skin.is_none();
    }
    let mut known = HashMap::new();
    let mut posed = HashMap::new();
    for (node, mesh, skin) in users() {
        let Some(skin) = skin else { continue };
        let slot = known.entry((mesh, skin)).or_insert_with(|| match &mut jobs[mesh] {
            own @ (_, None) if !plain[mesh] => {
                *own = (mesh, Some(skin));
                mesh
            }
            _ => {
                jobs.push((mesh, Some(skin)));
                jobs.len() - 1
            }
        });
        posed.insert(node, *slot);
    }

    // 2. The default material.
    let default = materials.len();
    if sources.iter().flat_map(|mesh| &mesh.primitives).any(|primitive| primitive.material.is_none()) {
        let mut name = Material::default().name;
        while materials.iter().any(|material| material.name == name) {
            name.push('_');
        }
        materials.push(Material { name, ..Material::default() });
    }

    // 3. The meshes.
    let materials = Materials { all: materials, default };
    let run = |job: usize| {
        let (index, skin) = jobs[job];
        let source = &sources[index];
        let joints = skin.and_then(|skin| skins.get(skin)).map(Vec::as_slice);
        let at = place("mesh", index, source.name.as_ref());
        let mut warnings = Vec::new();
        let mut primitives = Vec::new();
        for (i, primitive) in source.primitives.iter().enumerate() {
            let at = format!("{at}, primitive {i}");
            primitives.extend(build(file, primitive, joints, &materials, &at, &mut warnings)?);
        }
        let name = source.name.clone().filter(|name| !name.is_empty()).unwrap_or_else(|| format!("mesh {index}"));
        Ok((Mesh { name, primitives }, warnings))
    };
    let fault = |job: usize| file.error(format!("mesh {}", jobs[job].0), "could not be built");
    let built = parallel::map(jobs.len(), run, fault)?;
    let meshes = built.into_iter().map(|(mesh, passed_over)| {
        warnings.extend(passed_over);
        mesh
    });
    Ok(Meshes { meshes: meshes.collect(), posed })
}

struct Materials<'a> {
    all: &'a [Material],
    default: usize,
}

/// One primitive as an indexed triangle list with all attributes; `None` where it has no triangles.
fn build(
    file: &File,
    source: &json::mesh::Primitive,
    joints: Option<&[DMat4]>,
    materials: &Materials,
    at: &str,
    warnings: &mut Vec<String>,
) -> Result<Option<Primitive>> {
    // 1. Is it there, is it triangles?
    let index = source.material.map_or(materials.default, |material| material.value());
    let Some(material) = materials.all.get(index) else {
        return Err(file.error(at, format!("uses material {index}, but there are {}", materials.all.len())));
    };
    let Checked::Valid(mode) = source.mode else {
        return Err(file.error(at, "has a mode that glTF does not know"));
    };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        warnings.push(format!("{at} is passed over: it is {mode:?}, not triangles"));
        return Ok(None);
    }
    if !source.attributes.contains_key(&Checked::Valid(Semantic::Positions)) {
        warnings.push(format!("{at} is passed over: it has no POSITION"));
        return Ok(None);
    }
    if source.targets.as_ref().is_some_and(|targets| !targets.is_empty()) {
        warnings.push(format!("{at}: its morph targets are passed over"));
    }

    // 2. Attributes and triangles as stored.
    let mut primitive = attributes(file, source, at)?;
    primitive.material = index;
    primitive.indices = triangles(file, source, mode, primitive.positions.len(), at, warnings)?;
    if primitive.indices.is_empty() {
        warnings.push(format!("{at} is passed over: it has no triangles"));
        return Ok(None);
    }

    // 3. The pose.
    if let Some(joints) = joints {
        skin::pose(file, source, joints, &mut primitive, at)?;
    }

    // 4. What is missing: normals are flat (their vertices unshared), the rest has its neutral value.
    if let Some(vertex) = primitive.positions.iter().position(|p| !p.is_finite()) {
        return Err(file.error(at, format!("POSITION of vertex {vertex} is not finite")));
    }
    let flat = primitive.normals.is_empty();
    let corners = if flat { primitive.indices.len() } else { primitive.positions.len() };
    file.spend(corners as u64 * VERTEX_BYTES, at)?;
    if flat {
        unshare(&mut primitive);
    }
    let count = primitive.positions.len();
    primitive.uvs.iter_mut().for_each(|uvs| uvs.resize(count, Vec2::ZERO));
    primitive.colors.resize(count, Vec4::ONE);
    repair_normals(&mut primitive);

    // 5. Tangents, where a normal map needs them.
    match material.normal_texture {
        None => primitive.tangents = vec![Vec4::ZERO; count],
        Some(_) if primitive.tangents.len() == count => {
            let frames = primitive.tangents.iter_mut().zip(&primitive.normals);
            frames.for_each(|(tangent, &normal)| *tangent = repaired(*tangent, normal));
        }
        Some(slot) => {
            file.spend(primitive.indices.len() as u64 * VERTEX_BYTES, at)?;
            tangents::generate(&mut primitive, &slot);
        }
    }
    Ok(Some(primitive))
}

/// All attributes of one vertex.
const VERTEX_BYTES: u64 = 72;

/// Attributes as stored; those that the file lacks stay empty.
fn attributes(file: &File, source: &json::mesh::Primitive, at: &str) -> Result<Primitive> {
    let mut primitive = Primitive::default();
    let find = |semantic| source.attributes.get(&Checked::Valid(semantic)).copied();
    if let Some(accessor) = find(Semantic::Positions) {
        let positions = file.floats::<3>(&file.elements(accessor, at)?, at)?;
        primitive.positions = positions.into_iter().map(Vec3::from).collect();
    }
    let count = primitive.positions.len();
    let same_length = |length: usize, name: &str| {
        if length == count {
            return Ok(());
        }
        Err(file.error(at, format!("{name} has {length} elements, POSITION {count}")))
    };
    let finite = |finite: bool, name: &str| {
        if finite { Ok(()) } else { Err(file.error(at, format!("{name} has a value that is not finite"))) }
    };

    if let Some(accessor) = find(Semantic::Normals) {
        let normals = file.floats::<3>(&file.elements(accessor, at)?, at)?;
        same_length(normals.len(), "NORMAL")?;
        primitive.normals = normals.into_iter().map(Vec3::from).collect();
        if let Some(accessor) = find(Semantic::Tangents) {
            let tangents = file.floats::<4>(&file.elements(accessor, at)?, at)?;
            same_length(tangents.len(), "TANGENT")?;
            primitive.tangents = tangents.into_iter().map(Vec4::from).collect();
        }
    }
    for (set, uvs) in primitive.uvs.iter_mut().enumerate() {
        let Some(accessor) = find(Semantic::TexCoords(set as u32)) else { continue };
        let name = format!("TEXCOORD_{set}");
        *uvs = file.floats::<2>(&file.elements(accessor, at)?, at)?.into_iter().map(Vec2::from).collect();
        same_length(uvs.len(), &name)?;
        finite(uvs.iter().all(|uv| uv.is_finite()), &name)?;
    }
    if let Some(accessor) = find(Semantic::Colors(0)) {
        let elements = file.elements(accessor, at)?;
        primitive.colors = match elements.kind {
            json::accessor::Type::Vec3 => {
                let colors = file.floats::<3>(&elements, at)?;
                colors.into_iter().map(|c| Vec3::from(c).extend(1.0)).collect()
            }
            _ => file.floats::<4>(&elements, at)?.into_iter().map(Vec4::from).collect(),
        };
        same_length(primitive.colors.len(), "COLOR_0")?;
        finite(primitive.colors.iter().all(|color| color.is_finite()), "COLOR_0")?;
    }
    Ok(primitive)
}

/// Indices of a triangle list, all in range. Strips and fans are unrolled (section 3.7.2.1).
fn triangles(
    file: &File,
    source: &json::mesh::Primitive,
    mode: Mode,
    vertices: usize,
    at: &str,
    warnings: &mut Vec<String>,
) -> Result<Vec<u32>> {
    let mut indices: Vec<u32> = match source.indices {
        Some(accessor) => {
            let at = format!("{at}, indices");
            let indices = file.integers::<1>(&file.elements(accessor, &at)?, &at)?;
            indices.into_iter().map(|[index]| index).collect()
        }
        None => {
            let count = u32::try_from(vertices).map_err(|_| file.error(at, "has more vertices than 32 bits count"))?;
            (0..count).collect()
        }
    };
    if let Some(index) = indices.iter().find(|&&index| index as usize >= vertices) {
        return Err(file.error(at, format!("index {index} is out of range: there are {vertices} vertices")));
    }
    if mode == Mode::Triangles {
        let over = indices.len() % 3;
        if over != 0 {
            warnings.push(format!("{at}: its last {over} indices make no triangle and are passed over"));
            indices.truncate(indices.len() - over);
        }
        return Ok(indices);
    }
    file.spend(indices.len() as u64 * 12, at)?;
    Ok(match mode {
        // Every other triangle of a strip is turned.
        Mode::TriangleStrip => {
            let turn = |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] };
            indices.windows(3).enumerate().flat_map(turn).collect()
        }
        _ => match indices.split_first() {
            Some((&hub, rim)) => rim.windows(2).flat_map(|edge| [edge[0], edge[1], hub]).collect(),
            None => Vec::new(),
        },
    })
}

/// Gives every corner a vertex of its own.
fn unshare(primitive: &mut Primitive) {
    fn each<T: Copy>(values: &mut Vec<T>, indices: &[u32]) {
        *values = indices.iter().filter_map(|&index| values.get(index as usize).copied()).collect();
    }
    each(&mut primitive.positions, &primitive.indices);
    each(&mut primitive.colors, &primitive.indices);
    primitive.uvs.iter_mut().for_each(|uvs| each(uvs, &primitive.indices));
    primitive.tangents.clear();
    primitive.indices = (0..primitive.positions.len() as u32).collect();
}

/// Unit length for all; a normal without a direction, or a missing one, is that of the triangles around it.
fn repair_normals(primitive: &mut Primitive) {
    primitive.normals.resize(primitive.positions.len(), Vec3::ZERO);
    let mut bad = false;
    for normal in &mut primitive.normals {
        *normal = normal.normalize_or_zero();
        bad |= *normal == Vec3::ZERO;
    }
    if !bad {
        return;
    }
    let missing: Vec<bool> = primitive.normals.iter().map(|normal| *normal == Vec3::ZERO).collect();
    for corners in primitive.indices.as_chunks::<3>().0 {
        let [a, b, c] = corners.map(|index| primitive.positions[index as usize].as_dvec3());
        // Unit vectors: the cross product of a tiny triangle would vanish in 32 bits.
        let face = (b - a).cross(c - a).normalize_or_zero().as_vec3();
        for &index in corners.iter().filter(|&&index| missing[index as usize]) {
            primitive.normals[index as usize] += face;
        }
    }
    for normal in &mut primitive.normals {
        *normal = normal.try_normalize().unwrap_or(Vec3::Y);
    }
}

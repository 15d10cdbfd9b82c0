//! The node hierarchy: what stands where. glTF 2.0, section 3.5.

use ::gltf::json;
use glam::{DMat4, DQuat, DVec3, Mat4};

use super::{
    File,
    accessor::Index,
    mesh::Meshes,
    names::{Names, first_name},
};
use crate::{
    error::Result,
    geometry::Aabb,
    scene::{Mesh, Object},
};

/// The hierarchy in its rest pose.
pub struct Placed {
    /// Nodes of the scene, parents before children.
    pub order: Vec<usize>,
    /// World matrix of every node that can be reached from a root, by node.
    pub world: Vec<Option<DMat4>>,
}

/// Walks the default scene, or else the first one; then the roots outside it, whose nodes may be joints of a skin.
pub fn hierarchy(file: &File, warnings: &mut Vec<String>) -> Result<Placed> {
    let root = file.root;
    let count = root.nodes.len();
    let mut world = vec![None; count];

    let scene = root.scene.map(|scene| scene.value());
    let roots: Vec<usize> = match (scene, root.scenes.get(scene.unwrap_or(0))) {
        (_, Some(scene)) => scene.nodes.iter().map(|node| node.value()).collect(),
        (Some(scene), None) => {
            let what = format!("is {scene}, but there are {} scenes", root.scenes.len());
            return Err(file.error("scene", what));
        }
        (None, None) => {
            warnings.push("the file has no scene: all its root nodes are shown".into());
            outer_roots(root)
        }
    };
    let order = walk(file, &roots, &mut world)?;
    if !root.skins.is_empty() {
        let others: Vec<usize> = outer_roots(root).into_iter().filter(|&node| world[node].is_none()).collect();
        walk(file, &others, &mut world)?;
    }
    Ok(Placed { order, world })
}

/// Nodes that are nobody's child.
fn outer_roots(root: &json::Root) -> Vec<usize> {
    let mut child = vec![false; root.nodes.len()];
    for index in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if let Some(child) = child.get_mut(index.value()) {
            *child = true;
        }
    }
    (0..child.len()).filter(|&node| !child[node]).collect()
}

/// Depth first, in the order of the file, without recursion: a hierarchy may be as deep as it is long.
fn walk(file: &File, roots: &[usize], world: &mut [Option<DMat4>]) -> Result<Vec<usize>> {
    let nodes = &file.root.nodes;
    let mut order = Vec::new();
    let mut stack: Vec<(usize, DMat4)> = roots.iter().rev().map(|&node| (node, DMat4::IDENTITY)).collect();
    while let Some((index, parent)) = stack.pop() {
        let Some(node) = nodes.get(index) else {
            let what = format!("node {index} is used, but there are {}", nodes.len());
            return Err(file.error("nodes", what));
        };
        let at = || super::place("node", index, node.name.as_ref());
        if world[index].is_some() {
            return Err(file.error(at(), "is reached twice: a node has at most one parent, and no cycle is allowed"));
        }
        let matrix = parent * local(node);
        if !matrix.is_finite() || !matrix.as_mat4().is_finite() {
            return Err(file.error(at(), "has a transform that is not finite"));
        }
        world[index] = Some(matrix);
        order.push(index);
        stack.extend(node.children.iter().flatten().rev().map(|child| (child.value(), matrix)));
    }
    Ok(order)
}

/// Parent from node.
fn local(node: &json::Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector = |v: Option<[f32; 3]>, otherwise| v.map_or(otherwise, |v| DVec3::from_array(v.map(f64::from)));
    transform(
        vector(node.translation, DVec3::ZERO),
        node.rotation.map_or(DQuat::IDENTITY, |r| DQuat::from_array(r.0.map(f64::from))),
        vector(node.scale, DVec3::ONE),
    )
}

/// Translation · rotation · scale. The quaternion is taken as it stands: it should have unit length, and where it has
/// not quite, all viewers show the same.
fn transform(translation: DVec3, rotation: DQuat, scale: DVec3) -> DMat4 {
    let linear = glam::DMat3::from_quat(rotation) * glam::DMat3::from_diagonal(scale);
    DMat4::from_mat3_translation(linear, translation)
}

/// What an instance of a primitive takes, about, until it is on the device.
const BYTES_OF_INSTANCE: usize = 256;

/// Instances of meshes, in the order of the hierarchy.
pub fn objects(file: &File, placed: &Placed, meshes: &Meshes) -> Result<Vec<Object>> {
    let bounds: Vec<Option<Aabb>> = meshes.meshes.iter().map(Mesh::bounds).collect();
    let mut names = Names::default();
    let mut objects = Vec::new();
    for &index in &placed.order {
        let (Some(node), Some(Some(world))) = (file.root.nodes.get(index), placed.world.get(index)) else { continue };
        let Some(mesh) = node.mesh else { continue };
        let at = super::place("node", index, node.name.as_ref());
        let wanted = file.root.meshes.get(mesh.value()).and_then(|mesh| mesh.name.as_ref());
        let wanted = first_name([node.name.as_ref(), wanted], "object");
        let mut add = |mesh: usize, world: DMat4| {
            let world_from_object = world.as_mat4();
            let box_of_mesh = bounds.get(mesh).copied().flatten();
            let end = box_of_mesh.map(|bounds| bounds.transformed(world_from_object));
            if !world_from_object.is_finite() || end.is_some_and(|b| !b.size().is_finite() || !b.min.is_finite()) {
                return Err(file.error(&at, "takes its mesh out of the range of 32-bit floats"));
            }
            let primitives = meshes.meshes.get(mesh).map_or(0, |mesh| mesh.primitives.len());
            file.spend((primitives * BYTES_OF_INSTANCE) as u64, &at)?;
            objects.push(Object { name: names.unique(&wanted), mesh, world_from_object });
            Ok(())
        };
        match (meshes.posed.get(&index), instances(file, node, &at)?) {
            // The joints have put its vertices into world space; the node has no say (section 3.7.3.3).
            (Some(&mesh), _) => add(mesh, DMat4::IDENTITY)?,
            (None, None) => add(mesh.value(), *world)?,
            (None, Some(instances)) => instances.iter().try_for_each(|own| add(mesh.value(), *world * *own))?,
        }
    }
    Ok(objects)
}

/// `EXT_mesh_gpu_instancing`: node from instance, for each instance.
fn instances(file: &File, node: &json::Node, at: &str) -> Result<Option<Vec<DMat4>>> {
    const NAME: &str = "EXT_mesh_gpu_instancing";
    let Some(value) = node.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { return Ok(None) };
    let at = format!("{at}, {NAME}");
    let attribute = |name: &str| -> Result<Option<Index>> {
        let Some(value) = value.get("attributes").and_then(|attributes| attributes.get(name)) else { return Ok(None) };
        let index = value.as_u64().and_then(|index| u32::try_from(index).ok());
        index.map(|index| Some(Index::new(index))).ok_or_else(|| file.error(&at, format!("{name} is no accessor")))
    };
    fn read<const N: usize>(file: &File, index: Option<Index>, at: &str) -> Result<Option<Vec<[f32; N]>>> {
        let Some(index) = index else { return Ok(None) };
        file.floats(&file.elements(index, at)?, at).map(Some)
    }
    let translations = read::<3>(file, attribute("TRANSLATION")?, &at)?;
    let rotations = read::<4>(file, attribute("ROTATION")?, &at)?;
    let scales = read::<3>(file, attribute("SCALE")?, &at)?;
    let counts = [translations.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)];
    let Some(&count) = counts.iter().flatten().next() else {
        return Err(file.error(&at, "has none of TRANSLATION, ROTATION, SCALE"));
    };
    if counts.iter().flatten().any(|&other| other != count) {
        return Err(file.error(&at, "its attributes differ in length"));
    }
    file.spend((count * 2 * size_of::<Object>()) as u64 * 2, &at)?;
    let vector = |v: &Option<Vec<[f32; 3]>>, i: usize, otherwise| {
        v.as_ref().and_then(|v| v.get(i)).map_or(otherwise, |v| DVec3::from_array(v.map(f64::from)))
    };
    let rotation = |i: usize| {
        let rotation = rotations.as_ref().and_then(|r| r.get(i));
        rotation.map_or(DQuat::IDENTITY, |r| DQuat::from_array(r.map(f64::from)))
    };
    let instance =
        |i: usize| transform(vector(&translations, i, DVec3::ZERO), rotation(i), vector(&scales, i, DVec3::ONE));
    Ok(Some((0..count).map(instance).collect()))
}

/// Position and axes of a light or camera: the node's, without scale and mirroring. `None` where the scale leaves no
/// axes.
pub fn rigid(world: DMat4) -> Option<Mat4> {
    let back = world.z_axis.truncate().try_normalize()?;
    let up = world.y_axis.truncate();
    let right = up.cross(back).try_normalize().or_else(|| {
        // Without a second axis any turn about the first one will do.
        Some(back.any_orthonormal_vector())
    })?;
    let axes = glam::DMat3::from_cols(right, back.cross(right), back);
    let matrix = DMat4::from_mat3_translation(axes, world.w_axis.truncate()).as_mat4();
    matrix.is_finite().then_some(matrix)
}

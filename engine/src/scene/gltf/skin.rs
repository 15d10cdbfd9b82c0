//! Skins in their rest pose. glTF 2.0, section 3.7.3.

use ::gltf::json::{mesh::Semantic, validation::Checked};
use glam::{DMat3, DMat4, DVec4};

use super::{File, node::Placed, place};
use crate::{error::Result, scene::Primitive};

/// World from bind space for each joint, by skin. Empty for a skin that no node of the scene uses.
pub fn load(file: &File, placed: &Placed) -> Result<Vec<Vec<DMat4>>> {
    let mut skins = vec![Vec::new(); file.root.skins.len()];
    for node in placed.order.iter().filter_map(|&node| file.root.nodes.get(node)) {
        let Some(index) = node.skin.filter(|_| node.mesh.is_some()) else { continue };
        let Some(matrices) = skins.get_mut(index.value()) else {
            let what = format!("a node uses skin {}, but there are {}", index.value(), file.root.skins.len());
            return Err(file.error("skins", what));
        };
        if matrices.is_empty() {
            *matrices = joints(file, placed, index.value())?;
        }
    }
    Ok(skins)
}

fn joints(file: &File, placed: &Placed, index: usize) -> Result<Vec<DMat4>> {
    let Some(skin) = file.root.skins.get(index) else { return Ok(Vec::new()) };
    let at = place("skin", index, skin.name.as_ref());
    let inverse_bind = match skin.inverse_bind_matrices {
        Some(accessor) => file.floats::<16>(&file.elements(accessor, &at)?, &at)?,
        None => Vec::new(),
    };
    if skin.joints.is_empty() || (skin.inverse_bind_matrices.is_some() && inverse_bind.len() < skin.joints.len()) {
        let what = format!("{} joints, {} inverse bind matrices", skin.joints.len(), inverse_bind.len());
        return Err(file.error(at, format!("{what}: at least one joint, and a matrix for each, is needed")));
    }
    let joints = skin.joints.iter().enumerate().map(|(i, joint)| {
        let Some(Some(world)) = placed.world.get(joint.value()) else {
            return Err(file.error(&at, format!("joint node {} is not part of a hierarchy", joint.value())));
        };
        let bind = inverse_bind.get(i).map_or(DMat4::IDENTITY, |m| DMat4::from_cols_array(&m.map(f64::from)));
        Ok(*world * bind)
    });
    joints.collect()
}

/// Moves positions, normals and tangents to where the joints put them, in world space.
pub fn pose(
    file: &File,
    source: &::gltf::json::mesh::Primitive,
    joints: &[DMat4],
    primitive: &mut Primitive,
    at: &str,
) -> Result<()> {
    let vertices = primitive.positions.len();
    file.spend((vertices * (size_of::<DMat4>() + size_of::<f64>())) as u64, at)?;
    let mut blended = vec![DMat4::ZERO; vertices];
    let mut totals = vec![0.0; blended.len()];
    for set in 0..u32::MAX {
        let attribute = |semantic| source.attributes.get(&Checked::Valid(semantic));
        let (Some(&joint), Some(&weight)) = (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set)))
        else {
            if set == 0 {
                return Err(file.error(at, "has no JOINTS_0 and WEIGHTS_0, but a node gives it a skin"));
            }
            break;
        };
        let indices = file.integers::<4>(&file.elements(joint, at)?, at)?;
        let weights = file.floats::<4>(&file.elements(weight, at)?, at)?;
        if indices.len() != blended.len() || weights.len() != blended.len() {
            return Err(file.error(at, format!("JOINTS_{set} or WEIGHTS_{set} is not as long as POSITION")));
        }
        let corners = indices.iter().zip(&weights).zip(blended.iter_mut().zip(&mut totals));
        for ((indices, weights), (blended, total)) in corners {
            for (&index, &weight) in indices.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
                let Some(joint) = joints.get(index as usize) else {
                    return Err(file.error(at, format!("joint {index} is out of range: there are {}", joints.len())));
                };
                *blended += *joint * f64::from(weight);
                *total += f64::from(weight);
            }
        }
    }

    // A vertex without weights stays with the first joint.
    for (blended, total) in blended.iter_mut().zip(totals) {
        let fallback = joints.first().copied().unwrap_or(DMat4::IDENTITY);
        *blended = if total > 0.0 { *blended * (1.0 / total) } else { fallback };
    }
    for (position, m) in primitive.positions.iter_mut().zip(&blended) {
        *position = m.transform_point3(position.as_dvec3()).as_vec3();
    }
    for (normal, m) in primitive.normals.iter_mut().zip(&blended) {
        let m = DMat3::from_mat4(*m);
        // Cofactors: the inverse transpose up to a factor, also where there is no inverse.
        let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        *normal = (cofactors * normal.as_dvec3()).normalize_or_zero().as_vec3();
    }
    for (tangent, m) in primitive.tangents.iter_mut().zip(&blended) {
        let direction: DVec4 = *m * tangent.as_dvec4().truncate().extend(0.0);
        *tangent = direction.truncate().normalize_or_zero().as_vec3().extend(tangent.w);
    }
    Ok(())
}

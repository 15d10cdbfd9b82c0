//! Cameras. glTF 2.0, section 3.10. The aspect ratio of a file has no say: the picture's is used.

use ::gltf::json::{self, camera::Type, validation::Checked};

use super::{
    File,
    names::{Names, first_name},
    node::{Placed, rigid},
    place,
};
use crate::{
    error::Result,
    scene::{Camera, Projection},
};

/// Cameras of the scene, in the order of the hierarchy.
pub fn load(file: &File, placed: &Placed) -> Result<Vec<Camera>> {
    let mut names = Names::default();
    let mut cameras = Vec::new();
    for &index in &placed.order {
        let (Some(node), Some(Some(world))) = (file.root.nodes.get(index), placed.world.get(index)) else { continue };
        let Some(camera) = node.camera else { continue };
        let at = place("node", index, node.name.as_ref());
        let Some(source) = file.root.cameras.get(camera.value()) else {
            let what = format!("uses camera {}, but there are {}", camera.value(), file.root.cameras.len());
            return Err(file.error(at, what));
        };
        let Some(world_from_view) = rigid(*world) else {
            return Err(file.error(at, "its camera has no direction: the scale of the node is zero"));
        };
        let name = first_name([source.name.as_ref(), node.name.as_ref()], "camera");
        let at = place("camera", camera.value(), source.name.as_ref());
        let projection = projection(source).map_err(|what| file.error(at, what))?;
        cameras.push(Camera { name: names.unique(&name), world_from_view, projection });
    }
    Ok(cameras)
}

fn projection(source: &json::Camera) -> Result<Projection, String> {
    match (source.type_, &source.perspective, &source.orthographic) {
        (Checked::Valid(Type::Perspective), Some(lens), _) => {
            let (fov_y, near, far) = (lens.yfov, lens.znear, lens.zfar);
            let far_fits = far.is_none_or(|far| far.is_finite() && far > near);
            if fov_y > 0.0 && fov_y < std::f32::consts::PI && near > 0.0 && near.is_finite() && far_fits {
                return Ok(Projection::Perspective { fov_y, near, far });
            }
            Err(format!("yfov {fov_y}, znear {near}, zfar {far:?}: 0 < yfov < pi and 0 < znear < zfar are needed"))
        }
        (Checked::Valid(Type::Orthographic), _, Some(lens)) => {
            let (half_height, near, far) = (lens.ymag, lens.znear, lens.zfar);
            if half_height > 0.0 && half_height.is_finite() && near >= 0.0 && far > near && far.is_finite() {
                return Ok(Projection::Orthographic { half_height, near, far });
            }
            Err(format!("ymag {half_height}, znear {near}, zfar {far}: 0 < ymag and 0 <= znear < zfar are needed"))
        }
        _ => Err("is neither a perspective nor an orthographic camera".into()),
    }
}

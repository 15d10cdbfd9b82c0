//! `KHR_lights_punctual`.

use ::gltf::json::{
    extensions::scene::khr_lights_punctual::{Light as Source, Type},
    validation::Checked,
};
use glam::Vec3;

use super::{
    File,
    names::{Names, first_name, layer_name},
    node::{Placed, rigid},
    place,
};
use crate::{
    error::Result,
    scene::{Light, LightKind},
};

/// Lights of the scene, in the order of the hierarchy.
pub fn load(file: &File, placed: &Placed, warnings: &mut Vec<String>) -> Result<Vec<Light>> {
    let mut names = Names::default();
    let mut lights = Vec::new();
    let sources = file.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let sources = sources.map_or(&[][..], |lights| &lights.lights);
    for &index in &placed.order {
        let (Some(node), Some(Some(world))) = (file.root.nodes.get(index), placed.world.get(index)) else { continue };
        let Some(light) = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()) else { continue };
        let at = place("node", index, node.name.as_ref());
        let Some(source) = sources.get(light.light.value()) else {
            let what = format!("uses light {}, but there are {}", light.light.value(), sources.len());
            return Err(file.error(at, what));
        };
        let at = place("light", light.light.value(), source.name.as_ref());
        let axes = rigid(*world);
        if axes.is_none() && source.type_ != Checked::Valid(Type::Point) {
            warnings.push(format!("{at}: a zero scale leaves it no direction; it shines along -z"));
        }
        let position = world.w_axis.truncate().as_vec3();
        let direction = axes.map_or(Vec3::NEG_Z, |axes| -axes.z_axis.truncate());
        let name = first_name([source.name.as_ref(), node.name.as_ref()], "light");
        lights.push(Light {
            name: names.unique(&layer_name(&name)),
            color: color(file, source, &at)?,
            kind: kind(file, source, position, direction, &at, warnings)?,
        });
    }
    Ok(lights)
}

fn color(file: &File, source: &Source, at: &str) -> Result<Vec3> {
    let color = Vec3::from(source.color);
    if color.is_finite() && color.min_element() >= 0.0 {
        return Ok(color);
    }
    Err(file.error(at, format!("its color {:?} is not three finite numbers from 0", source.color)))
}

fn kind(
    file: &File,
    source: &Source,
    position: Vec3,
    direction: Vec3,
    at: &str,
    warnings: &mut Vec<String>,
) -> Result<LightKind> {
    let intensity = source.intensity;
    if !(intensity.is_finite() && intensity >= 0.0) {
        return Err(file.error(at, format!("its intensity {intensity} is not a finite number from 0")));
    }
    let range = match source.range {
        None => f32::INFINITY,
        Some(range) if range > 0.0 => range,
        Some(range) => {
            warnings.push(format!("{at}: its range {range} is not above 0; it is taken as unlimited"));
            f32::INFINITY
        }
    };
    match source.type_ {
        Checked::Valid(Type::Directional) => Ok(LightKind::Directional { direction, illuminance: intensity }),
        Checked::Valid(Type::Point) => Ok(LightKind::Point { position, intensity, range }),
        Checked::Valid(Type::Spot) => {
            let spot = source.spot.clone().unwrap_or_default();
            let (inner, outer) = (spot.inner_cone_angle, spot.outer_cone_angle);
            if !(inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= std::f32::consts::FRAC_PI_2 + 1e-6) {
                let what = format!("cone angles {inner} and {outer}: 0 <= inner < outer <= pi/2 is needed");
                return Err(file.error(at, what));
            }
            Ok(LightKind::Spot { position, direction, intensity, range, inner, outer })
        }
        Checked::Invalid => Err(file.error(at, "its type is none of directional, point, spot")),
    }
}

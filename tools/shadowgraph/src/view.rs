//! Which camera looks, and which sun shines.

use glam::Vec3;
use shadowgraph::geometry::Aabb;
use shadowgraph::scene::{Camera, Light, LightKind, Scene};

use crate::arguments::Sun;
use crate::cli::FrameArguments;
use crate::failure::{Failure, Result};

/// Vertical field of view where none is given, radians.
const FIELD_OF_VIEW: f32 = std::f32::consts::FRAC_PI_3;

/// The camera that the arguments ask for.
pub fn camera(arguments: &FrameArguments, scene: &Scene) -> Result<Camera> {
    let bounds = scene.bounds().unwrap_or(Aabb { min: Vec3::ZERO, max: Vec3::ZERO });
    if let Some(wanted) = &arguments.camera {
        return named(wanted, &scene.cameras);
    }
    let fov = arguments.fov.unwrap_or(FIELD_OF_VIEW);
    if let Some(eye) = arguments.eye {
        let target = arguments.target.unwrap_or(bounds.center());
        if eye == target {
            return Err(Failure::input("--eye and --target are the same point: there is no direction to look in"));
        }
        return Ok(Camera::look_at(eye, target, arguments.up.unwrap_or(Vec3::Y), fov, Camera::near_for(bounds, eye)));
    }
    let [width, height] = arguments.size.0;
    let framing = || Camera::framing(bounds, fov, width as f32 / height as f32);
    Ok(scene.cameras.first().cloned().unwrap_or_else(framing))
}

/// A camera by name, or by index where none has this name.
pub fn named(wanted: &str, cameras: &[Camera]) -> Result<Camera> {
    let by_name = cameras.iter().find(|camera| camera.name == wanted);
    let by_index = || wanted.parse::<usize>().ok().and_then(|index| cameras.get(index));
    by_name.or_else(by_index).cloned().ok_or_else(|| {
        let known: Vec<_> = cameras.iter().enumerate().map(|(i, camera)| format!("{i} ({})", camera.name)).collect();
        let known = if known.is_empty() { "no cameras".into() } else { known.join(", ") };
        Failure::input(format!("unknown camera {wanted:?}; the scene has {known}"))
    })
}

/// Puts a sun in place of directional lights, or into a scene without any light.
pub fn set_sun(scene: &mut Scene, wanted: Option<Sun>) {
    let mut sun = Light::default_sun();
    match wanted {
        Some(wanted) => {
            scene.lights.retain(|light| !matches!(light.kind, LightKind::Directional { .. }));
            sun.kind = LightKind::Directional { direction: wanted.direction, illuminance: wanted.illuminance };
        }
        None if scene.lights.is_empty() => {}
        None => return,
    }
    let taken = |name: &str| scene.lights.iter().any(|light| light.name == name);
    let numbered = (2..).map(|number| format!("sun{number}"));
    sun.name = std::iter::once(sun.name).chain(numbered).find(|name| !taken(name)).unwrap_or_default();
    scene.lights.insert(0, sun);
}

/// Luminance of a clear sky that goes with the scene's sun, cd/m²: a sky that lights the ground with about a sixth of
/// what the sun does. 0 where there is no sun.
pub fn sky(scene: &Scene) -> f32 {
    let suns = scene.lights.iter().map(|light| match light.kind {
        LightKind::Directional { illuminance, .. } => illuminance,
        _ => 0.0,
    });
    suns.fold(0.0, f32::max) * 0.05
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn light(name: &str, kind: LightKind) -> Light {
        Light { name: name.into(), color: Vec3::ONE, kind }
    }

    const POINT: LightKind = LightKind::Point { position: Vec3::ZERO, intensity: 1.0, range: f32::INFINITY };
    const DOWN: LightKind = LightKind::Directional { direction: Vec3::NEG_Y, illuminance: 7.0 };

    #[test]
    fn a_scene_without_light_gets_a_sun() {
        let mut scene = Scene::default();
        set_sun(&mut scene, None);
        assert_eq!((scene.lights.len(), scene.lights[0].name.as_str()), (1, "sun"));
        let mut lit = Scene { lights: vec![light("lamp", POINT)], ..Scene::default() };
        set_sun(&mut lit, None);
        assert_eq!(lit.lights.len(), 1);
        assert_eq!(sky(&lit), 0.0);
    }

    #[test]
    fn a_wanted_sun_replaces_directional_lights_only() {
        let mut scene = Scene { lights: vec![light("sun", POINT), light("moon", DOWN)], ..Scene::default() };
        set_sun(&mut scene, Some(Sun { direction: Vec3::X, illuminance: 5.0 }));
        let names: Vec<_> = scene.lights.iter().map(|light| light.name.as_str()).collect();
        assert_eq!(names, ["sun2", "sun"]);
        assert_eq!(sky(&scene), 0.25);
    }

    #[test]
    fn cameras_are_found_by_name_then_by_index() {
        let camera =
            |name: &str| Camera { name: name.into(), ..Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0, 0.1) };
        let cameras = [camera("a"), camera("0")];
        assert_eq!(named("a", &cameras).unwrap().name, "a");
        assert_eq!(named("0", &cameras).unwrap().name, "0");
        assert_eq!(named("1", &cameras).unwrap().name, "0");
        let error = named("b", &cameras).unwrap_err().to_string();
        assert!(error.contains("0 (a), 1 (0)"), "{error}");
        assert!(named("0", &[]).unwrap_err().to_string().contains("no cameras"));
    }
}

//! Scenes made in code: sizes, promises of their geometry, and the same bytes on every run.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hash::{DefaultHasher, Hash, Hasher};

use glam::Vec3;
use shadowgraph::scene::{AlphaMode, LightKind, Scene, builtin};

fn all() -> Vec<Scene> {
    builtin::NAMES.iter().map(|name| Scene::builtin(name).unwrap()).collect()
}

#[test]
fn the_courtyard_is_large_enough() {
    let scene = builtin::courtyard();
    assert!(scene.triangle_count() >= 100_000, "{} triangles", scene.triangle_count());
    let textured = scene.materials.iter().filter(|material| material.base_color_texture.is_some());
    assert!(textured.clone().count() >= 12, "{} textured materials", textured.count());
    let count = |mode: fn(&AlphaMode) -> bool| scene.materials.iter().filter(|m| mode(&m.alpha_mode)).count();
    assert!(count(|mode| matches!(mode, AlphaMode::Mask { .. })) >= 3);
    assert!(count(|mode| *mode == AlphaMode::Blend) >= 5);
    assert!(scene.materials.iter().any(|m| m.double_sided && m.alpha_mode == AlphaMode::Opaque), "no cloth");
    assert!(scene.cameras.len() >= 2);
    let kinds = |kind: fn(&LightKind) -> bool| scene.lights.iter().filter(|light| kind(&light.kind)).count();
    assert_eq!(kinds(|kind| matches!(kind, LightKind::Directional { .. })), 1);
    assert!(kinds(|kind| matches!(kind, LightKind::Spot { .. })) >= 2);
    assert_eq!(kinds(|kind| matches!(kind, LightKind::Point { .. })), 1);
    // Every texture is used.
    let mut used = vec![false; scene.textures.len()];
    for material in &scene.materials {
        let slots = [material.base_color_texture, material.normal_texture, material.metallic_roughness_texture];
        slots.into_iter().flatten().for_each(|slot| used[slot.texture] = true);
    }
    assert!(used.iter().all(|&used| used));
    // And every material.
    let mut used = vec![false; scene.materials.len()];
    scene.meshes.iter().flat_map(|mesh| &mesh.primitives).for_each(|primitive| used[primitive.material] = true);
    assert!(used.iter().all(|&used| used), "{used:?}");
}

#[test]
fn the_cornell_box_has_its_measures() {
    let scene = builtin::cornell();
    assert_eq!(scene.triangle_count(), 32);
    let size = scene.bounds().unwrap().size();
    assert!((size - Vec3::new(0.556, 0.5488, 0.5592)).length() < 1e-5, "{size}");
    // Closed but for the side of the camera: rays from the middle of the room meet a front face everywhere else.
    let middle = Vec3::new(0.0, 0.4, 0.1);
    for direction in [Vec3::NEG_X, Vec3::X, Vec3::NEG_Y, Vec3::Y, Vec3::NEG_Z] {
        let nearest = triangles(&scene).filter_map(|t| hit(middle, direction, t)).min_by(|a, b| a.0.total_cmp(&b.0));
        let (_, front) = nearest.unwrap();
        assert!(front, "{direction} meets a back face");
    }
    let view = scene.cameras[0].view([512, 512]);
    let corner = view.clip_from_world() * Vec3::new(-0.2748, 0.0, 0.28).extend(1.0);
    assert!((corner.x / corner.w).abs() < 1.0 && (corner.y / corner.w).abs() < 1.0, "the camera misses the room");
}

#[test]
fn geometry_keeps_its_promises() {
    for scene in all() {
        let names: std::collections::HashSet<_> = scene.objects.iter().map(|object| &object.name).collect();
        assert_eq!(names.len(), scene.objects.len(), "{}: names occur twice", scene.name);
        let lights: std::collections::HashSet<_> = scene.lights.iter().map(|light| &light.name).collect();
        assert!(lights.len() == scene.lights.len() && lights.iter().all(|name| !name.contains('.')));
        for object in &scene.objects {
            assert!(object.world_from_object.determinant() > 0.0, "{} mirrors", object.name);
        }
        for mesh in &scene.meshes {
            for primitive in &mesh.primitives {
                let at = format!("{}, {}, {}", scene.name, mesh.name, scene.materials[primitive.material].name);
                let count = primitive.positions.len();
                assert!(!primitive.indices.is_empty(), "{at}: empty");
                assert_eq!([primitive.normals.len(), primitive.tangents.len(), primitive.colors.len()], [count; 3]);
                assert_eq!([primitive.uvs[0].len(), primitive.uvs[1].len()], [count; 2]);
                assert!(primitive.positions.iter().all(|p| p.is_finite()), "{at}");
                assert!(primitive.uvs[0].iter().all(|uv| uv.is_finite()), "{at}");
                for (normal, tangent) in primitive.normals.iter().zip(&primitive.tangents) {
                    assert!((normal.length() - 1.0).abs() < 1e-4, "{at}: normal {normal}");
                    assert!((tangent.truncate().length() - 1.0).abs() < 1e-4, "{at}: tangent {tangent}");
                    assert!(normal.dot(tangent.truncate()).abs() < 1e-3, "{at}: {normal} {tangent}");
                    assert!(tangent.w.abs() == 1.0, "{at}");
                }
                for triangle in primitive.indices.as_chunks::<3>().0 {
                    assert!(triangle.iter().all(|&index| (index as usize) < count), "{at}: index out of range");
                    let [a, b, c] = triangle.map(|index| primitive.positions[index as usize]);
                    let face = (b - a).cross(c - a);
                    assert!(face.length() > 0.0, "{at}: a triangle without area");
                    let mean: Vec3 = triangle.iter().map(|&index| primitive.normals[index as usize]).sum();
                    assert!(face.dot(mean) > 0.0, "{at}: winding and normals disagree at {a}");
                }
            }
        }
    }
}

#[test]
fn two_runs_give_the_same_bytes() {
    for name in builtin::NAMES {
        let digest = || {
            let scene = Scene::builtin(name).unwrap();
            let mut hasher = DefaultHasher::new();
            scene.textures.iter().for_each(|texture| texture.pixels.hash(&mut hasher));
            // Debug output of floats is exact.
            format!("{:?}{:?}{:?}", scene.materials, scene.objects, scene.lights).hash(&mut hasher);
            for primitive in scene.meshes.iter().flat_map(|mesh| &mesh.primitives) {
                let floats = primitive.positions.iter().chain(&primitive.normals).flat_map(|v| v.to_array());
                floats.for_each(|value| value.to_bits().hash(&mut hasher));
                primitive.indices.hash(&mut hasher);
            }
            hasher.finish()
        };
        assert_eq!(digest(), digest(), "{name}");
    }
}

#[test]
fn an_unknown_name_lists_the_known_ones() {
    let error = Scene::builtin("sponza").unwrap_err().to_string();
    assert!(error.contains("sponza") && error.contains("cornell, courtyard"), "{error}");
}

fn triangles(scene: &Scene) -> impl Iterator<Item = [Vec3; 3]> {
    scene.objects.iter().flat_map(|object| {
        scene.meshes[object.mesh].primitives.iter().flat_map(move |primitive| {
            let at = |index: u32| object.world_from_object.transform_point3(primitive.positions[index as usize]);
            primitive.indices.as_chunks::<3>().0.iter().map(move |t| t.map(at))
        })
    })
}

/// Distance along a ray, and whether the front is met.
fn hit(origin: Vec3, direction: Vec3, [a, b, c]: [Vec3; 3]) -> Option<(f32, bool)> {
    let normal = (b - a).cross(c - a);
    let t = (a - origin).dot(normal) / direction.dot(normal);
    let p = origin + direction * t;
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(p0, p1)| (*p1 - *p0).cross(p - *p0).dot(normal) >= 0.0);
    (t.is_finite() && t > 0.0 && inside).then_some((t, direction.dot(normal) < 0.0))
}

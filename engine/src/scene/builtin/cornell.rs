//! The Cornell box, after the measurements published by the Cornell University Program of Computer Graphics
//! (<https://www.graphics.cornell.edu/online/box/data.html>), in metres.

use glam::{Mat4, Vec3, Vec4};

use super::shapes::Shape;
use crate::scene::{Camera, Light, LightKind, Material, Mesh, Object, Scene};

/// The Cornell box: a room 55 cm wide with a red and a green wall, two white blocks, a square lamp in the ceiling as
/// an emissive surface and, as light cast by punctual lights, a spot below it.
///
/// The middle of the floor is the origin; the open side faces +z, where the camera stands.
pub fn cornell() -> Scene {
    // The original runs x to the left and z away from the eye, from a corner of the floor.
    let point = |[x, y, z]: [f32; 3]| Vec3::new(278.0 - x, y, 280.0 - z) * 1e-3;
    let quad = |corners: [[f32; 3]; 4]| {
        let mut shape = Shape::new();
        shape.quad(corners.map(point));
        shape
    };

    let matte = |name: &str, [r, g, b]: [f32; 3]| Material {
        name: name.into(),
        base_color: Vec4::new(r, g, b, 1.0),
        metallic: 0.0,
        roughness: 1.0,
        ..Material::default()
    };
    let materials = vec![
        matte("white", [0.73, 0.71, 0.68]),
        matte("red", [0.61, 0.056, 0.062]),
        matte("green", [0.117, 0.435, 0.115]),
        // The lamp's radiance is 2,000 cd/m²; the spot below gives the light that it would cast.
        Material { emissive: Vec3::new(1.0, 0.67, 0.28) * 2000.0, ..matte("lamp", [0.78, 0.78, 0.78]) },
    ];

    let floor = quad([[552.8, 0., 0.], [0., 0., 0.], [0., 0., 559.2], [549.6, 0., 559.2]]);
    let back = quad([[549.6, 0., 559.2], [0., 0., 559.2], [0., 548.8, 559.2], [556., 548.8, 559.2]]);
    let right = quad([[0., 0., 559.2], [0., 0., 0.], [0., 548.8, 0.], [0., 548.8, 559.2]]);
    let left = quad([[552.8, 0., 0.], [549.6, 0., 559.2], [556., 548.8, 559.2], [556., 548.8, 0.]]);
    let lamp = quad([[343., 548.7, 332.], [213., 548.7, 332.], [213., 548.7, 227.], [343., 548.7, 227.]]);

    // The ceiling leaves no hole for the lamp, which hangs a tenth of a millimetre below.
    let ceiling = quad([[556., 548.8, 559.2], [0., 548.8, 559.2], [0., 548.8, 0.], [556., 548.8, 0.]]);

    // Footprints of the blocks; what runs clockwise in the original's frame is counter-clockwise in ours.
    let short = block([[130., 65.], [82., 225.], [240., 272.], [290., 114.]], 165.0, point);
    let tall = block([[265., 296.], [314., 456.], [472., 406.], [423., 247.]], 330.0, point);

    let parts = [
        ("floor", floor, 0),
        ("ceiling", ceiling, 0),
        ("back wall", back, 0),
        ("right wall", right, 2),
        ("left wall", left, 1),
        ("lamp", lamp, 3),
        ("short block", short, 0),
        ("tall block", tall, 0),
    ];
    let mut scene = Scene { name: "cornell".into(), materials, ..Scene::default() };
    for (mesh, (name, shape, material)) in parts.into_iter().enumerate() {
        scene.meshes.push(Mesh { name: name.into(), primitives: vec![shape.primitive(material)] });
        scene.objects.push(Object { name: name.into(), mesh, world_from_object: Mat4::IDENTITY });
    }

    scene.lights.push(Light {
        name: "lamp".into(),
        color: Vec3::new(1.0, 0.78, 0.5),
        kind: LightKind::Spot {
            position: point([278., 545., 279.5]),
            direction: Vec3::NEG_Y,
            // Area times radiance: 0.0137 m² of lamp.
            intensity: 27.0,
            range: f32::INFINITY,
            inner: 0.6,
            outer: 1.25,
        },
    });
    scene.cameras.push(Camera {
        name: "front".into(),
        // A film 25 mm high behind a lens of 35 mm.
        ..Camera::look_at(
            point([278., 273., -800.]),
            point([278., 273., 0.]),
            Vec3::Y,
            2.0 * (12.5f32 / 35.0).atan(),
            0.1,
        )
    });
    scene
}

/// Four walls and a lid over a footprint (x, z).
fn block(footprint: [[f32; 2]; 4], height: f32, point: impl Fn([f32; 3]) -> Vec3) -> Shape {
    let at = |i: usize, y: f32| point([footprint[i % 4][0], y, footprint[i % 4][1]]);
    let mut shape = Shape::new();
    for i in 0..4 {
        shape.quad([at(i, 0.0), at(i + 1, 0.0), at(i + 1, height), at(i, height)]);
    }
    shape.quad([at(0, height), at(1, height), at(2, height), at(3, height)]);
    shape
}

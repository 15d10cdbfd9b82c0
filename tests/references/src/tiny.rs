//! Scenes of a few triangles whose pictures and shadows can be worked out by hand.

use glam::{Mat4, Vec2, Vec3, Vec4};
use shadowgraph::scene::{Filter, Light, LightKind, Material, Mesh, Object, Primitive, Scene, Texture, Wrap};

/// A texture of one texel, RGBA.
pub fn texel(name: &str, rgba: [u8; 4]) -> Texture {
    Texture {
        name: name.into(),
        size: [1; 2],
        pixels: rgba.to_vec().into(),
        wrap: [Wrap::Repeat; 2],
        magnify: Filter::Nearest,
        minify: Filter::Nearest,
        mip: None,
    }
}

/// A scene with one material, white and rough, and nothing in it.
pub fn empty() -> Scene {
    let material = Material { metallic: 0.0, ..Material::default() };
    Scene { name: "tiny".into(), materials: vec![material], ..Scene::default() }
}

/// A scene of these parts.
pub fn one(name: &str, parts: Vec<(Primitive, Mat4)>) -> Scene {
    let mut scene = empty();
    scene.name = name.into();
    for (primitive, world_from_object) in parts {
        add(&mut scene, primitive, world_from_object);
    }
    scene
}

/// Adds an instance of a mesh of one primitive, and gives the index of the object.
pub fn add(scene: &mut Scene, primitive: Primitive, world_from_object: Mat4) -> usize {
    let mesh = scene.meshes.len();
    scene.meshes.push(Mesh { name: format!("mesh {mesh}"), primitives: vec![primitive] });
    scene.objects.push(Object { name: format!("object {}", scene.objects.len()), mesh, world_from_object });
    scene.objects.len() - 1
}

/// Triangles with flat normals, no texture coordinates and white vertices.
pub fn triangles(corners: &[[Vec3; 3]], material: usize) -> Primitive {
    let positions: Vec<Vec3> = corners.concat();
    let normals = corners.iter().flat_map(|[a, b, c]| [(*b - *a).cross(*c - *a).normalize_or_zero(); 3]).collect();
    let count = positions.len();
    Primitive {
        positions,
        normals,
        tangents: vec![Vec4::ZERO; count],
        uvs: [vec![Vec2::ZERO; count], vec![Vec2::ZERO; count]],
        colors: vec![Vec4::ONE; count],
        indices: (0..count as u32).collect(),
        material,
    }
}

/// A parallelogram seen from the front where `right` × `up` points to the viewer. Texture coordinates run along
/// `right` and against `up`; tangents along `right`.
pub fn quad(corner: Vec3, right: Vec3, up: Vec3, material: usize) -> Primitive {
    let [a, b, c, d] = [corner, corner + right, corner + right + up, corner + up];
    let mut quad = triangles(&[[a, b, c], [a, c, d]], material);
    let uv = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0]].map(Vec2::from);
    quad.uvs = [uv.to_vec(), uv.to_vec()];
    quad.tangents = vec![right.normalize().extend(1.0); 6];
    quad
}

/// A box from `min` to `max`, its faces outwards.
pub fn cuboid(min: Vec3, max: Vec3, material: usize) -> Primitive {
    let corner = |k: usize| {
        let pick = |axis: usize| if k >> axis & 1 == 0 { min[axis] } else { max[axis] };
        Vec3::new(pick(0), pick(1), pick(2))
    };
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let corners: Vec<_> =
        faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|triangle| triangle.map(corner)).collect();
    triangles(&corners, material)
}

/// A unit sphere of `2 · segments · (rings − 1)` triangles with smooth normals, its poles on the y axis.
pub fn sphere(segments: u32, rings: u32, material: usize) -> Primitive {
    let mut sphere = Primitive { material, ..Primitive::default() };
    for i in 0..=rings {
        for k in 0..=segments {
            let (theta, phi) =
                (std::f32::consts::PI * i as f32 / rings as f32, std::f32::consts::TAU * k as f32 / segments as f32);
            let (ring, height) = if i % rings == 0 { (0.0, theta.cos().round()) } else { theta.sin_cos() };
            let p = Vec3::new(ring * phi.sin(), height, ring * phi.cos());
            sphere.positions.push(p);
            sphere.normals.push(p);
            sphere.tangents.push(Vec4::new(phi.cos(), 0.0, -phi.sin(), 1.0));
            let uv = Vec2::new(k as f32 / segments as f32, i as f32 / rings as f32);
            sphere.uvs.iter_mut().for_each(|set| set.push(uv));
            sphere.colors.push(Vec4::ONE);
        }
    }
    let at = |i: u32, k: u32| i * (segments + 1) + k;
    for i in 0..rings {
        for k in 0..segments {
            if i > 0 {
                sphere.indices.extend([at(i, k), at(i + 1, k), at(i, k + 1)]);
            }
            if i + 1 < rings {
                sphere.indices.extend([at(i, k + 1), at(i + 1, k), at(i + 1, k + 1)]);
            }
        }
    }
    sphere
}

/// A sun of 1 lux, white.
pub fn sun(direction: Vec3) -> Light {
    let kind = LightKind::Directional { direction: direction.normalize(), illuminance: 1.0 };
    Light { name: "sun".into(), color: Vec3::ONE, kind }
}

/// A spot light of 1 cd, white, without range.
pub fn spot(position: Vec3, direction: Vec3, inner: f32, outer: f32) -> Light {
    let direction = direction.normalize();
    let kind = LightKind::Spot { position, direction, intensity: 1.0, range: f32::INFINITY, inner, outer };
    Light { name: "spot".into(), color: Vec3::ONE, kind }
}

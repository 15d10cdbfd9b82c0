//! Alpha, texture coordinates, levels and normal maps.

use glam::{DVec3, Mat3, Mat4, Vec2, Vec3, Vec4};
use shadowgraph::scene::{
    AlphaMode, Camera as Lens, Filter, Projection, Scene as Source, Texture, TextureSlot, View, Wrap,
};

use crate::tiny;
use crate::twin::camera::{Picture, Tolerance, cast};
use crate::twin::scene::{Footprint, Ray, Rule, Scene};

/// 16 × 16 pixels of 1 × 1 m from above z = 0.
fn view() -> View {
    let mut lens = Lens::look_at(Vec3::Z * 4.0, Vec3::ZERO, Vec3::Y, 1.0, 1.0);
    lens.projection = Projection::Orthographic { half_height: 8.0, near: 1.0, far: 9.0 };
    lens.view([16, 16])
}

fn picture_of(source: &Source) -> Picture {
    cast(&Scene::new(source), &view(), Tolerance::default())
}

/// Fills the picture; texture coordinates 0 to 1 from the upper left.
fn sheet(z: f32, material: usize) -> shadowgraph::scene::Primitive {
    tiny::quad(Vec3::new(-8.0, -8.0, z), Vec3::X * 16.0, Vec3::Y * 16.0, material)
}

fn texture(
    source: &mut Source,
    size: [u32; 2],
    texel: impl Fn(u32, u32) -> [u8; 4],
    mip: Option<Filter>,
) -> TextureSlot {
    let pixels: Vec<u8> =
        (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).flat_map(|(x, y)| texel(x, y)).collect();
    let (magnify, minify) = (Filter::Nearest, Filter::Nearest);
    source.textures.push(Texture {
        name: "t".into(),
        size,
        pixels: pixels.into(),
        wrap: [Wrap::Repeat; 2],
        magnify,
        minify,
        mip,
    });
    TextureSlot { texture: source.textures.len() - 1, uv_set: 0, transform: Mat3::IDENTITY }
}

#[test]
fn masks_have_holes_and_blends_are_passed_over() {
    let mut source = tiny::empty();
    let left_half = |x: u32, _| [255, 255, 255, if x < 2 { 255 } else { 0 }];
    let slot = texture(&mut source, [4, 1], left_half, None);
    let mut mask = source.materials[0].clone();
    mask.base_color_texture = Some(slot);
    mask.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    let mut blend = source.materials[0].clone();
    blend.alpha_mode = AlphaMode::Blend;
    source.materials.extend([mask, blend]);
    tiny::add(&mut source, sheet(2.0, 2), Mat4::IDENTITY);
    tiny::add(&mut source, sheet(1.0, 1), Mat4::IDENTITY);
    tiny::add(&mut source, sheet(0.0, 0), Mat4::IDENTITY);
    let ids = |picture: &Picture, x| picture.at(x, 2).surface.as_ref().unwrap().ids[0];
    let picture = picture_of(&source);
    assert_eq!((ids(&picture, 7), ids(&picture, 8)), (2, 3));
    // The factor counts too: 0.4 · 1 is below the cutoff, 0.5 · 1 is not, but so near that rounding may decide.
    source.materials[1].base_color.w = 0.4;
    assert_eq!(ids(&picture_of(&source), 7), 3);
    source.materials[1].base_color.w = 0.5;
    assert_eq!(ids(&picture_of(&source), 7), 2);
    assert!(picture_of(&source).at(7, 2).near_edge && !picture.at(7, 2).near_edge);

    let scene = Scene::new(&source);
    let shadow = |x: f64| scene.any(&Ray { far: 2.5, ..Ray::new(DVec3::new(x, 1.0, 0.5), DVec3::Z) }, Rule::SHADOW);
    assert_eq!((shadow(-1.0), shadow(1.0)), (true, false));
}

#[test]
fn texture_coordinates_are_transformed_and_vertex_colours_multiplied() {
    let mut source = tiny::empty();
    let mut slot = texture(&mut source, [16, 16], |x, y| [255, 255, 255, (x * 16 + y) as u8], None);
    // KHR_texture_transform: scale (0.5, 1), then offset (0.25, 0).
    slot.transform = Mat3::from_translation(Vec2::new(0.25, 0.0)) * Mat3::from_scale(Vec2::new(0.5, 1.0));
    source.materials[0].base_color_texture = Some(slot);
    source.materials[0].base_color = Vec4::new(0.5, 1.0, 1.0, 1.0);
    let mut primitive = sheet(0.0, 0);
    primitive.colors = vec![Vec4::new(0.5, 0.25, 1.0, 1.0); 6];
    tiny::add(&mut source, primitive, Mat4::IDENTITY);
    let picture = picture_of(&source);
    for (x, y) in [(0_u32, 0_u32), (5, 3), (15, 15)] {
        let color = picture.at(x, y).surface.as_ref().unwrap().base_color;
        let texel = ((2 * x + 1) / 4 + 4) * 16 + y;
        assert!((color.w * 255.0 - f64::from(texel)).abs() < 1e-9, "{x} {y}: {color}");
        assert!(color.truncate().distance(DVec3::new(0.25, 0.25, 1.0)) < 1e-12);
    }
}

#[test]
fn pixels_read_the_level_whose_texels_are_their_size() {
    // Level 0 red, and by averaging grey levels: alpha tells the level. 64 texels over 16 pixels: level 2.
    let mut source = tiny::empty();
    let slot =
        texture(&mut source, [64, 64], |x, _| [255, 255, 255, if x % 2 == 0 { 255 } else { 0 }], Some(Filter::Nearest));
    source.materials[0].base_color_texture = Some(slot);
    tiny::add(&mut source, sheet(0.0, 0), Mat4::IDENTITY);
    let alpha = |source: &Source| picture_of(source).at(3, 12).surface.as_ref().unwrap().base_color.w;
    assert!((alpha(&source) - 128.0 / 255.0).abs() < 1e-9);
    // 8 texels over 16 pixels magnify.
    source.materials[0].base_color_texture.as_mut().unwrap().transform = Mat3::from_scale(Vec2::splat(0.125));
    assert!([0.0, 1.0].contains(&alpha(&source)));

    // A shadow texel of 1 m covers four texels of the whole texture too; a point covers none.
    source.materials[0].base_color_texture.as_mut().unwrap().transform = Mat3::IDENTITY;
    source.materials[0].alpha_mode = AlphaMode::Mask { cutoff: 0.4 };
    let scene = Scene::new(&source);
    let holes = |footprint| {
        let down =
            |k: i32| Ray { footprint, ..Ray::new(DVec3::new(f64::from(k) * 0.25 - 7.9, 1.0, 1.0), DVec3::NEG_Z) };
        (0..60).filter(|&k| !scene.any(&down(k), Rule::SHADOW)).count()
    };
    assert_eq!((holes(Footprint::Width(1.0)), holes(Footprint::Point)), (0, 30));
}

#[test]
fn normal_maps_turn_normals_in_tangent_space() {
    // One texel that leans towards +u by 3-4-5: (0.6, 0, 0.8) up to 8 bits.
    let build = |transform: Mat4, double_sided: bool, scale: f32, texel: [u8; 4]| {
        let mut source = tiny::empty();
        let slot = texture(&mut source, [1, 1], |_, _| texel, None);
        source.materials[0].normal_texture = Some(slot);
        source.materials[0].normal_scale = scale;
        source.materials[0].double_sided = double_sided;
        tiny::add(&mut source, sheet(0.0, 0), transform);
        picture_of(&source).at(5, 9).surface.as_ref().unwrap().normal
    };
    let (along_u, along_v) = ([204, 128, 230, 255], [128, 204, 230, 255]);
    let near = |a: DVec3, b: [f64; 3]| assert!(a.distance(DVec3::from(b)) < 0.01, "{a} not {b:?}");
    near(build(Mat4::IDENTITY, false, 1.0, along_u), [0.6, 0.0, 0.8]);
    // Bitangent: normal × tangent, which is +y here.
    near(build(Mat4::IDENTITY, false, 1.0, along_v), [0.0, 0.6, 0.8]);
    near(build(Mat4::IDENTITY, false, 0.5, along_u), [0.351, 0.0, 0.936]);
    // Mirrored in x: u runs to −x, v still along +y.
    let mirror = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    near(build(mirror, false, 1.0, along_u), [-0.6, 0.0, 0.8]);
    near(build(mirror, false, 1.0, along_v), [0.0, 0.6, 0.8]);
    // From behind: turned half about y, the front leans to −x and −z; its reverse is seen.
    let turn = Mat4::from_rotation_y(std::f32::consts::PI);
    near(build(turn, true, 1.0, along_u), [0.6, 0.0, 0.8]);
    near(build(turn, true, 1.0, along_v), [0.0, -0.6, 0.8]);
}

#[test]
fn factors_and_textures_make_the_rest_of_the_material() {
    let mut source = tiny::empty();
    let slot = texture(&mut source, [1, 1], |_, _| [102, 51, 204, 255], None);
    let m = &mut source.materials[0];
    (m.metallic, m.roughness, m.occlusion_strength, m.emissive) = (0.5, 0.5, 0.5, Vec3::splat(10.0));
    (m.metallic_roughness_texture, m.occlusion_texture, m.emissive_texture) = (Some(slot), Some(slot), Some(slot));
    tiny::add(&mut source, sheet(0.0, 0), Mat4::IDENTITY);
    let picture = picture_of(&source);
    let s = picture.at(1, 5).surface.as_ref().unwrap();
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} not {b}");
    near(s.roughness, 0.1);
    near(s.metallic, 0.4);
    near(s.occlusion, 1.0 + 0.5 * (0.4 - 1.0));
    // 102 / 255 in sRGB is 0.13287 in linear light.
    assert!((s.emissive.x - 1.3287).abs() < 1e-4);
}

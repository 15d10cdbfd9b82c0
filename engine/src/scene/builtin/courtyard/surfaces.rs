//! Materials of the courtyard and their textures.

use glam::{Vec2, Vec4, vec3};

use super::patterns::*;
use crate::parallel;

use crate::scene::{
    AlphaMode, Material, Texture,
    builtin::{
        paint::{Painting, Texel, slot},
        random::Noise,
    },
};

/// Materials by their index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Surface {
    Ashlar,
    Paving,
    Marble,
    Brick,
    Planks,
    RoofTile,
    Plaster,
    Azulejo,
    Bronze,
    Terracotta,
    Bark,
    Earth,
    Leaves,
    Ivy,
    Flowers,
    BannerCloth,
    SailCloth,
    Water,
    StainedGlass,
    FallingWater,
    RedGlass,
    AmberGlass,
    GreenGlass,
    BlueGlass,
    VioletGlass,
    Lamp,
}

/// What a surface is painted with.
struct Recipe {
    surface: Surface,
    name: &'static str,
    /// Texels a side; 0 for a surface without textures.
    size: u32,
    /// Metres that the texture covers.
    extent: Vec2,
    texel: fn(&Noise, Vec2) -> Texel,
    normal: bool,
    metallic_roughness: bool,
    material: Material,
}

/// All materials, in the order of [`Surface`], and their textures.
pub fn materials() -> (Vec<Material>, Vec<Texture>) {
    let recipes = recipes();
    let noise = Noise::new(7);
    // Painting cannot fail.
    let painted: Result<Vec<_>, ()> = parallel::map(
        recipes.len(),
        |i| {
            let recipe = &recipes[i];
            let painting = Painting::new(recipe.size, recipe.extent, |p| (recipe.texel)(&noise, p));
            let name = |map: &str| format!("{} {map}", recipe.name);
            let base = (recipe.size > 0).then(|| painting.base_color(&name("base colour")));
            let normal = recipe.normal.then(|| painting.normal(&name("normal")));
            let rough = recipe.metallic_roughness.then(|| painting.metallic_roughness(&name("roughness")));
            Ok([base, normal, rough])
        },
        |_| (),
    );
    let mut textures = Vec::new();
    let mut materials = Vec::new();
    for (recipe, [base, normal, rough]) in recipes.into_iter().zip(painted.unwrap_or_default()) {
        let mut used = |texture: Option<Texture>| {
            textures.push(texture?);
            Some(slot(textures.len() - 1, recipe.extent))
        };
        materials.push(Material {
            name: recipe.name.into(),
            base_color_texture: used(base),
            normal_texture: used(normal),
            metallic_roughness_texture: used(rough),
            ..recipe.material
        });
    }
    (materials, textures)
}

fn recipes() -> Vec<Recipe> {
    // A texture that says how rough it is has factors of 1.
    let matte = |roughness: f32| Material { metallic: 0.0, roughness, ..Material::default() };
    let mapped = || Material { metallic: 1.0, roughness: 1.0, ..Material::default() };
    let both_sides = |roughness: f32| Material { double_sided: true, ..matte(roughness) };
    let cutout = || Material { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, ..both_sides(0.7) };
    let painted = |surface, name, size, extent: [f32; 2], texel, normal, metallic_roughness, material| Recipe {
        surface,
        name,
        size,
        extent: extent.into(),
        texel,
        normal,
        metallic_roughness,
        material,
    };
    let plain =
        |surface, name, material| painted(surface, name, 0, [1.0; 2], |_, _| Texel::default(), false, false, material);
    let glass = |surface, name, [r, g, b]: [f32; 3], alpha: f32| {
        let base_color = Vec4::new(r, g, b, alpha);
        let alpha_mode = AlphaMode::Blend;
        plain(surface, name, Material { base_color, transmission: 0.9, alpha_mode, ..both_sides(0.08) })
    };
    let mut recipes = vec![
        painted(Surface::Ashlar, "ashlar", 256, [3.0, 2.4], ashlar, true, false, matte(0.9)),
        painted(Surface::Paving, "paving", 512, [3.6, 3.6], paving, true, true, mapped()),
        painted(Surface::Marble, "marble", 256, [2.0, 2.0], marble, false, true, mapped()),
        painted(Surface::Brick, "brick", 256, [1.25, 1.2], brick, true, false, matte(0.92)),
        painted(Surface::Planks, "planks", 256, [2.4, 2.4], planks, true, false, matte(0.75)),
        painted(Surface::RoofTile, "roof tile", 256, [1.5, 1.5], roof_tile, false, false, matte(0.85)),
        painted(Surface::Plaster, "plaster", 256, [3.5, 3.5], plaster, true, false, matte(0.95)),
        painted(Surface::Azulejo, "azulejo", 256, [0.44, 0.44], azulejo, true, true, mapped()),
        painted(Surface::Bronze, "bronze", 256, [0.8, 0.8], bronze, false, true, mapped()),
        painted(Surface::Terracotta, "terracotta", 256, [0.9, 0.9], terracotta, true, false, matte(0.8)),
        painted(Surface::Bark, "bark", 256, [0.8, 0.8], bark, true, false, matte(0.95)),
        painted(Surface::Earth, "earth", 256, [1.2, 1.2], earth, true, false, matte(1.0)),
        painted(Surface::Leaves, "leaves", 256, [1.0, 1.0], leaves, false, false, cutout()),
        painted(Surface::Ivy, "ivy", 256, [1.0, 1.0], ivy, false, false, cutout()),
        painted(Surface::Flowers, "flowers", 256, [1.0, 1.0], flowers, false, false, cutout()),
        painted(Surface::BannerCloth, "banner cloth", 256, [1.0, 1.0], banner, true, false, both_sides(0.85)),
        painted(Surface::SailCloth, "sail cloth", 256, [2.0, 2.0], sail, true, false, both_sides(0.9)),
        painted(
            Surface::Water,
            "water",
            256,
            [1.6, 1.6],
            water,
            true,
            false,
            Material { alpha_mode: AlphaMode::Blend, ..matte(0.06) },
        ),
        painted(
            Surface::StainedGlass,
            "stained glass",
            256,
            [0.8, 0.8],
            stained_glass,
            true,
            false,
            Material { transmission: 0.9, alpha_mode: AlphaMode::Blend, ..both_sides(0.15) },
        ),
        plain(
            Surface::FallingWater,
            "falling water",
            Material { base_color: Vec4::new(0.75, 0.85, 0.88, 0.22), alpha_mode: AlphaMode::Blend, ..both_sides(0.1) },
        ),
        glass(Surface::RedGlass, "red glass", [0.75, 0.03, 0.03], 0.55),
        glass(Surface::AmberGlass, "amber glass", [0.95, 0.5, 0.04], 0.5),
        glass(Surface::GreenGlass, "green glass", [0.05, 0.5, 0.12], 0.55),
        glass(Surface::BlueGlass, "blue glass", [0.03, 0.12, 0.75], 0.55),
        glass(Surface::VioletGlass, "violet glass", [0.4, 0.05, 0.55], 0.5),
        plain(Surface::Lamp, "lamp", Material { emissive: vec3(1.0, 0.72, 0.35) * 12_000.0, ..matte(1.0) }),
    ];
    recipes.sort_by_key(|recipe| recipe.surface as usize);
    recipes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_stand_in_the_order_of_the_surfaces() {
        for (index, recipe) in recipes().iter().enumerate() {
            assert_eq!(recipe.surface as usize, index, "{}: one is missing before it", recipe.name);
        }
    }
}

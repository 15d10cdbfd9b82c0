//! Materials. glTF 2.0, section 3.9.

use std::collections::HashMap;

use ::gltf::json::{self, extensions::texture::TextureTransform, validation::Checked};
use glam::{Mat3, Vec2, Vec3, Vec4};

use super::{
    File,
    names::{Names, first_name},
    place,
};
use crate::{
    error::Result,
    scene::{AlphaMode, Material, TextureSlot},
};

/// Materials of a file and the textures that they use.
pub struct Materials {
    /// In the order of the file.
    pub materials: Vec<Material>,
    /// What to decode; a [`TextureSlot`] is an index into it.
    pub textures: Vec<UsedTexture>,
}

/// An image with a sampler that some material uses.
#[derive(Clone)]
pub struct UsedTexture {
    /// Index of the image.
    pub image: usize,
    /// Index of the sampler; `None` is the default sampler.
    pub sampler: Option<usize>,
    /// Name of the texture or of its image.
    pub name: String,
    /// The first material that uses it, for messages.
    pub user: String,
}

/// Reads all materials.
pub fn load(file: &File, warnings: &mut Vec<String>) -> Result<Materials> {
    let mut names = Names::default();
    let mut slots = Slots { file, textures: Vec::new(), found: HashMap::new(), warnings };
    let mut materials = Vec::with_capacity(file.root.materials.len());
    for (index, source) in file.root.materials.iter().enumerate() {
        let at = place("material", index, source.name.as_ref());
        let name = names.unique(&first_name([source.name.as_ref()], "material"));
        materials.push(Material { name, ..material(&mut slots, source, &at)? });
    }
    Ok(Materials { materials, textures: slots.textures })
}

fn material(slots: &mut Slots, source: &json::Material, at: &str) -> Result<Material> {
    let file = slots.file;
    let pbr = &source.pbr_metallic_roughness;
    let extensions = source.extensions.as_ref();
    let strength = extensions.and_then(|e| e.emissive_strength.as_ref()).map_or(1.0, |e| e.emissive_strength.0);
    let Checked::Valid(alpha_mode) = source.alpha_mode else {
        return Err(file.error(at, "alphaMode is none of OPAQUE, MASK, BLEND"));
    };
    let mut transmission = extensions.and_then(|e| e.transmission.as_ref());
    if alpha_mode == json::material::AlphaMode::Mask && transmission.is_some() {
        slots.warnings.push(format!("{at}: transmission has no effect on a material with an alpha cutoff"));
        transmission = None;
    }
    let material = Material {
        name: String::new(),
        base_color: Vec4::from(pbr.base_color_factor.0),
        base_color_texture: slots.info(&pbr.base_color_texture, at, "baseColorTexture")?,
        metallic: pbr.metallic_factor.0,
        roughness: pbr.roughness_factor.0,
        metallic_roughness_texture: slots.info(&pbr.metallic_roughness_texture, at, "metallicRoughnessTexture")?,
        normal_texture: match &source.normal_texture {
            Some(normal) => {
                let transform = normal.extensions.as_ref().and_then(|e| e.others.get("KHR_texture_transform"));
                let transform = slots.parsed(transform, at)?;
                slots.slot(normal.index, normal.tex_coord, transform.as_ref(), at, "normalTexture")?
            }
            None => None,
        },
        normal_scale: source.normal_texture.as_ref().map_or(1.0, |normal| normal.scale),
        occlusion_texture: match &source.occlusion_texture {
            Some(occlusion) => {
                let transform = occlusion.extensions.as_ref().and_then(|e| e.others.get("KHR_texture_transform"));
                let transform = slots.parsed(transform, at)?;
                slots.slot(occlusion.index, occlusion.tex_coord, transform.as_ref(), at, "occlusionTexture")?
            }
            None => None,
        },
        occlusion_strength: source.occlusion_texture.as_ref().map_or(1.0, |occlusion| occlusion.strength.0),
        emissive: Vec3::from(source.emissive_factor.0) * strength,
        emissive_texture: slots.info(&source.emissive_texture, at, "emissiveTexture")?,
        transmission: transmission.map_or(0.0, |transmission| transmission.transmission_factor.0),
        transmission_texture: match transmission {
            Some(transmission) => slots.info(&transmission.transmission_texture, at, "transmissionTexture")?,
            None => None,
        },
        alpha_mode: match alpha_mode {
            json::material::AlphaMode::Opaque => AlphaMode::Opaque,
            json::material::AlphaMode::Mask => AlphaMode::Mask { cutoff: source.alpha_cutoff.unwrap_or_default().0 },
            json::material::AlphaMode::Blend => AlphaMode::Blend,
        },
        double_sided: source.double_sided,
        unlit: extensions.is_some_and(|e| e.unlit.is_some()),
    };
    let cutoff = if let AlphaMode::Mask { cutoff } = material.alpha_mode { cutoff } else { 0.0 };
    let Material { metallic, roughness, normal_scale, occlusion_strength, transmission, .. } = material;
    let factors = [metallic, roughness, normal_scale, occlusion_strength, transmission, cutoff];
    if !(material.base_color.is_finite() && material.emissive.is_finite() && factors.iter().all(|f| f.is_finite())) {
        return Err(file.error(at, "a factor is not a finite number"));
    }
    Ok(material)
}

/// Collects the textures that materials use.
struct Slots<'a> {
    file: &'a File<'a>,
    textures: Vec<UsedTexture>,
    found: HashMap<(usize, Option<usize>), usize>,
    warnings: &'a mut Vec<String>,
}

impl Slots<'_> {
    fn info(&mut self, info: &Option<json::texture::Info>, at: &str, what: &str) -> Result<Option<TextureSlot>> {
        let Some(info) = info else { return Ok(None) };
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        self.slot(info.index, info.tex_coord, transform, at, what)
    }

    fn slot(
        &mut self,
        index: json::Index<json::Texture>,
        uv_set: u32,
        transform: Option<&TextureTransform>,
        at: &str,
        what: &str,
    ) -> Result<Option<TextureSlot>> {
        let root = self.file.root;
        let fail = |what: String| self.file.error(at, what);
        let Some(texture) = root.textures.get(index.value()) else {
            return Err(fail(format!("{what} is texture {}, but there are {}", index.value(), root.textures.len())));
        };
        let image = texture.source.value();
        let Some(source) = root.images.get(image) else {
            let why = if image == u32::MAX as usize {
                "has no image in PNG or JPEG".into()
            } else {
                format!("uses image {image}, but there are {}", root.images.len())
            };
            return Err(fail(format!("{what}: texture {} {why}", index.value())));
        };
        let sampler = texture.sampler.map(|sampler| sampler.value());
        if let Some(sampler) = sampler.filter(|&sampler| sampler >= root.samplers.len()) {
            return Err(fail(format!("{what} uses sampler {sampler}, but there are {}", root.samplers.len())));
        }

        let uv_set = transform.and_then(|transform| transform.tex_coord).unwrap_or(uv_set);
        if uv_set > 1 {
            let warning =
                format!("{at}: {what} is left out: it uses TEXCOORD_{uv_set}, and only 0 and 1 are supported");
            self.warnings.push(warning);
            return Ok(None);
        }
        let transform = transform.map_or(Mat3::IDENTITY, matrix);
        if !transform.is_finite() {
            return Err(fail(format!("{what}: KHR_texture_transform is not finite")));
        }
        let texture = *self.found.entry((image, sampler)).or_insert_with(|| {
            let uri = source.uri.as_ref().filter(|uri| !uri.starts_with("data:"));
            let name = first_name([texture.name.as_ref(), source.name.as_ref(), uri], "texture");
            self.textures.push(UsedTexture { image, sampler, name, user: at.to_owned() });
            self.textures.len() - 1
        });
        Ok(Some(TextureSlot { texture, uv_set: uv_set as usize, transform }))
    }

    fn parsed(&self, value: Option<&json::Value>, at: &str) -> Result<Option<TextureTransform>> {
        let Some(value) = value else { return Ok(None) };
        let parsed = json::deserialize::from_value(value.clone());
        parsed.map(Some).map_err(|error| self.file.error(at, format!("KHR_texture_transform: {error}")))
    }
}

/// Translation · rotation · scale of (u, v, 1). With v pointing down, the rotation is counter-clockwise to the eye.
fn matrix(transform: &TextureTransform) -> Mat3 {
    Mat3::from_translation(Vec2::from(transform.offset.0))
        * Mat3::from_angle(-transform.rotation.0)
        * Mat3::from_scale(Vec2::from(transform.scale.0))
}

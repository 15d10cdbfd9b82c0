//! Metallic-roughness materials, as glTF 2.0 defines them.

use glam::{Mat3, Vec3, Vec4};

/// A material: glTF 2.0, section 3.9, with `KHR_materials_unlit`, `KHR_materials_emissive_strength`, and
/// `KHR_materials_transmission` for thin and clear surfaces: what passes is multiplied by the base colour, neither
/// refracted nor blurred by roughness.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name made unique in the scene.
    pub name: String,
    /// Linear RGBA factor.
    pub base_color: Vec4,
    /// sRGB-encoded RGBA.
    pub base_color_texture: Option<TextureSlot>,
    /// Factor, 0 to 1.
    pub metallic: f32,
    /// Perceptual roughness factor, 0 to 1.
    pub roughness: f32,
    /// Roughness in G, metallic in B, linear.
    pub metallic_roughness_texture: Option<TextureSlot>,
    /// Tangent space, linear.
    pub normal_texture: Option<TextureSlot>,
    /// Scale of the normal map's x and y.
    pub normal_scale: f32,
    /// Occlusion in R, linear.
    pub occlusion_texture: Option<TextureSlot>,
    /// 0 (none) to 1.
    pub occlusion_strength: f32,
    /// Linear radiance factor in cd/m², emissive strength included.
    pub emissive: Vec3,
    /// sRGB-encoded RGB.
    pub emissive_texture: Option<TextureSlot>,
    /// Share of the light that enters the surface and passes through it rather than being diffused, 0 to 1. Materials with
    /// an alpha cutoff have none.
    pub transmission: f32,
    /// Transmission in R, linear.
    pub transmission_texture: Option<TextureSlot>,
    /// How alpha is meant.
    pub alpha_mode: AlphaMode,
    /// Back faces are seen, with the normal turned.
    pub double_sided: bool,
    /// Base colour is the picture: no lighting.
    pub unlit: bool,
}

impl Default for Material {
    /// glTF's default material: white, metallic 1, roughness 1.
    fn default() -> Self {
        Self {
            name: "default".into(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            transmission: 0.0,
            transmission_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
        }
    }
}

impl Material {
    /// Whether what lies behind shows through: it is composited.
    pub fn is_blended(&self) -> bool {
        match self.alpha_mode {
            AlphaMode::Opaque => self.transmission > 0.0,
            AlphaMode::Mask { .. } => false,
            AlphaMode::Blend | AlphaMode::Premultiplied | AlphaMode::Add => true,
        }
    }

    /// Whether light that passes through is multiplied channel by channel.
    pub fn is_transmissive(&self) -> bool {
        self.is_blended() && self.transmission > 0.0
    }
}

/// How a material's alpha is meant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Ignored.
    Opaque,
    /// Texels below the cutoff are not there.
    Mask {
        /// Alpha at and above which a texel is there.
        cutoff: f32,
    },
    /// Composited over what lies behind.
    Blend,
    /// The same, with a base colour that is multiplied by alpha already. glTF has no such materials.
    Premultiplied,
    /// Added to what lies behind, times alpha, and hides nothing. glTF has no such materials.
    Add,
}

/// Use of a texture by a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureSlot {
    /// Index into [`crate::scene::Scene::textures`].
    pub texture: usize,
    /// 0 or 1.
    pub uv_set: usize,
    /// `KHR_texture_transform`: maps (u, v, 1).
    pub transform: Mat3,
}

/// An image with its sampler. An image used by several samplers appears once for each.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Name, for messages.
    pub name: String,
    /// Width and height in texels.
    pub size: [u32; 2],
    /// RGBA, 8 bits a channel, rows from the top; as stored in the file, not yet decoded from sRGB.
    pub pixels: std::sync::Arc<[u8]>,
    /// u and v.
    pub wrap: [Wrap; 2],
    /// Magnification.
    pub magnify: Filter,
    /// Minification within a mip level.
    pub minify: Filter,
    /// Between mip levels; `None` samples level 0 only.
    pub mip: Option<Filter>,
}

/// What lies beyond the edge of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// Again.
    Repeat,
    /// Again, mirrored.
    MirroredRepeat,
    /// The edge texel.
    ClampToEdge,
}

/// Texture filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Filter {
    /// Nearest texel.
    Nearest,
    /// Linear interpolation.
    Linear,
}

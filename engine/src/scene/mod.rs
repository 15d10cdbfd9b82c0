//! Scenes: what a frame is made of, on the host. Metres, radians, linear Rec. 709 radiometry in glTF's units,
//! y up, right-handed.

mod bounds;
pub mod builtin;
mod camera;
mod depth_only;
mod draw;
mod gltf;
mod light;
mod light_buffer;
mod material;
mod mesh;
mod mips;
mod textures;
mod upload;
mod view_set;

pub use camera::{Camera, Projection, View, depth};
pub use draw::{ALPHA_TESTED, Draw, DrawClass, DrawList, Faces, POSITIONS, SHADED};
pub use light::{Light, LightKind};
pub use light_buffer::{LightShadow, MAX_LIGHTS, light_block};
pub use material::{AlphaMode, Filter, Material, Texture, TextureSlot, Wrap};
pub use mesh::{Mesh, Object, Primitive};
pub use upload::GpuScene;
pub use view_set::{MAX_VIEWS, Region, ViewSet};

/// A scene in host memory.
///
/// Made by [`Scene::load`] or [`Scene::builtin`].
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// File stem or built-in name.
    pub name: String,
    /// Shared geometry.
    pub meshes: Vec<Mesh>,
    /// Materials; a primitive without one uses [`Material::default`], which importers add at the end.
    pub materials: Vec<Material>,
    /// Decoded images.
    pub textures: Vec<Texture>,
    /// Instances of meshes, in a fixed order: `id.object` is the index plus 1.
    pub objects: Vec<Object>,
    /// Lights.
    pub lights: Vec<Light>,
    /// Cameras.
    pub cameras: Vec<Camera>,
    /// What was passed over while loading, a sentence each (a skipped point list, an unknown optional extension).
    pub warnings: Vec<String>,
}

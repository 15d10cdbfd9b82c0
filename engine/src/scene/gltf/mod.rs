//! glTF 2.0 import.
//!
//! The `gltf` crate gives the JSON schema. Everything a file points to (buffers, accessors, nodes, images) is checked
//! here before it is followed, so that no file can cause a panic, a hang, or an allocation out of proportion.

mod accessor;
mod buffer;
mod camera;
mod container;
mod light;
mod material;
mod mesh;
mod names;
mod node;
mod skin;
mod tangents;
mod texture;
mod uri;

use std::{
    collections::HashSet,
    fmt::Display,
    path::Path,
    sync::atomic::{AtomicU64, Ordering},
};

use ::gltf::json;

use super::Scene;
use crate::error::{Error, Result};

impl Scene {
    /// Loads a glTF 2.0 file (`.gltf` or `.glb`): its default scene in its rest pose, or else its first scene.
    ///
    /// Meshes of the file keep their order; a skinned mesh is posed and appended. Points, lines, morph targets,
    /// animations and unsupported optional extensions are passed over with a sentence in [`Scene::warnings`].
    ///
    /// # Errors
    /// [`Error::Scene`] names the file and the place in it that is wrong or not supported; [`Error::Io`] names a file
    /// that cannot be read.
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        load(path.as_ref())
    }
}

fn load(path: &Path) -> Result<Scene> {
    // 1. The container, with versions and required extensions checked.
    let bytes = uri::read_file(path, FILE_LIMIT)?;
    let container::Container { root, binary } = container::open(path, &bytes)?;
    let mut warnings = passed_over(&root);

    // 2. Buffers, and from here on a file whose accessors can be read.
    let buffers = buffer::load(path, &root, binary)?;
    let stored: u64 = buffers.iter().map(|buffer| buffer.len() as u64).sum();
    let budget = Budget(AtomicU64::new(DECODED_FLOOR + stored.saturating_mul(DECODED_PER_STORED)));
    let file = File { path, root: &root, buffers: &buffers, budget: &budget };

    // 3. Materials tell which textures are used; those are decoded.
    let material::Materials { mut materials, textures } = material::load(&file, &mut warnings)?;
    let textures = texture::load(&file, &textures)?;

    // 4. The node hierarchy tells what stands where.
    let placed = node::hierarchy(&file, &mut warnings)?;

    // 5. Meshes, posed where they have a skin.
    let skins = skin::load(&file, &placed)?;
    let meshes = mesh::load(&file, &mut materials, &placed, &skins, &mut warnings)?;

    // 6. Objects, lights and cameras.
    let objects = node::objects(&file, &placed, &meshes)?;
    let lights = light::load(&file, &placed, &mut warnings)?;
    let cameras = camera::load(&file, &placed)?;

    let name = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
    Ok(Scene { name, meshes: meshes.meshes, materials, textures, objects, lights, cameras, warnings })
}

/// Bytes read of one file at most.
const FILE_LIMIT: u64 = 8 << 30;
/// Bytes of decoded geometry that any file may ask for.
const DECODED_FLOOR: u64 = 1 << 30;
/// And how many more for each byte of its buffers.
const DECODED_PER_STORED: u64 = 64;

/// A file with its buffers in memory.
#[derive(Clone, Copy)]
struct File<'a> {
    path: &'a Path,
    root: &'a json::Root,
    buffers: &'a [std::borrow::Cow<'a, [u8]>],
    budget: &'a Budget,
}

impl File<'_> {
    fn error(&self, place: impl Display, what: impl Into<String>) -> Error {
        scene_error(self.path, place, what)
    }

    /// Accounts for memory that is about to be allocated for decoded data.
    fn spend(&self, bytes: u64, place: impl Display) -> Result<()> {
        let spend = |left: u64| left.checked_sub(bytes);
        self.budget.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, spend).map(drop).map_err(|left| {
            let what = format!(
                "asks for {bytes} bytes where {left} are left; a file may decode to 1 GiB and {DECODED_PER_STORED} \
                 times its buffers"
            );
            self.error(place, what)
        })
    }
}

/// Bytes that may still be decoded.
struct Budget(AtomicU64);

fn scene_error(path: &Path, place: impl Display, what: impl Into<String>) -> Error {
    Error::Scene { file: path.to_owned(), place: place.to_string(), what: what.into() }
}

/// `mesh 3 "Cube"`, or `mesh 3` where it has no name.
fn place(kind: &str, index: usize, name: Option<&String>) -> String {
    match name {
        Some(name) if !name.is_empty() => format!("{kind} {index} {:?}", uri::short(name)),
        _ => format!("{kind} {index}"),
    }
}

/// Sentences on what of the file is not taken in, for the file as a whole.
fn passed_over(root: &json::Root) -> Vec<String> {
    let mut said = HashSet::new();
    let unknown = root.extensions_used.iter().filter(|e| !container::SUPPORTED.contains(&e.as_str()));
    let once = unknown.filter(|extension| said.insert(extension.as_str()));
    let mut warnings: Vec<String> =
        once.map(|e| format!("the optional extension {} is not supported and has no effect", uri::short(e))).collect();
    if !root.animations.is_empty() {
        let count = root.animations.len();
        warnings.push(format!("{count} animations are passed over: the scene is in its rest pose"));
    }
    warnings
}

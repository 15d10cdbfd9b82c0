//! The two containers of a glTF file: `.gltf` (JSON alone) and `.glb` (JSON and the first buffer).
//! glTF 2.0, chapter 4.

use std::path::Path;

use ::gltf::json;

use super::scene_error;
use crate::error::Result;

/// Extensions whose meaning is taken in.
pub const SUPPORTED: [&str; 7] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// JSON and, of a `.glb`, the binary chunk.
pub struct Container<'a> {
    /// Parsed, not yet checked.
    pub root: json::Root,
    /// Data of the first buffer where that has no URI.
    pub binary: Option<&'a [u8]>,
}

/// Reads the container and refuses versions and required extensions that are not supported.
pub fn open<'a>(path: &Path, bytes: &'a [u8]) -> Result<Container<'a>> {
    let (text, binary) = if bytes.starts_with(b"glTF") {
        chunks(bytes).map_err(|what| scene_error(path, "GLB container", what))?
    } else {
        (bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), None)
    };
    // What does not even begin as one of the two is some other file.
    if binary.is_none() && !text.trim_ascii_start().starts_with(b"{") {
        let what = "is neither binary glTF (which begins with `glTF`) nor JSON; scenes are glTF 2.0, .gltf or .glb";
        return Err(scene_error(path, "container", what));
    }
    let text = std::str::from_utf8(text).map_err(|e| scene_error(path, "JSON", format!("not UTF-8: {e}")))?;
    let text = text.trim_end_matches('\0');

    // Versions and extensions come first: what they change may not fit the rest of the schema.
    let head: Head = json::deserialize::from_str(text).map_err(|e| scene_error(path, "JSON", e.to_string()))?;
    check(path, &head)?;
    let root = json::deserialize::from_str(text).map_err(|e| scene_error(path, "JSON", e.to_string()))?;
    Ok(Container { root, binary })
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    asset: Asset,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
struct Asset {
    version: String,
    min_version: Option<String>,
}

fn check(path: &Path, head: &Head) -> Result<()> {
    let Asset { version, min_version } = &head.asset;
    if version.split('.').next() != Some("2") || min_version.as_ref().is_some_and(|v| v != "2.0") {
        let version = min_version.as_ref().unwrap_or(version);
        return Err(scene_error(path, "asset", format!("glTF version {version:?}; only 2.0 is supported")));
    }
    let unknown: Vec<_> = head.extensions_required.iter().filter(|e| !SUPPORTED.contains(&e.as_str())).collect();
    if !unknown.is_empty() {
        let names = unknown.iter().map(|e| e.as_str()).collect::<Vec<_>>().join(", ");
        let what = format!("required extension not supported: {names}; supported are {}", SUPPORTED.join(", "));
        return Err(scene_error(path, "extensionsRequired", what));
    }
    Ok(())
}

/// JSON and binary chunk of a `.glb`; further chunks are passed over, as the specification asks.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let word = |at: usize| bytes.get(at..)?.first_chunk().map(|b| u32::from_le_bytes(*b) as usize);
    let (Some(version), Some(length)) = (word(4), word(8)) else { return Err("cut off in its header".into()) };
    if version != 2 {
        return Err(format!("version {version}; only version 2 is supported"));
    }
    let bytes = bytes.get(..length).ok_or(format!("says {length} bytes, but has {}", bytes.len()))?;
    // Kind, data, and where the next one starts.
    type Chunk<'a> = Option<(&'a [u8], &'a [u8], usize)>;
    let chunk = |at: usize| -> Result<Chunk, String> {
        let Some(head) = bytes.get(at..).filter(|rest| !rest.is_empty()) else { return Ok(None) };
        let (Some(length), Some(kind)) = (head.first_chunk::<4>(), head.get(4..8)) else {
            return Err(format!("cut off in the head of the chunk at byte {at}"));
        };
        let length = u32::from_le_bytes(*length) as usize;
        let data = head[8..].get(..length);
        let data =
            data.ok_or(format!("the chunk at byte {at} says {length} bytes, but {} are left", head.len() - 8))?;
        // Chunks start on multiples of four bytes.
        Ok(Some((kind, data, (at + 8 + length).next_multiple_of(4))))
    };
    let Some((b"JSON", text, next)) = chunk(12)? else { return Err("the first chunk is not JSON".into()) };
    let binary = match chunk(next)? {
        Some((b"BIN\0", data, _)) => Some(data),
        _ => None,
    };
    Ok((text, binary))
}

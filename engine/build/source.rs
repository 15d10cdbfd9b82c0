//! The tree of GLSL files: what there is, what includes what, and hashes of it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::files;

/// What messages call the root folder.
pub const ROOT: &str = "shaders_glsl";

/// Stage of a shader file, by its extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// `.vert`
    Vertex,
    /// `.geom`
    Geometry,
    /// `.frag`
    Fragment,
    /// `.comp`
    Compute,
}

/// One GLSL file.
pub struct File {
    /// Its text.
    pub text: String,
    /// Stage; an include file (`.glsl`) has none.
    pub stage: Option<Stage>,
    /// Hash of the text.
    hash: String,
}

/// Every GLSL file below a folder, by its path relative to it.
#[derive(Default)]
pub struct Tree {
    /// The files.
    pub files: BTreeMap<String, File>,
}

impl Tree {
    /// Reads every file below `root`.
    pub fn read(root: &Path) -> Result<Self, Vec<String>> {
        let mut tree = Self::default();
        let mut problems = Vec::new();
        for path in files::list(root).map_err(|problem| vec![problem])? {
            match File::read(root, &path) {
                Ok(Some(file)) => drop(tree.files.insert(path, file)),
                Ok(None) => {}
                Err(problem) => problems.push(problem),
            }
        }
        if problems.is_empty() { Ok(tree) } else { Err(problems) }
    }

    /// Shaders, without the include files.
    pub fn shaders(&self) -> impl Iterator<Item = (&str, Stage)> {
        self.files.iter().filter_map(|(path, file)| Some((path.as_str(), file.stage?)))
    }

    /// The file that `#include "name"` means in `from`: one below the root, else one next to `from`.
    pub fn resolve(&self, name: &str, from: &str) -> Option<&str> {
        let beside = match from.rsplit_once('/') {
            Some((folder, _)) => normalize(&format!("{folder}/{name}")),
            None => normalize(name),
        };
        [normalize(name), beside]
            .into_iter()
            .flatten()
            .find_map(|path| self.files.get_key_value(&path).map(|(path, _)| path.as_str()))
    }

    /// `path` and all it includes, directly or not.
    pub fn closure<'a>(&'a self, path: &'a str) -> BTreeSet<&'a str> {
        let mut found = BTreeSet::new();
        let mut open = vec![path];
        while let Some(path) = open.pop() {
            if let Some(file) = self.files.get(path).filter(|_| found.insert(path)) {
                open.extend(includes(&file.text).filter_map(|name| self.resolve(name, path)));
            }
        }
        found
    }

    /// Hash of a shader's name, its text and the text of all it includes; `salt` is hashed with them.
    pub fn key(&self, path: &str, salt: &str) -> String {
        let parts = self.closure(path).into_iter().flat_map(|path| [path, &self.files[path].hash]);
        hash([salt, path].into_iter().chain(parts))
    }

    /// Hash of all files.
    pub fn hash(&self) -> String {
        hash(self.files.iter().flat_map(|(path, file)| [path.as_str(), &file.hash]))
    }
}

impl File {
    /// `None` where the file is documentation.
    fn read(root: &Path, path: &str) -> Result<Option<Self>, String> {
        let stage = match path.rsplit_once('.').map(|(_, extension)| extension) {
            Some("glsl") => None,
            Some("vert") => Some(Stage::Vertex),
            Some("geom") => Some(Stage::Geometry),
            Some("frag") => Some(Stage::Fragment),
            Some("comp") => Some(Stage::Compute),
            Some("md") => return Ok(None),
            _ => {
                return Err(format!(
                    "{ROOT}/{path}: unknown kind of file; shaders end in .vert, .geom, .frag or .comp, include files in .glsl"
                ));
            }
        };
        let bytes = files::read(&root.join(path))?;
        let text = String::from_utf8(bytes).map_err(|_| format!("{ROOT}/{path}: not UTF-8"))?;
        // The compiler takes C strings.
        if let Some(line) = text.lines().position(|line| line.contains('\0')) {
            return Err(format!("{ROOT}/{path}:{}: a NUL character", line + 1));
        }
        let hash = hash([text.as_str()]);
        Ok(Some(Self { text, stage, hash }))
    }
}

/// Names in `#include` lines. Those in comments and switched-off branches are found too: that can only make a key
/// depend on more than it must.
fn includes(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| {
        let rest = line.trim_start().strip_prefix('#')?.trim_start().strip_prefix("include")?.trim_start();
        let close = match rest.chars().next()? {
            '"' => '"',
            '<' => '>',
            _ => return None,
        };
        rest[1..].split_once(close).map(|(name, _)| name)
    })
}

/// Resolves `.` and `..`; `None` where the path leaves the root.
fn normalize(path: &str) -> Option<String> {
    let mut parts = Vec::new();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()?),
            part => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

/// 128-bit FNV-1a: the same on every machine and with every compiler. The length of a part goes before it, so that
/// parts cannot run into each other.
fn hash<'a>(parts: impl IntoIterator<Item = &'a str>) -> String {
    let mut hash: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    for part in parts {
        for byte in (part.len() as u64).to_le_bytes().iter().chain(part.as_bytes()) {
            hash = (hash ^ u128::from(*byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
        }
    }
    format!("{hash:032x}")
}

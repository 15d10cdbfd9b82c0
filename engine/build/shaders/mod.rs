//! Compiles and reflects every shader, and writes the Rust that names them.

pub mod block;
pub mod compile;
pub mod generate;
pub mod name;
pub mod reflect;
pub mod scalar;
pub mod words;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::files;
use crate::prebuilt::{CODE, MANIFEST, SPIRV};
use crate::source::{ROOT, Tree};

/// Hashed into every key: a change of how shaders are compiled makes all of them anew.
const VERSION: &str = "1: vulkan 1.3, spir-v 1.6, performance";

/// What a build did.
#[derive(Debug, Default)]
pub struct Report {
    /// Shaders that were compiled; the others came from the last build.
    pub compiled: Vec<String>,
    /// What the compiler warns of.
    pub warnings: Vec<String>,
}

/// Makes `out` hold the SPIR-V and the Rust of the GLSL below `sources`. On errors, all of them, `out` keeps its last
/// good `shaders.rs`.
pub fn build(sources: &Path, out: &Path) -> Result<Report, Vec<String>> {
    if !sources.is_dir() {
        return Err(vec![format!("no folder {}: `compile-shaders` needs a whole checkout", sources.display())]);
    }
    // 1. Read the tree, and check what the compiler does not.
    let tree = Tree::read(sources)?;
    let mut problems = scalar::check(&tree);

    // 2. Compile what has changed since the last build.
    let old = read_manifest(out);
    let keys: BTreeMap<&str, String> = tree.shaders().map(|(path, _)| (path, tree.key(path, VERSION))).collect();
    let is_stale = |path: &str| old.get(path) != Some(&keys[path]) || !spirv_path(out, path).is_file();
    let stale: Vec<_> = tree.shaders().filter(|(path, _)| is_stale(path)).collect();
    let mut report = Report::default();
    for (path, result) in compile::compile_all(&tree, &stale) {
        match result {
            Ok(compiled) => {
                let bytes: Vec<u8> = words::strip(&compiled.words).iter().flat_map(|word| word.to_le_bytes()).collect();
                files::write_if_changed(&spirv_path(out, path), &bytes).map_err(|problem| vec![problem])?;
                report.compiled.push(path.to_owned());
                report.warnings.extend(compiled.warnings);
            }
            Err(errors) => problems.extend(errors),
        }
    }
    if !problems.is_empty() {
        return Err(without_repeats(problems));
    }

    // 3. Reflect all of them.
    let mut blocks = block::Blocks::default();
    let mut shaders = Vec::new();
    for (path, stage) in tree.shaders() {
        let bytes = files::read(&spirv_path(out, path)).map_err(|problem| vec![problem])?;
        let spirv: Vec<u32> = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        match reflect::reflect(path, stage, &spirv, &mut blocks) {
            Ok(shader) => shaders.push(shader),
            Err(errors) => problems.extend(errors.into_iter().map(|error| format!("{ROOT}/{path}: {error}"))),
        }
    }
    if !problems.is_empty() {
        return Err(without_repeats(problems));
    }

    // 4. Write the Rust, then the manifest, which makes the rest valid; drop what is no longer used.
    let code = generate::generate(&shaders, &blocks)?;
    finish(out, &tree, &keys, &code).map_err(|problem| vec![problem])?;
    Ok(report)
}

fn finish(out: &Path, tree: &Tree, keys: &BTreeMap<&str, String>, code: &str) -> Result<(), String> {
    files::write_if_changed(&out.join(CODE), code.as_bytes())?;
    let mut manifest = format!("sources {}\n", tree.hash());
    for (path, key) in keys {
        manifest.push_str(&format!("{key} {path}\n"));
    }
    files::write_if_changed(&out.join(MANIFEST), manifest.as_bytes())?;
    let keep: BTreeSet<String> = keys.keys().map(|path| format!("{path}.spv")).collect();
    files::keep_only(&out.join(SPIRV), &keep)
}

/// Keys of the last build, by shader.
fn read_manifest(out: &Path) -> BTreeMap<String, String> {
    let text = std::fs::read_to_string(out.join(MANIFEST)).unwrap_or_default();
    let lines = text.lines().skip(1).filter_map(|line| line.split_once(' '));
    lines.map(|(key, path)| (path.to_owned(), key.to_owned())).collect()
}

fn spirv_path(out: &Path, shader: &str) -> std::path::PathBuf {
    out.join(SPIRV).join(format!("{shader}.spv"))
}

/// A mistake in an include file is reported by every shader that includes it: once is enough.
fn without_repeats(problems: Vec<String>) -> Vec<String> {
    let mut seen = BTreeSet::new();
    problems.into_iter().filter(|problem| seen.insert(problem.clone())).collect()
}

//! GLSL to SPIR-V, with names kept for reflection.

use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use shaderc::{
    CompileOptions, Compiler, EnvVersion, Error, OptimizationLevel, ResolvedInclude, ShaderKind, SourceLanguage,
    SpirvVersion, TargetEnv,
};

use crate::source::{ROOT, Stage, Tree};

/// A compiled shader.
pub struct Compiled {
    /// SPIR-V with names and lines.
    pub words: Vec<u32>,
    /// What the compiler warns of.
    pub warnings: Vec<String>,
}

/// Compiles shaders on every core. Results are in the order of `shaders`; errors and warnings are
/// `file:line: error: …`.
pub fn compile_all<'a>(tree: &Tree, shaders: &[(&'a str, Stage)]) -> Vec<(&'a str, Result<Compiled, Vec<String>>)> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        let compiler = Compiler::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(&(path, stage)) = shaders.get(index) else { break };
            let result = match &compiler {
                Ok(compiler) => compile(compiler, tree, path, stage),
                Err(error) => Err(vec![format!("{ROOT}/{path}: the GLSL compiler does not start: {error}")]),
            };
            done.push((index, path, result));
        }
        done
    };
    let threads = thread::available_parallelism().map_or(1, NonZero::get).min(shaders.len());
    let mut done: Vec<_> = thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers
            .into_iter()
            .flat_map(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    });
    done.sort_by_key(|(index, ..)| *index);
    done.into_iter().map(|(_, path, result)| (path, result)).collect()
}

fn compile(compiler: &Compiler, tree: &Tree, path: &str, stage: Stage) -> Result<Compiled, Vec<String>> {
    let kind = match stage {
        Stage::Vertex => ShaderKind::Vertex,
        Stage::Geometry => ShaderKind::Geometry,
        Stage::Fragment => ShaderKind::Fragment,
        Stage::Compute => ShaderKind::Compute,
    };
    let failed = |error: Error| match error {
        Error::CompilationError(_, text) => messages(path, &text),
        other => vec![format!("{ROOT}/{path}: {other}")],
    };
    let mut options = CompileOptions::new().map_err(failed)?;
    options.set_source_language(SourceLanguage::GLSL);
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_3 as u32);
    options.set_target_spirv(SpirvVersion::V1_6);
    options.set_optimization_level(OptimizationLevel::Performance);
    // The optimiser drops all names without this; `words::strip` takes out what reflection does not need.
    options.set_generate_debug_info();
    options.set_include_callback(|name, _, from, _| {
        let from = from.strip_prefix(ROOT).map_or(from, |rest| rest.trim_start_matches('/'));
        let Some(found) = tree.resolve(name, from) else {
            return Err(format!("no file {name:?} below {ROOT}/ or next to {ROOT}/{from}"));
        };
        Ok(ResolvedInclude { resolved_name: format!("{ROOT}/{found}"), content: tree.files[found].text.clone() })
    });
    let artifact = compiler
        .compile_into_spirv(&tree.files[path].text, kind, &format!("{ROOT}/{path}"), "main", Some(&options))
        .map_err(failed)?;
    Ok(Compiled { words: artifact.as_binary().to_vec(), warnings: messages(path, &artifact.get_warning_messages()) })
}

/// The compiler's messages, without its closing count. One that names no file is given the shader's.
fn messages(path: &str, text: &str) -> Vec<String> {
    let lines = text.lines().map(str::trim_end).filter(|line| !line.is_empty() && !is_count(line));
    lines.map(|line| if line.contains(ROOT) { line.to_owned() } else { format!("{ROOT}/{path}: {line}") }).collect()
}

/// `2 errors generated.` and the like.
fn is_count(line: &str) -> bool {
    line.ends_with(" generated.") && line.starts_with(|c: char| c.is_ascii_digit())
}

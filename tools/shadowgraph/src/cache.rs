//! Where compiled shaders and pipelines are kept from run to run: the user's cache folder.

use std::env;
use std::ffi::OsStr;
use std::path::PathBuf;

/// Variable that tells Mesa's drivers where to keep compiled shaders.
pub const DRIVER_VARIABLE: &str = "MESA_SHADER_CACHE_DIR";

/// Variable that moves this program's cache folder.
pub const FOLDER_VARIABLE: &str = "SHADOWGRAPH_CACHE";

/// Tells the driver where to keep compiled shaders, unless the user does. Without this, programs that are started with
/// no home folder would compile everything anew, up to a second a shader.
#[allow(unsafe_code)]
pub fn set_driver_folder() {
    if env::var_os(DRIVER_VARIABLE).is_some() {
        return;
    }
    let Some(folder) = folder().map(|folder| folder.join("driver")) else { return };
    // Mesa does not make missing parents.
    if std::fs::create_dir_all(&folder).is_ok() {
        // SAFETY: called first in `main`, when no other thread runs that could read the environment.
        unsafe { env::set_var(DRIVER_VARIABLE, folder) };
    }
}

/// File of Vulkan's pipeline cache.
pub fn pipelines() -> Option<PathBuf> {
    folder().map(|folder| folder.join("pipelines.bin"))
}

/// This program's cache folder: `SHADOWGRAPH_CACHE`, or `shadowgraph` in the platform's cache folder. `None` where the
/// user has no home.
fn folder() -> Option<PathBuf> {
    choose(|name| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from))
}

fn choose(variable: impl Fn(&str) -> Option<PathBuf>) -> Option<PathBuf> {
    if let Some(folder) = variable(FOLDER_VARIABLE) {
        return Some(folder);
    }
    let platform = if cfg!(windows) {
        variable("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        variable("HOME").map(|home| home.join("Library/Caches"))
    } else {
        // The XDG base directory specification: a relative path is to be ignored.
        let xdg = variable("XDG_CACHE_HOME").filter(|folder| folder.is_absolute());
        xdg.or_else(|| variable("HOME").map(|home| home.join(".cache")))
    };
    platform.filter(|folder| folder.as_os_str() != OsStr::new("")).map(|folder| folder.join("shadowgraph"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(variables: &[(&str, &str)]) -> Option<PathBuf> {
        choose(|name| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| PathBuf::from(value)))
    }

    #[test]
    fn our_own_variable_comes_first() {
        let variables = [("SHADOWGRAPH_CACHE", "/a"), ("XDG_CACHE_HOME", "/b"), ("HOME", "/c"), ("LOCALAPPDATA", "/d")];
        assert_eq!(chosen(&variables), Some("/a".into()));
    }

    #[cfg(all(unix, not(target_os = "macos")))]
    #[test]
    fn xdg_comes_before_home_and_must_be_absolute() {
        assert_eq!(chosen(&[("XDG_CACHE_HOME", "/b"), ("HOME", "/c")]), Some("/b/shadowgraph".into()));
        assert_eq!(chosen(&[("XDG_CACHE_HOME", "b"), ("HOME", "/c")]), Some("/c/.cache/shadowgraph".into()));
        assert_eq!(chosen(&[("HOME", "/c")]), Some("/c/.cache/shadowgraph".into()));
        assert_eq!(chosen(&[]), None);
    }
}

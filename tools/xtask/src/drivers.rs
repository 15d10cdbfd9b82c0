//! The Vulkan drivers the tests run on.
//!
//! The system's lavapipe is the one whose figures the tests state. Two more software drivers show that nothing leans on
//! one driver's habits. They are unpacked into `target/drivers/` and never installed.

use crate::failure::{Failure, Result};
use crate::workspace::{Workspace, make_folder, read, write};
use crate::{packages, shell};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A driver to run tests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Driver {
    /// The system's lavapipe (the default where it is installed).
    Lavapipe,
    /// lavapipe 25, of bookworm-backports.
    Lavapipe25,
    /// SwiftShader, of Debian's chromium.
    Swiftshader,
    /// Whatever the Vulkan loader finds: real hardware, MoltenVK.
    System,
}

impl Driver {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lavapipe => "lavapipe",
            Self::Lavapipe25 => "lavapipe25",
            Self::Swiftshader => "swiftshader",
            Self::System => "system",
        }
    }

    /// The driver's manifest for the Vulkan loader, fetched where need be; `None` leaves the choice to the loader.
    pub fn manifest(self, workspace: &Workspace) -> Result<Option<PathBuf>> {
        match self {
            Self::System => Ok(None),
            Self::Lavapipe => match system_lavapipe() {
                Some(manifest) => Ok(Some(manifest)),
                None => Err(Failure::Usage(format!(
                    "no manifest of lavapipe (lvp_icd*.json) in {}: install it, or choose another --driver",
                    MANIFEST_FOLDERS.join(" or ")
                ))),
            },
            Self::Lavapipe25 => fetch(workspace, &LAVAPIPE_25).map(Some),
            Self::Swiftshader => fetch(workspace, &SWIFTSHADER).map(Some),
        }
    }
}

/// Lets the Vulkan loader see one driver only.
pub fn select(command: &mut Command, manifest: &Path) {
    // Loaders before 1.3.207 know the second name alone.
    command.env("VK_DRIVER_FILES", manifest).env("VK_ICD_FILENAMES", manifest);
}

const MANIFEST_FOLDERS: &[&str] = &["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"];

/// The manifest of the lavapipe that is installed.
pub fn system_lavapipe() -> Option<PathBuf> {
    let entries = MANIFEST_FOLDERS.iter().filter_map(|folder| fs::read_dir(folder).ok()).flatten().flatten();
    let mut manifests: Vec<_> = entries.map(|entry| entry.path()).filter(|path| is_lavapipe(path)).collect();
    manifests.sort();
    manifests.into_iter().next()
}

fn is_lavapipe(manifest: &Path) -> bool {
    let name = manifest.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with("lvp_icd") && name.ends_with(".json")
}

/// A driver that is one library inside a package.
struct Packed {
    folder: &'static str,
    package: &'static str,
    library: &'static str,
    /// Where the package puts it: where it is installed, it is taken from there.
    installed: Option<&'static str>,
    /// A suite of Debian 12 that is not among the system's sources.
    suite: Option<&'static str>,
}

const LAVAPIPE_25: Packed = Packed {
    folder: "target/drivers/lavapipe25",
    package: "mesa-vulkan-drivers",
    library: "libvulkan_lvp.so",
    installed: None,
    suite: Some("bookworm-backports"),
};

const SWIFTSHADER: Packed = Packed {
    folder: "target/drivers/swiftshader",
    package: "chromium-common",
    library: "libvk_swiftshader.so",
    installed: Some("/usr/lib/chromium/libvk_swiftshader.so"),
    suite: None,
};

/// Takes a package's one library, installed or downloaded, and writes a manifest beside it.
fn fetch(workspace: &Workspace, driver: &Packed) -> Result<PathBuf> {
    let folder = workspace.path(driver.folder);
    let manifest = folder.join("icd.json");
    if manifest.exists() {
        return Ok(manifest);
    }
    let target = folder.join(driver.library);
    match driver.installed.map(Path::new).filter(|library| library.is_file()) {
        Some(library) => {
            make_folder(&folder)?;
            fs::copy(library, &target).map_err(|error| Failure::io("write", &target, &error))?;
        }
        None => unpack(&folder, &target, driver)?,
    }
    write(&manifest, &manifest_text(driver.library))?;
    println!("{}: {}", driver.package, target.display());
    Ok(manifest)
}

/// Downloads a package and keeps its one library.
fn unpack(folder: &Path, target: &Path, driver: &Packed) -> Result<()> {
    if !packages::is_debian() {
        return Err(Failure::Usage(format!(
            "this driver is taken from Debian's package {}, and this system is not Debian's: choose another --driver",
            driver.package
        )));
    }
    let scratch = folder.join("unpacking");
    let _ = fs::remove_dir_all(&scratch);
    make_folder(&scratch)?;
    let package = download(&scratch, driver)?;
    shell::run(&mut shell::command(&scratch, "dpkg", &["-x", &package.to_string_lossy(), "root"]))?;

    let library = find(&scratch.join("root"), &|name| name == driver.library)
        .ok_or_else(|| Failure::Failed(format!("{} holds no {}", package.display(), driver.library)))?;
    fs::rename(&library, target).map_err(|error| Failure::io("write", target, &error))?;
    fs::remove_dir_all(&scratch).map_err(|error| Failure::io("remove", &scratch, &error))
}

/// The package's file, fetched from the mirror that the system itself uses.
fn download(folder: &Path, driver: &Packed) -> Result<PathBuf> {
    let mut options = vec!["-o".to_owned(), "APT::Sandbox::User=root".to_owned()];
    if packages::is_root()? {
        packages::update()?;
    }
    if let Some(suite) = driver.suite {
        options.extend(extra_source(folder, suite)?);
        shell::run(apt_get(folder, &options).arg("update"))?;
    }
    shell::run(apt_get(folder, &options).args(["download", driver.package])).map_err(|failure| {
        Failure::Failed(format!("{failure}\nWhere apt does not know {}, run: sudo apt-get update", driver.package))
    })?;
    find(folder, &|name| name.starts_with(driver.package) && name.ends_with(".deb"))
        .ok_or_else(|| Failure::Failed(format!("apt-get downloaded no file of {}", driver.package)))
}

/// Options of apt-get for one suite of the system's own mirror, with lists and caches of its own in `folder`.
fn extra_source(folder: &Path, suite: &str) -> Result<Vec<String>> {
    let release = read(Path::new("/etc/os-release"))?;
    let base = suite.split('-').next().unwrap_or(suite);
    if !release.lines().any(|line| line == format!("VERSION_CODENAME={base}")) {
        return Err(Failure::Usage(format!("this driver comes from {suite}, and this system is not {base}")));
    }
    let targets = shell::checked_output(Command::new("apt-get").args([
        "indextargets",
        "--format",
        "$(REPO_URI) $(RELEASE) $(COMPONENT)",
        "Created-By: Packages",
    ]))?;
    let mirror = mirror(&targets, base).ok_or_else(|| {
        Failure::Usage(format!(
            "apt has no list of {base} main. Run this, then try again:\n\n    sudo apt-get update\n"
        ))
    })?;
    let sources = folder.join("sources.list");
    write(&sources, &format!("deb {mirror} {suite} main\n"))?;
    make_folder(&folder.join("lists/partial"))?;
    make_folder(&folder.join("cache/archives/partial"))?;
    let set = |key: &str, value: &Path| ["-o".to_owned(), format!("{key}={}", value.display())];
    let options = [
        set("Dir::Etc::SourceList", &sources),
        set("Dir::Etc::SourceParts", Path::new("/dev/null")),
        set("Dir::State::Lists", &folder.join("lists")),
        set("Dir::Cache", &folder.join("cache")),
    ];
    Ok(options.into_iter().flatten().collect())
}

fn apt_get(folder: &Path, options: &[String]) -> Command {
    let mut command = shell::command(folder, "apt-get", &["--quiet"]);
    command.args(options);
    command
}

/// The address of the mirror that serves `release main`, from apt's lines of `address release component`.
fn mirror<'a>(targets: &'a str, release: &str) -> Option<&'a str> {
    targets.lines().find_map(|line| {
        let mut words = line.split_whitespace();
        let address = words.next()?;
        (words.next()? == release && words.next()? == "main").then_some(address)
    })
}

fn manifest_text(library: &str) -> String {
    format!(
        "{{\n    \"file_format_version\": \"1.0.0\",\n    \"ICD\": {{ \"library_path\": \"./{library}\", \"api_version\": \"1.3.0\" }}\n}}\n"
    )
}

/// The first file below `folder` whose name pleases.
fn find(folder: &Path, pleases: &dyn Fn(&str) -> bool) -> Option<PathBuf> {
    let mut entries: Vec<_> = fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path()).collect();
    entries.sort();
    entries.iter().find_map(|path| {
        if path.is_dir() && !path.is_symlink() {
            return find(path, pleases);
        }
        pleases(&path.file_name()?.to_string_lossy()).then(|| path.clone())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TARGETS: &str = "http://mirror.example/extras/ bookworm extras\n\
        http://mirror.example/security/ bookworm-security main\n\
        http://mirror.example/debian/ bookworm main\n";

    #[test]
    fn the_mirror_is_the_one_of_the_release_itself() {
        assert_eq!(mirror(TARGETS, "bookworm"), Some("http://mirror.example/debian/"));
        assert_eq!(mirror(TARGETS, "trixie"), None);
        assert_eq!(mirror("", "bookworm"), None);
    }

    #[test]
    fn only_manifests_of_lavapipe_are_taken() {
        assert!(is_lavapipe(Path::new("/usr/share/vulkan/icd.d/lvp_icd.x86_64.json")));
        assert!(!is_lavapipe(Path::new("/usr/share/vulkan/icd.d/intel_icd.x86_64.json")));
        assert!(!is_lavapipe(Path::new("/usr/share/vulkan/icd.d/lvp_icd.x86_64.json.orig")));
    }

    #[test]
    fn the_manifest_points_beside_itself() {
        assert!(manifest_text("libx.so").contains("\"library_path\": \"./libx.so\""));
    }
}

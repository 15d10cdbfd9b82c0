//! One static library of shaderc out of the parts that Debian's packages ship.
//!
//! Debian 12's own `libshaderc_combined.a` lacks glslang and SPIRV-Tools, and adding their static parts to its shared
//! library crashes at run time. So the parts are merged into one archive, in the folder that `.cargo/config.toml`
//! names as `SHADERC_LIB_DIR`.

use crate::failure::{Failure, Result};
use crate::workspace::{Workspace, make_folder, write};
use crate::{packages, shell};
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::{fs, io::Write as _};

/// The packages that ship the parts.
const PARTS_PACKAGES: &[&str] = &["libshaderc-dev", "glslang-dev", "spirv-tools"];

/// The parts, and whether every release of Debian has them.
const PARTS: &[(&str, bool)] = &[
    ("libshaderc_combined.a", true), // shaderc and its helpers; libshaderc_static.a lacks the helpers
    ("libglslang.a", true),
    ("libMachineIndependent.a", true),
    ("libGenericCodeGen.a", true),
    ("libOSDependent.a", true),
    ("libOGLCompiler.a", false),
    ("libHLSL.a", false),
    ("libSPIRV.a", true),
    ("libSPVRemapper.a", false),
    ("libSPIRV-Tools-opt.a", true),
    ("libSPIRV-Tools.a", true),
];

const ARCHIVE: &str = "libshaderc_combined.a";
const TEMPORARY: &str = "libshaderc_combined.tmp.a";
const STAMP: &str = "parts.txt";

/// Merges the parts, unless that was done with the same parts before.
pub fn merge(workspace: &Workspace) -> Result<()> {
    let files = packages::files(PARTS_PACKAGES)?;
    let parts = find_parts(&files)?;
    let stamp = stamp(&parts)?;
    let folder = workspace.shaderc();
    let exists = folder.join(ARCHIVE).exists();
    if exists && fs::read_to_string(folder.join(STAMP)).is_ok_and(|old| old == stamp) {
        return Ok(());
    }
    make_folder(&folder)?;
    run_ar(&folder, &ar_script(&parts))?;
    let (from, to) = (folder.join(TEMPORARY), folder.join(ARCHIVE));
    fs::rename(&from, &to).map_err(|error| Failure::io("write", &to, &error))?;
    if exists {
        // The crate has copied the old archive and does not see that it has changed.
        for profile in ["dev", "demo", "release"] {
            shell::run(&mut shell::cargo(
                &workspace.root,
                &["clean", "--quiet", "--package", "shaderc-sys", "--profile", profile],
            ))?;
        }
    }
    write(&folder.join(STAMP), &stamp)?;
    println!("shaderc: merged {} archives into {}", parts.len(), to.display());
    Ok(())
}

/// The parts among the packages' files, in the order of `PARTS`.
fn find_parts(files: &str) -> Result<Vec<&str>> {
    let mut found = Vec::new();
    for &(name, required) in PARTS {
        let part = files.lines().find(|line| Path::new(line).file_name().is_some_and(|file| file == name));
        match part {
            Some(path) => found.push(path),
            None if required => {
                return Err(Failure::Failed(format!(
                    "{name} is in none of the packages {}: this release packs shaderc in another way.\n\
                     Set SHADERC_LIB_DIR to the folder of a complete libshaderc_combined.a, or to an empty folder and \
                     install cmake, ninja-build, git and python3: the shaderc crate then builds its own.",
                    PARTS_PACKAGES.join(", ")
                )));
            }
            None => {}
        }
    }
    Ok(found)
}

/// What tells one state of the parts from another: their sizes and times.
fn stamp(parts: &[&str]) -> Result<String> {
    let mut stamp = String::new();
    for part in parts {
        let metadata = fs::metadata(part).map_err(|error| Failure::io("read", Path::new(part), &error))?;
        let modified = metadata.modified().ok().and_then(|time| time.duration_since(std::time::UNIX_EPOCH).ok());
        let _ = writeln!(stamp, "{part} {} {}", metadata.len(), modified.unwrap_or_default().as_secs());
    }
    Ok(stamp)
}

/// The script for `ar -M` that puts all members of the parts into one archive.
fn ar_script(parts: &[&str]) -> String {
    let mut script = format!("CREATE {TEMPORARY}\n");
    for part in parts {
        let _ = writeln!(script, "ADDLIB {part}");
    }
    script + "SAVE\nEND\n"
}

fn run_ar(folder: &Path, script: &str) -> Result<()> {
    let failed = |what: String| Failure::Failed(format!("`ar -M` (package binutils) {what}"));
    let mut ar = Command::new("ar");
    let mut child = ar
        .arg("-M")
        .current_dir(folder)
        .stdin(Stdio::piped())
        .spawn()
        .map_err(|error| failed(format!("does not start: {error}")))?;
    if let Some(mut stdin) = child.stdin.take() {
        stdin.write_all(script.as_bytes()).map_err(|error| failed(format!("does not read its script: {error}")))?;
    }
    let status = child.wait().map_err(|error| failed(format!("failed: {error}")))?;
    if status.success() { Ok(()) } else { Err(failed(format!("failed: {status}"))) }
}

/// Says, where the system's packages are not Debian's, what to install instead.
pub fn print_alternatives() {
    println!("{ALTERNATIVES}");
}

const ALTERNATIVES: &str = "\
This system's packages are not Debian's, so nothing was installed. Shadowgraph needs:
  - a Vulkan 1.3 driver, the Vulkan loader and the Khronos validation layer
      Fedora:  vulkan-loader mesa-vulkan-drivers vulkan-validation-layers openexr
      Arch:    vulkan-icd-loader vulkan-swrast vulkan-validation-layers openexr
      macOS:   the Vulkan SDK (with MoltenVK), and `brew install openexr`
      Windows: the Vulkan SDK, and the graphics card's driver
  - shaderc: point SHADERC_LIB_DIR at the folder of a complete libshaderc_combined.a (Windows: shaderc_combined.lib);
    the Vulkan SDK has one in its lib folder. Without it the shaderc crate builds its own: install cmake, git, python3
    and ninja for that (it takes ten minutes or more).";

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// What `dpkg -L` prints on Debian 12, shortened.
    const DEBIAN_12: &str = "/.\n/usr/lib/x86_64-linux-gnu\n\
        /usr/lib/x86_64-linux-gnu/libshaderc_combined.a\n/usr/lib/x86_64-linux-gnu/libshaderc_static.a\n\
        /usr/lib/x86_64-linux-gnu/libGenericCodeGen.a\n/usr/lib/x86_64-linux-gnu/libHLSL.a\n\
        /usr/lib/x86_64-linux-gnu/libMachineIndependent.a\n/usr/lib/x86_64-linux-gnu/libOGLCompiler.a\n\
        /usr/lib/x86_64-linux-gnu/libOSDependent.a\n/usr/lib/x86_64-linux-gnu/libSPIRV.a\n\
        /usr/lib/x86_64-linux-gnu/libSPVRemapper.a\n/usr/lib/x86_64-linux-gnu/libglslang-default-resource-limits.a\n\
        /usr/lib/x86_64-linux-gnu/libglslang.a\n/usr/lib/x86_64-linux-gnu/libSPIRV-Tools-diff.a\n\
        /usr/lib/x86_64-linux-gnu/libSPIRV-Tools-opt.a\n/usr/lib/x86_64-linux-gnu/libSPIRV-Tools.a\n";

    #[test]
    fn parts_are_found_in_the_order_of_the_list() {
        let parts = find_parts(DEBIAN_12).unwrap();
        let names: Vec<_> = parts.iter().map(|part| part.rsplit('/').next().unwrap()).collect();
        let wanted: Vec<_> = PARTS.iter().map(|&(name, _)| name).collect();
        assert_eq!(names, wanted);
    }

    #[test]
    fn a_release_without_the_stubs_still_works() {
        let files =
            DEBIAN_12.replace("libHLSL.a", "x").replace("libOGLCompiler.a", "x").replace("libSPVRemapper.a", "x");
        assert_eq!(find_parts(&files).unwrap().len(), PARTS.len() - 3);
    }

    #[test]
    fn a_missing_part_is_named_with_the_way_out() {
        let failure = find_parts(&DEBIAN_12.replace("libglslang.a", "x")).unwrap_err().to_string();
        assert!(failure.contains("libglslang.a is in none of"), "{failure}");
        assert!(failure.contains("SHADERC_LIB_DIR"), "{failure}");
    }

    #[test]
    fn the_script_creates_adds_and_saves() {
        assert_eq!(
            ar_script(&["/a/libx.a", "/b/liby.a"]),
            "CREATE libshaderc_combined.tmp.a\nADDLIB /a/libx.a\nADDLIB /b/liby.a\nSAVE\nEND\n"
        );
    }
}

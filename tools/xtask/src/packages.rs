//! The system's packages on Debian and its relatives.

use crate::failure::{Failure, Result};
use crate::shell;
use std::path::Path;
use std::process::Command;

/// What building and testing need beside a Rust tool chain and a C linker.
pub const PACKAGES: &[&str] = &[
    "g++",                     // the C++ run time shaderc links
    "libvulkan1",              // the loader
    "mesa-vulkan-drivers",     // lavapipe
    "vulkan-validationlayers", // every test runs under them
    "libshaderc-dev",          // the shader compiler's three parts
    "glslang-dev",
    "spirv-tools",
    "openexr",        // tests open our files with its tools
    "libopenexr-dev", // and deep ones with its library
];

/// What the gate needs beside [`PACKAGES`].
pub const GATE_PACKAGES: &[&str] = &[
    "chromium-headless-shell", // tests open the report's page in a browser; its chromium-common has SwiftShader
];

/// Whether this system's packages are Debian's.
pub fn is_debian() -> bool {
    Path::new("/etc/debian_version").exists() && shell::has("dpkg-query") && shell::has("apt-get")
}

/// The packages of `wanted` that are not installed.
pub fn missing(wanted: &[&'static str]) -> Result<Vec<&'static str>> {
    let mut query = Command::new("dpkg-query");
    query.args(["--show", "--showformat", "${Package} ${db:Status-Status}\\n"]).args(wanted);
    // It fails where it knows no package of a name: what it prints is what counts.
    Ok(not_installed(wanted, &shell::output(&mut query)?))
}

/// Installs packages, as root; without root, a failure that gives the command to run.
pub fn install(packages: &[&str]) -> Result<()> {
    if !is_root()? {
        return Err(Failure::Usage(format!(
            "these packages are missing: {}\nRun this, then try again:\n\n    {}\n",
            packages.join(" "),
            install_line(packages)
        )));
    }
    update()?;
    let mut install = apt_get(&["install", "--yes", "--no-install-recommends"]);
    shell::run(install.args(packages))
}

/// Fetches the lists of packages, as root.
pub fn update() -> Result<()> {
    shell::run(&mut apt_get(&["update"]))
}

/// Whether this process may install packages.
pub fn is_root() -> Result<bool> {
    Ok(shell::checked_output(Command::new("id").arg("-u"))?.trim() == "0")
}

/// The files that installed packages have put on the system.
pub fn files(packages: &[&str]) -> Result<String> {
    shell::checked_output(Command::new("dpkg").arg("-L").args(packages))
}

fn apt_get(arguments: &[&str]) -> Command {
    let mut command = Command::new("apt-get");
    command.env("DEBIAN_FRONTEND", "noninteractive").arg("--quiet").args(arguments);
    command
}

/// The command line that installs packages.
fn install_line(packages: &[&str]) -> String {
    format!("sudo apt-get update && sudo apt-get install --yes --no-install-recommends {}", packages.join(" "))
}

/// The packages that `dpkg-query`'s lines of `name status` do not call installed.
fn not_installed(wanted: &[&'static str], lines: &str) -> Vec<&'static str> {
    let is_installed = |package: &str| {
        lines
            .lines()
            .any(|line| line.split_once(' ').is_some_and(|(name, status)| name == package && status == "installed"))
    };
    wanted.iter().copied().filter(|package| !is_installed(package)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn installed_packages_are_not_missing() {
        let lines = "libvulkan1 installed\nopenexr not-installed\nspirv-tools config-files\n";
        assert_eq!(not_installed(&["libvulkan1"], lines), [""; 0]);
        assert_eq!(not_installed(&["openexr", "libvulkan1", "spirv-tools"], lines), ["openexr", "spirv-tools"]);
    }

    #[test]
    fn unknown_packages_are_missing() {
        assert_eq!(not_installed(&["glslang-dev"], ""), ["glslang-dev"]);
        // A longer name is another package.
        assert_eq!(not_installed(&["glslang-dev"], "glslang-dev-tools installed\n"), ["glslang-dev"]);
    }

    #[test]
    fn the_command_to_run_names_every_missing_package() {
        let line = install_line(&["openexr", "libvulkan1"]);
        assert_eq!(
            line,
            "sudo apt-get update && sudo apt-get install --yes --no-install-recommends openexr libvulkan1"
        );
    }
}

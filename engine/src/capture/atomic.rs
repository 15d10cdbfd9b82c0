//! Files that appear whole or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process;

use crate::{Error, Result};

/// Writes a file through `fill`, under a temporary name in the same folder, and renames it to `path` when all of it
/// is written. A file that stood there is replaced in one step; on any error it stays as it was, and the temporary
/// file is removed.
///
/// The data is handed to the system and not forced to the disk: a crash of the program leaves the old file or the new
/// one, a loss of power may not.
///
/// # Errors
/// [`Error::Io`] where the folder is missing or not writable, where `path` is a folder or no regular file, where the
/// disk is full, or where `fill` fails.
pub fn write_atomically(path: &Path, fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<()> {
    let target = resolve(path).map_err(|e| Error::io("write", path, e))?;
    let (temporary, file) = Temporary::beside(&target).map_err(|e| Error::io("create a file beside", path, e))?;
    let written = fill_and_close(file, fill).and_then(|()| fs::rename(&temporary.0, &target));
    written.map_err(|e| Error::io("write", path, e))?;
    // After the rename the temporary name is free, and may be somebody else's by now.
    std::mem::forget(temporary);
    Ok(())
}

fn fill_and_close(file: File, fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    let mut writer = BufWriter::with_capacity(1 << 18, file);
    fill(&mut writer)?;
    writer.flush()
}

/// Where the file really goes: a symbolic link is followed, not replaced.
fn resolve(path: &Path) -> io::Result<PathBuf> {
    if path.file_name().is_none() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "this names no file"));
    }
    match fs::metadata(path) {
        Ok(existing) if existing.is_dir() => Err(io::Error::new(io::ErrorKind::IsADirectory, "this is a folder")),
        // Renaming over a device or a pipe would replace it.
        Ok(existing) if !existing.is_file() => {
            Err(io::Error::new(io::ErrorKind::InvalidInput, "this exists and is no regular file"))
        }
        Ok(_) => fs::canonicalize(path),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(path.to_path_buf()),
        Err(e) => Err(e),
    }
}

/// A file that is removed when this is dropped.
struct Temporary(PathBuf);

impl Temporary {
    fn beside(target: &Path) -> io::Result<(Self, File)> {
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        // Names are limited to 255 bytes on common file systems; the target's own may need them all.
        let stem: String = name.chars().take(40).collect();
        for attempt in 0..1000 {
            let path = target.with_file_name(format!(".{stem}.{}-{attempt}.tmp", process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok((Self(path), file)),
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(e),
            }
        }
        Err(io::Error::new(io::ErrorKind::AlreadyExists, "1000 temporary files of this name are left over"))
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // Gone already where the rename succeeded; where removal fails, the error on its way says more.
        let _ = fs::remove_file(&self.0);
    }
}

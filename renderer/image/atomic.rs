//! Output files appear whole or not at all: written beside their place, then renamed into it.

use std::fs::{self, Permissions};
use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::{Format, ImageError};

/// What `produce` writes to.
pub trait WriteSeek: Write + Seek {}
impl<T: Write + Seek> WriteSeek for T {}

/// Writes a file under a temporary name in its own folder and renames it to `path` when `produce`
/// has succeeded. On failure the temporary file is removed and what stood at `path` is untouched.
///
/// # Errors
/// [`ImageError::Write`]: `path` is a folder, its folder is missing or read-only, the disk is
/// full, or the reason that `produce` gave.
pub fn write(path: &Path, produce: impl FnOnce(&mut dyn WriteSeek) -> Result<(), String>) -> Result<(), ImageError> {
    let failed = |reason: String| ImageError::Write { path: path.to_owned(), reason };
    // A link is followed, so that the rename replaces what it points to and not the link.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let mut file = temporary_beside(&target).map_err(failed)?;
    let mut buffer = BufWriter::new(file.as_file_mut());
    produce(&mut buffer).map_err(failed)?;
    buffer.flush().map_err(|error| failed(error.to_string()))?;
    drop(buffer);
    file.persist(&target).map_err(|error| failed(error.error.to_string()))?;
    Ok(())
}

/// Whether a picture can be written at `path`, asked before the work that fills it.
///
/// # Errors
/// [`ImageError::UnknownExtension`], or [`ImageError::Write`] with what stands in the way.
pub fn check(path: &Path) -> Result<Format, ImageError> {
    let format = Format::of(path)?;
    check_place(path)?;
    Ok(format)
}

/// Whether a file of any kind can be written at `path`.
///
/// # Errors
/// [`ImageError::Write`] with what stands in the way.
pub fn check_place(path: &Path) -> Result<(), ImageError> {
    match temporary_beside(path) {
        Ok(_) => Ok(()),
        Err(reason) => Err(ImageError::Write { path: path.to_owned(), reason }),
    }
}

fn temporary_beside(target: &Path) -> Result<NamedTempFile, String> {
    if target.is_dir() {
        return Err("it is a folder".to_owned());
    }
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    if !folder.is_dir() {
        return Err(format!("the folder {} does not exist", folder.display()));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".nephroid-").suffix(".part");
    if let Some(permissions) = new_file_permissions() {
        builder.permissions(permissions);
    }
    builder.tempfile_in(&folder).map_err(|error| {
        // Only the kind: the full sentence has the temporary name, which means nothing to the user.
        format!("no file can be made in the folder {}: {}", folder.display(), error.kind())
    })
}

/// Temporary files are private by default; a picture should get what the umask leaves it.
#[cfg(unix)]
fn new_file_permissions() -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn new_file_permissions() -> Option<Permissions> {
    None
}

//! Output files appear whole or not at all: written beside their place, then renamed into it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, Permissions};
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::{Format, ImageError};

/// A temporary name is this, the name of the file that it is to become, RANDOM characters and the suffix. So what a
/// killed program left behind can be told from what another one, busy with other files, is writing now.
const PREFIX: &str = ".nephroid-";
const SUFFIX: &str = ".part";
const RANDOM: usize = 6;

/// Bytes of a file's name in its temporary one at most: file systems allow 255 in all. A longer one is cut, and gets a
/// hash of the whole.
const LONGEST_NAME: usize = 200;

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
    let target = target(path);
    let mut file = temporary_beside(&target).map_err(failed)?;
    let mut buffer = BufWriter::new(file.as_file_mut());
    produce(&mut buffer).map_err(failed)?;
    buffer.flush().map_err(|error| failed(error.to_string()))?;
    drop(buffer);
    file.persist(&target).map_err(|error| failed(error.error.to_string()))?;
    Ok(())
}

/// As [`write`], for another program that writes the file: `produce` gets the temporary name, at which an empty file
/// is.
///
/// # Errors
/// [`ImageError::Write`] as [`write`]'s; those of `produce` as they are.
pub fn write_by<E: From<ImageError>>(path: &Path, produce: impl FnOnce(&Path) -> Result<(), E>) -> Result<(), E> {
    let failed = |reason: String| ImageError::Write { path: path.to_owned(), reason };
    let target = target(path);
    let file = temporary_beside(&target).map_err(failed)?;
    produce(file.path())?;
    file.persist(&target).map_err(|error| failed(error.error.to_string()))?;
    Ok(())
}

/// Removes the temporary files that killed programs left behind on their way to `paths`, and returns their number.
/// Nobody may be writing these paths meanwhile.
///
/// # Errors
/// A temporary file that cannot be removed, or a folder that cannot be read; one that does not exist holds nothing.
pub fn remove_stale<'a>(paths: impl IntoIterator<Item = &'a Path>) -> Result<u32, ImageError> {
    let mut wanted: BTreeMap<PathBuf, BTreeSet<String>> = BTreeMap::new();
    for path in paths {
        let target = target(path);
        wanted.entry(folder_of(&target)).or_default().insert(temporary_prefix(&target));
    }
    let mut removed = 0;
    for (folder, prefixes) in wanted {
        let failed = |path: &Path, error: io::Error| ImageError::Read {
            path: path.to_owned(),
            reason: format!("temporary files are to be removed there: {error}"),
        };
        let entries = match fs::read_dir(&folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            entries => entries.map_err(|error| failed(&folder, error))?,
        };
        for entry in entries {
            let entry = entry.map_err(|error| failed(&folder, error))?;
            let name = entry.file_name();
            let Some(stem) = name.to_str().and_then(|name| name.strip_suffix(SUFFIX)) else { continue };
            let cut = stem.len().saturating_sub(RANDOM);
            if stem.get(..cut).is_some_and(|prefix| prefixes.contains(prefix)) {
                fs::remove_file(entry.path()).map_err(|error| failed(&entry.path(), error))?;
                removed += 1;
            }
        }
    }
    Ok(removed)
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

/// A link is followed, so that the rename replaces what it points to and not the link.
fn target(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

fn folder_of(target: &Path) -> PathBuf {
    match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn temporary_prefix(target: &Path) -> String {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    if name.len() <= LONGEST_NAME {
        return format!("{PREFIX}{name}-");
    }
    let end = (0..=LONGEST_NAME).rev().find(|end| name.is_char_boundary(*end)).unwrap_or(0);
    format!("{PREFIX}{}~{:016x}-", &name[..end], fnv_1a(name.as_bytes()))
}

fn fnv_1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

fn temporary_beside(target: &Path) -> Result<NamedTempFile, String> {
    if target.is_dir() {
        return Err("it is a folder".to_owned());
    }
    let folder = folder_of(target);
    if folder.exists() && !folder.is_dir() {
        return Err(format!("{} is not a folder", folder.display()));
    }
    if !folder.is_dir() {
        return Err(format!("the folder {} does not exist", folder.display()));
    }
    let prefix = temporary_prefix(target);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).rand_bytes(RANDOM).suffix(SUFFIX);
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

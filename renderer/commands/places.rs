//! Every file that a command reads or writes has a place of its own.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fs;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Two options name one file.
#[derive(Debug, Error)]
#[error("{path}: {first} and {second} name the same file; each needs its own")]
pub struct PlaceError {
    path: PathBuf,
    first: &'static str,
    second: &'static str,
}

/// Sees that no two of these are one file, whatever way their paths are spelled.
///
/// # Errors
/// The first two that are, by the options that name them.
pub fn distinct(places: impl IntoIterator<Item = (&'static str, PathBuf)>) -> Result<(), PlaceError> {
    let mut taken: HashMap<PathBuf, &'static str> = HashMap::new();
    for (second, path) in places {
        match taken.entry(resolved(&path)) {
            Entry::Occupied(found) => return Err(PlaceError { path, first: found.get(), second }),
            Entry::Vacant(free) => free.insert(second),
        };
    }
    Ok(())
}

/// Without links, as far as the path is there.
fn resolved(path: &Path) -> PathBuf {
    let of_folder = || Some(fs::canonicalize(folder_of(path)).ok()?.join(path.file_name()?));
    let absolute = || std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    fs::canonicalize(path).ok().or_else(of_folder).unwrap_or_else(absolute)
}

/// The folder that a file is in, `.` where its path names none.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

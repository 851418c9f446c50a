//! Why a scene was refused, one sentence each.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// A place in a text file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Location {
    pub path: Box<Path>,
    /// From 1.
    pub line: u32,
    /// From 1, in characters; only where the line alone does not tell.
    pub column: Option<u32>,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.path.display(), self.line)?;
        self.column.map_or(Ok(()), |column| write!(f, ":{column}"))
    }
}

/// Why a scene was refused. The messages are meant for the person who wrote the file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    #[error("the scene file {} cannot be read: {reason}", path.display())]
    Unreadable { path: PathBuf, reason: String },

    #[error("{at}: not valid TOML: {reason}")]
    Syntax { at: Location, reason: String },

    #[error("{at}: unknown key `{key}` in {table}; allowed: {allowed}")]
    UnknownKey { at: Location, key: String, table: String, allowed: String },

    #[error("{at}: {table} lacks `{key}`; allowed: {allowed}")]
    MissingKey { at: Location, table: String, key: String, allowed: String },

    /// A wrong type, or a value outside its range.
    #[error("{at}: `{key}` is {found}; allowed: {allowed}")]
    Value { at: Location, key: String, found: String, allowed: String },

    #[error("{at}: `{key}` names the {kind} \"{found}\", which is not in the scene; known: {known}")]
    UnknownName { at: Location, key: String, kind: &'static str, found: String, known: String },

    #[error("{at}: the {kind} name \"{name}\" is taken; allowed: a name no other {kind} has")]
    TakenName { at: Location, kind: &'static str, name: String },

    /// A file the scene refers to, with the place of the reference.
    #[error("{at}: `{key}` refers to {}, which {problem}", file.display())]
    File { at: Location, key: String, file: PathBuf, problem: String },

    /// A place inside a mesh or material file.
    #[error("{at}: {problem}")]
    Mesh { at: Location, problem: String },
}

/// The system's reason without its error number.
pub(super) fn io_reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "permission is denied".to_owned(),
        io::ErrorKind::IsADirectory => "it is a folder".to_owned(),
        io::ErrorKind::InvalidData => "it is not UTF-8 text".to_owned(),
        _ => error.to_string(),
    }
}

/// A line of a mesh or material file.
pub(super) fn in_file(path: &Path, line: u32, problem: String) -> SceneError {
    SceneError::Mesh { at: Location { path: path.into(), line, column: None }, problem }
}

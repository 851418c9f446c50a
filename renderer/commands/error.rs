use std::path::PathBuf;

use thiserror::Error;

use super::animate::VideoError;
use super::output::ValidationError;
use super::places::PlaceError;
use crate::image::ImageError;
use crate::render::RenderError;
use crate::scene::SceneError;

/// Why pictures were not rendered, one or a sequence of them.
#[derive(Debug, Error)]
pub enum PictureError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Place(#[from] PlaceError),
    #[error(transparent)]
    Image(#[from] ImageError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[cfg(feature = "hot-reload")]
    #[error(transparent)]
    Watch(#[from] crate::gpu::WatchError),
    #[error(transparent)]
    Video(#[from] VideoError),
    #[error(transparent)]
    Validation(#[from] ValidationError),
    #[error("{scene} does not say how many frames it has; say which to render by --frames, such as --frames 0..47")]
    Frames { scene: PathBuf },
    #[error(
        "{path}: all shards would write this one file for {option}; put {{shard}} into its name, for the shard's number"
    )]
    Shared { option: &'static str, path: PathBuf },
    #[error("the folder {path} cannot be made: {reason}")]
    Folder { path: PathBuf, reason: String },
}

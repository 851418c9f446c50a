//! What can go wrong on the way to a picture.

use super::MAX_SIDE;
use crate::gpu::GpuError;
use crate::technique::eikonal::file::VolumeFileError;
use crate::technique::{CreateError, TechniqueError};
use crate::trace::TraceError;

/// Why a picture cannot be rendered.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    Trace(#[from] TraceError),
    #[error(transparent)]
    Technique(#[from] TechniqueError),
    #[error(transparent)]
    Volumes(#[from] VolumeFileError),
    #[error("{scene} has no camera \"{found}\"; it has: {allowed}")]
    UnknownCamera { scene: String, found: String, allowed: String },
    #[error("the picture is {width} x {height} pixels; allowed are 1 to {MAX_SIDE} each way")]
    Size { width: u32, height: u32 },
    #[error(
        "frame {frame} of {scene} is out of reach: its simulated water has to be taken there step by step; allowed are \
         frames up to {last}"
    )]
    Frame { scene: String, frame: u32, last: u32 },
    #[error("there is nothing to render into, since an earlier change of the picture's size or technique failed")]
    Unmade,
    #[error("{found} samples were asked for; at least 1 is needed")]
    Samples { found: u32 },
    #[error(
        "adaptive sampling needs a technique that finds the light of each sample by itself, and {technique} with these \
         settings does not"
    )]
    NotAdaptive { technique: &'static str },
}

impl From<CreateError> for RenderError {
    fn from(error: CreateError) -> Self {
        match error {
            CreateError::Gpu(error) => error.into(),
            CreateError::Volumes(error) => error.into(),
        }
    }
}

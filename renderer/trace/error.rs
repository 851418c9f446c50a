//! What can go wrong in front of the first ray.

use crate::gpu::GpuError;

/// An error of the tracer; each message is a sentence for the user.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    #[error("unknown tracing back-end \"{found}\"; allowed are: {allowed}")]
    UnknownChoice { found: String, allowed: String },
    #[error("the device {device} has no ray queries in use, so that --trace ray-query cannot be; use auto or bvh")]
    NoRayQuery { device: String },
    #[error("no tree could be built over the mesh {mesh}: {reason}")]
    Build { mesh: String, reason: String },
    #[error("the mesh {mesh} was to be moved, but its number of triangles or vertices has changed")]
    Changed { mesh: String },
    #[error("a scene of {was} {what} was to be followed, but it now has {now}")]
    ChangedCount { what: &'static str, was: usize, now: usize },
    #[error("the instance {instance} was to be moved, but it now is one of another mesh")]
    Exchanged { instance: String },
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

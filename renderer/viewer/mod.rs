//! The window of `nephroid view`: one renderer or two side by side, and a panel to play with.
//!
//! Everything runs on one thread. Between two samples of the picture the window's events are handled and the window is
//! drawn. What the picture is to show is a [`state::Wish`] that panel, keys and script change; the renderers follow it.

mod camera;
mod heat;
mod history;
mod medium;
mod pane;
mod panel;
mod picture;
mod script;
mod session;
mod state;
mod window;

use std::path::PathBuf;

use thiserror::Error;

use crate::gpu::GpuError;
use crate::image::ImageError;
use crate::render::{RenderError, RenderSettings};
use crate::scene::SceneError;

pub use script::{HELP as SCRIPT_HELP, Script, ScriptError};
pub use window::run;

/// What the window starts with.
pub struct ViewSettings {
    pub scene: PathBuf,
    pub render: RenderSettings,
    /// Samples a pixel after which the picture is left as it is.
    pub samples: u32,
    /// A picture that errors are measured against.
    pub truth: Option<PathBuf>,
    pub script: Option<PathBuf>,
    /// The folder whose kernels are watched.
    #[cfg(feature = "hot-reload")]
    pub watch: Option<PathBuf>,
}

/// Why the window could not be opened, or had to close.
#[derive(Debug, Error)]
pub enum ViewError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Image(#[from] ImageError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    Script(#[from] ScriptError),
    #[cfg(feature = "hot-reload")]
    #[error(transparent)]
    Watch(#[from] crate::gpu::WatchError),
    #[error(
        "no window can be opened: {reason}; run it on a desktop, or make pictures without a window by 'nephroid render'"
    )]
    NoDisplay { reason: String },
    #[error("{reason}")]
    Picture { reason: String },
    #[error("the validation layers have {count} messages, of which the first is: {first}")]
    Validation { count: usize, first: String },
}

/// How the window was left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Closed {
    ByUser,
    ByCtrlC,
}

//! The subcommands of the binary, one file each, and what several of them share.

pub mod animate;
pub mod args;
pub mod compare;
pub mod conformance;
pub mod devices;
mod error;
pub(crate) mod interrupt;
mod output;
mod places;
mod progress;
pub mod render;
mod request;
pub mod shell;
mod trace_file;
#[cfg(feature = "viewer")]
pub mod view;
pub mod volume;

pub use error::PictureError;

//! The subcommands of the binary, one file each.

pub mod compare;
pub mod devices;
pub mod render;
pub mod shell;

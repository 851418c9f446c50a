//! What `nephroid render` takes, and its help.

use std::path::PathBuf;

use clap::Args;

use crate::commands::args::{PictureArgs, long_help};

const EXAMPLES: &str = "\
Examples:
  A picture to look at, and all layers in linear light to measure:
    nephroid render scenes/pool.toml --technique reference -o pool.png -o pool.exr
  A quick look through another camera:
    nephroid render scenes/pool.toml --camera under --size 320x240 --samples 4 -o under.png
  On the second device of 'nephroid devices', as if it could not trace rays itself:
    nephroid render scenes/cup.toml --device 1 --disable ray-query -o cup.png

Ctrl-C ends a rendering after the current sample and writes the picture as it is then; a second one ends it at once.";

/// Render a scene to picture files
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES, after_long_help = long_help(EXAMPLES))]
pub struct RenderArgs {
    /// A file to write; give it again for more: .exr holds all layers in linear light, .png the picture for display
    #[arg(short, long, value_name = "FILE", required = true)]
    pub output: Vec<PathBuf>,
    /// The frame of the scene's animation to render
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub frame: u32,
    #[command(flatten)]
    pub picture: PictureArgs,
    /// Start over with the changed kernels whenever a GLSL file in FOLDER changes [default: where they were built from]
    #[cfg(feature = "hot-reload")]
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, require_equals = true)]
    pub watch_kernels: Option<Option<PathBuf>>,
}

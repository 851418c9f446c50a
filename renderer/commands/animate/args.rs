//! What `nephroid animate` takes, and its help.

use std::path::PathBuf;

use clap::Args;

use super::pattern::Pattern;
use super::sequence::{Frames, Shard};
use crate::commands::args::{PictureArgs, long_help};
use crate::scene::FPS;

const EXAMPLES: &str = "\
Examples:
  Two seconds of the pool, as pictures and as a video (which needs ffmpeg):
    nephroid animate scenes/pool.toml --frames 0..47 -o out/pool_%04d.png --video pool.mp4
  After an interruption, only what is missing, damaged or of other settings:
    nephroid animate scenes/pool.toml --frames 0..47 -o out/pool_%04d.png --resume
  Every third frame from the second, as one of three machines that share a folder:
    nephroid animate scenes/pool.toml --frames 0..47 -o out/pool_%04d.png --shard 2/3

A frame depends on its number, the scene and the seed alone: it is the same whether it is
rendered alone, in its row or by a shard. Folders that do not exist are made. Ctrl-C ends the
sequence after the current frame; a second one ends it at once. With --shard, the names of
--stats and --trace-file need {shard} in them, which becomes the shard's number.";

/// Render frames of a scene's animation to numbered picture files
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES, after_long_help = long_help(EXAMPLES))]
pub struct AnimateArgs {
    /// The first and the last frame, both included: 0..47 is 48 frames; or one frame [default: the scene's]
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    pub frames: Option<Frames>,
    /// The files to write, with %d or, with leading zeros, %04d for the frame's number; give it again for more: .exr
    /// holds all layers in linear light, .png the picture for display
    #[arg(short, long, value_name = "PATTERN", required = true)]
    pub output: Vec<Pattern>,
    /// Frames a second: frame n shows the scene n / N seconds after its start [default: the scene's]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = fps)]
    pub fps: Option<f64>,
    /// Render part I of N only: frames A + I - 1, A + I - 1 + N and so on
    #[arg(long, value_name = "I/N", allow_hyphen_values = true)]
    pub shard: Option<Shard>,
    /// Keep frames that are there whole and of the same scene and settings
    #[arg(long)]
    pub resume: bool,
    /// Make a video of the frames when all are there; needs ffmpeg
    #[arg(long, value_name = "MP4")]
    pub video: Option<PathBuf>,
    #[command(flatten)]
    pub picture: PictureArgs,
}

fn fps(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|fps| FPS.contains(fps));
    found.ok_or_else(|| format!("allowed are numbers from {} to {}", FPS.start(), FPS.end()))
}

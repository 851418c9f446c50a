//! `--video`: the frames of a sequence through ffmpeg into an MP4 file.

use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use thiserror::Error;

use super::pattern::Pattern;
use crate::image::{Format, ImageError, atomic, openexr, png, tone};
use crate::scene::FilmSettings;
use crate::spans;

/// Why there is no video.
#[derive(Debug, Error)]
pub enum VideoError {
    #[error("{path}: a video is an MP4 file; give it a name that ends in .mp4")]
    Extension { path: PathBuf },
    #[error("--video needs the program ffmpeg, which is not on the PATH; install it, or leave --video out")]
    NoFfmpeg,
    #[error("{path}: ffmpeg made no video: {reason}")]
    Ffmpeg { path: PathBuf, reason: String },
    #[error(transparent)]
    Image(#[from] ImageError),
}

/// A video that can be made.
pub struct Video {
    path: PathBuf,
    ffmpeg: PathBuf,
}

impl Video {
    /// Whether a video can be written at `path`, asked before any frame is rendered.
    ///
    /// # Errors
    /// Another extension, no ffmpeg on the PATH, or a place where no file can be.
    pub fn new(path: &Path) -> Result<Self, VideoError> {
        if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mp4")) {
            return Err(VideoError::Extension { path: path.to_owned() });
        }
        atomic::check_place(path)?;
        let name = format!("ffmpeg{}", std::env::consts::EXE_SUFFIX);
        let folders = std::env::var_os("PATH").unwrap_or_default();
        let ffmpeg = std::env::split_paths(&folders).map(|folder| folder.join(&name)).find(|file| file.is_file());
        Ok(Video { path: path.to_owned(), ffmpeg: ffmpeg.ok_or(VideoError::NoFfmpeg)? })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes the video of `frames`, which are all there, at `fps` frames a second. From `output` where that is PNG; EXR
    /// files are shown as the film's settings say.
    ///
    /// # Errors
    /// Frames that cannot be read, or what ffmpeg complains of. No file is left then.
    pub fn make(
        &self,
        output: &(Pattern, Format),
        frames: impl Iterator<Item = u32>,
        fps: f64,
        film: &FilmSettings,
    ) -> Result<(), VideoError> {
        let _span = spans::span("make video");
        let mut frames = frames.peekable();
        let Some(first) = frames.peek() else { return Ok(()) };
        let (width, height, _) = display(output, *first, film)?;
        atomic::write_by(&self.path, |temporary| {
            let mut child = self.start(temporary, (width, height), fps)?;
            let fed = feed(&mut child, output, frames, (width, height), film);
            let mut said = String::new();
            child.stderr.take().map(|mut stderr| stderr.read_to_string(&mut said));
            let ended = child.wait().map_err(|error| self.failed(error.to_string()))?;
            let last = said.lines().rev().find(|line| !line.trim().is_empty());
            if !ended.success() {
                return Err(self.failed(last.map_or_else(|| ended.to_string(), str::to_owned)));
            }
            fed
        })
    }

    /// An ffmpeg that takes RGB pictures, frame after frame, and complains on its standard error.
    fn start(&self, temporary: &Path, (width, height): (usize, usize), fps: f64) -> Result<Child, VideoError> {
        let encoders = Command::new(&self.ffmpeg).args(["-hide_banner", "-encoders"]).stdin(Stdio::null()).output();
        let encoders = encoders.map_err(|error| self.failed(error.to_string()))?;
        // Where it is missing, ffmpeg's own choice for MP4 has to do, which knows another scale of quality.
        let x264 = String::from_utf8_lossy(&encoders.stdout).contains(" libx264 ");
        let quality = if x264 { ["-c:v", "libx264", "-crf", "16"] } else { ["-f", "mp4", "-q:v", "2"] };
        let mut command = Command::new(&self.ffmpeg);
        command.args(["-hide_banner", "-nostats", "-loglevel", "error", "-y"]);
        command.args(["-f", "rawvideo", "-pixel_format", "rgb24", "-video_size", &format!("{width}x{height}")]);
        command.args(["-framerate", &fps.to_string(), "-i", "-"]);
        // Colour at half resolution, as players want it, needs even sides.
        command.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p"]);
        command.args(["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1"]);
        command.args(quality).args(["-movflags", "+faststart", "-f", "mp4"]).arg(temporary);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().map_err(|error| self.failed(error.to_string()))
    }

    fn failed(&self, reason: String) -> VideoError {
        VideoError::Ffmpeg { path: self.path.clone(), reason }
    }
}

fn feed(
    child: &mut Child,
    output: &(Pattern, Format),
    frames: impl Iterator<Item = u32>,
    size: (usize, usize),
    film: &FilmSettings,
) -> Result<(), VideoError> {
    let Some(stdin) = child.stdin.take() else { return Ok(()) };
    let mut stdin = BufWriter::new(stdin);
    for frame in frames {
        let (width, height, pixels) = display(output, frame, film)?;
        if (width, height) != size {
            let reason = format!("it is {width}x{height} pixels, where the first frame is {}x{}", size.0, size.1);
            return Err(ImageError::Read { path: output.0.path(frame), reason }.into());
        }
        // Where ffmpeg has gone, its own words say why.
        if is_gone(stdin.write_all(pixels.as_flattened())) {
            break;
        }
    }
    is_gone(stdin.flush());
    Ok(())
}

fn is_gone(written: io::Result<()>) -> bool {
    written.is_err()
}

/// Width, height and display values of a frame's file.
fn display(
    (pattern, format): &(Pattern, Format),
    frame: u32,
    film: &FilmSettings,
) -> Result<(usize, usize, Vec<[u8; 3]>), ImageError> {
    let path = pattern.path(frame);
    match format {
        Format::Png => png::read_display(&path).map(|image| (image.width, image.height, image.pixels)),
        Format::Exr => {
            let image = openexr::read(&path)?.select(&path, None)?;
            let pixels = tone::display(&image.pixels, film.exposure, tone::curve(film.tone_curve));
            Ok((image.width, image.height, pixels))
        }
    }
}

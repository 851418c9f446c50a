//! `--video`: the frames of a sequence through ffmpeg into an MP4 file.

use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, ExitStatus, Stdio};
use std::thread;
use std::time::Duration;

use thiserror::Error;

use super::files::Files;
use super::pattern::Pattern;
use crate::commands::interrupt;
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
    #[error("--video needs the program ffmpeg, and {path} does not run: {reason}; mend it, or leave --video out")]
    Broken { path: PathBuf, reason: String },
    #[error("{path}: Ctrl-C came before the video was made")]
    Stopped { path: PathBuf },
    #[error(transparent)]
    Image(#[from] ImageError),
}

/// How often a video that is being made asks whether it still should be.
const POLL: Duration = Duration::from_millis(20);

/// A video that can be made.
pub struct Video {
    path: PathBuf,
    ffmpeg: PathBuf,
    /// Whether ffmpeg has the encoder libx264.
    x264: bool,
}

impl Video {
    /// Whether a video of `files` can be written at `path`, asked before any frame is rendered.
    ///
    /// # Errors
    /// Another extension, no ffmpeg on the PATH or one that does not run, or a place where no file can be.
    pub fn new(path: &Path, files: &Files) -> Result<Self, VideoError> {
        if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mp4")) {
            return Err(VideoError::Extension { path: path.to_owned() });
        }
        files.check_place(path)?;
        let name = format!("ffmpeg{}", std::env::consts::EXE_SUFFIX);
        let folders = std::env::var_os("PATH").unwrap_or_default();
        let ffmpeg = std::env::split_paths(&folders).map(|folder| folder.join(&name)).find(|file| file.is_file());
        let ffmpeg = ffmpeg.ok_or(VideoError::NoFfmpeg)?;
        let x264 = encoders(&ffmpeg)?.contains(" libx264 ");
        Ok(Video { path: path.to_owned(), ffmpeg, x264 })
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
            // Read meanwhile: an ffmpeg that cannot get rid of its complaints takes no more pictures.
            let said = child.stderr.take().map(|stderr| thread::spawn(|| last_line(stderr)));
            let fed = feed(&mut child, output, frames, (width, height), film);
            let ended = self.wait(&mut child)?;
            if !ended.success() {
                let said = said.and_then(|said| said.join().ok()).flatten();
                return Err(self.failed(said.unwrap_or_else(|| ended.to_string())));
            }
            fed
        })
    }

    /// Waits for an ffmpeg that has all pictures, and ends it where Ctrl-C comes.
    fn wait(&self, child: &mut Child) -> Result<ExitStatus, VideoError> {
        loop {
            // Asked first: an ffmpeg that got some of the pictures may have ended in success.
            if interrupt::came() {
                let _ = child.kill();
                let _ = child.wait();
                return Err(VideoError::Stopped { path: self.path.clone() });
            }
            if let Some(ended) = child.try_wait().map_err(|error| self.failed(error.to_string()))? {
                return Ok(ended);
            }
            thread::sleep(POLL);
        }
    }

    /// An ffmpeg that takes RGB pictures, frame after frame, and complains on its standard error.
    fn start(&self, temporary: &Path, (width, height): (usize, usize), fps: f64) -> Result<Child, VideoError> {
        // Where it is missing, ffmpeg's own choice for MP4 has to do, which knows another scale of quality.
        let quality = if self.x264 { ["-c:v", "libx264", "-crf", "16"] } else { ["-f", "mp4", "-q:v", "2"] };
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

/// What ffmpeg can encode, which also shows that it runs.
fn encoders(ffmpeg: &Path) -> Result<String, VideoError> {
    let broken = |reason: String| VideoError::Broken { path: ffmpeg.to_owned(), reason };
    let output = Command::new(ffmpeg).args(["-hide_banner", "-encoders"]).stdin(Stdio::null()).output();
    let output = output.map_err(|error| broken(error.to_string()))?;
    if !output.status.success() {
        return Err(broken(output.status.to_string()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The last line that says something.
fn last_line(mut stderr: ChildStderr) -> Option<String> {
    let mut said = Vec::new();
    // What came before an error is as good as nothing or better.
    let _ = stderr.read_to_end(&mut said);
    String::from_utf8_lossy(&said).lines().rev().find(|line| !line.trim().is_empty()).map(str::to_owned)
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
        if interrupt::came() {
            break;
        }
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

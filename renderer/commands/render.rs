//! `nephroid render`: from a scene file to picture files.

mod args;
mod interrupt;
mod progress;
#[cfg(feature = "hot-reload")]
mod watch;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use thiserror::Error;

pub use args::RenderArgs;

use crate::gpu::Device;
use crate::image::{Format, ImageError, LayeredImage, atomic, openexr, png, tone};
use crate::render::{Picture, RenderError, Renderer};
use crate::scene::{self, FilmSettings, SceneError};
use crate::stats::Stats;
use progress::Display;

/// Why a rendering failed.
#[derive(Debug, Error)]
pub enum RenderCommandError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Image(#[from] ImageError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[cfg(feature = "hot-reload")]
    #[error(transparent)]
    Watch(#[from] crate::gpu::WatchError),
    #[error("the validation layers have {count} messages, of which the first is: {first}")]
    Validation { count: usize, first: String },
}

/// Renders and writes all files. The status is 0, or 130 where Ctrl-C made the picture one of fewer samples.
///
/// # Errors
/// Everything that can be checked is, before the first sample: outputs, scene, device, settings.
pub fn run(args: &RenderArgs) -> Result<ExitCode, RenderCommandError> {
    let start = Instant::now();
    let formats = args.output.iter().map(|path| atomic::check(path)).collect::<Result<Vec<_>, _>>()?;
    args.stats.as_deref().map_or(Ok(()), atomic::check_place)?;

    let scene = scene::load(&args.scene)?;
    let mut teller = Teller { quiet: args.quiet, warned: Vec::new() };
    teller.warn(&scene.warnings);

    let mut renderer = Renderer::new(scene, &args.settings())?;
    let device = renderer.device().clone();
    teller.tell_device(&renderer);
    teller.warn(&device.warnings());

    let done = render(&mut renderer, args)?;
    let Picture { image, stats } = renderer.finish()?;
    interrupt::writing();
    for (path, format) in args.output.iter().zip(formats) {
        write(path, format, &image, &renderer.scene().film)?;
    }
    args.stats.as_deref().map_or(Ok(()), |path| write_stats(path, &stats))?;

    teller.warn(&stats.warnings);
    teller.tell_result(args, done, renderer.samples(), start.elapsed());
    refuse_validation_messages(&device)?;
    Ok(if done < renderer.samples() { ExitCode::from(interrupt::STATUS) } else { ExitCode::SUCCESS })
}

/// Renders all samples, or fewer where Ctrl-C comes, and returns their number.
fn render(renderer: &mut Renderer, args: &RenderArgs) -> Result<u32, RenderCommandError> {
    #[cfg(feature = "hot-reload")]
    let mut watch = watch::Watch::new(args, renderer)?;
    interrupt::catch();
    let mut display = Display::new(renderer.samples(), args.quiet);
    let mut done = 0;
    while done < renderer.samples() && !(interrupt::came() && done > 0) {
        #[cfg(feature = "hot-reload")]
        if watch.poll(renderer, &display)? {
            display.finish();
            display = Display::new(renderer.samples(), args.quiet);
        }
        let progress = renderer.sample()?;
        display.update(&progress);
        done = progress.done;
    }
    display.finish();
    Ok(done)
}

fn write(path: &Path, format: Format, image: &LayeredImage, film: &FilmSettings) -> Result<(), ImageError> {
    match format {
        Format::Exr => openexr::write(path, image),
        Format::Png => {
            let picture = image.select(path, None)?;
            let bytes = tone::display(&picture.pixels, film.exposure, tone::curve(film.tone_curve));
            png::write(path, picture.width, picture.height, &bytes)
        }
    }
}

fn write_stats(path: &Path, stats: &Stats) -> Result<(), ImageError> {
    atomic::write(path, |mut output| {
        serde_json::to_writer_pretty(&mut output, stats).map_err(|error| error.to_string())?;
        writeln!(output).map_err(|error| error.to_string())
    })
}

fn refuse_validation_messages(device: &Device) -> Result<(), RenderCommandError> {
    let messages = device.validation_messages();
    match messages.first() {
        None => Ok(()),
        Some(first) => Err(RenderCommandError::Validation { count: messages.len(), first: first.clone() }),
    }
}

/// Says what happens: results on standard output, warnings on standard error. That nobody listens is no reason to
/// stop a rendering.
struct Teller {
    quiet: bool,
    /// Each warning is told once, as soon as it is known.
    warned: Vec<String>,
}

impl Teller {
    fn warn(&mut self, warnings: &[String]) {
        for warning in warnings {
            if !self.quiet && !self.warned.contains(warning) {
                let _ = writeln!(io::stderr(), "nephroid: warning: {warning}");
                self.warned.push(warning.clone());
            }
        }
    }

    fn tell_device(&self, renderer: &Renderer) {
        let info = &renderer.device().info;
        self.tell(format_args!("Device  {}", info.name));
        self.tell(format_args!("Driver  {} {}, Vulkan {}", info.driver, info.driver_version, info.vulkan));
        self.tell(format_args!("Tier    {}", renderer.tier()));
        self.tell(format_args!("{}", renderer.trace_choice()));
    }

    fn tell_result(&self, args: &RenderArgs, done: u32, samples: u32, time: Duration) {
        if done < samples {
            self.tell(format_args!("Stopped by Ctrl-C: the picture has {done} of {samples} samples"));
        }
        self.tell(format_args!("Time    {:.1} s for {done} samples a pixel", time.as_secs_f64()));
        for path in args.output.iter().chain(&args.stats) {
            let full = std::path::absolute(path).unwrap_or_else(|_| PathBuf::from(path));
            self.tell(format_args!("Wrote   {}", full.display()));
        }
    }

    fn tell(&self, line: std::fmt::Arguments) {
        if !self.quiet {
            let _ = writeln!(io::stdout(), "{line}");
        }
    }
}

//! What commands that render have in common on their way out: pictures into files, words to the user.

use std::fmt;
use std::io::{self, Write};
use std::path::Path;

use serde::Serialize;
use thiserror::Error;

use crate::display::Look;
use crate::gpu::Device;
use crate::image::{self, Format, ImageError, LayeredImage, atomic};
use crate::render::Renderer;
use crate::scene::animation::{Water, WaterMotion};
use crate::scene::{FilmSettings, Scene};
use crate::spans;

/// The validation layers found something.
#[derive(Debug, Error)]
#[error("the validation layers have {count} messages, of which the first is: {first}")]
pub struct ValidationError {
    count: usize,
    first: String,
}

/// Fails where the validation layers had anything to say.
pub fn refuse_validation_messages(device: &Device) -> Result<(), ValidationError> {
    let messages = device.validation_messages();
    match messages.first() {
        None => Ok(()),
        Some(first) => Err(ValidationError { count: messages.len(), first: first.clone() }),
    }
}

/// Writes a picture: all of it as EXR, as the film's settings show it as PNG.
pub fn write(path: &Path, format: Format, layers: &LayeredImage, film: &FilmSettings) -> Result<(), ImageError> {
    let _span = spans::span_of("write picture", || path.display().to_string());
    image::write(path, format, layers, Look::from(film))
}

pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), ImageError> {
    atomic::write(path, |mut output| {
        serde_json::to_writer_pretty(&mut output, value).map_err(|error| error.to_string())?;
        writeln!(output).map_err(|error| error.to_string())
    })
}

/// Says what happens: results on standard output, warnings on standard error. That nobody listens is no reason to
/// stop a rendering.
pub struct Teller {
    quiet: bool,
    /// Each warning is told once, as soon as it is known.
    warned: Vec<String>,
}

impl Teller {
    pub fn new(quiet: bool) -> Self {
        Teller { quiet, warned: Vec::new() }
    }

    pub fn warn(&mut self, warnings: &[String]) {
        for warning in warnings {
            if !self.quiet && !self.warned.contains(warning) {
                let _ = writeln!(io::stderr(), "nephroid: warning: {warning}");
                self.warned.push(warning.clone());
            }
        }
    }

    /// What a frame has to warn of. What differs from what was told before by its numbers alone is not told again: a
    /// sequence would repeat itself at every frame.
    pub fn warn_of_frame(&mut self, frame: u32, warnings: &[String]) {
        for warning in warnings {
            let numberless: String = warning.chars().filter(|c| !c.is_ascii_digit()).collect();
            if !self.quiet && !self.warned.contains(warning) && !self.warned.contains(&numberless) {
                let _ = writeln!(io::stderr(), "nephroid: warning: frame {frame}: {warning}");
                self.warned.push(numberless);
            }
        }
    }

    pub fn tell_device(&self, renderer: &Renderer) {
        let info = &renderer.device().info;
        self.tell(format_args!("Device  {}", info.name));
        self.tell(format_args!("Driver  {} {}, Vulkan {}", info.driver, info.driver_version, info.vulkan));
        self.tell(format_args!("Tier    {}", renderer.tier()));
        self.tell(format_args!("{}", renderer.trace_choice()));
    }

    /// Where `frame` is the first that is shown: simulated water has to come to it first.
    pub fn tell_late_start(&self, scene: &Scene, frame: u32) {
        let simulated = |water: &Water| matches!(water.motion, WaterMotion::Simulated(_));
        if frame > 0 && scene.animation.waters.iter().any(simulated) {
            self.tell(format_args!("Water   simulated from time 0 on to reach frame {frame}"));
        }
    }

    /// Where anti-aliasing makes the picture of `frame`, the first, of frames before it too.
    pub fn tell_frames_before(&self, renderer: &Renderer, frame: u32) {
        let first = frame.saturating_sub(renderer.taa_frames() - 1);
        if first < frame {
            self.tell(format_args!(
                "History frames {first} to {} are rendered first: the picture is made of them",
                frame - 1
            ));
        }
    }

    pub fn tell_file(&self, path: &Path) {
        let full = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.tell(format_args!("Wrote   {}", full.display()));
    }

    pub fn tell(&self, line: fmt::Arguments) {
        if !self.quiet {
            let _ = writeln!(io::stdout(), "{line}");
        }
    }
}

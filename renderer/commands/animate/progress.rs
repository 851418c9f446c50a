//! How far a sequence is: a bar on a terminal, a line a frame elsewhere, or nothing.

use std::io::{self, IsTerminal, Write};
use std::time::Instant;

use indicatif::{HumanDuration, ProgressBar};

use crate::commands::progress;
use crate::render::Progress;

/// Shows progress on standard error.
pub struct Display {
    form: Form,
    /// To be rendered in all.
    frames: u64,
    done: u64,
}

enum Form {
    Nothing,
    Bar(ProgressBar),
    Lines(Instant),
}

impl Display {
    /// For `frames` frames of `samples` samples each.
    pub fn new(frames: usize, samples: u32, quiet: bool) -> Self {
        let frames = frames as u64;
        let form = match (quiet, io::stderr().is_terminal()) {
            (true, _) => Form::Nothing,
            (false, true) => Form::Bar(progress::bar(frames * u64::from(samples), "{wide_bar} {msg}, {eta} left")),
            (false, false) => Form::Lines(Instant::now()),
        };
        Display { form, frames, done: 0 }
    }

    /// After each sample of `frame`.
    pub fn sample(&self, frame: u32, progress: &Progress) {
        if let Form::Bar(bar) = &self.form {
            let Progress { done, total, .. } = progress;
            bar.set_message(format!("frame {frame} ({} of {}), sample {done} of {total}", self.done + 1, self.frames));
            bar.set_position(self.done * u64::from(*total) + u64::from(*done));
        }
    }

    /// After the files of `frame` were written.
    pub fn frame(&mut self, frame: u32) {
        self.done += 1;
        if let Form::Lines(start) = &self.form {
            let (done, frames) = (self.done, self.frames);
            let left = HumanDuration(start.elapsed().mul_f64((frames - done) as f64 / done as f64));
            let _ = writeln!(io::stderr(), "frame {frame} is done, {done} of {frames}, {left} left");
        }
    }

    /// Takes the bar off the screen while something else is told.
    pub fn aside(&self, tell: impl FnOnce()) {
        match &self.form {
            Form::Bar(bar) => bar.suspend(tell),
            _ => tell(),
        }
    }

    /// Takes the bar off the screen.
    pub fn finish(self) {
        if let Form::Bar(bar) = self.form {
            bar.finish_and_clear();
        }
    }
}

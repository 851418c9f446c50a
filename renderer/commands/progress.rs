//! How far a rendering is: a bar on a terminal, a line every tenth elsewhere, or nothing.

use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};

use crate::render::Progress;

/// Shows progress on standard error.
pub struct Display {
    form: Form,
    /// The newest estimate, which does not come with every sample.
    error: String,
}

enum Form {
    Nothing,
    Bar(ProgressBar),
    Lines { start: Instant, tenths: u64 },
}

impl Display {
    /// `samples`: how many there will be.
    pub fn new(samples: u32, quiet: bool) -> Self {
        let form = match (quiet, io::stderr().is_terminal()) {
            (true, _) => Form::Nothing,
            (false, true) => Form::Bar(bar(samples.into(), "{wide_bar} {pos} of {len} samples, {eta} left{msg}")),
            (false, false) => Form::Lines { start: Instant::now(), tenths: 0 },
        };
        Display { form, error: String::new() }
    }

    /// After each sample.
    pub fn update(&mut self, progress: &Progress) {
        if let Some(noise) = progress.noise {
            self.error = format!(", estimated error {:.2} %", 100.0 * noise);
        }
        match &mut self.form {
            Form::Nothing => {}
            Form::Bar(bar) => {
                bar.set_message(self.error.clone());
                bar.set_position(progress.done.into());
            }
            Form::Lines { start, tenths } => {
                let now = u64::from(progress.done) * 10 / u64::from(progress.total.max(1));
                if progress.done == 1 || now > *tenths {
                    *tenths = now;
                    let left = time_left(start.elapsed(), progress);
                    let Progress { done, total, .. } = progress;
                    let _ = writeln!(io::stderr(), "sample {done} of {total}, {left} left{}", self.error);
                }
            }
        }
    }

    /// Says something that is no progress, quiet or not.
    #[cfg(feature = "hot-reload")]
    pub fn aside(&self, text: &str) {
        let tell = || drop(writeln!(io::stderr(), "{text}"));
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

/// A bar of `length` samples, in indicatif's words.
pub fn bar(length: u64, template: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(length).with_style(style);
    // A sample can take many seconds on a software device; the falling time shows that all is well.
    bar.enable_steady_tick(Duration::from_millis(250));
    bar
}

/// As long for each sample to come as for those done so far.
fn time_left(elapsed: Duration, progress: &Progress) -> HumanDuration {
    let to_come = progress.total.saturating_sub(progress.done);
    HumanDuration(elapsed.mul_f64(f64::from(to_come) / f64::from(progress.done.max(1))))
}

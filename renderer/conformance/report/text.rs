//! For people at a terminal.

use std::fmt::Write;

use super::{Outcome, Report, Run, number};

/// A run in one line, or several where it failed; ends without a newline. `details`: with all that was measured.
pub fn told(run: &Run, details: bool) -> String {
    let mut text = format!("{:<16} {:<18} {} ({:.1} s)", run.outcome.name(), run.tier, run.case, run.seconds);
    if !run.reason.is_empty() {
        let _ = write!(text, "\n    {}", run.reason);
    }
    if let Some(known) = run.known.as_ref().filter(|_| run.outcome == Outcome::ExpectedFailure) {
        let _ = write!(text, "\n    expected: {} ({})", known.reason, known.upstream);
    }
    let failed = run.outcome.fails();
    for check in run.checks.iter().filter(|check| details || (failed && !check.passed)) {
        let (measured, bound) = (number(check.measured), number(check.bound));
        let mark = if check.passed { "" } else { ", which is too much" };
        let unit = if check.unit.is_empty() { String::new() } else { format!(" {}", check.unit) };
        let _ = write!(text, "\n    {}: {measured}{unit}, allowed {bound}{mark}", check.what);
        if !check.place.is_empty() {
            let _ = write!(text, "\n        {}", check.place);
        }
    }
    for note in run.notes.iter().filter(|_| details) {
        let _ = write!(text, "\n    {}: {}", note.what, note.value);
    }
    if failed {
        let _ = write!(text, "\n    again: {}", run.rerun);
    }
    text
}

/// The last lines of a run.
pub fn summary(report: &Report) -> String {
    let s = report.summary;
    let counts = [
        (s.pass, "passed"),
        (s.fail, "failed"),
        (s.crash, "crashed"),
        (s.timeout, "took too long"),
        (s.unexpected_pass, "passed unexpectedly"),
        (s.expected_failure, "failed as expected"),
        (s.skip, "skipped"),
    ];
    let parts: Vec<String> =
        counts.into_iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect();
    let device = &report.device;
    format!(
        "{}, {} {}\n{}, in {:.0} s",
        device.name,
        device.driver,
        device.driver_version,
        parts.join(", "),
        report.seconds
    )
}

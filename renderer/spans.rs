//! Spans of time on the host and passes on the device, kept while somebody asked for them: `--trace-file` and the split
//! of a sequence's cost are made of them. While nobody has, a span costs one load of a flag.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::Instant;

use crate::stats::cpu_seconds;

/// Some 400 MB; a timeline of more is of no use to anybody. What comes later is left out and counted.
pub const MOST_EVENTS: usize = 4_000_000;

static RECORDING: AtomicBool = AtomicBool::new(false);
static LEFT_OUT: AtomicU32 = AtomicU32::new(0);
static EVENTS: Mutex<Vec<Event>> = Mutex::new(Vec::new());

/// Where a span belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Track {
    /// A thread of the host, counted from 1 in the order of their first spans.
    Host(u32),
    /// The device's queue.
    Device,
}

/// A span that has ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    pub name: String,
    /// Which frame or file, where that matters.
    pub detail: Option<String>,
    pub track: Track,
    /// Microseconds since the first span.
    pub start: f64,
    /// Microseconds.
    pub duration: f64,
    /// What this process used meanwhile, in all its threads; `None` where several passes ran at once.
    pub cpu_seconds: Option<f64>,
}

/// Keeps spans from now on.
pub fn record() {
    origin();
    RECORDING.store(true, Ordering::Relaxed);
}

/// Whether spans are kept.
pub fn recording() -> bool {
    RECORDING.load(Ordering::Relaxed)
}

/// What has ended since the last call, in the order of ends.
pub fn drain() -> Vec<Event> {
    std::mem::take(&mut EVENTS.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Counts spans that were drained and found no room where they were to be kept.
pub fn leave_out(count: usize) {
    LEFT_OUT.fetch_add(count.try_into().unwrap_or(u32::MAX), Ordering::Relaxed);
}

/// How many spans found no room.
pub fn left_out() -> u32 {
    LEFT_OUT.load(Ordering::Relaxed)
}

/// A span of the host, from now to when it is dropped.
#[must_use]
pub fn span(name: &'static str) -> Span {
    Span(mark().map(|start| (start, name, None)))
}

/// As [`span`]; `detail` is asked only where spans are kept.
#[must_use]
pub fn span_of(name: &'static str, detail: impl FnOnce() -> String) -> Span {
    Span(mark().map(|start| (start, name, Some(detail()))))
}

/// An open span.
pub struct Span(Option<(Mark, &'static str, Option<String>)>);

impl Drop for Span {
    fn drop(&mut self) {
        if let Some((start, name, detail)) = self.0.take() {
            let cpu_seconds = Some(cpu_seconds() - start.cpu_seconds);
            let duration = microseconds() - start.microseconds;
            let track = Track::Host(thread());
            keep(Event { name: name.to_owned(), detail, track, start: start.microseconds, duration, cpu_seconds });
        }
    }
}

/// A moment on the clocks that spans are measured by.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mark {
    microseconds: f64,
    cpu_seconds: f64,
}

/// Now, where spans are kept.
pub(crate) fn mark() -> Option<Mark> {
    recording().then(|| Mark { microseconds: microseconds(), cpu_seconds: cpu_seconds() })
}

/// A pass that ran alone, since `submitted`.
pub(crate) fn pass_alone(name: &str, submitted: Mark, milliseconds: f64) {
    let cpu_seconds = Some(cpu_seconds() - submitted.cpu_seconds);
    keep(on_device(name, submitted.microseconds, 1e3 * milliseconds, cpu_seconds));
}

/// Passes of one submission that was made at `submitted` and has just been waited for. `passes`: name, begin and
/// duration in milliseconds of the device's own clock.
///
/// The device's clock tells nothing about the host's, so the last pass is taken to have ended now. A wait returns some
/// microseconds after that.
pub(crate) fn passes(submitted: Mark, passes: impl Iterator<Item = (String, f64, f64)> + Clone) {
    let end = passes.clone().map(|(_, begin, duration)| begin + duration).fold(f64::NEG_INFINITY, f64::max);
    let now = microseconds();
    for (name, begin, duration) in passes {
        let start = (now - 1e3 * (end - begin)).max(submitted.microseconds);
        keep(on_device(&name, start, 1e3 * duration, None));
    }
}

fn on_device(name: &str, start: f64, duration: f64, cpu_seconds: Option<f64>) -> Event {
    Event { name: name.to_owned(), detail: None, track: Track::Device, start, duration, cpu_seconds }
}

fn keep(event: Event) {
    let mut events = EVENTS.lock().unwrap_or_else(PoisonError::into_inner);
    if events.len() < MOST_EVENTS {
        events.push(event);
    } else {
        LEFT_OUT.fetch_add(1, Ordering::Relaxed);
    }
}

fn origin() -> Instant {
    static ORIGIN: OnceLock<Instant> = OnceLock::new();
    *ORIGIN.get_or_init(Instant::now)
}

fn microseconds() -> f64 {
    origin().elapsed().as_nanos() as f64 * 1e-3
}

fn thread() -> u32 {
    static NEXT: AtomicU32 = AtomicU32::new(1);
    thread_local!(static THREAD: u32 = NEXT.fetch_add(1, Ordering::Relaxed));
    THREAD.with(|id| *id)
}

//! Which frames are there already: whole, of the right frame, and of the same request.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::pattern::Pattern;
use crate::commands::request::{self, Request};
use crate::image::{Format, ImageError, openexr, png};

/// What was found at a frame's places.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum State {
    /// All files are there as they should be; made on this device and tier, as the files name them.
    Kept(Maker),
    /// A file is not there.
    Missing,
    /// A file cannot be read to its end.
    Damaged,
    /// A file is of another scene, frame or settings, or does not say.
    Other,
}

/// Device and tier, in words.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Maker {
    pub device: String,
    pub tier: String,
}

/// The state of every frame, in their order. Files are read whole, on all cores.
pub fn look(outputs: &[(Pattern, Format)], frames: &[u32], request: &Request) -> Vec<State> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(frames.len());
    let (next, states) = (AtomicUsize::new(0), Mutex::new(vec![State::Missing; frames.len()]));
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some((index, &frame)) = {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    frames.get(index).map(|frame| (index, frame))
                } {
                    let state = state(outputs, frame, request);
                    if let Ok(mut states) = states.lock() {
                        states[index] = state;
                    }
                }
            });
        }
    });
    states.into_inner().unwrap_or_default()
}

/// The worst of its files'.
fn state(outputs: &[(Pattern, Format)], frame: u32, request: &Request) -> State {
    let files = outputs.iter().map(|(pattern, format)| {
        let path = pattern.path(frame);
        if !path.exists() {
            return State::Missing;
        }
        match attributes(&path, *format) {
            Err(_) => State::Damaged,
            Ok(found) => judge(&found, frame, request),
        }
    });
    files.max().unwrap_or(State::Missing)
}

fn judge(found: &BTreeMap<String, String>, frame: u32, request: &Request) -> State {
    let text = |name| found.get(name).map_or("", String::as_str);
    if text(request::ATTRIBUTE) == request.text() && text("nephroid.frame") == frame.to_string() {
        State::Kept(Maker { device: text("nephroid.device").to_owned(), tier: text("nephroid.tier").to_owned() })
    } else {
        State::Other
    }
}

/// Of a file that can be read to its end.
fn attributes(path: &Path, format: Format) -> Result<BTreeMap<String, String>, ImageError> {
    match format {
        Format::Exr => Ok(openexr::read(path)?.attributes),
        Format::Png => Ok(png::read_display(path)?.attributes),
    }
}

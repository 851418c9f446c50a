//! What a sequence's `--stats` holds: what was used, and what each frame took.

use serde::Serialize;
use serde_json::{Map, Value};

use super::sequence::{Frames, Shard};
use crate::spans::{Event, Track};
use crate::stats::{self, PassTotal, Stats};

/// What a still's report says of its frame alone; all else is the whole sequence's.
const OF_FRAME: [&str; 7] = ["samples", "adaptive", "passes", "ledger", "counters", "noise", "warnings"];
/// Frames with a report of some ten kilobytes of their own; those of a million would fill a machine.
const MOST_REPORTS: usize = 10_000;
/// Passes of moving the scene, which are within what the host's clock measures.
const MOVING: [&str; 2] = ["animate/", "trace/"];
/// Of the process since its start, which says nothing about a frame.
const OF_PROCESS: [&str; 3] = ["cpu_seconds", "wall_seconds", "peak_memory_bytes"];

/// A sequence's report.
#[derive(Debug, Serialize)]
pub struct SequenceStats {
    pub first: u32,
    /// Included.
    pub last: u32,
    /// Frames a second.
    pub fps: f64,
    pub shard: Shard,
    /// Frames that were there already.
    pub kept: Vec<u32>,
    /// What [`Stats`] says of all frames alike; empty where none was rendered.
    #[serde(flatten)]
    shared: Map<String, Value>,
    /// Sums over the frames that were rendered.
    total: Split,
    frames: Vec<FrameStats>,
    cpu_seconds: f64,
    wall_seconds: f64,
    peak_memory_bytes: u64,
}

#[derive(Debug, Serialize)]
struct FrameStats {
    frame: u32,
    /// Of the scene's animation.
    seconds: f64,
    split: Split,
    /// Empty where [`MOST_REPORTS`] frames came before.
    #[serde(flatten)]
    own: Map<String, Value>,
}

/// Where a frame's time went.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Split {
    /// Moving the scene: poses, vertices, their way to the device.
    pub animate: Cost,
    /// Fitting the tracing structures to it.
    pub refit: Cost,
    /// The passes of the frame itself: visibility, walk, direct light, film.
    pub frame: Cost,
    /// The technique's passes, and what it does on the host before the first.
    pub technique: Cost,
    /// Reading the film back, finding motion vectors where they are wanted, and writing the files.
    pub output: Cost,
    /// From start to end, with all that has no name above.
    pub whole: Cost,
}

/// A part of a frame's time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cost {
    /// On the host's clock; for passes on the device's. `None` where a pass was not timed.
    pub milliseconds: Option<f64>,
    /// Of all threads of this process, a software device's too. `None` where passes run together, so that it cannot be
    /// shared out.
    pub cpu_seconds: Option<f64>,
}

impl Default for Cost {
    fn default() -> Self {
        Cost { milliseconds: Some(0.0), cpu_seconds: Some(0.0) }
    }
}

impl Cost {
    pub fn include(&mut self, other: Cost) {
        let sum = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a + b);
        self.milliseconds = sum(self.milliseconds, other.milliseconds);
        self.cpu_seconds = sum(self.cpu_seconds, other.cpu_seconds);
    }

    fn add(&mut self, event: &Event) {
        self.include(Cost { milliseconds: Some(event.duration * 1e-3), cpu_seconds: event.cpu_seconds });
    }
}

impl Split {
    /// Counts what happened while the scene moved.
    pub fn moved(&mut self, events: &[Event]) {
        for event in events.iter().filter(|event| event.track != Track::Device) {
            match event.name.as_str() {
                "animate" => self.animate.add(event),
                "refit" => self.refit.add(event),
                "restart technique" => self.technique.add(event),
                _ => {}
            }
        }
    }

    /// Counts what happened while samples were rendered, those of frames before that a picture is made of among them.
    pub fn rendered(&mut self, events: &[Event]) {
        self.moved(events);
        let moves = |event: &Event| MOVING.iter().any(|folder| event.name.starts_with(folder));
        for event in events.iter().filter(|event| event.track == Track::Device && !moves(event)) {
            self.part(&event.name).add(event);
        }
    }

    /// Takes back what is said of parts with passes that were not timed. `passes`: all of the frame.
    pub fn untimed(&mut self, passes: &[PassTotal]) {
        for pass in passes.iter().filter(|pass| pass.milliseconds.is_none()) {
            // Those of motion vectors and anti-aliasing, too.
            let mut by_host = MOVING.iter().chain(&["frame/motion", "taa/"]);
            let by_host = by_host.any(|name| pass.name.starts_with(name));
            if !by_host {
                *self.part(&pass.name) = Cost { milliseconds: None, cpu_seconds: None };
            }
        }
    }

    /// Where a pass that renders a sample belongs.
    fn part(&mut self, pass: &str) -> &mut Cost {
        match pass.split_once('/').map_or("", |(folder, _)| folder) {
            "frame" | "film" | "taa" => &mut self.frame,
            // What the host reads between samples is no work of the technique.
            "memory" => &mut self.output,
            _ => &mut self.technique,
        }
    }

    fn include(&mut self, other: &Split) {
        for (sum, part) in [
            (&mut self.animate, other.animate),
            (&mut self.refit, other.refit),
            (&mut self.frame, other.frame),
            (&mut self.technique, other.technique),
            (&mut self.output, other.output),
            (&mut self.whole, other.whole),
        ] {
            sum.include(part);
        }
    }
}

/// A stretch of time, on the wall's clock and the process's.
#[derive(Debug, Clone, Copy)]
pub struct Watch {
    wall: std::time::Instant,
    cpu: f64,
}

impl Watch {
    pub fn start() -> Self {
        Watch { wall: std::time::Instant::now(), cpu: stats::cpu_seconds() }
    }

    pub fn cost(&self) -> Cost {
        let cpu_seconds = Some(stats::cpu_seconds() - self.cpu);
        Cost { milliseconds: Some(1e3 * self.wall.elapsed().as_secs_f64()), cpu_seconds }
    }
}

impl SequenceStats {
    pub fn new(frames: Frames, fps: f64, shard: Shard, kept: Vec<u32>) -> Self {
        SequenceStats {
            first: frames.first,
            last: frames.last,
            fps,
            shard,
            kept,
            shared: Map::new(),
            total: Split::default(),
            frames: Vec::new(),
            cpu_seconds: 0.0,
            wall_seconds: 0.0,
            peak_memory_bytes: 0,
        }
    }

    /// Takes up a frame that was rendered.
    pub fn add(&mut self, frame: u32, stats: &Stats, split: Split) {
        let Ok(Value::Object(mut shared)) = serde_json::to_value(stats) else { return };
        let mut own: Map<_, _> =
            OF_FRAME.iter().filter_map(|key| Some(((*key).to_owned(), shared.remove(*key)?))).collect();
        if self.frames.len() >= MOST_REPORTS {
            own.clear();
        }
        OF_PROCESS.iter().for_each(|key| drop(shared.remove(*key)));
        self.shared = shared;
        self.total.include(&split);
        self.peak_memory_bytes = self.peak_memory_bytes.max(stats.peak_memory_bytes);
        self.frames.push(FrameStats { frame, seconds: f64::from(frame) / self.fps, split, own });
    }

    /// Before it is written. `wall_seconds`: since the program's start.
    pub fn finish(&mut self, wall_seconds: f64) {
        (self.cpu_seconds, self.wall_seconds) = (stats::cpu_seconds(), wall_seconds);
    }
}

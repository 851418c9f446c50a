//! `--trace-file`: spans in Chrome's trace event format, which ui.perfetto.dev and chrome://tracing open.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use crate::image::{ImageError, atomic};
use crate::spans::{self, Event, Track};

/// The format knows processes and threads; the device is shown as a process of its own.
const HOST: u32 = 1;
const DEVICE: u32 = 2;

/// The spans of a whole run, and where they will be written.
pub struct TraceFile {
    path: PathBuf,
    events: Vec<Event>,
    /// For so many more.
    room: usize,
}

impl TraceFile {
    /// Keeps spans from now on, for a file at `path`.
    pub fn start(path: &Path) -> TraceFile {
        spans::record();
        TraceFile { path: path.to_owned(), events: Vec::new(), room: spans::MOST_EVENTS }
    }

    /// Keeps `events` too, as many as there is room for: a sequence may be longer than memory.
    pub fn extend(&mut self, events: Vec<Event>) {
        let kept = events.len().min(self.room);
        self.room -= kept;
        spans::leave_out(events.len() - kept);
        self.events.extend(events.into_iter().take(kept));
    }

    /// Writes what was kept up to now. `device`: its name.
    ///
    /// # Errors
    /// [`ImageError::Write`].
    pub fn write(mut self, device: &str) -> Result<PathBuf, ImageError> {
        self.extend(spans::drain());
        atomic::write(&self.path, |output| {
            write_events(output, &self.events, device).map_err(|error| error.to_string())
        })?;
        Ok(self.path)
    }
}

fn write_events(mut output: impl Write, events: &[Event], device: &str) -> io::Result<()> {
    let other = json!({ "software": crate::image::openexr::SOFTWARE, "spans_left_out": spans::left_out() });
    write!(output, "{{\"displayTimeUnit\": \"ms\", \"otherData\": {other}, \"traceEvents\": [")?;
    let threads = events.iter().filter_map(|event| match event.track {
        Track::Host(thread) => Some(thread),
        Track::Device => None,
    });
    let mut threads: Vec<u32> = threads.collect();
    threads.sort_unstable();
    threads.dedup();
    let mut separator = "\n";
    let processes = [(HOST, "host: nephroid".to_owned()), (DEVICE, format!("device: {device}"))];
    let names = processes.iter().flat_map(|(process, name)| {
        let order = metadata("process_sort_index", *process, 0, json!({ "sort_index": process }));
        [metadata("process_name", *process, 0, json!({ "name": name })), order]
    });
    let threads = threads.iter().map(|&thread| {
        let name = if thread == 1 { "main".to_owned() } else { format!("thread {thread}") };
        metadata("thread_name", HOST, thread, json!({ "name": name }))
    });
    let queue = metadata("thread_name", DEVICE, 1, json!({ "name": "passes" }));
    for event in names.chain(threads).chain([queue]).chain(events.iter().map(complete)) {
        write!(output, "{separator}{event}")?;
        separator = ",\n";
    }
    writeln!(output, "\n]}}")
}

fn metadata(name: &str, process: u32, thread: u32, args: Value) -> Value {
    json!({ "ph": "M", "name": name, "pid": process, "tid": thread, "args": args })
}

fn complete(event: &Event) -> Value {
    let (process, thread, category) = match event.track {
        Track::Host(thread) => (HOST, thread, "host"),
        Track::Device => (DEVICE, 1, "device"),
    };
    let mut args = Map::new();
    if let Some(detail) = &event.detail {
        args.insert("of".to_owned(), detail.clone().into());
    }
    if let Some(seconds) = event.cpu_seconds {
        args.insert("cpu_ms".to_owned(), (1e3 * seconds).into());
    }
    json!({
        "ph": "X", "name": event.name, "cat": category, "pid": process, "tid": thread,
        "ts": event.start, "dur": event.duration, "args": args,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_timeline_has_an_end() {
        let event = Event {
            name: String::new(),
            detail: None,
            track: Track::Device,
            start: 0.0,
            duration: 1.0,
            cpu_seconds: None,
        };
        let mut file = TraceFile { path: PathBuf::new(), events: Vec::new(), room: 2 };
        let before = spans::left_out();
        file.extend(vec![event.clone()]);
        file.extend(vec![event; 3]);
        assert_eq!((file.events.len(), spans::left_out() - before), (2, 2));
    }
}

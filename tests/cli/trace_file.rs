//! `--trace-file`: what a viewer of Chrome's trace events shows is what happened.

use std::collections::BTreeMap;
use std::fs;

use serde_json::Value;

use crate::program::Folder;

/// Microseconds are written as decimal fractions; a nanosecond is the clock's own step.
const ROUNDING: f64 = 1e-3;
/// Of sums of durations that both files hold in full.
const RELATIVE: f64 = 1e-9;

fn read(folder: &Folder, name: &str) -> Value {
    serde_json::from_slice(&fs::read(folder.at(name)).unwrap()).unwrap()
}

fn events(file: &Value) -> Vec<&Value> {
    file["traceEvents"].as_array().unwrap().iter().filter(|event| event["ph"] == "X").collect()
}

/// Begin, end, name.
type Span<'a> = (f64, f64, &'a str);

/// Every span ends inside of the one that is open when it begins.
fn assert_nested(events: &[&Value]) {
    let mut tracks: BTreeMap<(u64, u64), Vec<Span>> = BTreeMap::new();
    for event in events {
        let number = |field: &str| event[field].as_f64().unwrap();
        let track = (event["pid"].as_u64().unwrap(), event["tid"].as_u64().unwrap());
        let span = (number("ts"), number("ts") + number("dur"), event["name"].as_str().unwrap());
        tracks.entry(track).or_default().push(span);
    }
    for spans in tracks.values_mut() {
        spans.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
        let mut open: Vec<Span> = Vec::new();
        for &span in spans.iter() {
            while open.last().is_some_and(|outer| outer.1 <= span.0 + ROUNDING) {
                open.pop();
            }
            assert!(open.last().is_none_or(|outer| span.1 <= outer.1 + ROUNDING), "{span:?} leaves {:?}", open.last());
            open.push(span);
        }
    }
}

/// Milliseconds of each pass, from a list as in `--stats`.
fn add_passes(sums: &mut BTreeMap<String, f64>, passes: &Value) {
    for pass in passes.as_array().unwrap() {
        *sums.entry(pass["name"].as_str().unwrap().to_owned()).or_default() += pass["milliseconds"].as_f64().unwrap();
    }
}

/// Every pass of the report is on the device's track, and takes as long there. The report leaves out what prepares a
/// technique.
fn assert_same_passes(events: &[&Value], report: &BTreeMap<String, f64>) {
    assert!(report.len() >= 3, "{report:?}");
    let start = |event: &Value| event["ts"].as_f64().unwrap();
    let end = |event: &Value| start(event) + event["dur"].as_f64().unwrap();
    let preparing = |event: &&&Value| event["name"] == "make pipelines" || event["name"] == "restart technique";
    let left_out: Vec<_> = events.iter().filter(preparing).map(|event| (start(event), end(event))).collect();
    for (name, milliseconds) in report {
        let spans = events.iter().filter(|event| event["pid"] == 2 && event["name"] == name.as_str());
        let counted = spans.filter(|event| !left_out.iter().any(|(from, to)| (from..=to).contains(&&start(event))));
        let sum: f64 = counted.map(|event| 1e-3 * event["dur"].as_f64().unwrap()).sum();
        let differs = format!("{name} takes {sum} ms, and {milliseconds} ms by --stats");
        assert!((sum - milliseconds).abs() <= RELATIVE * milliseconds, "{differs}");
    }
}

fn assert_has(events: &[&Value], names: &[&str]) {
    for name in names {
        assert!(events.iter().any(|event| event["pid"] == 1 && event["name"] == *name), "there is no span '{name}'");
    }
}

const KEPT: &str = "--trace bvh --samples 3 --stats s.json --trace-file t.json --quiet";

#[test]
fn a_still_leaves_its_spans() {
    let folder = Folder::new();
    // On every device: passes are timed by the host or by the device.
    for device in 0..folder.device_names().len() {
        folder.run(&format!("render scene.toml --technique none -o a.png --device {device} {KEPT}"));
        let (file, stats) = (read(&folder, "t.json"), read(&folder, "s.json"));
        let events = events(&file);
        assert_nested(&events);
        let before = ["load scene", "open device", "upload scene", "build tracing structures", "make pipelines"];
        assert_has(&events, &before);
        assert_has(&events, &["sample", "record", "submit and wait", "read back", "write picture"]);
        let mut report = BTreeMap::new();
        add_passes(&mut report, &stats["passes"]);
        assert_same_passes(&events, &report);
        let named: Vec<_> =
            file["traceEvents"].as_array().unwrap().iter().filter(|e| e["name"] == "process_name").collect();
        assert_eq!(named[1]["args"]["name"], format!("device: {}", stats["device"].as_str().unwrap()));
    }
}

#[test]
fn a_sequence_leaves_its_spans() {
    let folder = Folder::new();
    folder.run(&format!("animate scene.toml --technique mnee --frames 1..2 -o f_%d.png {KEPT}"));
    let (file, stats) = (read(&folder, "t.json"), read(&folder, "s.json"));
    let events = events(&file);
    assert_nested(&events);
    let frames = events.iter().filter(|event| event["name"] == "frame");
    assert_eq!(frames.map(|event| event["args"]["of"].as_str().unwrap()).collect::<Vec<_>>(), ["1", "2"]);
    let mut report = BTreeMap::new();
    stats["frames"].as_array().unwrap().iter().for_each(|frame| add_passes(&mut report, &frame["passes"]));
    assert_same_passes(&events, &report);
}

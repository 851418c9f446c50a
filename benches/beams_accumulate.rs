//! What adding up the light of given beams costs, by each tier: those of a lamp under flat water, clear and turbid, seen from
//! in it. `cargo bench --bench beams_accumulate -- 360` for a picture of 480x360.
//!
//! CPU-s of one sample beyond the frame's own passes, and the fragments of hulls that were drawn.

#[path = "../tests/beams/mod.rs"]
mod beams;
#[path = "../tests/common/mod.rs"]
mod common;

use std::path::Path;

use beams::flat_water::flat_water_beams;
use beams::stage::{Stage, counter};
use cpu_time::ProcessTime;
use nephroid::frame::Sampling;
use nephroid::gpu::{Device, DeviceRequest, Recorder};
use nephroid::scene;
use nephroid::technique::beams::accumulate::{Accumulator, Bounds, Options, Tier};

/// Squares along a side of the water, of two beams each.
const CELLS: u32 = 160;

fn main() {
    // The other argument is what cargo adds.
    let side = std::env::args().find_map(|a| a.parse().ok()).unwrap_or(360u32);
    let device = Device::open(&DeviceRequest::default()).unwrap();
    println!("{}, {} x {side} pixels", device.info.describe(), side * 4 / 3);
    let points = Options { footprints: false, ..Options::DEFAULT };
    let with = |tier, bounds| Options { tier: Some(tier), bounds, ..points };
    let rows = [
        ("tiles, footprints", Options::DEFAULT),
        ("tiles", points),
        ("vertices, six", with(Tier::Vertices, Bounds::Six)),
        ("vertices, prism", with(Tier::Vertices, Bounds::Prism)),
        ("geometry, six", with(Tier::Geometry, Bounds::Six)),
        ("geometry, prism", with(Tier::Geometry, Bounds::Prism)),
    ];
    let beams = flat_water_beams(CELLS);
    let clear = std::fs::read_to_string("scenes/flat_water.toml").unwrap();
    let turbid = clear.replace("index = 1.33", "index = 1.33\nscattering = 0.05\nabsorption = 0.05");
    for (name, text) in [("clear", clear), ("turbid", turbid)] {
        let scene = scene::parse(&text, Path::new("scenes/flat_water.toml")).unwrap();
        let mut stage = Stage::on(device.clone(), scene, (side * 4 / 3, side), Sampling::Uniform);
        for (what, options) in rows {
            let accumulator = stage.accumulator(&beams, options);
            sample(&mut stage, Some(&accumulator)); // makes pipelines
            let before = counter(&accumulator, "beam_fragments_drawn");
            let frame = sample(&mut stage, None);
            let all = sample(&mut stage, Some(&accumulator));
            let drawn = counter(&accumulator, "beam_fragments_drawn") - before;
            println!("{name}, {} beams, {what}: {:.3} CPU-s, {drawn} fragments drawn", beams.len(), all - frame);
        }
    }
}

/// CPU-s of a sample with what an accumulator adds to it.
fn sample(stage: &mut Stage, accumulator: Option<&Accumulator>) -> f64 {
    let started = ProcessTime::now();
    let mut recorder = Recorder::new(&stage.device).unwrap();
    stage.frame.record(&mut recorder, 1).unwrap();
    if let Some(accumulator) = accumulator {
        accumulator.record(&stage.frame, &mut recorder, true).unwrap();
    }
    recorder.submit().unwrap();
    started.elapsed().as_secs_f64()
}

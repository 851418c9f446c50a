//! What adding up the light of given beams costs, by each tier: those of a lamp under flat water, clear and turbid, seen from
//! in it. CPU-s of one sample beyond the frame's own passes, and the fragments of hulls that were drawn.

use std::error::Error;
use std::path::Path;

use cpu_time::ProcessTime;
use nephroid::frame::Sampling;
use nephroid::gpu::{Device, GpuError, Recorder};
use nephroid::scene;
use nephroid::technique::beams::accumulate::{Accumulator, Bounds, Options, Tier};

use crate::beams::flat_water::flat_water_beams;
use crate::beams::stage::{Stage, counter};

const SIZE: (u32, u32) = (480, 360);

/// Squares along a side of the water, of two beams each.
const CELLS: u32 = 160;

#[derive(Debug, Clone, serde::Serialize)]
struct Row {
    water: &'static str,
    tier: &'static str,
    seconds: f64,
    drawn: f64,
}

pub fn measure(asked: &crate::Options, device: &Device) -> Result<serde_json::Value, Box<dyn Error>> {
    let points = Options { footprints: false, ..Options::DEFAULT };
    let with = |tier, bounds| Options { tier: Some(tier), bounds, ..points };
    let tiers = [
        ("tiles, footprints", Options::DEFAULT),
        ("tiles", points),
        ("vertices, six", with(Tier::Vertices, Bounds::Six)),
        ("vertices, prism", with(Tier::Vertices, Bounds::Prism)),
        ("geometry, six", with(Tier::Geometry, Bounds::Six)),
        ("geometry, prism", with(Tier::Geometry, Bounds::Prism)),
    ];
    let beams = flat_water_beams(CELLS);
    let path = Path::new("scenes/flat_water.toml");
    let clear = std::fs::read_to_string(path)?;
    let turbid = clear.replace("index = 1.33", "index = 1.33\nscattering = 0.05\nabsorption = 0.05");
    println!("{} beams under flat water\nwater  tier                CPU-s      drawn", beams.len());
    let mut rows = Vec::new();
    for (water, text) in [("clear", clear), ("turbid", turbid)] {
        let size = asked.settings.size.unwrap_or(SIZE);
        let mut stage = Stage::on(device.clone(), scene::parse(&text, path)?, size, Sampling::Uniform);
        for (tier, options) in tiers {
            let accumulator = stage.accumulator(&beams, options);
            sample(&mut stage, Some(&accumulator))?; // makes pipelines
            let before = counter(&accumulator, "beam_fragments_drawn");
            let frame = sample(&mut stage, None)?;
            let seconds = sample(&mut stage, Some(&accumulator))? - frame;
            let drawn = counter(&accumulator, "beam_fragments_drawn") - before;
            println!("{water:<6} {tier:<18} {seconds:>6.3} {drawn:>10}");
            rows.push(Row { water, tier, seconds, drawn });
        }
    }
    println!();
    Ok(serde_json::json!({ "beams": beams.len(), "rows": rows }))
}

/// CPU-s of a sample with what an accumulator adds to it.
fn sample(stage: &mut Stage, accumulator: Option<&Accumulator>) -> Result<f64, GpuError> {
    let started = ProcessTime::now();
    let mut recorder = Recorder::new(&stage.device)?;
    stage.frame.record(&mut recorder, 1)?;
    if let Some(accumulator) = accumulator {
        accumulator.record(&stage.frame, &mut recorder, true)?;
    }
    recorder.submit()?;
    Ok(started.elapsed().as_secs_f64())
}

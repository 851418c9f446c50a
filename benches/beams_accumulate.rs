//! What adding up the light of given beams costs: `cargo bench --bench beams_accumulate`.

#[path = "../tests/beams/mod.rs"]
mod beams;
#[path = "../tests/common/mod.rs"]
mod common;

use cpu_time::ProcessTime;

use beams::flat_water::flat_water_beams;
use beams::stage::Stage;
use nephroid::frame::Sampling;
use nephroid::gpu::{Device, DeviceRequest, Recorder};
use nephroid::scene;
use nephroid::technique::beams::accumulate::{Integral, Options};

fn main() {
    let side: u32 = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(360);
    let size = (side * 4 / 3, side);
    let device = Device::open(&DeviceRequest::default()).unwrap();
    println!("{}", device.info.name);
    for (name, medium) in [("turbid", "\nscattering = 0.05\nabsorption = 0.05")] {
        let text = std::fs::read_to_string("scenes/flat_water.toml")
            .unwrap()
            .replace("index = 1.33", &format!("index = 1.33{medium}"));
        let scene = || scene::parse(&text, std::path::Path::new("scenes/flat_water.toml")).unwrap();
        let mut stage = Stage::on(device.clone(), scene(), size, Sampling::Uniform);
        for cells in [160] {
            let beams = flat_water_beams(cells);
            for (what, options) in [
                ("points", Options::default()),
                ("midpoint", Options { integral: Integral::Midpoint, ..Default::default() }),
            ] {
                let accumulator = stage.accumulator(&beams, options);
                let mut record = |index: u32, accumulate: bool| {
                    let started = ProcessTime::now();
                    let mut recorder = Recorder::new(&device).unwrap();
                    stage.frame.record(&mut recorder, index).unwrap();
                    if accumulate {
                        accumulator.record(&stage.frame, &mut recorder, true).unwrap();
                    }
                    recorder.submit().unwrap();
                    started.elapsed().as_secs_f64()
                };
                // The first makes pipelines.
                record(0, true);
                let frame = record(1, false);
                let all = record(1, true);
                println!("{name} {} beams {what}: {:.3} CPU-s", beams.len(), all - frame);
                println!("   {:?}", accumulator.counters().unwrap().iter().map(|c| c.value).collect::<Vec<_>>());
            }
        }
    }
}

//! What adding up the light of given beams costs: `cargo bench --bench beams_accumulate`.

#[path = "../tests/beams/mod.rs"]
mod beams;
#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use beams::flat_water::flat_water_beams;
use beams::stage::Stage;
use nephroid::frame::Sampling;
use nephroid::gpu::{Device, DeviceRequest, Recorder};
use nephroid::scene;
use nephroid::technique::beams::accumulate::{Integral, Options, Shadows};

fn main() {
    let size = (480, 360);
    let device = Device::open(&DeviceRequest::default()).unwrap();
    println!("{}", device.info.name);
    for (name, medium) in [("clear", ""), ("turbid", "\nscattering = 0.05\nabsorption = 0.05")] {
        let text = std::fs::read_to_string("scenes/flat_water.toml")
            .unwrap()
            .replace("index = 1.33", &format!("index = 1.33{medium}"));
        let scene = || scene::parse(&text, std::path::Path::new("scenes/flat_water.toml")).unwrap();
        let mut stage = Stage::on(device.clone(), scene(), size, Sampling::Uniform);
        for cells in [80, 160] {
            let beams = flat_water_beams(cells);
            for (what, options) in [
                ("points", Options::default()),
                ("edges", Options { shadows: Shadows::Edges, ..Default::default() }),
                ("midpoint", Options { integral: Integral::Midpoint, ..Default::default() }),
            ] {
                let started = Instant::now();
                let accumulator = stage.accumulator(&beams, options);
                let made = started.elapsed().as_secs_f64();
                for round in 0..2 {
                    let mut recorder = Recorder::new(&device).unwrap();
                    stage.frame.record(&mut recorder, round).unwrap();
                    accumulator.record(&stage.frame, &mut recorder, true).unwrap();
                    let times = recorder.submit().unwrap();
                    if round == 0 {
                        continue;
                    }
                    let ms: Vec<String> = times
                        .iter()
                        .filter(|t| t.name.starts_with("beams"))
                        .map(|t| format!("{} {:.0}", t.name, t.milliseconds.unwrap_or_default()))
                        .collect();
                    println!("{name} {} beams {what} (made in {made:.1} s): {}", beams.len(), ms.join(", "));
                }
                println!("   {:?}", accumulator.counters().unwrap().iter().map(|c| c.value).collect::<Vec<_>>());
            }
        }
    }
}

//! Time to quality: error and time at every doubling of uniform samples, and at budgets of adaptive ones.
//!
//! Time is the process's CPU time on a software device, else the clock's. Set-up stands apart: opening the device, reading
//! the scene and building trees; and what the first sample takes beyond the others, mostly footprints. A short run of
//! each kind comes before, so that kernels are in the driver's cache by then: without one, llvmpipe compiles them for
//! 20 s in the first sample of each run.

use std::error::Error;
use std::time::Instant;

use nephroid::image::metrics::Metrics;
use nephroid::render::{RenderSettings, Renderer};
use nephroid::{scene, stats};

use crate::report::Truth;
use crate::{Options, about};

const SIZE: (u32, u32) = (120, 90);
const SAMPLES: u32 = 64;
const CAMERA: &str = "under";
/// relRMSE to come below.
const GOALS: [f64; 3] = [0.10, 0.05, 0.02];

/// Work that is done once a surface; `mnee/clear` clears more than this but is small.
const SURFACE_PASSES: [&str; 3] = ["mnee/surface", "mnee/landing", "mnee/footprint"];

#[derive(Debug, Clone, Copy, serde::Serialize)]
struct Row {
    samples: u32,
    /// Of all samples, the first one's set-up left out.
    seconds: f64,
    rel_rmse: f64,
    energy_ratio: f64,
}

/// Before samples, and of the first one beyond the others.
#[derive(Debug, Clone, Copy, Default, serde::Serialize)]
struct SetUp {
    seconds: f64,
    first_sample_seconds: f64,
    /// Of the first sample, by the device's clock; 0 without timestamps.
    surface_milliseconds: f64,
}

/// Seconds that count on this device.
struct Timer {
    software: bool,
    start: Instant,
}

impl Timer {
    fn now(&self) -> f64 {
        if self.software { stats::cpu_seconds() } else { self.start.elapsed().as_secs_f64() }
    }
}

pub fn measure(options: &Options) -> Result<serde_json::Value, Box<dyn Error>> {
    let truth = Truth::read(&options.truth, &options.layer, options.mask.as_deref())?;
    let uniform = RenderSettings {
        camera: Some(options.settings.camera.clone().unwrap_or(CAMERA.to_string())),
        size: Some(options.settings.size.unwrap_or(SIZE)),
        samples: Some(options.settings.samples.unwrap_or(SAMPLES)),
        ..options.settings.clone()
    };
    let kernels = fill_cache(options, &uniform, &truth)?;
    let (device, set_up, rows) = run(options, &uniform, &truth)?;
    println!("{device}, camera {}", uniform.camera.as_deref().unwrap_or_default());
    println!("kernels made in {kernels:.1} s, little where the driver had them cached\n");
    header();
    let mut results = vec![finish("uniform", set_up, &rows)];
    println!();
    header();
    let mut budgets = Vec::new();
    let mut largest = SetUp::default();
    for &samples in &options.adaptive {
        let settings = RenderSettings { samples: Some(samples), adaptive: true, ..uniform.clone() };
        let (_, set_up, rows) = run(options, &settings, &truth)?;
        budgets.extend(rows.last());
        largest = set_up;
    }
    results.push(finish("adaptive", largest, &budgets));
    println!();
    Ok(serde_json::json!({ "device": device, "size": uniform.size, "kernels_seconds": kernels, "runs": results }))
}

/// Seconds that the first samples of the shortest runs take beyond their second ones.
fn fill_cache(options: &Options, uniform: &RenderSettings, truth: &Truth) -> Result<f64, Box<dyn Error>> {
    let mut seconds = 0.0;
    for adaptive in [false, true] {
        let settings = RenderSettings { samples: Some(2), adaptive, ..uniform.clone() };
        seconds += run(options, &settings, truth)?.1.first_sample_seconds;
    }
    Ok(seconds)
}

/// Renders all samples. Uniform ones are measured at every doubling, adaptive ones at the end, for which they are planned.
fn run(
    options: &Options,
    settings: &RenderSettings,
    truth: &Truth,
) -> Result<(String, SetUp, Vec<Row>), Box<dyn Error>> {
    let (cpu, start) = (stats::cpu_seconds(), Instant::now());
    let mut renderer = Renderer::new(scene::load(&options.scene)?, settings)?;
    let timer = Timer { software: renderer.device().info.kind == "cpu", start };
    let made = timer.now();
    let mut set_up = SetUp { seconds: if timer.software { made - cpu } else { made }, ..Default::default() };
    renderer.sample()?;
    let first = timer.now() - made;
    set_up.surface_milliseconds = surface_milliseconds(&renderer)?;
    let (mut rows, mut later) = (Vec::new(), 0.0);
    for _ in 1..renderer.samples() {
        let before = timer.now();
        let done = renderer.sample()?.done;
        later += timer.now() - before;
        if done == renderer.samples() || (done.is_power_of_two() && !settings.adaptive) {
            let seconds = later * f64::from(done) / f64::from(done - 1);
            let Metrics { rel_rmse, energy_ratio, .. } = truth.error(&renderer, &options.layer)?;
            rows.push(Row { samples: done, seconds, rel_rmse, energy_ratio });
        }
    }
    set_up.first_sample_seconds = first - later / f64::from(renderer.samples().max(2) - 1);
    Ok((about(&renderer), set_up, rows))
}

fn surface_milliseconds(renderer: &Renderer) -> Result<f64, Box<dyn Error>> {
    let passes = renderer.finish()?.stats.passes;
    Ok(passes.iter().filter(|p| SURFACE_PASSES.contains(&p.name.as_str())).filter_map(|p| p.milliseconds).sum())
}

fn header() {
    println!("{:<9} {:>8} {:>9} {:>9} {:>9}", "", "samples", "s", "relRMSE", "energy");
}

/// Prints what was measured and when each goal was met.
fn finish(name: &str, set_up: SetUp, rows: &[Row]) -> serde_json::Value {
    for row in rows {
        println!(
            "{name:<9} {:>8} {:>9.2} {:>8.2}% {:>9.5}",
            row.samples,
            row.seconds,
            100.0 * row.rel_rmse,
            row.energy_ratio
        );
    }
    println!(
        "set-up {:.2} s, and {:.2} s more in the first sample (of that {:.0} ms surfaces and footprints)",
        set_up.seconds, set_up.first_sample_seconds, set_up.surface_milliseconds
    );
    for goal in GOALS {
        let percent = 100.0 * goal;
        match rows.iter().position(|row| row.rel_rmse <= goal) {
            Some(met) => println!(
                "{percent:>4.0} %: {:>8.2} s at {} samples{}",
                rows[met].seconds,
                rows[met].samples,
                between(&rows[..=met], goal).map_or(String::new(), |s| format!("; about {s:.2} s by interpolation"))
            ),
            None => println!("{percent:>4.0} %: not met"),
        }
    }
    let met: Vec<_> = GOALS.iter().map(|&goal| (goal, rows.iter().find(|row| row.rel_rmse <= goal))).collect();
    serde_json::json!({ "name": name, "set_up": set_up, "rows": rows, "goals": met })
}

/// Seconds to `goal` between the last two rows, error taken as a power of time.
fn between(rows: &[Row], goal: f64) -> Option<f64> {
    let [.., a, b] = rows else { return None };
    let part = (a.rel_rmse / goal).ln() / (a.rel_rmse / b.rel_rmse).ln();
    Some(a.seconds * (b.seconds / a.seconds).powf(part))
}

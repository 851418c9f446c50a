//! Error by levels of refinement, at every doubling of samples.

use std::error::Error;
use std::path::PathBuf;

use nephroid::gpu::Device;

use crate::Options;
use crate::report::Truth;
use crate::report::run::Run;
use crate::run::{dropped, items, settings, truth};

/// relRMSE to come below.
const GOALS: [f64; 3] = [0.10, 0.05, 0.02];

/// The pool's.
const CAMERAS: [&str; 2] = ["under", "above"];

#[derive(Debug, Clone, serde::Serialize)]
struct Row {
    camera: String,
    levels: u32,
    samples: u32,
    /// Of the last set.
    beams: f64,
    /// Of vertices, sheets and beams, what there was no room for.
    dropped: f64,
    rel_rmse: f64,
    energy_ratio: f64,
    seconds: f64,
    /// What became of the device's capabilities.
    tier: String,
}

pub fn measure(options: &Options, device: &Device) -> Result<serde_json::Value, Box<dyn Error>> {
    let all = || CAMERAS.map(String::from).to_vec();
    let mut rows = Vec::new();
    for camera in options.settings.camera.clone().map_or_else(all, |camera| vec![camera]) {
        let truth = truth(options, &camera)?;
        println!("camera {camera}, {:?} pixels\nlevels samples     beams  relRMSE    energy  CPU-s", truth.size());
        let mut found = Vec::new();
        for &levels in &options.levels {
            found.extend(row_of_doublings(options, device, &camera, levels, &truth)?);
        }
        for goal in GOALS {
            print_goal(goal, &found);
        }
        println!();
        rows.extend(found);
    }
    Ok(serde_json::json!({ "rows": rows }))
}

/// The quickest to come below an error.
fn print_goal(goal: f64, rows: &[Row]) {
    let percent = 100.0 * goal;
    let met = rows.iter().filter(|row| row.rel_rmse <= goal).min_by(|a, b| a.seconds.total_cmp(&b.seconds));
    match met {
        Some(row) => println!("{percent:>4.0} %: {:.2} s, {} levels, {} samples", row.seconds, row.levels, row.samples),
        None => println!("{percent:>4.0} %: not met"),
    }
}

/// Samples until `options.seconds` are gone.
fn row_of_doublings(
    options: &Options,
    device: &Device,
    camera: &str,
    levels: u32,
    truth: &Truth,
) -> Result<Vec<Row>, Box<dyn Error>> {
    let scene: PathBuf = options.scene.clone().unwrap_or_else(|| "scenes/pool.toml".into());
    // The truth is of light refracted once.
    let set = items(&[("bounces", "1"), ("levels", &levels.to_string())]);
    let mut run = Run::new(device, &scene, &settings(options, Some(camera), truth.size(), &set))?;
    let mut rows = Vec::new();
    loop {
        run.sample()?;
        if !run.renderer.done().is_power_of_two() {
            continue;
        }
        let metrics = truth.error(&run.renderer, &options.layer)?;
        let row = Row {
            camera: camera.to_string(),
            levels,
            samples: run.renderer.done(),
            beams: run.counter("beams")?,
            dropped: dropped(&run)?,
            rel_rmse: metrics.rel_rmse,
            energy_ratio: metrics.energy_ratio,
            seconds: run.seconds,
            tier: run.renderer.tier(),
        };
        print(&row);
        rows.push(row);
        // The next doubling takes as long again.
        if 2.0 * run.seconds > options.seconds {
            return Ok(rows);
        }
    }
}

fn print(row: &Row) {
    let room = if row.dropped > 0.0 { format!(", no room for {}", row.dropped) } else { String::new() };
    println!(
        "{:>6} {:>7} {:>9} {:>7.2}% {:>9.5} {:>6.2}{room}",
        row.levels,
        row.samples,
        row.beams,
        100.0 * row.rel_rmse,
        row.energy_ratio,
        row.seconds
    );
}

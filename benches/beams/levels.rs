//! Error by levels of refinement, at every doubling of samples.

use std::error::Error;
use std::path::{Path, PathBuf};

use crate::Options;
use crate::run::{Run, Truth, items, settings};

/// relRMSE to come below.
const GOALS: [f64; 3] = [0.10, 0.05, 0.02];

#[derive(Debug, Clone, Copy, serde::Serialize)]
struct Row {
    levels: u32,
    samples: u32,
    /// Of the last set.
    beams: f64,
    rel_rmse: f64,
    energy_ratio: f64,
    seconds: f64,
}

pub fn measure(options: &Options) -> Result<serde_json::Value, Box<dyn Error>> {
    let truth = Truth::of(options)?;
    let scene: PathBuf = options.scene.clone().unwrap_or_else(|| "scenes/pool.toml".into());
    let mut rows = Vec::new();
    let mut device = String::new();
    for &levels in &options.levels {
        device = row_of_doublings(options, &scene, levels, &truth, &mut rows)?;
    }
    for goal in GOALS {
        let met = rows.iter().filter(|row| row.rel_rmse <= goal).min_by(|a, b| a.seconds.total_cmp(&b.seconds));
        match met {
            Some(row) => println!(
                "{:>4.0} %: {:.2} s, {} levels, {} samples",
                100.0 * goal,
                row.seconds,
                row.levels,
                row.samples
            ),
            None => println!("{:>4.0} %: not met", 100.0 * goal),
        }
    }
    println!();
    Ok(serde_json::json!({ "device": device, "size": truth.size(), "rows": rows }))
}

/// Samples until `options.seconds` are gone.
fn row_of_doublings(
    options: &Options,
    scene: &Path,
    levels: u32,
    truth: &Truth,
    rows: &mut Vec<Row>,
) -> Result<String, Box<dyn Error>> {
    // The truth is of light refracted once.
    let set = items(&[("bounces", "1"), ("levels", &levels.to_string())]);
    let mut run = Run::new(scene, &settings(options, Some("under"), truth.size(), &set))?;
    if rows.is_empty() {
        println!("{}", run.about());
        println!("levels samples     beams  relRMSE    energy  CPU-s");
    }
    loop {
        run.sample()?;
        let samples = run.renderer.done();
        if samples.is_power_of_two() {
            let metrics = run.error(truth, &options.layer)?;
            let row = Row {
                levels,
                samples,
                beams: run.counter("beams")?,
                rel_rmse: metrics.rel_rmse,
                energy_ratio: metrics.energy_ratio,
                seconds: run.seconds,
            };
            println!(
                "{levels:>6} {samples:>7} {:>9} {:>7.2}% {:>9.5} {:>6.2}",
                row.beams,
                100.0 * row.rel_rmse,
                row.energy_ratio,
                row.seconds
            );
            rows.push(row);
            // The next doubling takes as long again.
            if 2.0 * run.seconds > options.seconds {
                return Ok(run.about());
            }
        }
    }
}

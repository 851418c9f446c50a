//! Grids refined where they have to be against a static one of 64 x 64 cells, at equal error.
//!
//! One sample without jitter, so that the error is the grid's. For each number of levels the coarsest `deviation` that still
//! comes to the static grid's error is looked for. Fragments are what the tier that draws shades at points.

use std::error::Error;
use std::path::PathBuf;

use nephroid::gpu::Device;

use crate::Options;
use crate::report::Truth;
use crate::report::run::Run;
use crate::run::{Split, items, settings, truth};

/// Pixels that an edge's middle may land beside the mean of its ends: from where to where, and how often the range is
/// halved, by its logarithm.
const DEVIATIONS: (f64, f64) = (1.0, 1000.0);
const HALVINGS: u32 = 7;

const CAMERA: &str = "under";

#[derive(Debug, Clone, serde::Serialize)]
struct Row {
    name: String,
    beams: f64,
    rel_rmse: f64,
    energy_ratio: f64,
    split: Split,
    /// By what is drawn; only of those at equal error.
    fragments: Option<f64>,
}

/// What all rows share.
struct Bench<'a> {
    options: &'a Options,
    device: &'a Device,
    truth: Truth,
}

pub fn measure(options: &Options, device: &Device) -> Result<serde_json::Value, Box<dyn Error>> {
    let truth = truth(options, options.settings.camera.as_deref().unwrap_or(CAMERA))?;
    let bench = Bench { options, device, truth };
    let mut rows = Vec::new();
    println!("grid                       beams  relRMSE   energy fragments  made ms added ms");
    let grid = [("grid", "64"), ("levels", "0"), ("least_level", "0")].map(owned);
    let stands = bench.drawn(bench.row("static 64 x 64".to_string(), &grid)?, &grid)?;
    rows.push(stands.clone());
    let mut equal: Vec<Row> = Vec::new();
    for &levels in &options.levels {
        let refined = |deviation: f64| {
            // By deviation alone: where all of a surface focuses light, the rule for focus splits all of it.
            let mut set = [("grid", "16"), ("split_energy", "off")].map(owned).to_vec();
            set.extend([("levels", levels.to_string()), ("deviation", format!("{deviation:.3}"))]);
            set
        };
        let (mut fine, mut coarse) = DEVIATIONS;
        let mut best = None;
        for _ in 0..HALVINGS {
            let deviation = (fine * coarse).sqrt();
            let set = refined(deviation);
            let row = bench.row(format!("{levels} levels, {deviation:.2} pixels"), &set)?;
            rows.push(row.clone());
            if row.rel_rmse <= stands.rel_rmse {
                fine = deviation;
                best = Some((row, set));
            } else {
                coarse = deviation;
            }
        }
        match best {
            Some((row, set)) => equal.push(bench.drawn(row, &set)?),
            None => println!("{levels} levels do not come to the static grid's error"),
        }
    }
    println!("at its error, parts of the static grid's:");
    for row in &equal {
        let part = |value: fn(&Row) -> f64| value(row) / value(&stands);
        println!(
            "{:<22} beams {:.2}, fragments {:.2}, time {:.2} to make and {:.2} to add up",
            row.name,
            part(|row| row.beams),
            part(|row| row.fragments.unwrap_or(0.0)),
            part(|row| row.split.generation),
            part(|row| row.split.accumulation)
        );
    }
    println!();
    Ok(serde_json::json!({ "rows": rows, "equal": equal }))
}

fn owned((key, value): (&'static str, &str)) -> (&'static str, String) {
    (key, value.to_string())
}

impl Bench<'_> {
    fn run(&self, set: &[(&str, String)], more: &[(&str, &str)]) -> Result<Run, Box<dyn Error>> {
        let Bench { options, device, truth } = self;
        let scene: PathBuf = options.scene.clone().unwrap_or_else(|| "scenes/pool.toml".into());
        let set: Vec<(&str, &str)> = set.iter().map(|(key, value)| (*key, value.as_str())).collect();
        let set = items(&[&[("bounces", "1"), ("jitter", "off")], &set[..], more].concat());
        let mut run = Run::new(device, &scene, &settings(options, Some(CAMERA), truth.size(), &set))?;
        run.sample()?;
        Ok(run)
    }

    fn row(&self, name: String, set: &[(&str, String)]) -> Result<Row, Box<dyn Error>> {
        let run = self.run(set, &[])?;
        let metrics = self.truth.error(&run.renderer, &self.options.layer)?;
        let row = Row {
            name,
            beams: run.counter("beams")?,
            rel_rmse: metrics.rel_rmse,
            energy_ratio: metrics.energy_ratio,
            split: Split::of(&run)?,
            fragments: None,
        };
        print(&row);
        Ok(row)
    }

    /// With the fragments of hulls.
    fn drawn(&self, row: Row, set: &[(&str, String)]) -> Result<Row, Box<dyn Error>> {
        let run = self.run(set, &[("accumulate", "vertices"), ("footprint", "point")])?;
        let row = Row { fragments: Some(run.counter("beam_fragments_drawn")?), ..row };
        print(&row);
        Ok(row)
    }
}

fn print(row: &Row) {
    println!(
        "{:<22} {:>9} {:>7.2}% {:>8.5} {:>9} {:>8.0} {:>8.0}",
        row.name,
        row.beams,
        100.0 * row.rel_rmse,
        row.energy_ratio,
        row.fragments.map_or("-".to_string(), |n| n.to_string()),
        row.split.generation,
        row.split.accumulation
    );
}

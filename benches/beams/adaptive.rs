//! Grids refined where they have to be against a static one of 64 x 64 cells, at equal error.
//!
//! One sample without jitter, so that the error is the grid's. Fragments are what the tier that draws shades at points.

use std::error::Error;
use std::path::PathBuf;

use crate::Options;
use crate::run::{Run, Split, Truth, items, settings};

/// Pixels that an edge's middle may land beside the mean of its ends.
const DEVIATIONS: [&str; 6] = ["64", "32", "16", "8", "4", "2"];

#[derive(Debug, Clone, serde::Serialize)]
struct Row {
    name: String,
    beams: f64,
    rel_rmse: f64,
    energy_ratio: f64,
    fragments: f64,
    split: Split,
}

pub fn measure(options: &Options) -> Result<serde_json::Value, Box<dyn Error>> {
    let truth = Truth::of(options)?;
    let mut rows = Vec::new();
    println!("grid                     beams  relRMSE   energy fragments  made ms added ms");
    let grid = [("grid", "64"), ("levels", "0"), ("least_level", "0")];
    rows.push(row(options, &truth, "static 64 x 64", &grid)?);
    for &levels in &options.levels {
        for deviation in DEVIATIONS {
            let levels = levels.to_string();
            let set = [("grid", "16"), ("levels", levels.as_str()), ("least_level", "0"), ("deviation", deviation)];
            // By deviation alone: where all of a surface focuses light, the rule for focus splits all of it.
            let set = [&set[..], &[("split_energy", "off")]].concat();
            rows.push(row(options, &truth, &format!("{levels} levels, {deviation} pixels"), &set)?);
        }
    }
    let stands = &rows[0];
    let equal = rows[1..].iter().filter(|row| row.rel_rmse <= stands.rel_rmse);
    if let Some(best) = equal.min_by(|a, b| a.beams.total_cmp(&b.beams)) {
        let part = |value: fn(&Row) -> f64| value(best) / value(stands);
        println!(
            "at its error {} takes {:.2} of the static grid's beams, {:.2} of its fragments, {:.2} of its time\n",
            best.name,
            part(|row| row.beams),
            part(|row| row.fragments),
            part(|row| row.split.generation + row.split.accumulation)
        );
    }
    Ok(serde_json::json!({ "rows": rows }))
}

fn row(options: &Options, truth: &Truth, name: &str, set: &[(&str, &str)]) -> Result<Row, Box<dyn Error>> {
    let scene: PathBuf = options.scene.clone().unwrap_or_else(|| "scenes/pool.toml".into());
    let common = [("bounces", "1"), ("jitter", "off")];
    let run = |more: &[(&str, &str)]| -> Result<Run, Box<dyn Error>> {
        let set = items(&[&common, set, more].concat());
        let mut run = Run::new(&scene, &settings(options, Some("under"), truth.size(), &set))?;
        run.sample()?;
        Ok(run)
    };
    let pixels = run(&[])?;
    let drawn = run(&[("accumulate", "vertices"), ("footprint", "point")])?;
    let metrics = pixels.error(truth, &options.layer)?;
    let row = Row {
        name: name.to_string(),
        beams: pixels.counter("beams")?,
        rel_rmse: metrics.rel_rmse,
        energy_ratio: metrics.energy_ratio,
        fragments: drawn.counter("beam_fragments_drawn")?,
        split: pixels.split()?,
    };
    print(&row);
    Ok(row)
}

fn print(row: &Row) {
    println!(
        "{:<20} {:>9} {:>7.2}% {:>8.5} {:>9} {:>8.0} {:>8.0}",
        row.name,
        row.beams,
        100.0 * row.rel_rmse,
        row.energy_ratio,
        row.fragments,
        row.split.generation,
        row.split.accumulation
    );
}

//! What is drawn in a beam's place: hulls of six sides against prisms, from either tier.

use std::error::Error;
use std::path::PathBuf;

use nephroid::gpu::Device;

use crate::Options;
use crate::report::run::Run;
use crate::run::{Split, items, settings};

const SIZE: (u32, u32) = (240, 180);
const SCENES: [&str; 2] = ["scenes/pool.toml", "scenes/turbid_pool.toml"];

#[derive(Debug, Clone, serde::Serialize)]
struct Row {
    scene: PathBuf,
    tier: &'static str,
    bounds: &'static str,
    beams: f64,
    /// Shaded by a rasteriser, of points and volumes.
    drawn: f64,
    split: Split,
}

pub fn measure(options: &Options, device: &Device) -> Result<serde_json::Value, Box<dyn Error>> {
    let scenes = options.scene.clone().map_or(SCENES.map(PathBuf::from).to_vec(), |scene| vec![scene]);
    println!("scene             tier      bounds     beams      drawn  made ms added ms");
    let mut rows = Vec::new();
    for scene in scenes {
        for tier in ["vertices", "geometry"] {
            for bounds in ["six", "prism"] {
                let set = items(&[("accumulate", tier), ("bounds", bounds), ("footprint", "point"), ("levels", "4")]);
                let mut run = Run::new(device, &scene, &settings(options, None, SIZE, &set))?;
                run.sample()?;
                let row = Row {
                    scene: scene.clone(),
                    tier,
                    bounds,
                    beams: run.counter("beams")?,
                    drawn: run.counter("beam_fragments_drawn")?,
                    split: Split::of(&run)?,
                };
                print(&row);
                rows.push(row);
            }
        }
    }
    println!();
    Ok(serde_json::json!({ "rows": rows }))
}

fn print(row: &Row) {
    println!(
        "{:<17} {:<9} {:<6} {:>9} {:>10} {:>8.0} {:>8.0}",
        row.scene.file_stem().unwrap_or_default().to_string_lossy(),
        row.tier,
        row.bounds,
        row.beams,
        row.drawn,
        row.split.generation,
        row.split.accumulation
    );
}

//! What beams take to make and to add up, scene by scene.

use std::error::Error;
use std::path::PathBuf;

use nephroid::gpu::Device;

use crate::Options;
use crate::report::run::Run;
use crate::run::{Split, settings};

const SIZE: (u32, u32) = (256, 192);
const SCENES: [&str; 7] = ["pool", "turbid_pool", "glass_sphere", "water_sphere", "smoke", "skull", "cup"];

#[derive(Debug, Clone, serde::Serialize)]
struct Row {
    scene: PathBuf,
    beams: f64,
    split: Split,
    seconds: f64,
}

pub fn measure(options: &Options, device: &Device) -> Result<serde_json::Value, Box<dyn Error>> {
    let shipped = || SCENES.map(|name| PathBuf::from(format!("scenes/{name}.toml"))).to_vec();
    let scenes = options.scene.clone().map_or_else(shipped, |scene| vec![scene]);
    println!("scene                 beams  made ms added ms frame ms  CPU-s");
    let mut rows = Vec::new();
    for scene in scenes {
        let mut run = Run::new(device, &scene, &settings(options, None, SIZE, &[]))?;
        run.sample()?;
        let row = Row { scene, beams: run.counter("beams")?, split: Split::of(&run)?, seconds: run.seconds };
        println!(
            "{:<17} {:>9} {:>8.0} {:>8.0} {:>8.0} {:>6.2}",
            row.scene.file_stem().unwrap_or_default().to_string_lossy(),
            row.beams,
            row.split.generation,
            row.split.accumulation,
            row.split.frame,
            row.seconds
        );
        rows.push(row);
    }
    println!();
    Ok(serde_json::json!({ "size": options.settings.size.unwrap_or(SIZE), "rows": rows }))
}

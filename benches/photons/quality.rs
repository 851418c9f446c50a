//! Error and energy by photons and sets, against the reference's light of one specular event.

use std::error::Error;
use std::path::{Path, PathBuf};

use nephroid::gpu::Device;
use nephroid::image::metrics::compare;
use nephroid::image::{Mask, RgbImage};
use nephroid::render::{RenderSettings, Renderer};
use nephroid::technique::TechniqueKind;

use crate::Options;
use crate::report::run::Run;
use crate::run::{items, name_of, scenes, settings};

const SIZE: (u32, u32) = (256, 192);
/// Sets of photons at which errors are taken, one a sample.
const SETS: [u32; 3] = [1, 4, 16];

#[derive(Debug, Clone, serde::Serialize)]
struct Row {
    scene: PathBuf,
    photons: u32,
    rescue: String,
    sets: u32,
    rel_rmse: f64,
    energy_ratio: f64,
    /// CPU seconds on a software device.
    seconds: f64,
}

/// Caustic light as the camera sees it: what a picture has more than one without.
fn seen(renderer: &Renderer, dark: &RgbImage) -> Result<RgbImage, Box<dyn Error>> {
    let mut picture = final_of(renderer)?;
    for (pixel, dark) in picture.pixels.iter_mut().zip(&dark.pixels) {
        (0..3).for_each(|c| pixel[c] -= dark[c]);
    }
    Ok(picture)
}

fn final_of(renderer: &Renderer) -> Result<RgbImage, Box<dyn Error>> {
    Ok(renderer.finish()?.image.select(Path::new("the picture"), None)?)
}

pub fn measure(options: &Options, device: &Device) -> Result<serde_json::Value, Box<dyn Error>> {
    println!("scene           photons rescue sets  relRMSE   energy      s");
    let mut rows = Vec::new();
    for scene in scenes(options) {
        let own = settings(options, SIZE, &[]);
        // Direct light has noise of its own at edges: each number of samples has the picture without caustics at that.
        let none = RenderSettings { technique: TechniqueKind::None, set: Vec::new(), ..own.clone() };
        let set = ["reference.photons=1000000", "reference.reuse=1", "reference.paths=once"].map(String::from).to_vec();
        let reference = RenderSettings { technique: TechniqueKind::Reference, set, ..own };
        let truth = {
            let [mut lit, mut dark] = [Run::new(device, &scene, &reference)?, Run::new(device, &scene, &none)?];
            for _ in 0..options.reference {
                lit.sample()?;
                dark.sample()?;
            }
            seen(&lit.renderer, &final_of(&dark.renderer)?)?
        };
        let mask = Mask::full(truth.width, truth.height);
        for rescue in ["off", "rays"] {
            for &photons in &options.photons {
                let set = items(&[("photons", &photons.to_string()), ("rescue", rescue)]);
                let mut run = Run::new(device, &scene, &settings(options, SIZE, &set))?;
                let mut dark = Run::new(device, &scene, &none)?;
                for sets in 1..=SETS[2] {
                    run.sample()?;
                    dark.sample()?;
                    if !SETS.contains(&sets) {
                        continue;
                    }
                    let found = compare(&seen(&run.renderer, &final_of(&dark.renderer)?)?, &truth, &mask)?;
                    let row = Row {
                        scene: scene.clone(),
                        photons,
                        rescue: rescue.to_string(),
                        sets,
                        rel_rmse: found.rel_rmse,
                        energy_ratio: found.energy_ratio,
                        seconds: run.seconds,
                    };
                    println!(
                        "{:<15} {photons:>7} {rescue:<6} {sets:>4} {:>7.2}% {:>8.5} {:>6.2}",
                        name_of(&scene),
                        100.0 * row.rel_rmse,
                        row.energy_ratio,
                        row.seconds
                    );
                    rows.push(row);
                }
            }
        }
    }
    println!();
    Ok(
        serde_json::json!({ "size": options.settings.size.unwrap_or(SIZE), "reference_samples": options.reference, "rows": rows }),
    )
}

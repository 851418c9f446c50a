//! Error and energy by photons, sets and filter, against the reference's light of one specular event.

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
/// From a first radius that is small from the first set on, since light is lost where larger ones hang over edges: 3 % of the
/// hall's ceiling at 160x120.
const REFERENCE: [&str; 5] = [
    "reference.photons=1000000",
    "reference.reuse=1",
    "reference.paths=once",
    "reference.neighbours=0",
    "reference.radius=0.5",
];
const RESCUES: [&str; 2] = ["off", "rays"];

#[derive(Debug, Clone, serde::Serialize)]
struct Row {
    scene: PathBuf,
    photons: u32,
    rescue: &'static str,
    denoise: String,
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
    println!("scene           photons rescue denoise  sets  relRMSE   energy      s");
    let mut rows = Vec::new();
    for scene in scenes(options) {
        let own = settings(options, SIZE, &[]);
        // Direct light has noise of its own at edges: each number of samples has the picture without caustics at that.
        let none = RenderSettings { technique: TechniqueKind::None, set: Vec::new(), ..own.clone() };
        let mut dark = Run::new(device, &scene, &none)?;
        let mut darks = Vec::new();
        for sets in 1..=options.reference.max(SETS[2]) {
            dark.sample()?;
            if SETS.contains(&sets) || sets == options.reference {
                darks.push((sets, final_of(&dark.renderer)?));
            }
        }
        let dark_at =
            |sets: u32| darks.iter().find(|(at, _)| *at == sets).map(|(_, dark)| dark).ok_or("no such samples");
        let set = REFERENCE.map(String::from).to_vec();
        let mut lit = Run::new(device, &scene, &RenderSettings { technique: TechniqueKind::Reference, set, ..own })?;
        for _ in 0..options.reference {
            lit.sample()?;
        }
        let truth = seen(&lit.renderer, dark_at(options.reference)?)?;
        let mask = Mask::full(truth.width, truth.height);
        let runs = RESCUES.iter().flat_map(|rescue| options.photons.iter().map(move |photons| (*rescue, *photons)));
        for (rescue, photons) in runs {
            for denoise in &options.denoise {
                let set = items(&[("photons", &photons.to_string()), ("rescue", rescue), ("denoise", denoise)]);
                let settings = settings(options, SIZE, &set);
                let mut run = Run::new(device, &scene, &settings)?;
                // A filter's history does not begin with the sample that made pipelines.
                run.renderer.set_technique(settings.technique, &settings.set)?;
                for sets in 1..=SETS[2] {
                    run.sample()?;
                    if !SETS.contains(&sets) {
                        continue;
                    }
                    let found = compare(&seen(&run.renderer, dark_at(sets)?)?, &truth, &mask)?;
                    let row = Row {
                        scene: scene.clone(),
                        photons,
                        rescue,
                        denoise: denoise.clone(),
                        sets,
                        rel_rmse: found.rel_rmse,
                        energy_ratio: found.energy_ratio,
                        seconds: run.seconds,
                    };
                    println!(
                        "{:<15} {photons:>7} {rescue:<6} {denoise:<8} {sets:>4} {:>7.2}% {:>8.5} {:>6.2}",
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
    let size = options.settings.size.unwrap_or(SIZE);
    Ok(serde_json::json!({ "size": size, "reference_samples": options.reference, "rows": rows }))
}

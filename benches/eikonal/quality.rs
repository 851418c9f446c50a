//! Error by how brightness is found.

use std::error::Error;
use std::path::Path;

use nephroid::gpu::Device;
use nephroid::image::RgbImage;
use nephroid::render::RenderSettings;
use nephroid::technique::TechniqueKind;

use crate::Options;
use crate::report::Truth;
use crate::report::run::Run;

/// Settings of `eikonal`, a run each. The last one's gain is fitted to `pool` by hand, as the paper does it.
pub const RUNS: [&str; 10] = [
    "resolution=64",
    "resolution=128",
    "resolution=256",
    "resolution=128,solver=sweeps",
    "resolution=128,dissipation=waves",
    "resolution=128,intensity=laplacian",
    "resolution=128,intensity=laplacian,dissipation=waves",
    "resolution=128,index=infinite,solver=marching,order=first,start=printed,intensity=laplacian,sides=printed",
    "resolution=128,intensity=wave",
    "resolution=128,index=infinite,intensity=wave,start=printed,sum=absolute,gain=0.13",
];

#[derive(serde::Serialize)]
struct Row {
    run: String,
    rel_rmse: f64,
    correlation: f64,
    energy_ratio: f64,
    /// CPU-seconds of the first sample, which solves for volumes, and of each after it.
    first: f64,
    further: f64,
}

pub fn measure(options: &Options, device: &Device) -> Result<serde_json::Value, Box<dyn Error>> {
    let (truth, settings) = truth(options, device)?;
    let size = truth.size();
    println!("{}, {size:?} pixels, {} samples, layer {}", options.scene.display(), options.samples, options.layer);
    println!("| settings | relRMSE | correlation | energy | CPU-s, first | a sample |");
    println!("|---|---|---|---|---|---|");
    let mut rows = Vec::new();
    for run in &options.runs {
        let set = run.iter().map(|item| format!("eikonal.{item}")).collect();
        let settings = RenderSettings { set, technique: TechniqueKind::Eikonal, ..settings.clone() };
        let mut one = Run::new(device, &options.scene, &settings)?;
        one.sample()?;
        let first = one.seconds;
        for _ in 1..options.samples {
            one.sample()?;
        }
        let metrics = truth.error(&one.renderer, &options.layer)?;
        let picture = one.renderer.finish()?.image.select(Path::new("the picture"), Some(&options.layer))?;
        let row = Row {
            run: run.join(","),
            rel_rmse: metrics.rel_rmse,
            correlation: correlation(&picture, &truth),
            energy_ratio: metrics.energy_ratio,
            first,
            further: (one.seconds - first) / f64::from((options.samples - 1).max(1)),
        };
        println!(
            "| {} | {:.1} % | {:.3} | {:.4} | {:.2} | {:.2} |",
            row.run,
            100.0 * row.rel_rmse,
            row.correlation,
            row.energy_ratio,
            row.first,
            row.further
        );
        rows.push(row);
    }
    println!();
    Ok(serde_json::json!({ "rows": rows }))
}

/// What pictures are held against, and how they are to be rendered.
fn truth(options: &Options, device: &Device) -> Result<(Truth, RenderSettings), Box<dyn Error>> {
    let samples = Some(options.samples);
    if let Some(path) = &options.truth {
        let truth = Truth::read(path, &options.layer, options.mask.as_deref())?;
        let size = Some(truth.size());
        return Ok((truth, RenderSettings { size, samples, ..options.settings.clone() }));
    }
    // Of light that is refracted once, which is all that eikonal finds.
    let settings = RenderSettings {
        technique: TechniqueKind::Reference,
        samples: Some(options.reference),
        set: vec!["reference.paths=refracted-once".to_string()],
        ..options.settings.clone()
    };
    let mut run = Run::new(device, &options.scene, &settings)?;
    for _ in 0..options.reference {
        run.sample()?;
    }
    let picture = run.renderer.finish()?.image.select(Path::new("the reference"), Some(&options.layer))?;
    Ok((Truth::of(picture), RenderSettings { samples, ..options.settings.clone() }))
}

/// Pearson's, of the channels' means where the truth holds.
fn correlation(picture: &RgbImage, truth: &Truth) -> f64 {
    let mean = |pixel: &[f32; 3]| f64::from(pixel[0] + pixel[1] + pixel[2]) / 3.0;
    let pairs: Vec<(f64, f64)> =
        truth.pixels().zip(&picture.pixels).filter_map(|(truth, found)| Some((mean(found), mean(truth?)))).collect();
    let count = pairs.len().max(1) as f64;
    let (a, b) = (pairs.iter().map(|p| p.0).sum::<f64>() / count, pairs.iter().map(|p| p.1).sum::<f64>() / count);
    let sum = |of: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|p| of(p.0 - a, p.1 - b)).sum::<f64>();
    sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt()
}

//! What the filter of `photons` does to noise, frame by frame: relative RMSE and energy against the mean of many unfiltered
//! sets, and how much pixels vary from frame to frame.
//!
//! `cargo bench --bench denoise` shows 32 frames of a sample each of the pool, still; `--moving yes` lets the scene's water
//! run. `--scene`, `--camera`, `--layer`, `--size`, `--frames`, `--photons`, `--truth` (samples), `--set`, `--device`, `--trace`,
//! `--pictures` (a folder for the last frame of each run) and `--runs` (settings of `photons` joined by `+`, runs apart by
//! `,`) change that. Prints a table and writes `target/bench/denoise.json`.
//!
//! The truth has noise of its own, which is in all numbers; it is rendered for the frames that errors are shown of.

#[path = "report/mod.rs"]
mod report;

use std::error::Error;
use std::path::{Path, PathBuf};

use nephroid::image::openexr;
use nephroid::render::{RenderSettings, Renderer};
use nephroid::scene;
use nephroid::technique::TechniqueKind;
use report::options;

/// Frames whose errors are shown, counted from 1.
const SHOWN: [u32; 4] = [1, 8, 16, 32];
/// Of the frames, the part before which they are not counted in the variance.
const WARM_UP: u32 = 2;
const TRUTH_SEED: u32 = 99;
/// Of a set of the truth, over those of a run.
const TRUTH_PHOTONS: u32 = 10;

struct Options {
    scene: PathBuf,
    layer: String,
    frames: u32,
    photons: u32,
    truth: u32,
    moving: bool,
    pictures: Option<PathBuf>,
    runs: Vec<String>,
    settings: RenderSettings,
}

#[derive(serde::Serialize)]
struct Row {
    settings: String,
    /// Of the frames of `SHOWN`: relative RMSE, and energy over the truth's.
    errors: Vec<(u32, f64, f64)>,
    /// RMS over pixels of the standard deviation over frames, over the truth's mean.
    variation: f64,
    milliseconds: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = options()?;
    let shown: Vec<u32> = SHOWN.into_iter().filter(|frame| *frame <= options.frames).collect();
    let mut truth = renderer(&options, "", TRUTH_SEED)?;
    let mut truths = Vec::new();
    for &frame in shown.iter().take(if options.moving { shown.len() } else { 1 }) {
        go_to(&options, &mut truth, frame)?;
        for _ in 0..options.truth {
            truth.sample()?;
        }
        truths.push(picture(&options, &truth)?);
    }
    drop(truth);
    let mut rows = Vec::new();
    for run in &options.runs {
        let mut renderer = renderer(&options, run, 0)?;
        let mut frames = Vec::new();
        let mut milliseconds = 0.0;
        for frame in 1..=options.frames {
            // Without a history each frame of a still scene is the same, noise and all.
            if !run.contains("temporal") {
                renderer = self::renderer(&options, run, frame)?;
            }
            go_to(&options, &mut renderer, frame)?;
            renderer.sample()?;
            frames.push(picture(&options, &renderer)?);
            let filter = ["photons/reproject", "photons/accumulate", "photons/guide", "photons/wavelet"];
            let passes = renderer.passes().iter().filter(|pass| filter.contains(&pass.name.as_str()));
            milliseconds += passes.filter_map(|pass| pass.milliseconds).sum::<f64>();
        }
        if let Some(folder) = &options.pictures {
            let name = if run.is_empty() { "raw" } else { run };
            openexr::write(&folder.join(format!("{name}.exr")), &renderer.finish()?.image)?;
        }
        let of = |index: usize| &truths[index.min(truths.len() - 1)];
        let errors = shown.iter().enumerate().map(|(index, &frame)| {
            let (error, energy) = against(&frames[frame as usize - 1], of(index));
            (frame, error, energy)
        });
        let row = Row {
            settings: run.clone(),
            errors: errors.collect(),
            variation: variation(&frames[(options.frames / WARM_UP) as usize..]) / mean(of(0)),
            milliseconds: milliseconds / f64::from(options.frames),
        };
        let errors = row.errors.iter().map(|(frame, error, energy)| format!("{frame}: {error:.3} ({energy:.4})"));
        let errors = errors.collect::<Vec<_>>().join("  ");
        println!("{run:<50} {errors}  variation {:.3}  {:.1} ms", row.variation, row.milliseconds);
        rows.push(row);
    }
    report::write(
        "denoise",
        serde_json::json!({ "scene": options.scene, "photons": options.photons, "moving": options.moving, "rows": rows }),
    )
}

fn renderer(options: &Options, run: &str, seed: u32) -> Result<Renderer, Box<dyn Error>> {
    let photons = options.photons * if seed == TRUTH_SEED { TRUTH_PHOTONS } else { 1 };
    let mut set = vec![format!("photons.photons={photons}"), "photons.rescue=rays".to_string()];
    set.extend(options.settings.set.iter().cloned());
    set.extend(run.split('+').filter(|item| !item.is_empty()).map(|item| format!("photons.{item}")));
    let samples = if seed == TRUTH_SEED { options.truth } else { 1 };
    let settings = RenderSettings { samples: Some(samples), seed, set, ..options.settings.clone() };
    Ok(Renderer::new(scene::load(&options.scene)?, &settings)?)
}

fn go_to(options: &Options, renderer: &mut Renderer, frame: u32) -> Result<(), Box<dyn Error>> {
    let gone = if options.moving { renderer.go_to(frame) } else { renderer.restart() };
    Ok(gone?)
}

/// Channels, pixel by pixel.
fn picture(options: &Options, renderer: &Renderer) -> Result<Vec<f32>, Box<dyn Error>> {
    let picture = renderer.finish()?.image.select(Path::new("the picture"), Some(&options.layer))?;
    Ok(picture.pixels.into_iter().flatten().collect())
}

fn mean(picture: &[f32]) -> f64 {
    picture.iter().map(|&v| f64::from(v)).sum::<f64>() / picture.len() as f64
}

/// RMSE over the truth's mean, and the ratio of means.
fn against(found: &[f32], truth: &[f32]) -> (f64, f64) {
    let squares: f64 = found.iter().zip(truth).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    ((squares / found.len() as f64).sqrt() / mean(truth), mean(found) / mean(truth))
}

/// RMS over pixels of the standard deviation over frames.
fn variation(frames: &[Vec<f32>]) -> f64 {
    let count = frames.len() as f64;
    let variance = |pixel: usize| {
        let values = || frames.iter().map(|frame| f64::from(frame[pixel]));
        let mean = values().sum::<f64>() / count;
        values().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0)
    };
    let pixels = frames.first().map_or(0, Vec::len);
    ((0..pixels).map(variance).sum::<f64>() / pixels as f64).sqrt()
}

fn options() -> Result<Options, Box<dyn Error>> {
    let mut options = Options {
        scene: "scenes/pool.toml".into(),
        layer: "refracted".to_string(),
        frames: 32,
        photons: 100_000,
        truth: 64,
        moving: false,
        pictures: None,
        runs: ["", "denoise=spatial", "denoise=temporal", "denoise=temporal+history=fixed"].map(String::from).to_vec(),
        settings: RenderSettings {
            technique: TechniqueKind::Photons,
            camera: Some("under".to_string()),
            size: Some((320, 240)),
            trace: "bvh".parse()?,
            ..Default::default()
        },
    };
    for (name, value) in options::given()? {
        match name.as_str() {
            "--scene" => options.scene = value.into(),
            "--layer" => options.layer = value,
            "--frames" => options.frames = value.parse::<u32>()?.max(1),
            "--photons" => options.photons = value.parse()?,
            "--truth" => options.truth = value.parse::<u32>()?.max(1),
            "--moving" => options.moving = value == "yes",
            "--pictures" => options.pictures = Some(value.into()),
            "--runs" => options.runs = value.split(',').map(String::from).collect(),
            _ => options::put(&mut options.settings, (name, value))?,
        }
    }
    Ok(options)
}

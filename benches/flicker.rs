//! How much pictures of moving water flicker: per technique, the error of the differences between successive frames
//! against a truth's differences.
//!
//! `cargo bench --bench flicker` looks at 48 frames of the pool; `--scene`, `--camera`, `--layer`, `--size`, `--frames`,
//! `--truth reference:16`, `--photons`, `--set` (for the runs of its technique), `--device`, `--trace` and `--runs
//! mnee:4,mnee:4:8` (technique:samples, and frames of anti-aliasing, which changes the layer `final` alone) change that.
//! Prints a table and writes `target/bench/flicker.json`.
//!
//! The truth is the mean of two runs of one technique with seeds of their own. Its noise is known from their difference and
//! taken out of what is shown: of the mean square of (difference of frames - the truth's), half the mean square noise of
//! one run's differences is the truth's own. What both runs have in common, the blur of few photons, is not taken out.
//! All runs are of light refracted once, which is what `mnee` finds by itself. Numbers are relative to the truth's mean.

#[path = "report/mod.rs"]
mod report;

use std::error::Error;
use std::path::{Path, PathBuf};

use nephroid::render::{RenderSettings, Renderer};
use nephroid::taa::{History, TaaSettings};
use nephroid::technique::TechniqueKind;
use nephroid::{scene, stats};
use report::options;

/// Seeds of the truth's two runs; the techniques' is 0.
const TRUTH_SEEDS: [u32; 2] = [1, 2];

struct Options {
    scene: PathBuf,
    layer: String,
    frames: u32,
    truth: Run,
    /// Of the reference, a set.
    photons: u32,
    runs: Vec<Run>,
    settings: RenderSettings,
}

/// Of all frames.
#[derive(Clone, Copy)]
struct Run {
    technique: TechniqueKind,
    samples: u32,
    /// That anti-aliasing makes a picture of.
    taa: Option<u32>,
}

/// One channel after the other, pixel by pixel.
type Picture = Vec<f32>;

#[derive(serde::Serialize)]
struct Row {
    technique: &'static str,
    samples: u32,
    /// Frames of anti-aliasing.
    taa: Option<u32>,
    /// Of the differences between frames, RMS over the truth's mean.
    flicker: f64,
    /// `flicker` before the truth's noise was taken out.
    raw: f64,
    /// Of the frames themselves, RMS over the truth's mean, the truth's noise taken out.
    error: f64,
    cpu_seconds_per_frame: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = options()?;
    let mut runs = Vec::new();
    for seed in TRUTH_SEEDS {
        runs.push(sequence(&options, options.truth, seed)?.0);
    }
    let truth: Vec<Picture> = runs[0].iter().zip(&runs[1]).map(|(a, b)| mean_of(a, b)).collect();
    let mean = truth.iter().flatten().map(|&v| f64::from(v)).sum::<f64>() / truth.iter().flatten().count() as f64;
    // Of one run: independent noise adds up in the difference of two.
    let noise_of_frames = mean_square(&runs[0], &runs[1]) / 2.0;
    let noise_of_steps = mean_square(&steps(&runs[0]), &steps(&runs[1])) / 2.0;
    let still: Vec<Picture> = truth[1..].iter().map(|picture| vec![0.0; picture.len()]).collect();
    let motion = (mean_square(&steps(&truth), &still) - noise_of_steps / 2.0).max(0.0).sqrt() / mean;
    println!("true motion {:.2} % a frame; the truth's own noise {:.2} % of it", 100.0 * motion, {
        100.0 * (noise_of_steps / 2.0).sqrt() / mean / motion
    });
    println!("{:<10} {:>8} {:>6} {:>9} {:>9} {:>9} {:>10}", "", "samples", "taa", "flicker", "raw", "error", "CPU-s");
    let mut rows = Vec::new();
    for &run in &options.runs {
        let (frames, seconds) = sequence(&options, run, 0)?;
        let raw = mean_square(&steps(&frames), &steps(&truth));
        let row = Row {
            technique: run.technique.name(),
            samples: run.samples,
            taa: run.taa,
            flicker: (raw - noise_of_steps / 2.0).max(0.0).sqrt() / mean,
            raw: raw.sqrt() / mean,
            error: (mean_square(&frames, &truth) - noise_of_frames / 2.0).max(0.0).sqrt() / mean,
            cpu_seconds_per_frame: seconds / f64::from(options.frames),
        };
        println!(
            "{:<10} {:>8} {:>6} {:>8.2}% {:>8.2}% {:>8.2}% {:>10.2}",
            row.technique,
            row.samples,
            row.taa.map_or("-".to_string(), |frames| frames.to_string()),
            100.0 * row.flicker,
            100.0 * row.raw,
            100.0 * row.error,
            row.cpu_seconds_per_frame
        );
        rows.push(row);
    }
    let settings = RenderSettings { set: Vec::new(), ..options.settings.clone() };
    let device = Renderer::new(scene::load(&options.scene)?, &settings)?.device().info.describe();
    report::write(
        "flicker",
        serde_json::json!({
            "device": device,
            "scene": options.scene,
            "camera": options.settings.camera,
            "layer": options.layer,
            "size": options.settings.size,
            "frames": options.frames,
            "truth": [options.truth.technique.name(), options.truth.samples.to_string().as_str()],
            "photons": options.photons,
            "true_motion": motion,
            "noise_of_truth": (noise_of_steps / 2.0).sqrt() / mean,
            "rows": rows,
        }),
    )
}

/// All frames of a run, and the CPU-seconds of the process that they took.
fn sequence(options: &Options, run: Run, seed: u32) -> Result<(Vec<Picture>, f64), Box<dyn Error>> {
    let Run { technique, samples, taa } = run;
    let mut set = Vec::new();
    if technique == TechniqueKind::Reference {
        set = vec![format!("reference.photons={}", options.photons), "reference.paths=refracted-once".to_string()];
    }
    let own = format!("{}.", technique.name());
    set.extend(options.settings.set.iter().filter(|item| item.starts_with(&own)).cloned());
    let taa = taa.map(|frames| TaaSettings { frames, history: History::Numbered });
    let settings = RenderSettings { technique, samples: Some(samples), seed, set, taa, ..options.settings.clone() };
    let mut renderer = Renderer::new(scene::load(&options.scene)?, &settings)?;
    let start = stats::cpu_seconds();
    let mut frames = Vec::new();
    for frame in 0..options.frames {
        renderer.go_to(frame)?;
        for _ in 0..samples {
            renderer.sample()?;
        }
        let picture = renderer.finish()?.image.select(Path::new("the picture"), Some(&options.layer))?;
        frames.push(picture.pixels.into_iter().flatten().collect());
    }
    Ok((frames, stats::cpu_seconds() - start))
}

fn mean_of(a: &[f32], b: &[f32]) -> Picture {
    a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect()
}

/// What changes from each frame to the next.
fn steps(frames: &[Picture]) -> Vec<Picture> {
    frames.windows(2).map(|pair| pair[1].iter().zip(&pair[0]).map(|(b, a)| b - a).collect()).collect()
}

/// Of the differences between two lists of pictures.
fn mean_square(a: &[Picture], b: &[Picture]) -> f64 {
    let pairs = || a.iter().flatten().zip(b.iter().flatten());
    pairs().map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / pairs().count() as f64
}

fn options() -> Result<Options, Box<dyn Error>> {
    let mut options = Options {
        scene: "scenes/pool.toml".into(),
        layer: "refracted".to_string(),
        frames: 48,
        truth: run("reference:16")?,
        photons: 500_000,
        runs: ["mnee:4", "mnee:16", "reference:16"].map(run).into_iter().collect::<Result<_, _>>()?,
        settings: RenderSettings {
            camera: Some("under".to_string()),
            size: Some((96, 72)),
            trace: "bvh".parse()?,
            ..Default::default()
        },
    };
    for (name, value) in options::given()? {
        match name.as_str() {
            "--scene" => options.scene = value.into(),
            "--layer" => options.layer = value,
            "--frames" => options.frames = value.parse::<u32>()?.max(2),
            "--truth" => options.truth = run(&value)?,
            "--photons" => options.photons = value.parse()?,
            "--runs" => options.runs = value.split(',').map(run).collect::<Result<_, _>>()?,
            _ => options::put(&mut options.settings, (name, value))?,
        }
    }
    Ok(options)
}

/// `technique:samples` or `technique:samples:frames`.
fn run(text: &str) -> Result<Run, Box<dyn Error>> {
    let parts: Vec<&str> = text.split(':').collect();
    let (technique, samples, taa) = match parts[..] {
        [technique, samples] => (technique, samples, None),
        [technique, samples, frames] => (technique, samples, Some(frames.parse()?)),
        _ => return Err("runs are technique:samples or technique:samples:frames, separated by commas".into()),
    };
    Ok(Run { technique: TechniqueKind::parse(technique)?, samples: samples.parse()?, taa })
}

//! What volumes cost, and how right they are.
//!
//! `cargo bench --bench eikonal` measures all parts; `--part NAME`, which may be given again, chooses.
//! - `cost`: a pool in cubes of 64, 128 and 256 cells a side, as in the paper's Table 1: what is given next to the surface, the
//!   wave by each solver, the light, and a picture's sample of 320x240 once all is there; `--marching yes` adds fast marching.
//! - `wave`: the scalar wave in the same cubes, in time with the light and the paper's.
//! - `quality`: error, correlation and energy by `--runs`, settings with commas between and semicolons between runs, against the
//!   reference, or against `--truth FILE` with `--mask PNG`, of the layer `--layer`.
//!
//! `--scene`, `--cells 64,128`, `--repeat`, `--camera`, `--size`, `--samples`, `--reference` (its samples), `--device`, `--trace`
//! change what is measured. Writes `target/bench/eikonal.json`.

#[path = "eikonal/cost.rs"]
mod cost;
#[path = "eikonal/quality.rs"]
mod quality;
#[path = "report/mod.rs"]
mod report;
#[path = "eikonal/wave.rs"]
mod wave;

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use glam::DVec3;
use nephroid::gpu::{Device, GpuError, Recorder};
use nephroid::render::RenderSettings;
use nephroid::scene::Scene;
use nephroid::stats;
use nephroid::technique::eikonal::{Grid, SolverOptions, Volume, VolumeOptions};
use report::parts::{Part, measure, named};

const PARTS: [Part<Options>; 3] = [("cost", cost::measure), ("wave", wave::measure), ("quality", quality::measure)];

struct Options {
    scene: PathBuf,
    cells: Vec<u32>,
    repeat: u32,
    marching: bool,
    runs: Vec<Vec<String>>,
    truth: Option<PathBuf>,
    mask: Option<PathBuf>,
    layer: String,
    samples: u32,
    reference: u32,
    settings: RenderSettings,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut options = Options {
        scene: "scenes/pool.toml".into(),
        cells: vec![64, 128, 256],
        repeat: 3,
        marching: false,
        runs: quality::RUNS.iter().map(|run| run.split(',').map(String::from).collect()).collect(),
        truth: None,
        mask: None,
        layer: "caustic".to_string(),
        samples: 4,
        reference: 32,
        settings: RenderSettings { size: Some((160, 120)), ..RenderSettings::default() },
    };
    let mut asked = Vec::new();
    for (name, value) in report::options::given()? {
        match name.as_str() {
            "--part" => asked.push(named(&PARTS, value)?),
            "--scene" => options.scene = value.into(),
            "--cells" => options.cells = report::options::numbers(&value)?,
            "--repeat" => options.repeat = value.parse()?,
            "--marching" => options.marching = value == "yes",
            "--runs" => {
                let run = |run: &str| run.split(',').filter(|item| !item.is_empty()).map(String::from).collect();
                options.runs = value.split(';').map(run).collect();
            }
            "--truth" => options.truth = Some(value.into()),
            "--mask" => options.mask = Some(value.into()),
            "--layer" => options.layer = value,
            "--samples" => options.samples = value.parse()?,
            "--reference" => options.reference = value.parse()?,
            _ => report::options::put(&mut options.settings, (name, value))?,
        }
    }
    measure("eikonal", &PARTS, &asked, &options, &options.settings.device)
}

/// A cube from the surface to under the floor, in the middle of the pool.
fn volume_of(scene: &Scene, device: &Device, cells: u32, solver: SolverOptions) -> Result<Volume, Box<dyn Error>> {
    let bounds = scene.bounds();
    let depth = 2.0f64.max(f64::from(bounds.max.y - bounds.min.y));
    let cell = depth * 1.1 / f64::from(cells);
    let lower = DVec3::new(-0.55 * depth, 0.35 - 1.1 * depth, -0.55 * depth);
    let grid = Grid { lower, cell, cells: [cells; 3] };
    let options = VolumeOptions { grid: Some(grid), solver, ..VolumeOptions::default() };
    Ok(Volume::new(device, scene, 0, &options)?.ok_or("the scene has no refracting surface")?)
}

/// Milliseconds by the clock, the least of `repeat` runs, and CPU-milliseconds of all threads, the mean.
fn timed(
    device: &Device,
    repeat: u32,
    record: impl Fn(&mut Recorder) -> Result<(), GpuError>,
) -> Result<(f64, f64), Box<dyn Error>> {
    let (mut least, mut cpu) = (f64::INFINITY, 0.0);
    for _ in 0..repeat {
        let (started, spent) = (Instant::now(), stats::cpu_seconds());
        let mut recorder = Recorder::new(device)?;
        record(&mut recorder)?;
        recorder.submit()?;
        least = least.min(started.elapsed().as_secs_f64() * 1e3);
        cpu += (stats::cpu_seconds() - spent) * 1e3 / f64::from(repeat);
    }
    Ok((least, cpu))
}

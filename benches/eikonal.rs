//! What a volume costs: cells given next to the surface, and the wave.
//!
//! `cargo bench --bench eikonal` solves `scenes/pool.toml` in cubes of 64, 128 and 256 cells a side, like the paper's, and
//! prints milliseconds by the clock and of the CPU. `--cells`, `--order`, `--scene`, `--repeat`, `--device`, `--marching yes`
//! (fast marching too, with its differences) change that. `--part wave` measures the scalar wave instead, which is let go in time
//! with the light, or with `--start at-once` as the paper does. Writes `target/bench/eikonal.json` or `eikonal_wave.json`.

#[path = "report/mod.rs"]
mod report;

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use glam::DVec3;
use nephroid::gpu::{Device, DeviceRequest, Recorder};
use nephroid::gpu_scene::GpuScene;
use nephroid::scene::{self, Scene};
use nephroid::technique::eikonal::marching::{Order, march};
use nephroid::technique::eikonal::{
    Grid, Kernels, SolverOptions, Start, Volume, VolumeOptions, Wave, WaveKernels, WaveOptions,
};

struct Options {
    scene: PathBuf,
    cells: Vec<u32>,
    order: Order,
    repeat: u32,
    marching: bool,
    wave: Option<Start>,
    device: DeviceRequest,
}

#[derive(serde::Serialize)]
struct WaveRow {
    cells: u32,
    /// Milliseconds, the least of all runs: what the wave starts from, and the wave.
    before: f64,
    wave: f64,
    /// CPU-milliseconds of the wave, a run.
    cpu: f64,
    steps: u32,
    /// Of all blocks, those that a step goes through.
    part: f64,
}

#[derive(serde::Serialize)]
struct Row {
    cells: u32,
    /// Milliseconds, the least of all runs.
    given: f64,
    wave: f64,
    /// CPU-milliseconds of both, a run.
    cpu: f64,
    worst: f64,
    unsettled: u32,
    marching: Option<f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = options(std::env::args().skip(1))?;
    let scene = scene::load(&options.scene)?;
    let device = Device::open(&options.device)?;
    if let Some(start) = options.wave {
        return waves(&options, &scene, &device, start);
    }
    println!("{}, {}, {:?} order", device.info.name, options.scene.display(), options.order);
    println!("| cells | given, ms | wave, ms | CPU-ms | worst, cells | unsettled | marching, ms |");
    println!("|---|---|---|---|---|---|---|");
    let mut rows = Vec::new();
    for &cells in &options.cells {
        let row = measure(&options, &scene, &device, cells)?;
        let marching = row.marching.map_or("-".to_string(), |ms| format!("{ms:.0}"));
        println!(
            "| {}^3 | {:.1} | {:.1} | {:.0} | {:.1e} | {} | {marching} |",
            row.cells, row.given, row.wave, row.cpu, row.worst, row.unsettled
        );
        rows.push(row);
    }
    report::write("eikonal", serde_json::json!({ "device": device.info.name, "rows": rows }))
}

/// A cube from the surface to under the floor, in the middle of the pool.
fn volume_of(options: &Options, scene: &Scene, device: &Device, cells: u32) -> Result<Volume, Box<dyn Error>> {
    let bounds = scene.bounds();
    let depth = 2.0f64.max(f64::from(bounds.max.y - bounds.min.y));
    let cell = depth * 1.1 / f64::from(cells);
    let lower = DVec3::new(-0.55 * depth, 0.35 - 1.1 * depth, -0.55 * depth);
    let grid = Grid { lower, cell, cells: [cells; 3] };
    let solver = SolverOptions { order: options.order, ..SolverOptions::default() };
    let volume_options = VolumeOptions { grid: Some(grid), solver, ..VolumeOptions::default() };
    Ok(Volume::new(device, scene, 0, &volume_options)?.ok_or("the scene has no refracting surface")?)
}

fn waves(options: &Options, scene: &Scene, device: &Device, start: Start) -> Result<(), Box<dyn Error>> {
    println!("{}, {}, {start:?}", device.info.name, options.scene.display());
    println!("| cells | before, ms | wave, ms | CPU-ms | steps | blocks a step |");
    println!("|---|---|---|---|---|---|");
    let mut rows = Vec::new();
    for &cells in &options.cells {
        let row = measure_wave(options, scene, device, cells, start)?;
        let WaveRow { before, wave, cpu, steps, part, .. } = row;
        println!("| {cells}^3 | {before:.1} | {wave:.1} | {cpu:.0} | {steps} | {:.1} % |", 100.0 * part);
        rows.push(row);
    }
    report::write("eikonal_wave", serde_json::json!({ "device": device.info.name, "rows": rows }))
}

fn measure_wave(
    options: &Options,
    scene: &Scene,
    device: &Device,
    cells: u32,
    start: Start,
) -> Result<WaveRow, Box<dyn Error>> {
    let volume = volume_of(options, scene, device, cells)?;
    let gpu_scene = GpuScene::new(device, scene)?;
    let (kernels, wave_kernels) = (Kernels::new(device)?, WaveKernels::new(device)?);
    let wave = Wave::new(device, &volume, &WaveOptions { start, ..WaveOptions::default() })?;
    let (mut before, mut through, mut cpu) = (f64::INFINITY, f64::INFINITY, 0.0);
    for _ in 0..options.repeat {
        let started = Instant::now();
        let mut recorder = Recorder::new(device)?;
        wave.record_before(&mut recorder, &gpu_scene.bindings, &volume, &kernels)?;
        recorder.submit()?;
        before = before.min(started.elapsed().as_secs_f64() * 1e3);
        let (started, spent) = (Instant::now(), cpu_seconds());
        let mut recorder = Recorder::new(device)?;
        wave.record_through(&mut recorder, &wave_kernels)?;
        recorder.submit()?;
        through = through.min(started.elapsed().as_secs_f64() * 1e3);
        cpu += (cpu_seconds() - spent) * 1e3 / f64::from(options.repeat);
    }
    let stepped = wave.stepped()?;
    Ok(WaveRow { cells, before, wave: through, cpu, steps: stepped.steps, part: stepped.part })
}

fn measure(options: &Options, scene: &Scene, device: &Device, cells: u32) -> Result<Row, Box<dyn Error>> {
    let volume = volume_of(options, scene, device, cells)?;
    let grid = volume.grid;
    let gpu_scene = GpuScene::new(device, scene)?;
    let kernels = Kernels::new(device)?;
    let (mut given, mut wave) = (f64::INFINITY, f64::INFINITY);
    let mut cpu = 0.0;
    for _ in 0..options.repeat {
        let before = cpu_seconds();
        let started = Instant::now();
        let mut recorder = Recorder::new(device)?;
        volume.record_given(&mut recorder, &gpu_scene.bindings, &kernels)?;
        recorder.submit()?;
        given = given.min(started.elapsed().as_secs_f64() * 1e3);
        let started = Instant::now();
        let mut recorder = Recorder::new(device)?;
        volume.record_wave(&mut recorder, &kernels)?;
        recorder.submit()?;
        wave = wave.min(started.elapsed().as_secs_f64() * 1e3);
        cpu += (cpu_seconds() - before) * 1e3 / f64::from(options.repeat);
    }
    let settled = volume.check(device, &kernels)?;
    let marching = if options.marching {
        let (values, marks) = volume.read()?;
        let start: Vec<f64> =
            values.iter().zip(marks).map(|(&v, given)| if v.is_nan() || given { v } else { f64::INFINITY }).collect();
        let started = Instant::now();
        let index = f64::from(scene.media[1].index);
        march(&grid, |_| index, &start, options.order);
        Some(started.elapsed().as_secs_f64() * 1e3)
    } else {
        None
    };
    Ok(Row { cells, given, wave, cpu, worst: settled.worst, unsettled: settled.unsettled, marching })
}

/// Of this process, all threads; 0 where the system does not tell.
fn cpu_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = text.rsplit(") ").next().unwrap_or_default().split(' ').collect();
    let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(11) + ticks(12)) / 100.0
}

fn options(arguments: impl Iterator<Item = String>) -> Result<Options, Box<dyn Error>> {
    let mut options = Options {
        scene: "scenes/pool.toml".into(),
        cells: vec![64, 128, 256],
        order: Order::Second,
        repeat: 3,
        marching: false,
        wave: None,
        device: DeviceRequest::default(),
    };
    let mut arguments = arguments.filter(|argument| argument != "--bench");
    while let Some(name) = arguments.next() {
        let value = arguments.next().ok_or(format!("{name} wants a value"))?;
        match name.as_str() {
            "--scene" => options.scene = value.into(),
            "--cells" => options.cells = value.split(',').map(str::parse).collect::<Result<_, _>>()?,
            "--order" => options.order = if value == "1" { Order::First } else { Order::Second },
            "--repeat" => options.repeat = value.parse()?,
            "--marching" => options.marching = value == "yes",
            "--part" if value == "wave" => options.wave = options.wave.or(Some(Start::InTime)),
            "--start" if value == "at-once" => options.wave = Some(Start::AtOnce),
            "--device" => options.device.device = Some(value),
            _ => return Err(format!("there is no option {name}").into()),
        }
    }
    Ok(options)
}

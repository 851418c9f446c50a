//! What the scalar wave takes.

use std::error::Error;

use nephroid::gpu::Device;
use nephroid::gpu_scene::GpuScene;
use nephroid::scene;
use nephroid::technique::eikonal::{Kernels, SolverOptions, Start, Wave, WaveKernels, WaveOptions};

use crate::{Options, timed, volume_of};

/// Seconds that the paper prints.
const PRINTED: [(u32, f64); 3] = [(64, 17.0), (128, 21.0), (256, 107.0)];

#[derive(serde::Serialize)]
struct Row {
    cells: u32,
    start: String,
    /// Milliseconds by the clock: what the wave starts from, and the wave.
    before: f64,
    wave: f64,
    /// CPU-milliseconds of the wave.
    cpu: f64,
    steps: u32,
    /// Of all blocks, those that a step goes through.
    part: f64,
    /// The paper's time over both.
    gain: Option<f64>,
}

pub fn measure(options: &Options, device: &Device) -> Result<serde_json::Value, Box<dyn Error>> {
    println!("milliseconds, {}", options.scene.display());
    println!("| cells | start | before | wave | CPU | steps | blocks a step | printed over all |");
    println!("|---|---|---|---|---|---|---|---|");
    let mut rows = Vec::new();
    for &cells in &options.cells {
        for start in [Start::InTime, Start::AtOnce] {
            let row = row(options, device, cells, start)?;
            let gain = row.gain.map_or("-".to_string(), |gain| format!("{gain:.0}"));
            let Row { before, wave, cpu, steps, part, .. } = row;
            let part = 100.0 * part;
            println!("| {cells}^3 | {start:?} | {before:.1} | {wave:.1} | {cpu:.0} | {steps} | {part:.1} % | {gain} |");
            rows.push(row);
        }
    }
    println!();
    Ok(serde_json::json!({ "rows": rows }))
}

fn row(options: &Options, device: &Device, cells: u32, start: Start) -> Result<Row, Box<dyn Error>> {
    let scene = scene::load(&options.scene)?;
    let volume = volume_of(&scene, device, cells, SolverOptions::default())?;
    let bindings = GpuScene::new(device, &scene)?.bindings;
    let (kernels, wave_kernels) = (Kernels::new(device)?, WaveKernels::new(device)?);
    let wave = Wave::new(device, &volume, &WaveOptions { start, ..WaveOptions::default() })?;
    let (before, _) = timed(device, options.repeat, |r| wave.record_before(r, &bindings, &volume, &kernels))?;
    let (through, cpu) = timed(device, options.repeat, |r| wave.record_through(r, &wave_kernels))?;
    let stepped = wave.stepped()?;
    let printed = PRINTED.iter().find(|printed| printed.0 == cells).map(|printed| printed.1 * 1e3);
    Ok(Row {
        cells,
        start: format!("{start:?}"),
        before,
        wave: through,
        cpu,
        steps: stepped.steps,
        part: stepped.part,
        gain: printed.map(|printed| printed / (before + through)),
    })
}

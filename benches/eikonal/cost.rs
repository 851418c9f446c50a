//! The paper's Table 1: what a volume takes, and a picture once it is there.

use std::error::Error;
use std::time::Instant;

use nephroid::gpu::Device;
use nephroid::gpu_scene::GpuScene;
use nephroid::render::RenderSettings;
use nephroid::scene;
use nephroid::technique::TechniqueKind;
use nephroid::technique::eikonal::marching::{Order, march};
use nephroid::technique::eikonal::{Kernels, Scheme, SolverOptions};

use crate::report::run::Run;
use crate::{Options, timed, volume_of};

const SCHEMES: [(&str, Scheme); 3] = [
    ("planes", Scheme::Planes),
    ("sweeps", Scheme::Sweeps(Order::Second)),
    ("sweeps, first order", Scheme::Sweeps(Order::First)),
];

/// Seconds that the paper prints for marching.
const PRINTED: [(u32, f64); 3] = [(64, 0.3), (128, 2.5), (256, 26.0)];

#[derive(serde::Serialize)]
struct Row {
    cells: u32,
    solver: &'static str,
    /// Milliseconds by the clock.
    given: f64,
    wave: f64,
    light: f64,
    /// Of all three, of the CPU.
    cpu: f64,
    /// The paper's time over all three's.
    gain: Option<f64>,
    marching: Option<f64>,
}

pub fn measure(options: &Options, device: &Device) -> Result<serde_json::Value, Box<dyn Error>> {
    println!("milliseconds, {}", options.scene.display());
    println!("| cells | solver | given | wave | light | CPU | printed over all | marching |");
    println!("|---|---|---|---|---|---|---|---|");
    let mut rows = Vec::new();
    for &cells in &options.cells {
        for (name, scheme) in SCHEMES {
            let row = row(options, device, cells, (name, scheme))?;
            let or_none = |value: Option<f64>| value.map_or("-".to_string(), |value| format!("{value:.0}"));
            println!(
                "| {cells}^3 | {name} | {:.1} | {:.1} | {:.1} | {:.0} | {} | {} |",
                row.given,
                row.wave,
                row.light,
                row.cpu,
                or_none(row.gain),
                or_none(row.marching)
            );
            rows.push(row);
        }
    }
    let frame = frame(options, device)?;
    println!("a sample of 320x240 once the volume is there: {:.0} CPU-ms, gather {:.1} ms\n", frame.0, frame.1);
    Ok(serde_json::json!({ "rows": rows, "frame_cpu_ms": frame.0, "gather_ms": frame.1 }))
}

fn row(
    options: &Options,
    device: &Device,
    cells: u32,
    (solver, scheme): (&'static str, Scheme),
) -> Result<Row, Box<dyn Error>> {
    let scene = scene::load(&options.scene)?;
    let volume = volume_of(&scene, device, cells, SolverOptions { scheme, ..SolverOptions::default() })?;
    let bindings = GpuScene::new(device, &scene)?.bindings;
    let kernels = Kernels::new(device)?;
    let (given, given_cpu) = timed(device, options.repeat, |r| volume.record_given(r, &bindings, &kernels))?;
    let marching = if options.marching && scheme == Scheme::Planes {
        let (values, marks) = volume.read()?;
        let known = |(&value, given): (&f64, &bool)| if value.is_nan() || *given { value } else { f64::INFINITY };
        let start: Vec<f64> = values.iter().zip(&marks).map(known).collect();
        let index = f64::from(scene.media[1].index);
        let started = Instant::now();
        march(volume.grid(), |_| index, &start, Order::First);
        Some(started.elapsed().as_secs_f64() * 1e3)
    } else {
        None
    };
    let (wave, wave_cpu) = timed(device, options.repeat, |r| volume.record_wave(r, &kernels))?;
    let (light, light_cpu) = timed(device, options.repeat, |r| volume.record_light(r, &bindings, &kernels))?;
    let printed = PRINTED.iter().find(|printed| printed.0 == cells).map(|printed| printed.1 * 1e3);
    let gain = printed.map(|printed| printed / (given + wave + light));
    Ok(Row { cells, solver, given, wave, light, cpu: given_cpu + wave_cpu + light_cpu, gain, marching })
}

/// CPU-milliseconds of a sample that finds its volume there, and milliseconds of looking it up.
fn frame(options: &Options, device: &Device) -> Result<(f64, f64), Box<dyn Error>> {
    let settings = RenderSettings {
        technique: TechniqueKind::Eikonal,
        size: Some((320, 240)),
        samples: Some(8),
        ..options.settings.clone()
    };
    let mut run = Run::new(device, &options.scene, &settings)?;
    run.sample()?;
    run.seconds = 0.0;
    for _ in 1..8 {
        run.sample()?;
    }
    let gather = run.passes()?.into_iter().find(|(name, _)| *name == "eikonal/gather").map_or(0.0, |(_, time)| time);
    Ok((run.seconds * 1e3 / 7.0, gather))
}

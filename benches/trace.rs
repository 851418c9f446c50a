//! Speed of every tracing back-end on every device: 960 x 720 primary and shadow rays at a water surface of 131,072
//! triangles; what following moving water costs; and how much slower rays are after it. `cargo bench --bench trace` does
//! all, `-- --part speed`, `cost` or `quality` one; `--large` moves two million triangles too. The tables also go to
//! `target/bench/trace.json`.

#[path = "trace/motion.rs"]
mod motion;
#[path = "report/mod.rs"]
mod report;

use std::time::Instant;

use glam::{Affine3A, Vec3};
use nephroid::gpu::{Device, DeviceRequest};
use nephroid::gpu_scene::GpuScene;
use nephroid::scene::height_field::{HeightField, Wave};
use nephroid::scene::{FilmSettings, Instance, Material, Scene, Surface, ToneCurve};
use nephroid::stats::cpu_seconds;
use nephroid::trace::{Backend, NO_INSTANCE, Probe, ProbeHit, Ray, Tracer};

const WIDTH: u32 = 960;
const HEIGHT: u32 = 720;
const QUADS: u32 = 256;
const ANY_MASK: u32 = 0xff;

/// Speed of tracing; cost of following what moves; speed after that.
const PARTS: [&str; 3] = ["speed", "cost", "quality"];

/// CPU seconds per measurement at least, far above the noise of starting one.
const LEAST_CPU_SECONDS: f64 = 1.0;

/// Runs per measurement at most, for devices that use little of the CPU.
const MOST_RUNS: u32 = 20;

#[derive(serde::Serialize)]
struct Row {
    device: String,
    driver: String,
    backend: Backend,
    build_milliseconds: f64,
    memory_bytes: u64,
    /// Millions of rays per second of this process's CPU time, which is what counts on a software device.
    primary_per_cpu_second: f64,
    shadow_per_cpu_second: f64,
    /// Millions of rays per second of wall-clock time.
    primary_per_second: f64,
    shadow_per_second: f64,
}

#[derive(serde::Serialize)]
struct Report {
    triangles: usize,
    rays: usize,
    rows: Vec<Row>,
    motion_costs: Vec<motion::Cost>,
    motion_quality: Vec<motion::Quality>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // `cargo test --benches` wants no measurement.
    if std::env::args().any(|a| a == "--test") {
        return Ok(());
    }
    let (parts, large) = options(std::env::args().skip(1))?;
    let scene = water();
    let primary = primary_rays();
    let mut report = Report {
        triangles: scene.meshes[0].triangles.len(),
        rays: primary.len(),
        rows: Vec::new(),
        motion_costs: Vec::new(),
        motion_quality: Vec::new(),
    };
    let devices = Device::list()?
        .into_iter()
        .map(|info| Device::open(&DeviceRequest { device: Some(info.index.to_string()), ..Default::default() }));
    let devices = devices.collect::<Result<Vec<_>, _>>()?;
    if parts.contains(&"speed") {
        report.rows = tracing(&devices, &scene, &primary)?;
    }
    if parts.contains(&"cost") {
        motion::cost_header();
        for quads in [motion::QUADS, motion::MANY_QUADS].into_iter().take(if large { 2 } else { 1 }) {
            for device in &devices {
                report.motion_costs.extend(motion::costs(device, quads)?);
            }
        }
    }
    if parts.contains(&"quality") {
        for device in &devices {
            report.motion_quality.extend(motion::quality(device, &primary)?);
        }
    }
    report::write("trace", serde_json::to_value(report)?)
}

/// The parts to be measured, and whether on a large mesh too.
fn options(mut arguments: impl Iterator<Item = String>) -> Result<(Vec<&'static str>, bool), String> {
    let (mut parts, mut large) = (PARTS.to_vec(), false);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--bench" => {}
            "--large" => large = true,
            "--part" => {
                let named = arguments.next().unwrap_or_default();
                parts.retain(|part| *part == named);
            }
            other => return Err(format!("unknown argument {other}; allowed are: --part, --large")),
        }
    }
    if parts.is_empty() {
        return Err(format!("unknown part; allowed are: {}", PARTS.join(", ")));
    }
    Ok((parts, large))
}

fn tracing(devices: &[Device], scene: &Scene, primary: &[Ray]) -> Result<Vec<Row>, Box<dyn std::error::Error>> {
    println!(
        "{:<44} {:<10} {:>9} {:>9} {:>18} {:>18}",
        "device", "back-end", "build ms", "MiB", "primary M/CPU-s", "shadow M/CPU-s"
    );
    let mut rows = Vec::new();
    for device in devices {
        let gpu_scene = GpuScene::new(device, scene)?;
        for backend in Backend::ALL.into_iter().filter(|b| b.available(device)) {
            let row = measure(device, scene, &gpu_scene, backend, primary)?;
            println!(
                "{:<44} {:<10} {:>9.1} {:>9.1} {:>18.2} {:>18.2}",
                row.device,
                backend.name(),
                row.build_milliseconds,
                row.memory_bytes as f64 / f64::from(1 << 20),
                row.primary_per_cpu_second,
                row.shadow_per_cpu_second
            );
            rows.push(row);
        }
    }
    Ok(rows)
}

fn measure(
    device: &Device,
    scene: &Scene,
    gpu_scene: &GpuScene,
    backend: Backend,
    primary: &[Ray],
) -> Result<Row, Box<dyn std::error::Error>> {
    let tracer = Tracer::new(device, scene, gpu_scene, backend)?;
    let probe = Probe::new(device, &tracer, primary)?;
    let (primary_cpu, primary_wall) = speed(&probe, &tracer, gpu_scene, primary.len(), false)?;
    let shadow = shadow_rays(primary, &probe.hits()?);
    let probe = Probe::new(device, &tracer, &shadow)?;
    let (shadow_cpu, shadow_wall) = speed(&probe, &tracer, gpu_scene, shadow.len(), true)?;
    Ok(Row {
        device: device.info.name.clone(),
        driver: format!("{} {}", device.info.driver, device.info.driver_version),
        backend,
        build_milliseconds: tracer.build_milliseconds,
        memory_bytes: tracer.memory,
        primary_per_cpu_second: primary_cpu,
        shadow_per_cpu_second: shadow_cpu,
        primary_per_second: primary_wall,
        shadow_per_second: shadow_wall,
    })
}

/// Millions of rays per second of CPU time and of wall-clock time.
fn speed(
    probe: &Probe,
    tracer: &Tracer,
    scene: &GpuScene,
    rays: usize,
    any_hit: bool,
) -> Result<(f64, f64), Box<dyn std::error::Error>> {
    // The first run compiles.
    probe.run(tracer, scene, ANY_MASK, any_hit)?;
    let (cpu, wall) = (cpu_seconds(), Instant::now());
    let mut runs = 0;
    while runs < MOST_RUNS && cpu_seconds() - cpu < LEAST_CPU_SECONDS {
        probe.run(tracer, scene, ANY_MASK, any_hit)?;
        runs += 1;
    }
    let traced = rays as f64 * f64::from(runs) * 1e-6;
    Ok((traced / (cpu_seconds() - cpu).max(1e-2), traced / wall.elapsed().as_secs_f64()))
}

fn water() -> Scene {
    let wave = |wavelength, amplitude, direction, phase| Wave { wavelength, amplitude, direction, phase };
    let field = HeightField {
        x: [-6.0, 6.0],
        z: [-6.0, 6.0],
        quads: [QUADS, QUADS],
        base: 0.0,
        waves: vec![
            wave(0.6, 0.01, 0.84, 2.8),
            wave(0.95, 0.0144, 3.01, 4.85),
            wave(1.5, 0.0213, 4.05, 4.5),
            wave(3.0, 0.04, 1.89, 3.45),
        ],
        bumps: Vec::new(),
        relief: None,
    };
    Scene {
        path: Default::default(),
        film: FilmSettings {
            width: WIDTH,
            height: HEIGHT,
            samples: 1,
            exposure: 0.0,
            tone_curve: ToneCurve::Linear,
            background: Vec3::ZERO,
            volume_samples: 1,
        },
        cameras: Vec::new(),
        meshes: vec![field.mesh("water")],
        instances: vec![Instance { name: "water".to_string(), mesh: 0, material: 0, transform: Affine3A::IDENTITY }],
        materials: vec![Material { name: "water".to_string(), surface: Surface::Mirror { reflectance: Vec3::ONE } }],
        textures: Vec::new(),
        densities: Vec::new(),
        media: Vec::new(),
        lights: Vec::new(),
        animation: Default::default(),
        settings: Vec::new(),
        warnings: Vec::new(),
    }
}

/// Through pixel centres, row by row, from above the water.
fn primary_rays() -> Vec<Ray> {
    let eye = Vec3::new(0.0, 5.0, 5.0);
    let forward = (Vec3::new(0.0, -2.0, 0.0) - eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let half = (50.0f32.to_radians() * 0.5).tan();
    let pixel = |i: u32| {
        let x = (2.0 * ((i % WIDTH) as f32 + 0.5) / WIDTH as f32 - 1.0) * half * WIDTH as f32 / HEIGHT as f32;
        let y = (1.0 - 2.0 * ((i / WIDTH) as f32 + 0.5) / HEIGHT as f32) * half;
        let direction = (forward + right * x + up * y).normalize();
        Ray { origin: eye.to_array(), t_min: 0.0, direction: direction.to_array(), t_max: f32::INFINITY }
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

/// From the hits to the lamp of `scenes/pool.toml`, and as many at grazing angles to one low over the water.
fn shadow_rays(primary: &[Ray], hits: &[ProbeHit]) -> Vec<Ray> {
    let lamps = [Vec3::new(1.5, 6.0, -1.0), Vec3::new(5.0, 0.5, -5.0)];
    let shadow = |lamp: Vec3, (ray, hit): (&Ray, &ProbeHit)| {
        let at = Vec3::from(ray.origin) + Vec3::from(ray.direction) * hit.t;
        Ray { origin: at.to_array(), t_min: 1e-3, direction: (lamp - at).to_array(), t_max: 1.0 }
    };
    let lit = || primary.iter().zip(hits).filter(|(_, hit)| hit.instance != NO_INSTANCE);
    lamps.into_iter().flat_map(|lamp| lit().map(move |pair| shadow(lamp, pair))).collect()
}

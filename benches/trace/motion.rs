//! What following moving water costs, and how much slower rays are in structures that have followed than in new ones.
//!
//! The scene is `scenes/pool.toml`. Structures are built over the water at time 0, or where said over flat water.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use glam::{Affine3A, Vec3};
use nephroid::gpu::{Device, PassTime};
use nephroid::gpu_scene::{GpuScene, Vertex};
use nephroid::scene::animation::WaterMotion;
use nephroid::scene::{self, Scene};
use nephroid::stats::cpu_seconds;
use nephroid::trace::{Backend, Following, Probe, Ray, Tracer};

use crate::{ANY_MASK, shadow_rays};

/// Quads along each side of the water: 131,072 triangles, and two million, as many as a binary tree in a buffer of 128 MiB
/// can have.
pub const QUADS: u32 = 256;
pub const MANY_QUADS: u32 = 1000;

/// Frames that are gone to; the first, which makes kernels, is left out.
const FRAMES: u32 = 11;

/// Seconds of the animation between them.
const STEP: f64 = 0.25;

/// When tracing is measured, seconds.
const LATER: f64 = 10.0;

/// What heights of the pool's waves are multiplied by where structures are built, and where they are traced. Five times
/// them has a root mean square slope of 0.9.
const CASES: [(&str, f64, f64); 3] =
    [("the pool's waves", 1.0, 1.0), ("waves x 5", 1.0, 5.0), ("waves x 5, built over flat water", 0.0, 5.0)];

/// Times that two tracers take turns.
const ROUNDS: u32 = 5;

/// Milliseconds, the least of all frames.
#[derive(Debug, serde::Serialize)]
pub struct Cost {
    device: String,
    backend: Backend,
    /// How ray queries follow.
    following: Option<&'static str>,
    triangles: usize,
    /// Of a new tracer, wall-clock.
    build: f64,
    /// `Tracer::update`, wall-clock.
    update: f64,
    /// CPU time of the same, the mean of all frames.
    update_cpu: f64,
    passes: Vec<(String, f64)>,
    /// `Tracer::update` where the water's instance has moved and no vertex, wall-clock.
    instance: f64,
}

/// Millions of rays per CPU-second.
#[derive(Debug, serde::Serialize)]
pub struct Quality {
    device: String,
    backend: Backend,
    following: Option<&'static str>,
    case: &'static str,
    primary: f64,
    primary_new: f64,
    shadow: f64,
    shadow_new: f64,
}

/// The back-ends that the device has, ray queries in both ways.
fn ways(device: &Device) -> Vec<(Backend, Following, Option<&'static str>)> {
    let all = [
        (Backend::RayQuery, Following::Rebuild, Some("rebuild")),
        (Backend::RayQuery, Following::Update, Some("update")),
        (Backend::Cwbvh, Following::default(), None),
        (Backend::Bvh2, Following::default(), None),
    ];
    all.into_iter().filter(|(backend, ..)| backend.available(device)).collect()
}

fn pool(quads: u32) -> Result<Scene, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/pool.toml");
    let text = std::fs::read_to_string(&path)?.replace("quads = [256, 256]", &format!("quads = [{quads}, {quads}]"));
    Ok(scene::parse(&text, &path)?)
}

/// The scene's water at a time, its waves' heights times `strength`.
fn water_at(scene: &mut Scene, time: f64, strength: f64) {
    let water = scene.animation.waters[0].clone();
    let depth = if let WaterMotion::Waves { depth } = water.motion { depth } else { None };
    let mut field = water.field.at(depth, time);
    field.waves.iter_mut().for_each(|wave| wave.amplitude *= strength);
    scene.meshes[water.mesh].positions = field.mesh("water").positions;
}

fn upload(scene: &Scene, gpu_scene: &mut GpuScene) -> Result<(), Box<dyn Error>> {
    let mesh = scene.animation.waters[0].mesh;
    let vertex = |position: &Vec3| Vertex { position: position.to_array(), ..Vertex::default() };
    let vertices: Vec<Vertex> = scene.meshes[mesh].positions.iter().map(vertex).collect();
    let first = u64::from(gpu_scene.meshes[mesh].first_vertex) * size_of::<Vertex>() as u64;
    gpu_scene.vertices.upload_at(first, bytemuck::cast_slice(&vertices))?;
    Ok(gpu_scene.follow(scene)?)
}

/// Prints and returns a row for each back-end.
pub fn costs(device: &Device, quads: u32) -> Result<Vec<Cost>, Box<dyn Error>> {
    let mut scene = pool(quads)?;
    let mut gpu_scene = GpuScene::new(device, &scene)?;
    let mesh = scene.animation.waters[0].mesh;
    let instance = scene.instances.iter().position(|i| i.mesh == mesh).ok_or("the pool has no water")?;
    let mut rows = Vec::new();
    for (backend, following, way) in ways(device) {
        water_at(&mut scene, 0.0, 1.0);
        upload(&scene, &mut gpu_scene)?;
        let mut tracer = Tracer::following(device, &scene, &gpu_scene, backend, following)?;
        let mut cost = Cost {
            device: device.info.name.clone(),
            backend,
            following: way,
            triangles: scene.meshes[mesh].triangles.len(),
            build: tracer.build_milliseconds,
            update: f64::INFINITY,
            update_cpu: 0.0,
            passes: Vec::new(),
            instance: f64::INFINITY,
        };
        for frame in 0..FRAMES {
            water_at(&mut scene, f64::from(frame) * STEP, 1.0);
            upload(&scene, &mut gpu_scene)?;
            let (wall, cpu) = (Instant::now(), cpu_seconds());
            let times = tracer.update(device, &scene, &gpu_scene, &[mesh])?;
            if frame > 0 {
                cost.update = cost.update.min(wall.elapsed().as_secs_f64() * 1e3);
                cost.update_cpu += (cpu_seconds() - cpu) * 1e3 / f64::from(FRAMES - 1);
                least(&mut cost.passes, &times);
            }
            let still = scene.instances[instance].transform;
            scene.instances[instance].transform =
                Affine3A::from_translation(Vec3::Y * 1e-3 * (frame + 1) as f32) * still;
            gpu_scene.follow(&scene)?;
            let wall = Instant::now();
            tracer.update(device, &scene, &gpu_scene, &[])?;
            cost.instance = cost.instance.min(wall.elapsed().as_secs_f64() * 1e3);
            scene.instances[instance].transform = still;
        }
        let passes: Vec<_> = cost.passes.iter().map(|(name, ms)| format!("{name} {ms:.1}")).collect();
        println!(
            "{:<36} {:<18} {:>9} {:>9.1} {:>9.1} {:>9.1} {:>9.2}   {}",
            cost.device,
            name(backend, way),
            cost.triangles,
            cost.build,
            cost.update,
            cost.update_cpu,
            cost.instance,
            passes.join(", ")
        );
        rows.push(cost);
    }
    Ok(rows)
}

pub fn cost_header() {
    println!(
        "\n{:<36} {:<18} {:>9} {:>9} {:>9} {:>9} {:>9}   passes, ms",
        "device", "back-end", "triangles", "build ms", "update ms", "CPU ms", "moved ms"
    );
}

/// The sums of a frame's passes by name, where they are less than any before.
fn least(passes: &mut Vec<(String, f64)>, times: &[PassTime]) {
    let mut sums: Vec<(String, f64)> = Vec::new();
    for time in times {
        let milliseconds = time.milliseconds.unwrap_or(0.0);
        match sums.iter_mut().find(|(name, _)| *name == time.name) {
            Some((_, sum)) => *sum += milliseconds,
            None => sums.push((time.name.clone(), milliseconds)),
        }
    }
    for (name, sum) in sums {
        match passes.iter_mut().find(|(known, _)| *known == name) {
            Some((_, known)) => *known = known.min(sum),
            None => passes.push((name, sum)),
        }
    }
}

fn name(backend: Backend, way: Option<&str>) -> String {
    way.map_or(backend.name().to_string(), |way| format!("{}, {way}", backend.name()))
}

/// Prints and returns a row for each back-end and state of the water.
pub fn quality(device: &Device, primary: &[Ray]) -> Result<Vec<Quality>, Box<dyn Error>> {
    println!(
        "\n{:<36} {:<18} {:<42} {:>18} {:>18}",
        "device", "back-end", "water", "primary M/CPU-s", "shadow M/CPU-s"
    );
    let mut scene = pool(QUADS)?;
    let mut gpu_scene = GpuScene::new(device, &scene)?;
    let mesh = scene.animation.waters[0].mesh;
    let mut rows = Vec::new();
    for (backend, following, way) in ways(device).into_iter().filter(|(_, _, way)| *way != Some("rebuild")) {
        for (case, built, strength) in CASES {
            water_at(&mut scene, 0.0, built);
            upload(&scene, &mut gpu_scene)?;
            let mut tracer = Tracer::following(device, &scene, &gpu_scene, backend, following)?;
            water_at(&mut scene, LATER, strength);
            upload(&scene, &mut gpu_scene)?;
            tracer.update(device, &scene, &gpu_scene, &[mesh])?;
            let tracers = [tracer, Tracer::new(device, &scene, &gpu_scene, backend)?];
            let probe = Probe::new(device, &tracers[0], primary)?;
            let [primary_speed, primary_new] = speeds(&probe, &tracers, &gpu_scene, primary.len(), false)?;
            let shadows = shadow_rays(primary, &probe.hits()?);
            let probe = Probe::new(device, &tracers[0], &shadows)?;
            let [shadow, shadow_new] = speeds(&probe, &tracers, &gpu_scene, shadows.len(), true)?;
            let device = device.info.name.clone();
            let row = Quality {
                device,
                backend,
                following: way,
                case,
                primary: primary_speed,
                primary_new,
                shadow,
                shadow_new,
            };
            println!(
                "{:<36} {:<18} {:<42} {:>6.2} of {:>6.2} new {:>6.2} of {:>6.2} new",
                row.device,
                name(backend, way),
                row.case,
                row.primary,
                row.primary_new,
                row.shadow,
                row.shadow_new
            );
            rows.push(row);
        }
    }
    Ok(rows)
}

/// Of each tracer, millions of rays per CPU-second in the best of some rounds, the tracers by turns.
fn speeds(
    probe: &Probe,
    tracers: &[Tracer; 2],
    scene: &GpuScene,
    rays: usize,
    any_hit: bool,
) -> Result<[f64; 2], Box<dyn Error>> {
    // The first run compiles.
    probe.run(&tracers[0], scene, ANY_MASK, any_hit)?;
    let mut best = [0.0f64; 2];
    for _ in 0..ROUNDS {
        for (best, tracer) in best.iter_mut().zip(tracers) {
            let cpu = cpu_seconds();
            probe.run(tracer, scene, ANY_MASK, any_hit)?;
            *best = best.max(rays as f64 * 1e-6 / (cpu_seconds() - cpu).max(1e-3));
        }
    }
    Ok(best)
}

//! What caustics cost on top of a frame, and what memory, as the water is made of more triangles.
//!
//! Caustics are the passes `mnee/*` and `frame/accumulate`, the frame all others. The first sample is apart: it takes the
//! surfaces to world space and finds footprints. The coarsest water is rendered once before, so that kernels are in the
//! driver's cache by then.

use std::error::Error;
use std::fs;

use nephroid::render::{RenderSettings, Renderer};
use nephroid::scene::{self, Scene};
use nephroid::stats::{self, PassTotal};
use nephroid::technique::{CounterEntry, TechniqueKind};

use crate::{Options, about};

const SIZE: (u32, u32) = (240, 180);
const SAMPLES: u32 = 3;
const CAMERAS: [&str; 2] = ["under", "above"];
const MIB: f64 = 1_048_576.0;

/// Milliseconds of one pass.
#[derive(Debug, Clone, serde::Serialize)]
struct Pass {
    name: String,
    first: f64,
    /// Mean of a later sample.
    later: f64,
}

#[derive(Debug, serde::Serialize)]
struct Row {
    camera: String,
    triangles: u64,
    /// CPU time to read the scene, open the device, build trees and find neighbours.
    set_up_seconds: f64,
    passes: Vec<Pass>,
    /// Milliseconds of the passes that no later sample has.
    once: f64,
    /// Milliseconds a later sample.
    caustics: f64,
    frame: f64,
    /// All samples' sums and means.
    counters: Vec<CounterEntry>,
    /// Bytes at most with caustics, and without.
    memory: u64,
    memory_without: u64,
}

impl Row {
    fn added(&self) -> f64 {
        self.memory as f64 - self.memory_without as f64
    }
}

pub fn measure(options: &Options) -> Result<serde_json::Value, Box<dyn Error>> {
    let text = fs::read_to_string(&options.scene)?;
    let cameras = options.settings.camera.clone().map_or(CAMERAS.map(str::to_string).to_vec(), |camera| vec![camera]);
    let (mut rows, mut device) = (Vec::new(), String::new());
    let coarsest = *options.quads.first().ok_or("--quads needs a number")?;
    run(|| water(options, &text, coarsest), &settings_for(options, &cameras[0]), 0)?;
    for &quads in &options.quads {
        let load = || water(options, &text, quads);
        let settings = settings(options, &cameras[0], TechniqueKind::None);
        let memory_without = Renderer::new(load()?, &settings)?.device().peak_memory();
        for camera in &cameras {
            let (about, row) = run(load, &settings_for(options, camera), memory_without)?;
            if device.is_empty() {
                println!("{about}");
                header();
                device = about;
            }
            print(&row, rows.first().unwrap_or(&row));
            rows.push(row);
        }
    }
    for camera in &cameras {
        print_passes(&rows.iter().filter(|row| row.camera == *camera).collect::<Vec<_>>());
    }
    Ok(serde_json::json!({ "device": device, "size": options.settings.size.unwrap_or(SIZE), "rows": rows }))
}

fn settings_for(options: &Options, camera: &str) -> RenderSettings {
    settings(options, camera, TechniqueKind::Mnee)
}

fn settings(options: &Options, camera: &str, technique: TechniqueKind) -> RenderSettings {
    let set = if technique == TechniqueKind::None { Vec::new() } else { options.settings.set.clone() };
    RenderSettings {
        technique,
        camera: Some(camera.to_string()),
        size: Some(options.settings.size.unwrap_or(SIZE)),
        samples: Some(options.settings.samples.unwrap_or(SAMPLES).max(2)),
        set,
        ..options.settings.clone()
    }
}

/// The scene with height fields of `quads` quads a side.
fn water(options: &Options, text: &str, quads: u32) -> Result<Scene, Box<dyn Error>> {
    let key = |line: &&str| line.trim_start().starts_with("quads");
    if text.lines().filter(key).count() != 1 {
        return Err(format!("{} needs one line that begins with quads", options.scene.display()).into());
    }
    let line = |line: &str| if key(&line) { format!("quads = {quads}\n") } else { format!("{line}\n") };
    Ok(scene::parse(&text.lines().map(line).collect::<String>(), &options.scene)?)
}

fn run(
    load: impl Fn() -> Result<Scene, Box<dyn Error>>,
    settings: &RenderSettings,
    memory_without: u64,
) -> Result<(String, Row), Box<dyn Error>> {
    let start = stats::cpu_seconds();
    let mut renderer = Renderer::new(load()?, settings)?;
    let set_up_seconds = stats::cpu_seconds() - start;
    renderer.sample()?;
    let first = renderer.finish()?.stats.passes;
    for _ in 1..renderer.samples() {
        renderer.sample()?;
    }
    let stats = renderer.finish()?.stats;
    let passes = passes(&first, &stats.passes, renderer.samples() - 1)?;
    let sum = |caustics: bool, time: &dyn Fn(&Pass) -> f64| {
        passes.iter().filter(|pass| is_caustics(&pass.name) == caustics).map(time).sum::<f64>()
    };
    let row = Row {
        camera: stats.camera,
        triangles: triangles(renderer.scene()),
        set_up_seconds,
        once: sum(true, &|pass| if pass.later == 0.0 { pass.first } else { 0.0 }),
        caustics: sum(true, &|pass| pass.later),
        frame: sum(false, &|pass| pass.later),
        passes,
        counters: stats.counters,
        memory: stats.peak_memory_bytes,
        memory_without,
    };
    Ok((about(&renderer), row))
}

fn is_caustics(pass: &str) -> bool {
    pass.starts_with("mnee/") || pass == "frame/accumulate"
}

/// Of surfaces that refract.
fn triangles(scene: &Scene) -> u64 {
    let refracting = scene.instances.iter().filter(|instance| scene.refracts(instance));
    refracting.map(|instance| scene.meshes[instance.mesh].triangles.len() as u64).sum()
}

/// What one sample took, and what each of `later` more did.
fn passes(first: &[PassTotal], all: &[PassTotal], later: u32) -> Result<Vec<Pass>, Box<dyn Error>> {
    let time = |pass: &PassTotal| pass.milliseconds.ok_or("the device has no timestamps to take costs from");
    let mut passes = Vec::new();
    for pass in all {
        let total = time(pass)?;
        let first = first.iter().find(|p| p.name == pass.name).map_or(Ok(0.0), time)?;
        passes.push(Pass { name: pass.name.clone(), first, later: (total - first) / f64::from(later) });
    }
    Ok(passes)
}

fn header() {
    println!(
        "{:<7} {:>9} {:>8} {:>9} {:>10} {:>10} {:>9} {:>9} {:>9} {:>9}",
        "camera",
        "triangles",
        "set-up s",
        "once ms",
        "caustic ms",
        "frame ms",
        "of frame",
        "of all",
        "MiB more",
        "B/tri"
    );
}

/// One line of the table; memory a triangle is what it takes beyond `coarsest`.
fn print(row: &Row, coarsest: &Row) {
    let more = row.triangles.saturating_sub(coarsest.triangles);
    let each = if more == 0 { "-".into() } else { format!("{:.1}", (row.added() - coarsest.added()) / more as f64) };
    println!(
        "{:<7} {:>9} {:>8.2} {:>9.1} {:>10.1} {:>10.1} {:>8.1}% {:>8.1}% {:>9.1} {each:>9}",
        row.camera,
        row.triangles,
        row.set_up_seconds,
        row.once,
        row.caustics,
        row.frame,
        100.0 * row.caustics / row.frame,
        100.0 * row.caustics / (row.caustics + row.frame),
        row.added() / MIB,
    );
}

/// Milliseconds a later sample of every pass by size, and of those that only the first sample has; then how often what
/// happened, in all samples.
fn print_passes(rows: &[&Row]) {
    let Some(finest) = rows.last() else { return };
    println!("\n{}: ms a later sample, in brackets the first one's where no other has any", finest.camera);
    let columns =
        |cell: &dyn Fn(&Row) -> String| rows.iter().map(|row| format!(" {:>10}", cell(row))).collect::<String>();
    println!("{:<34}{}", "triangles", columns(&|row| row.triangles.to_string()));
    for pass in &finest.passes {
        let cell = |row: &Row| match row.passes.iter().find(|p| p.name == pass.name) {
            Some(Pass { first, later, .. }) if *later == 0.0 => format!("({first:.1})"),
            Some(Pass { later, .. }) => format!("{later:.1}"),
            None => String::new(),
        };
        println!("{:<34}{}", pass.name, columns(&cell));
    }
    for counter in finest.counters.iter().filter(|counter| counter.value > 0.0) {
        let cell = |row: &Row| {
            let here = row.counters.iter().find(|c| c.name == counter.name);
            here.map_or(String::new(), |c| format!("{:.6}", c.value).chars().take(10).collect())
        };
        println!("{:<34}{}", counter.name, columns(&cell));
    }
}

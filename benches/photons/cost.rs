//! What photons cost: by the way they are followed, by their order, and by how many they are.

use std::error::Error;
use std::path::{Path, PathBuf};

use nephroid::gpu::Device;

use crate::Options;
use crate::report::run::Run;
use crate::run::{Split, counter, items, name_of, quickest, scenes, settings};

const SIZE: (u32, u32) = (1920, 1080);
/// Of each run, after the one that makes pipelines: times of passes are means over them, seconds those of the quickest.
const SAMPLES: u32 = 2;

#[derive(Debug, Clone, serde::Serialize)]
struct Row {
    scene: PathBuf,
    what: String,
    /// That left a specular surface.
    traced: f64,
    /// Nodes and texels that each looked at, in the light's view and in the camera's.
    light_steps: f64,
    camera_steps: f64,
    light_hits: f64,
    camera_hits: f64,
    split: Split,
    /// CPU seconds of a sample on a software device.
    seconds: f64,
}

fn row(
    options: &Options,
    device: &Device,
    scene: &Path,
    what: &str,
    set: &[(&str, &str)],
) -> Result<Row, Box<dyn Error>> {
    let mut run = Run::new(device, scene, &settings(options, SIZE, &items(set)))?;
    let seconds = quickest(&mut run, SAMPLES)?;
    let traced = counter(&run, "photons_traced")?;
    let row = Row {
        scene: scene.to_path_buf(),
        what: what.to_string(),
        traced,
        light_steps: counter(&run, "light_steps")? / traced.max(1.0),
        camera_steps: counter(&run, "camera_steps")? / traced.max(1.0),
        light_hits: counter(&run, "light_hits")?,
        camera_hits: counter(&run, "camera_hits")?,
        split: Split::of(&run)?,
        seconds,
    };
    print(&row);
    Ok(row)
}

fn print_head() {
    println!(
        "scene           what           traced  steps light+camera  emit ms trace ms rescue ms store ms show ms other ms frame ms  s"
    );
}

fn print(row: &Row) {
    let Split { emit, trace, rescue, store, show, other, frame } = row.split;
    println!(
        "{:<15} {:<13} {:>8.0} {:>9.1} + {:<9.1} {emit:>7.0} {trace:>8.0} {rescue:>9.0} {store:>8.0} {show:>7.0} {other:>8.0} {frame:>8.0} {:>6.2}",
        name_of(&row.scene),
        row.what,
        row.traced,
        row.light_steps,
        row.camera_steps,
        row.seconds
    );
}

/// Both of `key`'s values in each scene; how many times as many steps and as much time in following the second takes.
fn pair(options: &Options, device: &Device, key: &str, values: [&str; 2]) -> Result<serde_json::Value, Box<dyn Error>> {
    print_head();
    let mut rows = Vec::new();
    for scene in scenes(options) {
        let first = row(options, device, &scene, values[0], &[(key, values[0])])?;
        let second = row(options, device, &scene, values[1], &[(key, values[1])])?;
        let steps = |row: &Row| row.light_steps + row.camera_steps;
        let same = first.light_hits == second.light_hits && first.camera_hits == second.camera_hits;
        println!(
            "{}: {} takes {:.2} times the steps and {:.2} times the time in following; {} hits",
            name_of(&scene),
            values[1],
            steps(&second) / steps(&first),
            second.split.trace / first.split.trace,
            if same { "equal" } else { "other" }
        );
        rows.extend([first, second]);
    }
    println!();
    Ok(serde_json::json!({ "size": options.settings.size.unwrap_or(SIZE), "rows": rows }))
}

pub fn march(options: &Options, device: &Device) -> Result<serde_json::Value, Box<dyn Error>> {
    pair(options, device, "march", ["hierarchical", "linear"])
}

pub fn order(options: &Options, device: &Device) -> Result<serde_json::Value, Box<dyn Error>> {
    pair(options, device, "order", ["tiles", "shuffled"])
}

/// By how many photons, with rescue off and on.
pub fn measure(options: &Options, device: &Device) -> Result<serde_json::Value, Box<dyn Error>> {
    print_head();
    let mut rows = Vec::new();
    for scene in scenes(options) {
        for rescue in ["off", "rays"] {
            for photons in &options.photons {
                let count = photons.to_string();
                let what = format!("{:.1} M {rescue}", f64::from(*photons) / 1e6);
                let found = row(options, device, &scene, &what, &[("photons", &count), ("rescue", rescue)])?;
                let Split { emit, trace, rescue, .. } = found.split;
                println!("{:>44.0} ns a photon", 1e6 * (emit + trace + rescue) / f64::from(*photons));
                rows.push(found);
            }
        }
    }
    println!();
    Ok(serde_json::json!({ "size": options.settings.size.unwrap_or(SIZE), "rows": rows }))
}

//! The reference's way to the truth: error, energy and CPU seconds at every doubling of the samples.
//!
//! `cargo bench --bench reference` renders the pool as the tests do. `-- --truth T.exr --mask M.png --size 480x360
//! --samples 256` holds it against another truth of the same scene, and `--layer caustic_volume` with `--scene` and `--truth`
//! light in volumes. Prints a table and writes `target/bench/reference.json`.

#[path = "report/mod.rs"]
mod report;

use std::error::Error;
use std::path::PathBuf;

use nephroid::render::{RenderSettings, Renderer};
use nephroid::{scene, stats};
use report::{Truth, options};

struct Options {
    scene: PathBuf,
    layer: String,
    truth: PathBuf,
    mask: Option<PathBuf>,
    settings: RenderSettings,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = options()?;
    let truth = Truth::read(&options.truth, &options.layer, options.mask.as_deref())?;
    let mut renderer = Renderer::new(scene::load(&options.scene)?, &options.settings)?;
    println!(
        "{}, {}, camera {}",
        renderer.device().info.describe(),
        renderer.tier(),
        options.settings.camera.as_deref().unwrap_or_default()
    );
    println!("{:>8} {:>8} {:>9} {:>9} {:>9} {:>7}", "samples", "CPU s", "relRMSE", "energy", "noise", "ratio");
    let start = stats::cpu_seconds();
    let (mut rows, mut before) = (Vec::new(), None::<f64>);
    for _ in 0..renderer.samples() {
        let progress = renderer.sample()?;
        if !progress.done.is_power_of_two() {
            continue;
        }
        let seconds = stats::cpu_seconds() - start;
        let metrics = truth.error(&renderer, &options.layer)?;
        let ratio = before.map(|b| metrics.rel_rmse / b);
        println!(
            "{:>8} {seconds:>8.1} {:>8.2}% {:>9.5} {:>8.2}% {:>7}",
            progress.done,
            100.0 * metrics.rel_rmse,
            metrics.energy_ratio,
            100.0 * progress.noise.unwrap_or(0.0),
            ratio.map_or(String::new(), |r| format!("{r:.3}"))
        );
        rows.push(serde_json::json!({
            "samples": progress.done,
            "cpu_seconds": seconds,
            "rel_rmse": metrics.rel_rmse,
            "energy_ratio": metrics.energy_ratio,
            "noise": progress.noise,
        }));
        before = Some(metrics.rel_rmse);
    }
    let info = &renderer.device().info;
    let results = serde_json::json!({
        "device": info.name,
        "driver": format!("{} {}", info.driver, info.driver_version),
        "tier": renderer.tier(),
        "rows": rows,
    });
    report::write("reference", results)
}

fn options() -> Result<Options, Box<dyn Error>> {
    let mut options = Options {
        scene: "scenes/pool.toml".into(),
        layer: "refracted".to_string(),
        truth: "tests/truth/pool_under_120x90.exr".into(),
        mask: None,
        settings: RenderSettings {
            camera: Some("under".to_string()),
            size: Some((120, 90)),
            samples: Some(64),
            ..Default::default()
        },
    };
    for (name, value) in options::given()? {
        match name.as_str() {
            "--scene" => options.scene = value.into(),
            "--layer" => options.layer = value,
            "--truth" => options.truth = value.into(),
            "--mask" => options.mask = Some(value.into()),
            "--samples" => options.settings.samples = Some(value.parse()?),
            _ => options::put(&mut options.settings, (name, value))?,
        }
    }
    Ok(options)
}

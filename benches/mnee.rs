//! The technique `mnee` by itself: how soon it is how good, and what it costs on top of a frame as water gets finer.
//!
//! `cargo bench --bench mnee` does both on small pictures; `-- --part quality` or `-- --part scaling` does one.
//! `-- --part quality --truth T.exr --mask M.png --size 480x360 --samples 256` holds the pool against another truth;
//! `-- --part scaling --size 960x720 --samples 2` is the paper's picture. `--adaptive 8,32` and `--quads 8,256` name
//! budgets and tessellations. Prints tables and writes `target/bench/mnee.json`.
//!
//! Times of passes are the device's clock. On a machine with other work on it their ratios within one row hold, and no
//! more.

#[path = "mnee/quality.rs"]
mod quality;
#[path = "report/mod.rs"]
mod report;
#[path = "mnee/scaling.rs"]
mod scaling;

use std::error::Error;
use std::path::PathBuf;

use nephroid::render::{RenderSettings, Renderer};
use nephroid::technique::TechniqueKind;
use report::options;

/// What was asked for; `None` and empty are each part's own choice.
pub struct Options {
    scene: PathBuf,
    layer: String,
    truth: PathBuf,
    mask: Option<PathBuf>,
    adaptive: Vec<u32>,
    quads: Vec<u32>,
    parts: Vec<String>,
    settings: RenderSettings,
}

const PARTS: [&str; 2] = ["quality", "scaling"];

fn main() -> Result<(), Box<dyn Error>> {
    let options = options()?;
    let mut results = serde_json::Map::new();
    for part in &options.parts {
        let result = if part == PARTS[0] { quality::measure(&options)? } else { scaling::measure(&options)? };
        results.insert(part.clone(), result);
    }
    report::write("mnee", results.into())
}

/// The device and what became of its capabilities.
pub fn about(renderer: &Renderer) -> String {
    format!("{}, {}", renderer.device().info.describe(), renderer.tier())
}

fn options() -> Result<Options, Box<dyn Error>> {
    let mut options = Options {
        scene: "scenes/pool.toml".into(),
        layer: "refracted".to_string(),
        truth: "tests/truth/pool_under_120x90.exr".into(),
        mask: None,
        adaptive: vec![4, 8, 12, 16, 32, 64],
        quads: vec![8, 32, 128, 256, 512, 1024],
        parts: PARTS.map(str::to_string).to_vec(),
        settings: RenderSettings { technique: TechniqueKind::Mnee, trace: "bvh".parse()?, ..Default::default() },
    };
    for (name, value) in options::given()? {
        match name.as_str() {
            "--part" if PARTS.contains(&value.as_str()) => options.parts = vec![value],
            "--part" => return Err(format!("--part is \"{value}\"; allowed are {}", PARTS.join(" and ")).into()),
            "--scene" => options.scene = value.into(),
            "--layer" => options.layer = value,
            "--truth" => options.truth = value.into(),
            "--mask" => options.mask = Some(value.into()),
            "--samples" => options.settings.samples = Some(value.parse()?),
            "--adaptive" => options.adaptive = options::numbers(&value)?,
            "--quads" => options.quads = options::numbers(&value)?,
            _ => options::put(&mut options.settings, (name, value))?,
        }
    }
    Ok(options)
}

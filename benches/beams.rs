//! The technique `beams` by itself: how good it is by how many levels, and what its parts cost.
//!
//! `cargo bench --bench beams` does all parts on small pictures; `-- --part NAME` does one:
//! - `levels`: error and CPU time at every doubling of samples, by levels of refinement, from both of the pool's cameras;
//! - `adaptive`: refined grids against a static one of 64 x 64 cells, at equal error;
//! - `bounds`: six-sided hulls against prisms, in both tiers that draw;
//! - `scenes`: what beams take to make and to add up in each scene;
//! - `accumulate`: what adding up given beams costs, by each tier.
//!
//! `-- --part levels --camera under --truth T.exr --mask M.png` holds the pool against another truth, at its size; `--size`
//! is that of the other parts' pictures. `--seconds` ends a row of doublings, `--levels 3,4,5,6` names levels, `--scene`, `--camera` and `--layer` what is rendered, `--set` settings
//! for all runs. Prints tables and writes `target/bench/beams.json`.
//!
//! Each run begins with a sample that is not counted: with it, drivers compile kernels.

#[path = "beams/accumulate.rs"]
mod accumulate;
#[path = "beams/adaptive.rs"]
mod adaptive;
#[path = "../tests/beams/mod.rs"]
mod beams;
#[path = "beams/bounds.rs"]
mod bounds;
#[path = "../tests/common/mod.rs"]
mod common;
#[path = "beams/levels.rs"]
mod levels;
#[path = "report/mod.rs"]
mod report;
#[path = "beams/run.rs"]
mod run;
#[path = "beams/scenes.rs"]
mod scenes;

use std::error::Error;
use std::path::PathBuf;

use nephroid::gpu::Device;
use nephroid::render::RenderSettings;
use nephroid::technique::TechniqueKind;

type Measure = fn(&Options, &Device) -> Result<serde_json::Value, Box<dyn Error>>;

const PARTS: [(&str, Measure); 5] = [
    ("levels", levels::measure),
    ("adaptive", adaptive::measure),
    ("bounds", bounds::measure),
    ("scenes", scenes::measure),
    ("accumulate", accumulate::measure),
];

/// What was asked for; `None` and empty are each part's own choice.
pub struct Options {
    scene: Option<PathBuf>,
    camera: Option<String>,
    layer: String,
    truth: Option<PathBuf>,
    mask: Option<PathBuf>,
    size: Option<(u32, u32)>,
    levels: Vec<u32>,
    seconds: f64,
    settings: RenderSettings,
}

fn main() -> Result<(), Box<dyn Error>> {
    let (parts, options) = options(std::env::args().skip(1))?;
    // One for all runs, so that kernels are compiled once.
    let device = Device::open(&options.settings.device)?;
    println!("{}\n", device.info.describe());
    let mut results = serde_json::Map::new();
    results.insert("device".to_string(), device.info.describe().into());
    for (name, measure) in PARTS {
        if parts.is_empty() || parts.iter().any(|part| part == name) {
            results.insert(name.to_string(), measure(&options, &device)?);
        }
    }
    report::write("beams", results.into())
}

fn options(mut arguments: impl Iterator<Item = String>) -> Result<(Vec<String>, Options), Box<dyn Error>> {
    let mut parts = Vec::new();
    let mut options = Options {
        scene: None,
        camera: None,
        layer: "refracted".to_string(),
        truth: None,
        mask: None,
        size: None,
        levels: vec![3, 4, 5, 6],
        seconds: 10.0,
        settings: RenderSettings { technique: TechniqueKind::Beams, trace: "bvh".parse()?, ..Default::default() },
    };
    while let Some(name) = arguments.next() {
        // Cargo passes --bench to every bench.
        if name == "--bench" {
            continue;
        }
        let value = arguments.next().ok_or(format!("{name} needs a value"))?;
        match name.as_str() {
            "--part" if PARTS.iter().any(|(part, _)| *part == value) => parts.push(value),
            "--part" => {
                let names = PARTS.map(|(part, _)| part).join(", ");
                return Err(format!("--part is \"{value}\"; allowed are {names}").into());
            }
            "--scene" => options.scene = Some(value.into()),
            "--camera" => options.camera = Some(value),
            "--layer" => options.layer = value,
            "--truth" => options.truth = Some(value.into()),
            "--mask" => options.mask = Some(value.into()),
            "--levels" => options.levels = value.split(',').map(|n| n.trim().parse()).collect::<Result<_, _>>()?,
            "--seconds" => options.seconds = value.parse()?,
            "--trace" => options.settings.trace = value.parse()?,
            "--device" => options.settings.device.device = Some(value),
            "--set" => options.settings.set.push(value),
            "--size" => {
                let (width, height) = value.split_once('x').ok_or("--size wants WxH")?;
                options.size = Some((width.parse()?, height.parse()?));
            }
            other => return Err(format!("unknown option {other}").into()),
        }
    }
    Ok((parts, options))
}

//! The technique `photons` by itself: how good it is by how many photons, and what its parts cost.
//!
//! `cargo bench --bench photons` does all parts; `-- --part NAME` does one:
//! - `quality`: error and energy by photons and sets, with rescue off and on, against the reference's light of one specular
//!   event;
//! - `march`: photons followed over pyramids against texel by texel;
//! - `order`: neighbours followed side by side against shuffled ones;
//! - `cost`: what starting, following, storing and showing photons takes, by how many there are (Table 1 of the paper).
//!
//! `--size WxH` is that of the pictures (256x192 of `quality`, else 1920x1080), `--photons 500000,1000000` how many,
//! `--scene` and `--camera` what is rendered, `--reference N` samples of the reference's 1,000,000 photons, `--set` settings
//! for all runs. Prints tables and writes `target/bench/photons.json`.
//!
//! Each run begins with a sample that is not counted: with it, drivers compile kernels. Times are of one sample: CPU
//! seconds of all cores on a software device, milliseconds of passes by the device.

#[path = "photons/cost.rs"]
mod cost;
#[path = "photons/quality.rs"]
mod quality;
#[path = "report/mod.rs"]
mod report;
#[path = "photons/run.rs"]
mod run;

use std::error::Error;
use std::path::PathBuf;

use nephroid::gpu::Device;
use nephroid::render::RenderSettings;
use nephroid::technique::TechniqueKind;

type Measure = fn(&Options, &Device) -> Result<serde_json::Value, Box<dyn Error>>;

const PARTS: [(&str, Measure); 4] =
    [("quality", quality::measure), ("march", cost::march), ("order", cost::order), ("cost", cost::measure)];

/// What was asked for; `None` is each part's own choice.
pub struct Options {
    scene: Option<PathBuf>,
    camera: Option<String>,
    size: Option<(u32, u32)>,
    photons: Vec<u32>,
    reference: u32,
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
    report::write("photons", results.into())
}

fn options(mut arguments: impl Iterator<Item = String>) -> Result<(Vec<String>, Options), Box<dyn Error>> {
    let mut parts = Vec::new();
    let mut options = Options {
        scene: None,
        camera: None,
        size: None,
        photons: vec![500_000, 1_000_000, 2_000_000],
        reference: 32,
        settings: RenderSettings { technique: TechniqueKind::Photons, trace: "cwbvh".parse()?, ..Default::default() },
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
            "--photons" => options.photons = value.split(',').map(|n| n.trim().parse()).collect::<Result<_, _>>()?,
            "--reference" => options.reference = value.parse()?,
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

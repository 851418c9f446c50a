//! The technique `photons` by itself: how good it is by how many photons, and what its parts cost.
//!
//! `cargo bench --bench photons` does all parts; `-- --part NAME` does one:
//! - `quality`: error and energy by photons and sets, with rescue off and on and each filter, against the reference's light of
//!   one specular event;
//! - `march`: photons followed over pyramids against texel by texel;
//! - `order`: neighbours followed side by side against shuffled ones;
//! - `cost`: what starting, following, storing and showing photons takes, by how many there are (Table 1 of the paper).
//!
//! `--size WxH` is that of the pictures (256x192 of `quality`, else 1920x1080), `--photons 500000,1000000` how many,
//! `--scene` and `--camera` what is rendered, `--reference N` samples of the reference's 1,000,000 photons, `--denoise off,spatial`
//! which filters `quality` measures, `--set` settings for all runs. Prints tables and writes `target/bench/photons.json`.
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

use nephroid::render::RenderSettings;
use nephroid::technique::TechniqueKind;
use report::options;
use report::parts::{self, Part};

const PARTS: [Part<Options>; 4] =
    [("quality", quality::measure), ("march", cost::march), ("order", cost::order), ("cost", cost::measure)];

/// What was asked for; `None` is each part's own choice.
pub struct Options {
    scene: Option<PathBuf>,
    photons: Vec<u32>,
    denoise: Vec<String>,
    reference: u32,
    settings: RenderSettings,
}

fn main() -> Result<(), Box<dyn Error>> {
    let (parts, options) = options()?;
    parts::measure("photons", &PARTS, &parts, &options, &options.settings.device)
}

fn options() -> Result<(Vec<String>, Options), Box<dyn Error>> {
    let mut parts = Vec::new();
    let mut options = Options {
        scene: None,
        photons: vec![500_000, 1_000_000, 2_000_000],
        denoise: ["off", "spatial", "temporal"].map(String::from).to_vec(),
        reference: 32,
        settings: RenderSettings { technique: TechniqueKind::Photons, trace: "cwbvh".parse()?, ..Default::default() },
    };
    for (name, value) in options::given()? {
        match name.as_str() {
            "--part" => parts.push(parts::named(&PARTS, value)?),
            "--scene" => options.scene = Some(value.into()),
            "--photons" => options.photons = options::numbers(&value)?,
            "--denoise" => options.denoise = value.split(',').map(String::from).collect(),
            "--reference" => options.reference = value.parse()?,
            _ => options::put(&mut options.settings, (name, value))?,
        }
    }
    Ok((parts, options))
}

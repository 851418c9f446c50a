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

use nephroid::render::RenderSettings;
use nephroid::technique::TechniqueKind;
use report::options;
use report::parts::{self, Part};

const PARTS: [Part<Options>; 5] = [
    ("levels", levels::measure),
    ("adaptive", adaptive::measure),
    ("bounds", bounds::measure),
    ("scenes", scenes::measure),
    ("accumulate", accumulate::measure),
];

/// What was asked for; `None` and empty are each part's own choice.
pub struct Options {
    scene: Option<PathBuf>,
    layer: String,
    truth: Option<PathBuf>,
    mask: Option<PathBuf>,
    levels: Vec<u32>,
    seconds: f64,
    settings: RenderSettings,
}

fn main() -> Result<(), Box<dyn Error>> {
    let (parts, options) = options()?;
    parts::measure("beams", &PARTS, &parts, &options, &options.settings.device)
}

fn options() -> Result<(Vec<String>, Options), Box<dyn Error>> {
    let mut parts = Vec::new();
    let mut options = Options {
        scene: None,
        layer: "refracted".to_string(),
        truth: None,
        mask: None,
        levels: vec![3, 4, 5, 6],
        seconds: 10.0,
        settings: RenderSettings { technique: TechniqueKind::Beams, trace: "bvh".parse()?, ..Default::default() },
    };
    for (name, value) in options::given()? {
        match name.as_str() {
            "--part" => parts.push(parts::named(&PARTS, value)?),
            "--scene" => options.scene = Some(value.into()),
            "--layer" => options.layer = value,
            "--truth" => options.truth = Some(value.into()),
            "--mask" => options.mask = Some(value.into()),
            "--levels" => options.levels = options::numbers(&value)?,
            "--seconds" => options.seconds = value.parse()?,
            _ => options::put(&mut options.settings, (name, value))?,
        }
    }
    Ok((parts, options))
}

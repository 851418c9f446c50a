//! What samples take, and the scenes and settings to render.

use std::error::Error;
use std::path::{Path, PathBuf};

use nephroid::render::RenderSettings;

use crate::Options;
use crate::report::run::Run;

/// The scenes without `--scene`.
const SCENES: [&str; 2] = ["cornell_flooded", "pool"];

pub fn scenes(options: &Options) -> Vec<PathBuf> {
    let shipped = || SCENES.map(|name| PathBuf::from(format!("scenes/{name}.toml"))).to_vec();
    options.scene.clone().map_or_else(shipped, |scene| vec![scene])
}

pub fn name_of(scene: &Path) -> String {
    scene.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Milliseconds a sample, by what they were for.
#[derive(Debug, Clone, Copy, Default, serde::Serialize)]
pub struct Split {
    pub emit: f64,
    pub trace: f64,
    pub rescue: f64,
    /// Emptying texels, drawing discs, and making irradiance of what texels hold.
    pub store: f64,
    pub show: f64,
    /// Whatever else the technique does; denoising is here.
    pub other: f64,
    pub frame: f64,
}

impl Split {
    /// The views are found by the first sample alone, so their passes are left out.
    pub fn of(run: &Run) -> Result<Self, Box<dyn Error>> {
        let mut split = Split::default();
        for (name, time) in run.passes()? {
            match name.strip_prefix("photons/") {
                Some("emit") => split.emit += time,
                Some("trace") => split.trace += time,
                Some("rescue") => split.rescue += time,
                Some("clear" | "splat" | "irradiance") => split.store += time,
                Some("show") => split.show += time,
                Some("visibility" | "visibility-copy" | "see" | "pyramid" | "camera" | "clear-areas" | "coverage") => {}
                Some(_) => split.other += time,
                None => split.frame += time,
            }
        }
        Ok(split)
    }
}

/// `count` samples; CPU seconds of the quickest, which what else the machine does disturbs least.
pub fn quickest(run: &mut Run, count: u32) -> Result<f64, Box<dyn Error>> {
    let mut quickest = f64::INFINITY;
    for _ in 0..count {
        let before = run.seconds;
        run.sample()?;
        quickest = quickest.min(run.seconds - before);
    }
    Ok(quickest)
}

/// A sample's part of what the technique counted.
pub fn counter(run: &Run, name: &str) -> Result<f64, Box<dyn Error>> {
    Ok(run.counter(name)? / f64::from(run.renderer.done()))
}

/// `options`' settings with a size and more `--set` items, which those of `options` win over.
pub fn settings(options: &Options, size: (u32, u32), set: &[String]) -> RenderSettings {
    let own = &options.settings;
    RenderSettings { size: own.size.or(Some(size)), set: [set, &own.set].concat(), ..own.clone() }
}

/// `photons.key=value` for each.
pub fn items(pairs: &[(&str, &str)]) -> Vec<String> {
    pairs.iter().map(|(key, value)| format!("photons.{key}={value}")).collect()
}

//! What samples take, and the truths and settings to render them by.

use std::error::Error;
use std::path::PathBuf;

use nephroid::render::RenderSettings;

use crate::Options;
use crate::report::Truth;
use crate::report::run::Run;

/// What beams are made by; the others of `beams/` add them up.
const GENERATION: [&str; 15] = [
    "clear",
    "corners",
    "advance",
    "trace",
    "split",
    "close",
    "count_leaves",
    "scan",
    "write_leaves",
    "cells",
    "size",
    "areas",
    "count_beams",
    "write_beams",
    "ledger",
];

/// Milliseconds a sample, by what they were for.
#[derive(Debug, Clone, Copy, Default, serde::Serialize)]
pub struct Split {
    pub generation: f64,
    pub accumulation: f64,
    pub frame: f64,
}

impl Split {
    pub fn of(run: &Run) -> Result<Self, Box<dyn Error>> {
        let mut split = Split::default();
        for (name, time) in run.passes()? {
            match name.strip_prefix("beams/") {
                Some(name) if GENERATION.contains(&name) => split.generation += time,
                Some(_) => split.accumulation += time,
                None => split.frame += time,
            }
        }
        Ok(split)
    }
}

/// What there was no room for.
pub fn dropped(run: &Run) -> Result<f64, Box<dyn Error>> {
    let counters = run.renderer.finish()?.stats.counters;
    Ok(counters.iter().filter(|counter| counter.name.ends_with("_dropped")).map(|counter| counter.value).sum())
}

/// The truth that was asked for, or what a camera of the pool sees.
pub fn truth(options: &Options, camera: &str) -> Result<Truth, Box<dyn Error>> {
    let own = || PathBuf::from(format!("tests/truth/pool_{camera}_120x90.exr"));
    Truth::read(&options.truth.clone().unwrap_or_else(own), &options.layer, options.mask.as_deref())
}

/// `options`' settings with a camera, a size and more `--set` items, which those of `options` win over.
pub fn settings(options: &Options, camera: Option<&str>, size: (u32, u32), set: &[String]) -> RenderSettings {
    let own = &options.settings;
    let camera = own.camera.clone().or(camera.map(str::to_string));
    RenderSettings { camera, size: own.size.or(Some(size)), set: [set, &own.set].concat(), ..own.clone() }
}

/// `beams.key=value` for each.
pub fn items(pairs: &[(&str, &str)]) -> Vec<String> {
    pairs.iter().map(|(key, value)| format!("beams.{key}={value}")).collect()
}

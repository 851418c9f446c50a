//! A renderer whose pipelines are made, and what its samples take.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use nephroid::gpu::Device;
use nephroid::image::metrics::{Metrics, compare};
use nephroid::image::{Mask, RgbImage};
use nephroid::render::{RenderSettings, Renderer};
use nephroid::scene;
use nephroid::stats;

use crate::{Options, report};

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

pub struct Run {
    pub renderer: Renderer,
    /// CPU seconds on a software device, else the clock's, of the samples so far.
    pub seconds: f64,
}

/// Milliseconds a sample, by what they were for.
#[derive(Debug, Clone, Copy, Default, serde::Serialize)]
pub struct Split {
    pub generation: f64,
    pub accumulation: f64,
    pub frame: f64,
}

impl Run {
    /// Ready for the first sample, after one that made pipelines.
    pub fn new(device: &Device, scene: &Path, settings: &RenderSettings) -> Result<Self, Box<dyn Error>> {
        let mut renderer = Renderer::with_device(device.clone(), scene::load(scene)?, settings)?;
        renderer.sample()?;
        renderer.restart()?;
        Ok(Run { renderer, seconds: 0.0 })
    }

    pub fn sample(&mut self) -> Result<(), Box<dyn Error>> {
        let (cpu, start) = (stats::cpu_seconds(), Instant::now());
        self.renderer.sample()?;
        let software = self.renderer.device().info.kind == "cpu";
        self.seconds += if software { stats::cpu_seconds() - cpu } else { start.elapsed().as_secs_f64() };
        Ok(())
    }

    pub fn error(&self, truth: &Truth, layer: &str) -> Result<Metrics, Box<dyn Error>> {
        let picture = self.renderer.finish()?.image.select(Path::new("the picture"), Some(layer))?;
        Ok(compare(&picture, &truth.picture, &truth.mask)?)
    }

    pub fn counter(&self, name: &str) -> Result<f64, Box<dyn Error>> {
        let counters = self.renderer.finish()?.stats.counters;
        Ok(counters.iter().find(|counter| counter.name == name).map_or(0.0, |counter| counter.value))
    }

    /// What there was no room for.
    pub fn dropped(&self) -> Result<f64, Box<dyn Error>> {
        let counters = self.renderer.finish()?.stats.counters;
        Ok(counters.iter().filter(|counter| counter.name.ends_with("_dropped")).map(|counter| counter.value).sum())
    }

    pub fn split(&self) -> Result<Split, Box<dyn Error>> {
        let mut split = Split::default();
        for pass in self.renderer.passes() {
            let time = pass.milliseconds.ok_or("the device has no timestamps to take costs from")?;
            let time = time / f64::from(self.renderer.done());
            match pass.name.strip_prefix("beams/") {
                Some(name) if GENERATION.contains(&name) => split.generation += time,
                Some(_) => split.accumulation += time,
                None => split.frame += time,
            }
        }
        Ok(split)
    }
}

/// What pictures are held against.
pub struct Truth {
    picture: RgbImage,
    mask: Mask,
}

impl Truth {
    /// The one asked for, or what a camera of the pool sees.
    pub fn of(options: &Options, camera: &str) -> Result<Self, Box<dyn Error>> {
        let own = || PathBuf::from(format!("tests/truth/pool_{camera}_120x90.exr"));
        let (picture, mask) = report::truth(&options.truth.clone().unwrap_or_else(own), options.mask.as_deref())?;
        Ok(Truth { picture, mask })
    }

    pub fn size(&self) -> (u32, u32) {
        (self.picture.width as u32, self.picture.height as u32)
    }
}

/// `options`' settings with a camera, a size and more `--set` items, which those of `options` win over.
pub fn settings(options: &Options, camera: Option<&str>, size: (u32, u32), set: &[String]) -> RenderSettings {
    let camera = options.camera.clone().or(camera.map(str::to_string));
    let set = [set, &options.settings.set].concat();
    RenderSettings { camera, size: Some(options.size.unwrap_or(size)), set, ..options.settings.clone() }
}

/// `beams.key=value` for each.
pub fn items(pairs: &[(&str, &str)]) -> Vec<String> {
    pairs.iter().map(|(key, value)| format!("beams.{key}={value}")).collect()
}
